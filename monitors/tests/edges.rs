//! Verdicts at the edges of numbers, fields and states: each was once wrong.

use std::fmt::Write;
use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, EventKind, FieldKind, Message, Monitor, Relation, Shape, Topology, Value};
use monitors::{EventAtom, Formula, FormulaError, MessageCondition, Outcome, ScopeMonitor, Term};

use crate::support::{Dice, event};

/// A channel from Ask to Arm whose messages have fields of one kind.
fn channel(names: &[&str], kind: &FieldKind) -> Arc<Topology> {
    let mut topology = Topology::default();
    let [ask, arm] = ["Ask", "Arm"].map(|name| topology.process(name).expect("a new process"));
    let shape = Shape::new(names.iter().map(|name| (*name, kind.clone())));
    topology.channel(ask, arm, Capacity::One, Domain::new([shape])).expect("a new channel");
    Arc::new(topology)
}

fn monitor(topology: &Arc<Topology>, formula: &str) -> ScopeMonitor {
    let text = format!("property p := {formula}");
    let file = monitors::load("p.scope", &text, topology, Duration::from_secs(1)).expect("the property is right");
    file.properties[0].scope_monitor().expect("it is made from a formula").clone()
}

/// The outcome of a property after a tick and messages with these values, one each, or one with all of them.
fn outcome(topology: &Arc<Topology>, formula: &str, messages: &[&[Value]]) -> Outcome {
    let mut monitor = monitor(topology, formula);
    monitor.observe(&event(0, 0, EventKind::Tick));
    let channel = topology.channels().next().expect("there is one");
    for (step, values) in messages.iter().enumerate() {
        let message = Message::new(values.iter().cloned());
        monitor.observe(&event(step as u64 + 1, 0, EventKind::Received { channel, message }));
    }
    monitor.outcome()
}

fn of_integers(formula: &str, numbers: &[i64]) -> Outcome {
    let messages: Vec<[Value; 1]> = numbers.iter().map(|number| [Value::Int(*number)]).collect();
    let messages: Vec<&[Value]> = messages.iter().map(|message| &message[..]).collect();
    outcome(&channel(&["n"], &FieldKind::Int), formula, &messages)
}

fn of_reals(formula: &str, number: f64) -> Outcome {
    outcome(&channel(&["j"], &FieldKind::Real), formula, &[&[Value::Real(number)]])
}

/// A property that these many fields are never all within bounds.
fn never_all_within(fields: usize) -> (Arc<Topology>, String) {
    let names: Vec<String> = (1..=fields).map(|field| format!("j{field}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut formula = "always not (Ask, Arm, true".to_owned();
    for (field, name) in names.iter().enumerate() {
        // Each bound differs, so that no two fields have the same regions.
        write!(formula, " and {name} > -2.{field:02} and {name} < 2.{field:02}").expect("a text grows");
    }
    (channel(&names, &FieldKind::Real), formula + ")")
}

#[test]
fn a_property_may_compare_any_number_of_fields() {
    for fields in [1, 7, 8, 40] {
        let (topology, formula) = never_all_within(fields);
        let inside = vec![Value::Real(0.0); fields];
        let mut outside = inside.clone();
        outside[fields - 1] = Value::Real(9.0);
        assert!(monitor(&topology, &formula).method().anticipates(), "{fields} fields");
        assert_eq!(outcome(&topology, &formula, &[&outside]), Outcome::Satisfied, "{fields} fields");
        assert_eq!(outcome(&topology, &formula, &[&outside, &inside]), Outcome::Violated, "{fields} fields");
    }
}

#[test]
fn neighbors_of_large_integers_are_different() {
    let beyond = "always not (Ask, Arm, n > 1000000000000000000)";
    assert_eq!(of_integers(beyond, &[9_000_000_000_000_000_000]), Outcome::Violated);
    let below = "eventually (Ask, Arm, n < 1700000000000000010)";
    assert_eq!(of_integers(below, &[5]), Outcome::Satisfied);
    assert_eq!(of_integers(below, &[1_700_000_000_000_000_010]), Outcome::Inconclusive);
    let other = "always (Ask, Arm, n != 9007199254740993)";
    assert_eq!(of_integers(other, &[9_007_199_254_740_992, 9_007_199_254_740_994]), Outcome::Satisfied);
    assert_eq!(of_integers(other, &[9_007_199_254_740_993]), Outcome::Violated);
    assert_eq!(of_integers("always (Ask, Arm, n <= 9223372036854775807)", &[i64::MAX]), Outcome::Satisfied);
    assert_eq!(of_integers("eventually (Ask, Arm, n < -9223372036854775807)", &[i64::MIN]), Outcome::Satisfied);
}

#[test]
fn remembered_integers_are_compared_exactly() {
    let same = "always ((Ask, Arm, n as p) implies next (Ask, Arm, n = p))";
    let stamp = 1_700_000_000_000_000_001;
    assert_eq!(of_integers(same, &[stamp, stamp]), Outcome::Inconclusive);
    assert_eq!(of_integers(same, &[stamp, stamp + 1]), Outcome::Violated);
}

#[test]
fn a_real_lies_between_any_two_constants() {
    let inside = "always not (Ask, Arm, -1e308 < j and j < 1e308)";
    assert_eq!(of_reals(inside, 0.0), Outcome::Violated);
    assert_eq!(of_reals(inside, f64::INFINITY), Outcome::Satisfied);
    assert_eq!(of_reals("eventually (Ask, Arm, j > 1.7976931348623157e308)", f64::INFINITY), Outcome::Satisfied);
    assert_eq!(of_reals("always (Ask, Arm, j != 9007199254740993)", 9_007_199_254_740_992.0), Outcome::Satisfied);
}

#[test]
fn an_event_that_simplifies_away_makes_no_states() {
    let topology = channel(&["n"], &FieldKind::Int);
    let channel = topology.channels().next().expect("there is one");
    let received = EventKind::Received { channel, message: Message::new([Value::Int(1)]) };
    let events = [event(0, 0, received), event(1, 0, EventKind::Tick)];
    for same in ["next true", "next ((Ask, Arm, n > 0) implies true)", "next (true or (Ask, Arm, n > 0))"] {
        let mut monitor = monitor(&topology, same);
        events.iter().for_each(|event| monitor.observe(event));
        assert_eq!(monitor.outcome(), Outcome::Inconclusive, "{same}");
        monitor.observe(&event(2, 1, EventKind::Tick));
        assert_eq!(monitor.outcome(), Outcome::Satisfied, "{same}");
    }
}

#[test]
fn an_antecedent_is_counted_after_the_verdict_is_settled() {
    let topology = channel(&["n"], &FieldKind::Int);
    for formula in [
        "always ((Ask, Arm, n > 5) implies once (Ask, Arm, n < 9))",
        "always ((Ask, Arm, n > 5) implies (Ask, Arm, n > 0))",
    ] {
        let mut monitor = monitor(&topology, formula);
        let channel = topology.channels().next().expect("there is one");
        let send = |monitor: &mut ScopeMonitor, step: u64, number: i64| {
            let message = Message::new([Value::Int(number)]);
            monitor.observe(&event(step, 0, EventKind::Received { channel, message }));
        };
        send(&mut monitor, 0, 3);
        assert_eq!(monitor.vacuous().len(), 1, "{formula}");
        assert_eq!(monitor.vacuous()[0].asked, 1);
        send(&mut monitor, 1, 7);
        assert_eq!((monitor.outcome(), monitor.vacuous().len()), (Outcome::Satisfied, 0), "{formula}");
    }
}

#[test]
fn too_many_combinations_are_told_and_make_no_verdict_wrong() {
    // Twenty fields that must not all be equal to different numbers: each pair is a condition of its own.
    let names: Vec<String> = (1..=20).map(|field| format!("f{field}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let topology = channel(&names, &FieldKind::Int);
    let events: Vec<String> = names.iter().map(|name| format!("(Ask, Arm, {name} = 1)")).collect();
    let text = format!("property p := always not ({})", events.join(" and "));
    let file = monitors::load("p.scope", &text, &topology, Duration::from_secs(1)).expect("the property is right");
    let warning = format!("{:?}", file.warnings.problems());
    assert!(warning.contains("too many combinations"), "{warning}");
    let (ones, mut other) = (vec![Value::Int(1); 20], vec![Value::Int(1); 20]);
    other[7] = Value::Int(2);
    let formula = text.trim_start_matches("property p := ");
    assert_eq!(outcome(&topology, formula, &[&other]), Outcome::Satisfied);
    assert_eq!(outcome(&topology, formula, &[&other, &ones]), Outcome::Violated);
}

#[test]
fn a_term_of_any_length_is_read_or_refused() {
    let topology = channel(&["n"], &FieldKind::Int);
    for (operands, is_read) in [(200, true), (12_000, false), (100_000, false)] {
        for operator in [" + ", " * "] {
            let term = vec!["n"; operands].join(operator);
            let text = format!("property p := always (Ask, Arm, {term} > {term})");
            let text = if operands == 200 { text.replacen(&format!("> {term}"), "> 5", 1) } else { text };
            let file = monitors::load("p.scope", &text, &topology, Duration::from_secs(1));
            assert_eq!(file.is_ok(), is_read, "{operands} operands");
        }
    }
}

/// Under a negation, the two events are parts of their own, and only one of them would see the new value.
#[test]
fn a_name_is_not_remembered_again_where_it_has_a_value() {
    let topology = channel(&["n"], &FieldKind::Int);
    let load = |formula: &str| {
        let text = format!("property p := {formula}");
        monitors::load("p.scope", &text, &topology, Duration::from_secs(1)).map_err(|error| format!("{error:?}"))
    };
    let event = |condition: &str| format!("(Ask, Arm, {condition})");
    let [named, below, other] = ["n as x", "n < x", "n as y"].map(event);
    let reported = load(&format!("always ({named} implies next ({named} or {below}))")).unwrap_err();
    assert!(reported.contains("two values named `x` are remembered at the same time"), "{reported}");
    assert!(load(&format!("always ({named} implies next ({other} or {below}))")).is_ok());
}

/// `previous` looks back any time; what is inside it looks back from there.
#[test]
fn a_window_inside_previous_ends_at_the_earlier_message() {
    let topology = channel(&["n"], &FieldKind::Int);
    let formula =
        "eventually ((Ask, Arm, n as p) and previous ((Ask, Arm, n < 0) or at most 0 (Ask, Arm, n > p) in 1))";
    let channel = topology.channels().next().expect("there is one");
    for (first, expected) in [(5, Outcome::Inconclusive), (2, Outcome::Satisfied)] {
        let mut monitor = monitor(&topology, formula);
        for (step, (tick, n)) in [(0, first), (0, 1), (9, 3)].into_iter().enumerate() {
            let message = Message::new([Value::Int(n)]);
            monitor.observe(&event(step as u64, tick, EventKind::Received { channel, message }));
        }
        assert_eq!(monitor.outcome(), expected, "{first}");
    }
}

/// Two channels, and a property that is violated by each message that makes `n > 0` true on the first one: from the
/// messages alone, without the operators that `becomes` stands for.
#[test]
fn what_becomes_true_is_found_at_each_edge_and_nowhere_else() {
    let mut topology = Topology::default();
    let [ask, arm, eye] = ["Ask", "Arm", "Eye"].map(|name| topology.process(name).expect("a new process"));
    for source in [ask, eye] {
        let domain = Domain::new([Shape::new([("n", FieldKind::Int)])]);
        topology.channel(source, arm, Capacity::One, domain).expect("a new channel");
    }
    let channels: Vec<_> = topology.channels().collect();
    let topology = Arc::new(topology);
    let mut dice = Dice(7);
    for _ in 0..2_000 {
        let mut alone = monitor(&topology, "always not becomes (Ask, Arm, n > 0)");
        let mut both = monitor(&topology, "always (becomes (Ask, Arm, n > 0) implies (Eye, Arm, n > 0))");
        let (mut was, mut eye, mut violated) = (false, false, [false; 2]);
        for step in 0..8 {
            let (channel, n) = (dice.roll(2) as usize, dice.roll(2) as i64);
            let message = Message::new([Value::Int(n)]);
            let received = event(step, 0, EventKind::Received { channel: channels[channel], message });
            if channel == 0 {
                let rises = n > 0 && !was;
                violated[0] |= rises;
                violated[1] |= rises && !eye;
                was = n > 0;
            } else {
                eye = n > 0;
            }
            for (monitor, violated) in [&mut alone, &mut both].into_iter().zip(violated) {
                monitor.observe(&received);
                assert_eq!(
                    monitor.outcome() == Outcome::Violated,
                    violated,
                    "{} at {step}",
                    monitor.formula().text(&topology)
                );
            }
        }
    }
}

#[test]
fn a_duration_is_refused_if_ticks_take_no_time() {
    let topology = channel(&["n"], &FieldKind::Int);
    let load =
        |text: &str| monitors::load("p.scope", text, &topology, Duration::ZERO).map(|file| file.properties.len());
    for formula in [
        "time_until (Ask, Arm, n > 0) < 3 s",
        "always at most 3 (Ask, Arm, n > 0) in 10 s",
        "always once[<= 10 s] (Ask, Arm, n > 0)",
    ] {
        let refused = load(&format!("property p := {formula}")).expect_err(formula);
        let reported = refused.problems()[0].to_string();
        assert_eq!(reported, "a duration cannot be counted in ticks that take no time", "{formula}");
    }
    // A log without ticks is judged by such properties.
    for text in [
        "property p := time_until (Ask, Arm, n > 0) < 3",
        "timed property p := time_until (Ask, Arm, n > 0) < 3 s",
        "property p := always (Ask, Arm, n > 0)",
    ] {
        assert_eq!(load(text).expect(text), 1);
    }
}

#[test]
fn a_formula_about_field_0_is_refused() {
    let topology = channel(&["n"], &FieldKind::Int);
    let channel = topology.channels().next().expect("there is one");
    let made = |condition: MessageCondition| {
        ScopeMonitor::new("p", Formula::Event(EventAtom { channel, condition }).always(), &topology).map(drop)
    };
    let (relation, value) = (Relation::Greater, Value::Int(0));
    let compared = |number: usize| MessageCondition::Compare { field: number.into(), relation, value: value.clone() };
    let related =
        MessageCondition::Relate { left: Term::Field(0_usize.into()), relation, right: Term::Value(value.clone()) };
    for condition in [compared(0), MessageCondition::Not(Box::new(compared(0))), related] {
        assert_eq!(made(condition), Err(FormulaError::NoSuchField));
    }
    assert_eq!(made(compared(1)), Ok(()));
}
