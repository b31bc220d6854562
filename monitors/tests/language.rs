//! The language: printed text reads back as the same tree, and the paper's formulas read as printed there.

use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, EventKind, FieldKind, Message, Monitor, Relation, Shape, Topology, Value};
use monitors::syntax::{
    ByteRange, Condition, ConditionKind, Constant, Constraint, ConstraintKind, Event, Field, FieldName, File, Interval,
    Item, Literal, Name, Operand, Party, PropertyItem, Term, parse_file,
};
use monitors::{Arithmetic, Formula, Function, Infix, MessageCondition, Outcome, Prefix, Unit};
use proptest::prelude::*;

use crate::cases::cases;
use crate::robot::topology;
use crate::support::{self, Dice, random_formula};

fn name() -> impl Strategy<Value = Name> {
    let text = prop_oneof![4 => "[A-Za-zθ_][A-Za-z0-9_é]{0,6}", 1 => "[ -~]{0,6}", 1 => Just("always".to_owned()), 1 => Just("since".to_owned())];
    text.prop_map(|text| Name { text, span: ByteRange::default() })
}

fn plain_name() -> impl Strategy<Value = Name> {
    "n_[A-Za-z0-9_]{0,5}".prop_map(|text| Name { text, span: ByteRange::default() })
}

fn literal() -> impl Strategy<Value = Literal> {
    let unit = prop_oneof![Just(Unit::Milliseconds), Just(Unit::Seconds), Just(Unit::Minutes), Just(Unit::Hours)];
    prop_oneof![
        "[a-zA-Z_][a-zA-Z0-9_-]{0,8}".prop_map(Literal::Symbol),
        any::<bool>().prop_map(Literal::Bool),
        any::<i64>().prop_map(Literal::Int),
        any::<f64>().prop_filter("finite", |real| real.is_finite()).prop_map(Literal::Real),
        "[ -~\n\t\\\\\"é]{0,8}".prop_map(Literal::Text),
        (unit, 0_u64..1_000_000).prop_map(|(unit, n)| Literal::Duration { nanos: n * (unit.nanos() / 1000), unit }),
    ]
}

fn operand() -> impl Strategy<Value = Operand> {
    prop_oneof![
        literal().prop_map(|literal| Operand::Literal(literal, ByteRange::default())),
        plain_name().prop_map(Operand::Constant)
    ]
}

fn relation() -> impl Strategy<Value = Relation> {
    use Relation::{Equal, Greater, GreaterOrEqual, Less, LessOrEqual, NotEqual};
    proptest::sample::select(vec![Equal, NotEqual, Less, LessOrEqual, Greater, GreaterOrEqual])
}

fn condition() -> impl Strategy<Value = Condition> {
    let of = |kind| Condition { kind, span: ByteRange::default() };
    let field = || {
        let name =
            prop_oneof![(1_usize..99).prop_map(FieldName::Number), name().prop_map(|name| FieldName::Named(name.text))];
        name.prop_map(|name| Field { name, span: ByteRange::default() })
    };
    let number = prop_oneof![
        (0_i64..1000).prop_map(|number| Operand::Literal(Literal::Int(number), ByteRange::default())),
        plain_name().prop_map(Operand::Constant)
    ];
    let term =
        prop_oneof![field().prop_map(Term::Field), number.prop_map(Term::Operand)].prop_recursive(3, 8, 2, |term| {
            let operator = proptest::sample::select(vec![
                Arithmetic::Add,
                Arithmetic::Subtract,
                Arithmetic::Multiply,
                Arithmetic::Divide,
            ]);
            let function = proptest::sample::select(Function::ALL.to_vec());
            let terms = proptest::collection::vec(term.clone(), 4);
            let call = (function, terms).prop_map(|(function, mut terms)| {
                terms.truncate(function.signature().1.len());
                Term::Call(function, terms, ByteRange::default())
            });
            let arithmetic = (term.clone(), operator, term)
                .prop_map(|(left, operator, right)| Term::Arithmetic(Box::new(left), operator, Box::new(right)));
            prop_oneof![3 => arithmetic, 1 => call]
        });
    let simple = (field(), relation(), operand()).prop_map(|(left, relation, right)| ConditionKind::Compare {
        left: Term::Field(left),
        relation,
        right: Term::Operand(right),
    });
    // A name that stands alone on the left reads as a field.
    let is_alone = |term: &Term| matches!(term, Term::Operand(Operand::Constant(_)));
    let left = term.clone().prop_filter("alone", move |left| !is_alone(left));
    let relate =
        (left, relation(), term).prop_map(|(left, relation, right)| ConditionKind::Compare { left, relation, right });
    let remember = (field(), name()).prop_map(|(field, name)| ConditionKind::Remember { field, name });
    let compare = prop_oneof![4 => simple, 2 => relate, 1 => remember];
    let leaf = prop_oneof![8 => compare, 1 => Just(ConditionKind::True), 1 => Just(ConditionKind::False)].prop_map(of);
    leaf.prop_recursive(4, 16, 3, move |part| {
        let parts = || proptest::collection::vec(part.clone(), 2..4);
        let count = (part.clone(), relation(), operand()).prop_map(move |(counted, relation, bound)| {
            let left = Term::Count(Box::new(counted), ByteRange::default());
            of(ConditionKind::Compare { left, relation, right: Term::Operand(bound) })
        });
        let items = (any::<bool>(), part.clone())
            .prop_map(move |(every, inside)| of(ConditionKind::Items { every, condition: Box::new(inside) }));
        prop_oneof![
            count,
            items,
            part.clone().prop_map(move |a| of(ConditionKind::Not(Box::new(a)))),
            parts().prop_map(move |parts| of(ConditionKind::And(parts))),
            parts().prop_map(move |parts| of(ConditionKind::Or(parts))),
            (part.clone(), part.clone()).prop_map(move |(a, b)| of(ConditionKind::Implies(Box::new(a), Box::new(b)))),
        ]
    })
}

fn event() -> impl Strategy<Value = Event> {
    let party = || prop_oneof![4 => name().prop_map(Party::Named), 1 => Just(Party::Any(ByteRange::default()))];
    (party(), party(), condition()).prop_map(|(source, target, condition)| Event {
        source,
        target,
        condition,
        span: ByteRange::default(),
    })
}

fn constraint() -> impl Strategy<Value = Constraint> {
    let of = |kind| Constraint { kind, span: ByteRange::default() };
    let timed = (event(), relation(), operand()).prop_map(|(event, relation, bound)| ConstraintKind::TimeUntil {
        event,
        relation,
        bound,
    });
    // Symbols are read only after a relation.
    let number = || {
        prop_oneof![
            any::<i64>().prop_map(|number| Operand::Literal(Literal::Int(number), ByteRange::default())),
            plain_name().prop_map(Operand::Constant)
        ]
    };
    let count = (any::<bool>(), number(), event(), number())
        .prop_map(|(is_at_most, count, event, bound)| ConstraintKind::Count { is_at_most, count, event, bound });
    let ago = || {
        let interval = (relation(), operand()).prop_map(|(relation, bound)| Interval { relation, bound });
        proptest::option::of(interval)
    };
    let leaf = prop_oneof![
        4 => event().prop_map(ConstraintKind::Event),
        1 => event().prop_map(ConstraintKind::Fresh),
        1 => count,
        3 => timed,
        1 => Just(ConstraintKind::True),
        1 => Just(ConstraintKind::False)
    ];
    leaf.prop_map(of).prop_recursive(5, 24, 3, move |part| {
        let parts = || proptest::collection::vec(part.clone(), 2..4);
        let prefixed = (prop::sample::select(&Prefix::ALL), ago(), part.clone()).prop_map(move |(operator, ago, a)| {
            of(ConstraintKind::Prefix(operator, ago.filter(|_| operator.takes_bound()), Box::new(a)))
        });
        let two = (part.clone(), part.clone());
        let infixed = (prop::sample::select(&Infix::ALL), ago(), two).prop_map(move |(operator, ago, (a, b))| {
            let ago = ago.filter(|_| operator.takes_bound());
            of(ConstraintKind::Infix(operator, ago, Box::new(a), Box::new(b)))
        });
        prop_oneof![
            8 => prefixed,
            3 => infixed,
            1 => parts().prop_map(move |parts| of(ConstraintKind::And(parts))),
            1 => parts().prop_map(move |parts| of(ConstraintKind::Or(parts))),
        ]
    })
}

pub(crate) fn file() -> impl Strategy<Value = File> {
    let constant = (plain_name(), literal())
        .prop_map(|(name, value)| Item::Constant(Constant { name, value, value_span: ByteRange::default() }));
    let property = (name(), any::<bool>(), constraint()).prop_map(|(name, is_timed, constraint)| {
        Item::Property(Box::new(PropertyItem { name, is_timed, constraint, span: ByteRange::default() }))
    });
    proptest::collection::vec(prop_oneof![constant, property], 0..4).prop_map(|items| File { items })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn printed_text_reads_back_as_the_same_tree(file in file()) {
        let text = file.to_string();
        let parsed = parse_file(&text);
        prop_assert!(parsed.problems.is_empty(), "{text}\n{:?}", parsed.problems);
        prop_assert_eq!(&parsed.file, &file, "{}", text);
    }

    #[test]
    fn parsing_any_text_terminates(text in "[ -~θ≤∧\n]{0,200}") {
        let _ = parse_file(&text);
    }

    #[test]
    fn parsing_any_keywords_terminates(words in proptest::collection::vec(proptest::sample::select(vec![
        "property", "const", ":=", "always", "(", ")", "[", "]", ",", "m", "1", "and", "or", "not", "until", "=", "<",
        "<ok>", "a", "B", "*", "becomes", "time_until", "implies", "next", "5 s", "\"x\"", "true", ";", ".",
    ]), 0..60)) {
        let _ = parse_file(&words.join(" "));
    }
}

fn formula(text: &str) -> Formula {
    let file = format!("const θ := 10\nproperty p := {text}");
    let formulas = monitors::formulas("test.scope", &file, &topology(), Duration::from_secs(1));
    formulas.unwrap_or_else(|error| panic!("{:?}", error.problems())).remove(0).1
}

fn same(a: &str, b: &str) {
    assert_eq!(formula(a), formula(b), "{a}\n{b}");
}

const E: &str = "(Navigation, GoToDestination, m[1] = <ok>)";

#[test]
fn phi1_is_read_as_the_paper_prints_it() {
    let phi1 = formula("always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 20)");
    let Formula::Always(body) = phi1 else { panic!("{phi1:?}") };
    let Formula::Event(event) = *body else { panic!("{body:?}") };
    let read = |level: f64| event.condition.holds(&Message::new([Value::symbol("ok"), Value::Real(level)]));
    assert_eq!([read(20.0), read(19.9)], [true, false]);
    assert!(event.condition.holds(&Message::new([Value::symbol("error"), "no sensor".into()])));
}

#[test]
fn phi2_is_read_as_the_paper_prints_it_even_without_its_last_parenthesis() {
    let printed = "always ( (Navigation, GoToDestination,
          m[1] = <ok> and m[2] = <running>) and
        (BatteryReader, BatteryLevel,
          m[1] = <ok> and m[2] <= 30)
        implies time_until (
           GotoRechargingStation, Navigation,
           m[1] = <start_navigation> and
           m[2] = <RechargingStation>) < θ";
    let closed = format!("{printed})");
    same(printed, &closed);
    let text = format!("const θ := 10\nproperty phi2 := {printed}");
    let file = monitors::load("phi2.scope", &text, &topology(), Duration::from_secs(1)).expect("only a warning");
    assert_eq!(file.warnings.problems().len(), 1);
    let Formula::Always(body) = formula(&closed) else { panic!("always") };
    assert!(matches!(*body, Formula::Implies(..)), "antecedent and consequence are both inside");
}

#[test]
fn printed_formulas_read_back_as_the_same_formula() {
    let topology = support::topology();
    for seed in 0..cases(4_000) {
        let mut dice = Dice(seed + 5_000_000);
        // Events are allowed only inside temporal operators.
        let formula = random_formula(&mut dice, &topology, 1 + seed as u32 % 4).always();
        let text = format!("property p := {}", formula.text(&topology));
        let read = monitors::formulas("p", &text, &topology, Duration::from_secs(1));
        let read = read.unwrap_or_else(|error| panic!("{text}\n{:?}", error.problems()));
        assert_eq!(read[0].1, formula, "{text}");
    }
}

#[test]
fn operators_bind_as_documented() {
    let [a, b, c] = ["<x>", "<y>", "<z>"].map(|_| format!("always {E}"));
    same(&format!("{a} and {b} or {c}"), &format!("({a} and {b}) or {c}"));
    same(&format!("{a} or {b} implies {c} implies {a}"), &format!("({a} or {b}) implies ({c} implies {a})"));
    same(&format!("not {a} until {b} and {c}"), &format!("((not {a}) until {b}) and {c}"));
    same(&format!("always {E} until {E}"), &format!("(always {E}) until {E}"));
    same(&format!("next not {E} until {E} until {E}"), &format!("(next (not {E})) until ({E} until {E})"));
}

#[test]
fn signs_and_words_are_equivalent() {
    same(&format!("□ (¬ {E} ∨ {E} ∧ {E} → ◇ {E})"), &format!("always (not {E} or {E} and {E} implies eventually {E})"));
    same(
        &format!("○ {E} ⇒ always (Navigation, GoToDestination, m[1] ≠ <ok>)"),
        &format!("next {E} -> always (Navigation, GoToDestination, m[1] != <ok>)"),
    );
    let level = |relation: &str| format!("always (BatteryReader, BatteryLevel, m[2] {relation} 3)");
    same(&level("≤"), &level("<="));
    same(&level("≥"), &level(">="));
}

#[test]
fn a_symbol_needs_no_spaces_around_it() {
    same("always (Navigation, GoToDestination, m[1]=<ok>)", &format!("always {E}"));
    same("always (Navigation,GoToDestination,m[1]=< ok >)", &format!("always {E}"));
    let level = "always (BatteryReader, BatteryLevel, m[2]<5 and m[2]>3)";
    same(level, "always (BatteryReader, BatteryLevel, m[2] < 5 and m[2] > 3)");
}

#[test]
fn fields_have_names_and_numbers() {
    let numbered = "always (BatteryReader, BatteryLevel, m[2] >= 20)";
    same("always (BatteryReader, BatteryLevel, m.level >= 20)", numbered);
    same("always (BatteryReader, BatteryLevel, level >= 20)", numbered);
}

/// A speaker that can be asked in four ways, and an action.
fn speaker() -> Topology {
    let mut topology = Topology::default();
    let [guide, speaker] = ["Guide", "Speaker"].map(|name| topology.process(name).expect("a new name"));
    let shape = |heads: &[&str], fields: &[(&str, FieldKind)]| {
        let heads =
            heads.iter().zip(["request", "what"]).map(|(head, name)| (name.to_owned(), FieldKind::symbols([head])));
        Shape::new(heads.chain(fields.iter().map(|(name, kind)| ((*name).to_owned(), kind.clone()))))
    };
    let shapes = [
        shape(&["say"], &[("text", FieldKind::Text)]),
        shape(&["volume"], &[("level", FieldKind::Int)]),
        shape(&["charge"], &[("percent", FieldKind::Int)]),
        shape(&["dim"], &[("lamp", FieldKind::Text), ("level", FieldKind::Real)]),
        shape(&["goal", "pick"], &[("thing", FieldKind::Text)]),
        shape(&["goal", "drive"], &[("place", FieldKind::Text)]),
        shape(&["beep"], &[("left", FieldKind::Bool)]),
        shape(&["beep"], &[("right", FieldKind::Bool)]),
    ];
    topology.channel(guide, speaker, Capacity::One, Domain::new(shapes)).expect("a new channel");
    topology
}

fn spoken(condition: &str) -> Result<Formula, monitors::ScopeError> {
    let text = format!("property p := eventually (Guide, Speaker, {condition})");
    monitors::formulas("p.scope", &text, &speaker(), Duration::from_secs(1)).map(|mut read| read.remove(0).1)
}

fn condition_of(formula: &Formula) -> &MessageCondition {
    let Formula::Eventually(inside) = formula else { panic!("it is `eventually`") };
    let Formula::Event(event) = &**inside else { panic!("an event") };
    &event.condition
}

/// Messages of all shapes, with values that the conditions below distinguish.
fn messages_to_speaker() -> impl Iterator<Item = Message> {
    let values = |kind: &FieldKind| match kind {
        FieldKind::Symbol(symbols) => symbols.iter().cloned().map(Value::Symbol).collect(),
        FieldKind::Bool => vec![true.into()],
        FieldKind::Int => [4, 5, 60].map(Value::Int).to_vec(),
        FieldKind::Real => [4.0, 5.0, 60.0].map(Value::Real).to_vec(),
        _ => ["hi", "cup", "red"].map(Value::from).to_vec(),
    };
    let topology = speaker();
    let domain = &topology.get(topology.channels().next().expect("one")).domain;
    let of_shape = |shape: &Shape| {
        shape.fields().iter().fold(vec![Vec::new()], |all, (_, kind)| {
            let longer = |one: &Vec<Value>| {
                let one = one.clone();
                values(kind).into_iter().map(move |value| one.iter().cloned().chain([value]).collect())
            };
            all.iter().flat_map(longer).collect::<Vec<Vec<Value>>>()
        })
    };
    domain.shapes().iter().flat_map(of_shape).map(Message::new).collect::<Vec<_>>().into_iter()
}

#[test]
fn a_field_with_a_name_is_compared_only_in_messages_that_have_it() {
    for (named, numbered) in [
        ("m.text = \"hi\"", "m[1] = <say> and m[2] = \"hi\""),
        ("m.percent >= 50", "m[1] = <charge> and m[2] >= 50"),
        ("m.level > 5", "m[1] = <volume> and m[2] > 5 or m[3] > 5"),
        ("m.level != 5", "not (m[1] = <volume> and m[2] = 5 or m[3] = 5)"),
        ("m.thing = \"cup\"", "m[2] = <pick> and m[3] = \"cup\""),
        ("lamp != \"red\" or request = <say>", "not (m[1] = <dim> and m[2] = \"red\") or m[1] = <say>"),
        ("m.percent as p", "m[1] = <charge> and m[2] as p"),
    ] {
        let formula = spoken(named).unwrap_or_else(|error| panic!("{named}: {error:?}"));
        let numbers = spoken(numbered).unwrap();
        for message in messages_to_speaker() {
            let judged = [&formula, &numbers].map(|formula| condition_of(formula).holds(&message));
            assert_eq!(judged[0], judged[1], "{named}, {message}");
        }
        // Each is printed as it was written, and reads back as the same formula.
        for (formula, written) in [(&formula, named), (&numbers, numbered)] {
            let text = formula.text(&speaker());
            let written = written.replace("lamp", "m.lamp").replace("request", "m.request");
            assert_eq!(text, format!("eventually (Guide, Speaker, {written})"));
            let text = format!("property p := {text}");
            let read = monitors::formulas("p", &text, &speaker(), Duration::from_secs(1)).unwrap();
            assert_eq!(read[0].1, *formula, "{text}");
        }
    }
    let formula = spoken("m.percent + 1 < m.percent * 2 or m.level != 5").unwrap();
    let reported = monitors::explain(&formula, &speaker());
    assert!(reported.ends_with("that `percent` + 1 is less than `percent` * 2 or `level` is not 5."), "{reported}");
}

/// The level is at the position of the reason.
#[test]
fn a_value_is_remembered_and_compared_only_in_messages_that_have_the_field() {
    let topology = Arc::new(topology());
    let ok = |level: f64| Message::new([Value::symbol("ok"), level.into()]);
    let error = || Message::new([Value::symbol("error"), "no reading".into()]);
    for (property, messages, is_satisfied) in [
        ("(E, level as l) implies next (E, level <= l)", vec![error(), ok(50.0), ok(49.0)], true),
        ("(E, level as l) implies next (E, level <= l)", vec![error(), ok(50.0), ok(51.0)], false),
        ("(E, level as l) implies next (E, level <= l)", vec![ok(50.0), error()], false),
        ("(E, level as l) implies next (E, level != l)", vec![ok(50.0), error()], true),
        ("(E, reason as l) implies next not (E, level = l)", vec![error(), error()], true),
        ("(E, reason as l) implies next (E, reason = l)", vec![error(), error()], true),
    ] {
        let text = property.replace("(E,", "(BatteryReader, BatteryLevel,");
        let text = format!("property p := always ({text})");
        let file = monitors::load("p.scope", &text, &topology, Duration::from_secs(1)).unwrap();
        let mut monitor = file.properties[0].scope_monitor().expect("made from a formula").clone();
        let channel = topology.find_channel("BatteryReader", "BatteryLevel").unwrap();
        for (step, message) in messages.iter().enumerate() {
            let kind = EventKind::Received { channel, message: message.clone() };
            monitor.observe(&crate::support::event(step as u64, 0, kind));
        }
        assert_eq!(monitor.outcome() != Outcome::Violated, is_satisfied, "{property}: {messages:?}");
    }
}

/// Without symbols, the types of values tell messages apart.
#[test]
fn fields_of_other_names_are_told_apart_by_their_types() {
    let mut topology = Topology::default();
    let [from, to] = ["A", "B"].map(|name| topology.process(name).expect("a new name"));
    let shapes = [
        Shape::new([("level", FieldKind::Real), ("extra", FieldKind::Bool)]),
        Shape::new([("note", FieldKind::Text)]),
        Shape::new([("count", FieldKind::Int)]),
        Shape::new([("total", FieldKind::Int), ("more", FieldKind::Text)]),
    ];
    topology.channel(from, to, Capacity::One, Domain::new(shapes)).expect("a new channel");
    let read = |condition: &str| {
        let text = format!("property p := eventually (A, B, {condition})");
        let formula = monitors::formulas("p", &text, &topology, Duration::from_secs(1)).unwrap().remove(0).1;
        assert_eq!(formula.text(&topology), format!("eventually (A, B, {condition})"));
        formula
    };
    let messages = [
        Message::new([1.0.into(), true.into()]),
        Message::new(["hi".into()]),
        Message::new([1.into()]),
        Message::new([1.into(), "hi".into()]),
    ];
    for (condition, holds) in [
        ("m.level as l", [true, false, false, false]),
        ("m.note as l", [false, true, false, false]),
        ("m.count as l", [false, false, true, false]),
        ("m.total + 1 = 2", [false, false, false, true]),
        ("m.level != m.level", [false, true, true, true]),
    ] {
        let formula = read(condition);
        assert_eq!([0, 1, 2, 3].map(|index| condition_of(&formula).holds(&messages[index])), holds, "{condition}");
    }
}

#[test]
fn a_field_whose_messages_no_symbol_distinguishes_is_refused() {
    let error = spoken("m.left = true").unwrap_err();
    assert_eq!(error.problems()[0].message(), "no symbol distinguishes the messages with this field from others");
    let error = spoken("m.levle > 5").unwrap_err();
    assert_eq!(error.problems()[0].message(), "messages from Guide to Speaker have no field `levle`");
    let error = spoken("m.level = <loud>").unwrap_err();
    assert_eq!(error.problems()[0].message(), "m.level cannot be compared with `<loud>`");
}

#[test]
fn both_ways_to_write_time_until_are_equivalent() {
    let e = "Navigation, GoToDestination, m[1] = <ok>";
    same(&format!("time_until(({e})) < 10"), &format!("time_until({e}) < θ"));
    same(&format!("time_until ({e}) < 10 ticks"), &format!("time_until ({e}) < 10"));
}

#[test]
fn durations_become_ticks_of_the_period() {
    let e = "(Navigation, GoToDestination, m[1] = <ok>)";
    let ticks = |bound: &str, period_ms: u64| {
        let text = format!("property p := time_until {e} {bound}");
        let formulas = monitors::formulas("t", &text, &topology(), Duration::from_millis(period_ms));
        match formulas.map(|mut formulas| formulas.remove(0).1) {
            Ok(Formula::TimeUntil { bound, .. }) => Some(bound.ticks),
            _ => None,
        }
    };
    assert_eq!(ticks("< 30 s", 1000), Some(30));
    assert_eq!(ticks("< 2.5 s", 1000), Some(3));
    assert_eq!(ticks(">= 2.5 s", 1000), Some(3));
    assert_eq!(ticks("<= 2.5 s", 1000), Some(2));
    assert_eq!(ticks("> 2.5 s", 1000), Some(2));
    assert_eq!(ticks("= 2.5 s", 1000), None);
    assert_eq!(ticks("!= 2.5 s", 1000), None);
    assert_eq!(ticks("= 2.5 s", 500), Some(5));
    assert_eq!(ticks("!= 1 min", 500), Some(120));
    assert_eq!(ticks("< 100 ms", 20), Some(5));
    assert_eq!(ticks("< 1.5 h", 1000), Some(5400));
}

#[test]
fn bounds_are_shown_as_the_property_writes_them() {
    let e = "(Navigation, GoToDestination, m[1] = <ok>)";
    for (timed, bound, length) in
        [("", "2.5 s", "2.5 s"), ("", "90 s", "90 s"), ("", "3 ticks", "3 ticks"), ("timed ", "90 s", "90 s")]
    {
        let text = format!("{timed}property p := time_until {e} <= {bound}");
        let formulas = monitors::formulas("t", &text, &topology(), Duration::from_secs(1)).expect("a property");
        let formula = &formulas[0].1;
        let shown = formula.text(&topology());
        assert!(shown.ends_with(&format!("<= {}", length.trim_end_matches(" ticks"))), "{shown}");
        let explained = monitors::explain(formula, &topology());
        assert!(explained.starts_with(&format!("Within {length}, ")), "{explained}");
    }
}

#[test]
fn a_comparison_needs_a_field_of_its_type() {
    let compare = |relation, value| MessageCondition::Compare { field: 2.into(), relation, value };
    let message = Message::new([Value::symbol("error"), "no sensor".into()]);
    use Relation::{Equal, Greater, GreaterOrEqual, Less, LessOrEqual, NotEqual};
    for relation in [Equal, Less, LessOrEqual, Greater, GreaterOrEqual] {
        assert!(!compare(relation, Value::Int(20)).holds(&message), "{relation}");
        assert!(!compare(relation, Value::Int(20)).holds(&Message::symbols(["ok"])), "{relation}");
    }
    assert!(compare(NotEqual, Value::Int(20)).holds(&message));
    assert!(compare(NotEqual, Value::Int(20)).holds(&Message::symbols(["ok"])));
    assert!(!compare(NotEqual, Value::Int(20)).holds(&Message::new([Value::symbol("ok"), Value::Real(20.0)])));
    assert!(compare(LessOrEqual, Value::Int(20)).holds(&Message::new([Value::symbol("ok"), Value::Real(20.0)])));
}

#[test]
fn the_shipped_files_load() {
    for (name, text) in monitors::SHIPPED {
        let file = monitors::load(name, text, &topology(), Duration::from_secs(1));
        let file = file.unwrap_or_else(|error| panic!("{:?}", error.problems()));
        assert!(file.warnings.is_empty(), "{:?}", file.warnings.problems());
        assert_eq!(file.properties.len(), 1);
        assert_eq!(file.properties[0].name, name);
        let printed = format!("property again := {}", file.properties[0].formula).replace("theta", "10");
        assert!(monitors::load(name, &printed, &topology(), Duration::from_secs(1)).is_ok(), "{printed}");
    }
}

#[test]
fn a_file_may_begin_with_a_byte_order_mark() {
    let text = "// with one\nproperty p := always (BatteryReader, BatteryLevel, level > 20)\n";
    let loaded = |text: &str| monitors::load("p.scope", text, &topology(), Duration::from_secs(1)).unwrap();
    let [plain, marked] = [loaded(text), loaded(&format!("\u{FEFF}{text}"))];
    assert_eq!(plain.properties[0].formula, marked.properties[0].formula);
}

#[test]
fn what_becomes_holds_now_and_did_not_the_last_time() {
    same(&format!("always (becomes {E} implies {E})"), &format!("always ({E} and not previous {E} implies {E})"));
    let shown = formula(&format!("always not becomes {E}")).text(&topology());
    assert!(shown.starts_with("always not becomes (Navigation, "), "{shown}");
    let problem = |text: &str| {
        let file = format!("property p := always {text}");
        let error = monitors::formulas("t", &file, &topology(), Duration::from_secs(1)).unwrap_err();
        error.problems()[0].message().to_owned()
    };
    assert!(problem(&format!("becomes next {E}")).starts_with("`next` looks ahead"));
    let remembers = "(BatteryReader, BatteryLevel, m[2] as l)";
    assert_eq!(problem(&format!("becomes {remembers}")), "`l` cannot be remembered here");
}

#[test]
fn a_star_stands_for_every_process_whose_messages_the_condition_can_be_about() {
    let topology = topology();
    let requests = "(GoToDestination, Navigation, true) or (GotoRechargingStation, Navigation, true)";
    same("always not (*, Navigation, true)", &format!("always not ({requests})"));
    let awaited = "time_until (GoToDestination, Navigation, true) < 3 or time_until (GotoRechargingStation, Navigation, true) < 3";
    same(
        &format!("always ({E} implies time_until (*, Navigation, true) < 3)"),
        &format!("always ({E} implies {awaited})"),
    );
    // Only these messages have a level.
    same("always (*, *, m.level >= 20)", "always (BatteryReader, BatteryLevel, m.level >= 20)");
    same(
        "always (Navigation, *, m[1] = <ok>) ",
        "always ((Navigation, GoToDestination, m[1] = <ok>) or (Navigation, GotoRechargingStation, m[1] = <ok>))",
    );
    let problem = |text: &str| {
        let file = format!("property p := always {text}");
        let error = monitors::formulas("t", &file, &topology, Duration::from_secs(1)).unwrap_err();
        assert_eq!(error.problems().len(), 1, "{error:?}");
        error.problems()[0].message().to_owned()
    };
    assert_eq!(problem("(*, BatteryLevl, true)"), "unknown process `BatteryLevl`");
    assert!(problem("(BatteryReader, *, m.levle < 2)").contains("have no field `levle`"));
    assert_eq!(problem("(TickGenerator, Navigation, true)"), "there is no channel from TickGenerator to Navigation");
    assert_eq!(problem("at most 2 (*, Navigation, true) in 5"), "messages can be counted on one channel only");
}

#[test]
fn a_number_with_a_unit_stays_a_number_but_is_no_bound() {
    same(
        "always (BatteryReader, BatteryLevel, m.level >= 20 %)",
        "always (BatteryReader, BatteryLevel, m.level >= 20.0)",
    );
    let level = |condition: &str| format!("always (BatteryReader, BatteryLevel, {condition})");
    same(&level("level < 36 km/h and level / 2 < 30 cm"), &level("level < 10.0 and level / 2 < 0.3"));
    let problem = |bound: &str| {
        let file = format!("const near := 5 m\nproperty p := always time_until {E} < {bound}");
        let error = monitors::formulas("t", &file, &topology(), Duration::from_secs(1)).unwrap_err();
        error.problems()[0].message().to_owned()
    };
    for bound in ["5 m", "near", "5 %"] {
        assert_eq!(problem(bound), "a bound is a whole number of ticks or a duration", "{bound}");
    }
    assert_eq!(problem("5 m / s"), "a bound is a whole number of ticks or a duration");
    assert_eq!(problem("5 furlongs"), "unknown unit `furlongs`");
    assert_eq!(problem("5 m/min"), "unknown unit `m/min`");
}
