//! The messages about wrong files: snapshots of the rendered text.

use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, FieldKind, Shape, Topology};
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};

use crate::robot::topology;

fn render(diagnostic: &dyn Diagnostic) -> String {
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(120);
    let mut text = String::new();
    handler.render_report(&mut text, diagnostic).expect("writing to a string");
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// The problems or warnings of a file.
fn problems_of(text: &str) -> (usize, String) {
    match monitors::load("wrong.scope", text, &topology(), Duration::from_secs(1)) {
        Ok(file) => (0, if file.warnings.is_empty() { String::new() } else { render(&file.warnings) }),
        Err(error) => (error.problems().iter().filter(|problem| problem.is_error()).count(), render(&error)),
    }
}

#[test]
fn ten_mistakes_give_ten_diagnostics_each_with_its_location() {
    let text = r#"// Ten mistakes.
const limit := 20
propery p1 := always (BatteryReader, BatteryLevel, m[2] >= limit)
property p2 := alway (BatteryReader, BatteryLevel, m[2] >= limit)
property p3 := always (BateryReader, BatteryLevel, m[2] >= limit)
property p4 := always (BatteryLevel, Navigation, m[1] = <ok>)
property p5 := always (BatteryReader, BatteryLevel, m.charge >= 20)
property p6 := always (Navigation, GoToDestination, m[2] = <runing>)
property p7 := always (BatteryReader, BatteryLevel, m[1] >= 20)
property p8 := (BatteryReader, BatteryLevel, m[2] >= 20)
property p9 := always (BatteryReader, BatteryLevel, m[2] >= limt)
property p10 := time_until (BatteryReader, BatteryLevel, m[2] >= 20) = 2.5 s
"#;
    let (errors, reported) = problems_of(text);
    insta::assert_snapshot!(reported);
    assert_eq!(errors, 10);
}

#[test]
fn unreadable_text_is_reported_with_what_was_expected() {
    let text = r#"const a := 5 parsecs
const b := "without an end
const a = 3
property p := always ((BatteryReader, BatteryLevel, m[0] >= 20)
property q := always (BatteryReader BatteryLevel, m[1] = <ok>)
property r := always (BatteryReader, BatteryLevel, m[1] == <ok> && m[2] > 3)
property s := always (BatteryReader, BatteryLevel, always m[1] = <ok>)
property t := always not
property u := always (BatteryReader, BatteryLevel, m[1] = <ok>) always
property v := always (BatteryReader, BatteryLevel, m[1] = <ok>))
property w := always ((always (BatteryReader, BatteryLevel, m[1] = <ok>)
property x := time_until (BatteryReader, BatteryLevel, m[1] = <ok>)
# property y
"#;
    insta::assert_snapshot!(problems_of(text).1);
}

#[test]
fn a_file_in_another_language_is_one_mistake_that_names_the_language() {
    let files = [
        ("{\n  \"jani-version\": 1, \"name\": \"m\", \"properties\": [{\"name\": \"p\"}]\n}\n", "a JANI model"),
        ("[1, 2]", "JSON"),
        ("\n<?xml version=\"1.0\"?>\n<scxml initial=\"a\"><state id=\"a\"/></scxml>", "an SCXML machine"),
        ("<root/>", "XML"),
    ];
    for (text, language) in files {
        let (errors, reported) = problems_of(text);
        assert_eq!(errors, 1, "{reported}");
        assert!(reported.contains(&format!("this is {language}, not a file of SCOPE properties")), "{reported}");
        assert!(reported.contains("property NAME := always"), "{reported}");
    }
}

#[test]
fn operators_of_other_logics_are_refused_with_a_suggestion() {
    const FIRST: &str = "not, next, always, eventually, once, historically, previous, becomes, fresh, true";
    let q = "(BatteryReader, BatteryLevel, true)";
    let reported = |formula: &str| problems_of(&format!("property p := {formula}")).1;
    assert!(reported(&format!("sometime {q}")).contains(FIRST));
    assert!(reported(&format!("always (sometime {q})")).contains(FIRST));
    assert!(
        reported(&format!("always {q} while {q}")).contains("the binary operators: and, or, implies, until, since")
    );
    assert!(reported(&format!("always ({q} implise {q})")).contains("did you mean `implies`?"));
    assert!(reported(&format!("alwys {q}")).contains("did you mean `always`?"));
}

#[test]
fn operators_that_look_back_are_checked_too() {
    let text = r#"const few := 2.5
property a := once (BatteryReader, BatteryLevel, true)
property b := always once eventually (BatteryReader, BatteryLevel, true)
property c := always (once[5 s] (BatteryReader, BatteryLevel, true))
property d := always once[< 5 s (BatteryReader, BatteryLevel, true)
property e := always previous[= 2.5 s] (BatteryReader, BatteryLevel, true)
property f := always at most few (BatteryReader, BatteryLevel, true) in 10 s
property g := always at least -1 (BatteryReader, BatteryLevel, true) in 10
property h := always at most 3 (BatteryReader, BatteryLevel, true) within 10
property i := always at 3 (BatteryReader, BatteryLevel, true) in 10
property j := always at most 3 BatteryReader in 10
property k := always ((BatteryReader, BatteryLevel, true) since[< 3] time_until (BatteryReader, BatteryLevel, true) < 2)
property l := always fresh not (BatteryReader, BatteryLevel, true)
property m := fresh (BatteryReader, BatteryLevel, true)
"#;
    insta::assert_snapshot!(problems_of(text).1);
}

#[test]
fn values_and_times_are_checked_too() {
    let text = r#"const place := 3
property a := always ((BatteryReader, BatteryLevel, level as l) implies (BatteryReader, BatteryLevel, m[1] > l))
property b := always (BatteryReader, BatteryLevel, level + status < 3)
property c := always (BatteryReader, BatteryLevel, level + "x" < 3)
property d := always (BatteryReader, BatteryLevel, (level + 3 < 3)
property e := always ((BatteryReader, BatteryLevel, level as l) or (BatteryReader, BatteryLevel, level > l))
property f := always ((BatteryReader, BatteryLevel, true) implies time_until (BatteryReader, BatteryLevel, level > l) < 3)
property g := always (time_until (BatteryReader, BatteryLevel, level as l) < 3 implies time_until (BatteryReader, BatteryLevel, level > l) < 3)
property h := always ((BatteryReader, BatteryLevel, level as l) implies once (BatteryReader, BatteryLevel, level > l))
property i := always ((GoToDestination, Navigation, place as place) implies true)
property j := always ((BatteryReader, BatteryLevel, level as 3) implies true)
property k := always ((BatteryReader, BatteryLevel, level as l) and (BatteryReader, BatteryLevel, status as l) and (BatteryReader, BatteryLevel, level > l))
timed property l := always time_until (BatteryReader, BatteryLevel, true) < 3
timed const m := 3
property n := always (BatteryReader, BatteryLevel, level = status)
property o := always (BatteryReader, BatteryLevel, level < 9007199254740992.5)
"#;
    insta::assert_snapshot!(problems_of(text).1);
}

/// Five thousand mistakes give five thousand problems, and no more.
#[test]
fn many_mistakes_are_reported_once_each() {
    let wrong = |n: u32| format!("property p{n} := sometime (BatteryReader, BatteryLevel, true) and (a, b");
    let text: String = (0..5_000).map(|n| wrong(n) + "\n").collect();
    let error = monitors::load("wrong.scope", &text, &topology(), Duration::from_secs(1)).expect_err("it is wrong");
    assert_eq!(error.problems().len(), 5_000);
    let all = vec!["(BatteryReader, BatteryLevel, m[2] > 3)"; 20_000].join(" and ");
    let error = monitors::load("wrong.scope", &format!("property p := {all}"), &topology(), Duration::from_secs(1));
    assert_eq!(error.expect_err("no operator").problems().len(), 20_000);
}

#[test]
fn conditions_are_checked_against_the_channel() {
    let text = r#"const time := 30 s
property a := always (BatteryReader, BatteryLevel, m[3] = 5)
property b := always (BatteryReader, BatteryLevel, m[2] = true)
property c := always (BatteryReader, BatteryLevel, m[1] < <ok>)
property d := always (BatteryLevel, BatteryReader, m[2] < time)
property e := always time_until (BatteryReader, BatteryLevel, m[2] < time) < -3
property f := always time_until (BatteryReader, BatteryLevel, m[2] < 3) < 2.5
property g := always time_until (BatteryReader, BatteryLevel, m[2] < 3) < <soon>
property h := always (Navigation, BatteryReader, true)
property i := always (AtRechargingStation, Navigation, true)
property j := always (GoToDestination, Navigation, m[1] = <start>)
property j := always (GoToDestination, Navigation, always = <start>)
"#;
    insta::assert_snapshot!(problems_of(text).1);
}

#[test]
fn properties_that_can_never_fail_or_never_hold_cause_a_warning() {
    let text = r#"property valid := always ((BatteryReader, BatteryLevel, m[2] < 20) or not (BatteryReader, BatteryLevel, m[2] < 20))
property never := eventually false
property always_false := always false
property contradictory := always (BatteryReader, BatteryLevel, m[2] < 20 and m[2] > 30)
property large := always ((BatteryReader, BatteryLevel, m[2] < 20) implies
    time_until (BatteryReader, BatteryLevel, m[2] > 30) = 40 and
    time_until (Navigation, GoToDestination, m[2] = <running>) = 40)
property fine := always (BatteryReader, BatteryLevel, m[2] < 20)
"#;
    insta::assert_snapshot!(problems_of(text).1);
}

#[test]
fn at_least_0_messages_cause_a_warning() {
    for (count, is_told) in [
        ("at least 0", true),
        ("at least no", true),
        ("at least 1", false),
        ("at most 0", false),
        ("at most no", false),
    ] {
        let text = format!("const no := 0\nproperty p := always {count} (BatteryReader, BatteryLevel, true) in 10\n");
        let file = monitors::load("p.scope", &text, &topology(), Duration::from_secs(1)).expect("no mistakes");
        let mut problems = file.warnings.problems().iter();
        assert_eq!(problems.any(|problem| problem.message() == "`at least 0` always holds"), is_told, "{count}");
    }
}

#[test]
fn a_number_in_another_unit_than_that_of_the_field_causes_a_warning() {
    let warnings = |condition: &str| {
        let mut topology = Topology::default();
        let names = ["World", "BatteryReader", "Monitors"].map(|name| topology.process(name).expect("a new name"));
        let fields = |names: &[&str]| Domain::new([Shape::new(names.iter().map(|name| (*name, FieldKind::Real)))]);
        let of_world = fields(&["level_pct", "speed_mps", "yaw_deg", "m", "hall_slip_pct"]);
        topology.channel(names[0], names[2], Capacity::One, of_world).expect("a new channel");
        topology.channel(names[1], names[2], Capacity::One, fields(&["level", "depth"])).expect("a new channel");
        let text = format!("const low := 20 m\nconst share := 0.2\nproperty p := always ({condition})");
        let file = monitors::load("p.scope", &text, &Arc::new(topology), Duration::from_secs(1)).expect("no mistakes");
        let related = file.warnings.related().into_iter().flatten().map(ToString::to_string);
        related.collect::<Vec<_>>()
    };
    for (condition, found) in [
        ("World, Monitors, level_pct >= 20 m", "`20 m` is compared with `level_pct`, which is in %"),
        ("World, Monitors, m[1] >= 20 km/h", "`20 km/h` is compared with `level_pct`, which is in %"),
        ("World, Monitors, level_pct >= low", "`20 m` is compared with `level_pct`, which is in %"),
        ("World, Monitors, 20 m <= level_pct", "`20 m` is compared with `level_pct`, which is in %"),
        ("World, Monitors, speed_mps <= 2 rad/s", "`2 rad/s` is compared with `speed_mps`, which is in m/s"),
        ("World, Monitors, yaw_deg <= 90 deg", "`90 deg` is compared with `yaw_deg`, which is in deg"),
        ("BatteryReader, Monitors, level >= 20 m", "`20 m` is compared with `level`, which is in %"),
        ("BatteryReader, Monitors, level >= 0.2", "`level` is compared with 0.2 %, less than one percent"),
        ("World, Monitors, level_pct >= share", "`level_pct` is compared with 0.2 %, less than one percent"),
        ("World, Monitors, level_pct >= 0.2 %", "`level_pct` is compared with 0.2 %, less than one percent"),
    ] {
        assert_eq!(warnings(condition), [found], "{condition}");
    }
    for condition in [
        "World, Monitors, level_pct >= 20",
        "World, Monitors, level_pct >= 20 %",
        "World, Monitors, level_pct > 0 and level_pct < 1",
        "World, Monitors, hall_slip_pct < 0.5",
        "World, Monitors, speed_mps <= 0.2",
        "World, Monitors, speed_mps <= 3.6 km/h",
        "World, Monitors, yaw_deg <= 90",
        "World, Monitors, m <= 90 deg",
        "BatteryReader, Monitors, level >= 20 %",
        "BatteryReader, Monitors, depth >= 20 cm",
    ] {
        assert_eq!(warnings(condition), [""; 0], "{condition}");
    }
}

/// The message of each problem or warning, with what it is: `!` for a warning.
fn messages(constants: &str, condition: &str) -> Vec<String> {
    let text = format!("{constants}\nproperty p := always (BatteryReader, BatteryLevel, {condition})\n");
    let problems = match monitors::load("p.scope", &text, &topology(), Duration::from_secs(1)) {
        Ok(file) => file.warnings.problems().to_vec(),
        Err(error) => error.problems().to_vec(),
    };
    let message = |problem: &diagnostics::Problem| {
        let mark = if problem.is_error() { "" } else { "! " };
        format!("{mark}{}", problem.message())
    };
    // What follows from such a comparison is told, too.
    problems.iter().map(message).filter(|message| !message.contains(" can never be ")).collect()
}

#[test]
fn a_comparison_that_no_message_changes_is_told() {
    let (limit, level) = ("const limit := 20", "const level := 20");
    let hides = "! `level` is a constant here, and not the field of this name";
    for (constants, condition, expected) in [
        (limit, "level >= limit", vec![]),
        (limit, "20 <= level and m.level >= limit", vec![]),
        (limit, "level as l and 20 < l", vec![]),
        ("", "level >= 20 and level < 30", vec![]),
        (limit, "20 <= limit", vec!["! no field is compared here"]),
        (limit, "limit + 1 < 30 or level < 10", vec!["! no field is compared here"]),
        (limit, "level >= level", vec!["! a value is compared with itself"]),
        (limit, "m.level = level", vec!["! a value is compared with itself"]),
        (level, "20 <= level", vec!["`level` is a constant here, so no field is compared"]),
        (level, "level >= level", vec![hides]),
        (level, "m.level >= level", vec![hides]),
        (level, "m.level <= level + 1 and level <= m.level", vec!["! a value is compared with itself"]),
    ] {
        assert_eq!(messages(constants, condition), expected, "{constants} {condition}");
    }
}

#[test]
fn a_limit_that_is_shorter_than_a_tick_is_told() {
    let event = "(BatteryReader, BatteryLevel, level >= 20)";
    let warnings = |keyword: &str, bound: &str| {
        let text = format!("{keyword} p := always ({event} implies time_until {event} {bound})");
        let file = monitors::load("p.scope", &text, &topology(), Duration::from_secs(10)).unwrap();
        file.warnings.problems().iter().map(|problem| problem.message().to_owned()).collect::<Vec<_>>()
    };
    let less = "this is less than a tick, and there is one every 10s";
    assert!(warnings("property", "<= 500 ms").contains(&less.to_owned()));
    assert!(warnings("property", "< 9.9 s").contains(&less.to_owned()));
    for (keyword, bound) in [
        ("property", "< 10 s"),
        ("property", "<= 10 s"),
        ("property", "<= 0"),
        ("property", "> 500 ms"),
        ("timed property", "<= 500 ms"),
    ] {
        assert!(!warnings(keyword, bound).contains(&less.to_owned()), "{keyword} {bound}");
    }
}
