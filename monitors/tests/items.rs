//! Conditions on the items of lists, and functions of numbers.

use std::f64::consts::PI;
use std::time::Duration;

use channels::{Capacity, Domain, FieldKind, Message, Shape, Topology, Value};
use monitors::{Formula, MessageCondition, ScopeError};

fn topology() -> Topology {
    let mut topology = Topology::default();
    let [laser, watch] = ["Laser", "Monitor"].map(|name| topology.process(name).expect("a new name"));
    let list = |kind| FieldKind::List(Box::new(kind));
    let real = || FieldKind::Optional(Box::new(FieldKind::Real));
    let head = |name| ("topic", FieldKind::symbols([name]));
    let shapes = [
        Shape::new([head("scan"), ("ranges", list(real())), ("levels", list(FieldKind::Int)), ("near", real())]),
        Shape::new([head("parts"), ("names", list(FieldKind::Text))]),
        Shape::new([head("pose")].into_iter().chain(["x", "y", "z", "w"].map(|name| (name, FieldKind::Real)))),
    ];
    topology.channel(laser, watch, Capacity::One, Domain::new(shapes)).expect("a new channel");
    topology
}

fn read(condition: &str) -> Result<Formula, ScopeError> {
    let text = format!("property p := eventually (Laser, Monitor, {condition})");
    monitors::formulas("p.scope", &text, &topology(), Duration::from_secs(1)).map(|mut read| read.remove(0).1)
}

fn condition(text: &str) -> MessageCondition {
    match read(text) {
        Ok(Formula::Eventually(event)) => match *event {
            Formula::Event(event) => event.condition,
            other => panic!("{other:?}"),
        },
        other => panic!("{text}: {other:?}"),
    }
}

fn list(items: impl IntoIterator<Item = Value>) -> Value {
    Value::List(items.into_iter().collect())
}

/// A scan in which `-1` stands for a missing range.
fn scan(ranges: &[f64], levels: &[i64], near: f64) -> Message {
    let real = |real: f64| if real == -1.0 { Value::symbol(FieldKind::NONE) } else { real.into() };
    let levels = list(levels.iter().map(|level| Value::Int(*level)));
    Message::new([Value::symbol("scan"), list(ranges.iter().map(|range| real(*range))), levels, real(near)])
}

fn pose(parts: [f64; 4]) -> Message {
    Message::new([Value::symbol("pose")].into_iter().chain(parts.map(Value::from)))
}

#[test]
fn a_condition_on_items_holds_as_it_does_one_by_one() {
    const NO: bool = false;
    let far = scan(&[4.0, -1.0, 0.2, 3.0], &[1, 2], 0.3);
    let empty = scan(&[], &[], 0.3);
    let parts = Message::new([Value::symbol("parts"), list(["arm".into(), "base".into()])]);
    let pose = pose([0.0; 4]);
    // For a scan, one whose lists are empty, a message with another list, and one without a list.
    for (text, expected) in [
        ("any(m.ranges < 0.3)", [true, NO, NO, NO]),
        ("all(m.ranges < 5)", [NO, true, NO, NO]),
        ("all(m.ranges < 5 or m.ranges = <none>)", [true, true, NO, NO]),
        ("not any(m.ranges < 0.3)", [NO, true, true, true]),
        ("not all(m.ranges >= 0.1)", [true, NO, true, true]),
        ("count(ranges > 2) = 2", [true, NO, NO, NO]),
        ("count(ranges > 2) != 2", [NO, true, true, true]),
        ("count(m.ranges < 99) + 1 = 4", [true, NO, NO, NO]),
        ("count(true and ranges = ranges) = 4", [true, NO, NO, NO]),
        // Other fields are those of the message, and lists stand for their items at the same place.
        ("any(m.ranges < m.near)", [true, NO, NO, NO]),
        ("count(levels < ranges) = 1", [true, NO, NO, NO]),
        ("all(ranges > levels)", [NO, true, NO, NO]),
        ("count(levels != 1) = 3", [NO, NO, NO, NO]),
        ("count(levels != 1) = 1", [true, NO, NO, NO]),
        ("count(levels != 1 and (ranges > 0 or not ranges > 0)) = 3", [true, NO, NO, NO]),
        ("any(m.names = \"arm\")", [NO, NO, true, NO]),
        ("all(m.names != \"leg\")", [NO, NO, true, NO]),
    ] {
        let condition = condition(text);
        let shown = [&far, &empty, &parts, &pose].map(|message| condition.holds(message));
        assert_eq!(shown, expected, "{text}");
        let printed = condition.text(
            topology()
                .channels()
                .map(|c| topology().get(c).domain.shapes().to_vec())
                .next()
                .expect("a channel")
                .as_slice(),
        );
        assert_eq!(self::condition(&printed), condition, "{printed}");
    }
}

#[test]
fn the_documented_example_is_a_property() {
    let example =
        monitors::OPERATORS.iter().find(|operator| operator.written == "any(C)").expect("it is listed").example;
    let text = format!("property p := {example}");
    assert!(monitors::formulas("p.scope", &text, &topology(), Duration::from_secs(1)).is_ok(), "{example}");
}

#[test]
fn conditions_on_items_are_told_in_words() {
    let told = |condition: &str| {
        let formula = read(condition).unwrap();
        monitors::explain(&formula, &topology())
    };
    let texts = [
        "any(m.ranges < 0.3)",
        "not any(m.ranges < 0.3)",
        "all(m.ranges > 0.3 and m.levels > 0)",
        "not all(m.ranges > 0.3)",
        "count(m.ranges < m.near) > 3",
        "distance(m.x, m.y, 1.5, 2) <= 0.3 m",
        "angle(yaw(m.x, m.y, m.z, m.w), 90 deg) > 10 deg",
    ];
    insta::assert_snapshot!(texts.map(|text| format!("{text}\n  {}", told(text))).join("\n"));
}

#[test]
fn what_is_wrong_with_items_and_functions_is_told() {
    let problem = |condition: &str| {
        let error = read(condition).unwrap_err();
        let told = error
            .problems()
            .iter()
            .map(|problem| format!("{} ({})", problem.message(), problem.help_text().unwrap_or_default()));
        format!("{condition}\n  {}", told.collect::<Vec<_>>().join("\n  "))
    };
    let texts = [
        "m.ranges < 0.3",
        "any(m.near < 0.3)",
        "any(any(m.ranges < 0.3))",
        "any(m.ranges as r)",
        "m.ranges as r",
        "any(m.ranges = \"near\")",
        "count(m.ranges < 0.3) = \"many\"",
        "count(m.range < 0.3) > 1",
        "any m.ranges < 0.3",
        "some(m.ranges < 0.3)",
        "dist(m.x, m.y, 0, 0) < 1",
        "distance(m.x, m.y) < 1",
        "yaw(m.topic, 0, 0, 1) < 1",
        "distance(m.x, m.y, 0, 0 < 1",
    ];
    insta::assert_snapshot!(texts.map(problem).join("\n"));
}

#[test]
fn distance_angle_and_yaw_are_those_of_geometry() {
    let is = |text: &str, parts: [f64; 4]| condition(text).holds(&pose(parts));
    assert!(is("distance(x, y, z, w) = 5", [1.0, 2.0, 4.0, 6.0]));
    assert!(
        is("distance(m.x, m.y, 0, 0) > 4.9e200 and distance(x, y, 0, 0) < 5.1e200", [3e200, -4e200, 0.0, 0.0]),
        "squares would overflow"
    );
    assert!(is("distance(x, y, 0, 0) > 1.7e308 or distance(x, y, 0, 0) != 0", [f64::MAX, f64::MAX, 0.0, 0.0]));
    assert!(!is("distance(x, y, 0, 0) > 0", [f64::MAX, f64::MAX, 0.0, 0.0]), "what is not finite has no value");
    for turns in -4..=4 {
        for degrees in 0..=180 {
            let (angle, turned) = (f64::from(degrees).to_radians(), f64::from(turns) * 2.0 * PI + 1.0);
            for (a, b) in [(turned, 1.0 + angle), (1.0 - angle, turned)] {
                let text =
                    format!("angle(x, y) <= {:?} and angle(x, y) >= {:?}", angle + 1e-12, (angle - 1e-12).max(0.0));
                assert!(is(&text, [a, b, 0.0, 0.0]), "{a} {b}");
            }
        }
    }
    // A rotation about z after one about x or y, whose yaw is the former for those below a right angle.
    for degrees in -179..180 {
        let half = f64::from(degrees).to_radians() / 2.0;
        for (tilt, size) in [(0.0, 1.0), (0.3, 1.0), (-0.7, 1e-200), (1.2, 1e200)] {
            let [s, c]: [f64; 2] = [libm::sin(half), libm::cos(half)];
            let [p, q] = [libm::sin(tilt / 2.0), libm::cos(tilt / 2.0)];
            let about_x = [c * p, s * p, s * q, c * q];
            let about_y = [-s * p, c * p, s * q, c * q];
            for parts in [about_x, about_y].map(|parts| parts.map(|part| part * size)) {
                let text = format!("angle(yaw(x, y, z, w), {degrees} deg) <= 1e-9 and yaw(x, y, z, w) < 3.1416");
                assert!(is(&text, parts), "{degrees}° {tilt} {size}");
            }
        }
    }
    let none = "yaw(x, y, z, w) < 9 or yaw(x, y, z, w) >= 9 or angle(yaw(x, y, z, w), 0) < 9";
    assert!(!is(none, [0.0; 4]), "no rotation");
    assert!(!is(none, [f64::INFINITY, 0.0, 0.0, 1.0]));
}
