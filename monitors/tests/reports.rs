//! The explanations of monitors: witnesses, open obligations, vacuity, plain English, and exported graphs.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use channels::{Event, EventKind, Message, Topology, Value, Verdict};
use monitors::{Choice, Format, Formula, Method, Outcome, Property, SHIPPED, ScopeMonitor, explain, scope_monitor};

use crate::robot::topology;

/// A property over the robot's channels, with its monitor.
struct Watch {
    topology: Arc<Topology>,
    property: Property,
    step: u64,
    tick: u64,
}

impl Watch {
    fn new(formula: &str) -> Self {
        Self::of(&format!("property p := {formula}"))
    }

    fn of(text: &str) -> Self {
        let topology = topology();
        let file = monitors::load("p.scope", text, &topology, Duration::from_secs(1));
        let property = file.unwrap_or_else(|error| panic!("{:?}", error.problems())).properties.remove(0);
        Self { topology, property, step: 0, tick: 0 }
    }

    fn shipped(name: &str) -> Self {
        let topology = topology();
        let (_, text) = SHIPPED.into_iter().find(|(known, _)| *known == name).expect("shipped");
        let file = monitors::load(name, text, &topology, Duration::from_secs(1)).expect("it loads");
        let property = file.properties.into_iter().next().expect("one property");
        Self { topology, property, step: 0, tick: 0 }
    }

    fn monitor(&self) -> &ScopeMonitor {
        scope_monitor(self.property.monitor.as_ref()).expect("made from text")
    }

    fn show(&mut self, kind: EventKind) -> Verdict {
        let time = Duration::from_millis(self.tick * 1000 + self.step);
        self.property.monitor.observe(&Event { step: self.step, tick: self.tick, time, kind });
        self.property.monitor.verdict()
    }

    fn tick(&mut self) -> Verdict {
        self.tick += 1;
        self.show(EventKind::Tick)
    }

    fn see(&mut self, source: &str, target: &str, message: Message) -> Verdict {
        self.step += 1;
        let channel = self.topology.find_channel(source, target).expect("a channel of the robot");
        self.show(EventKind::Received { channel, message })
    }

    fn level(&mut self, level: f64) -> Verdict {
        self.see("BatteryReader", "BatteryLevel", Message::new([Value::symbol("ok"), level.into()]))
    }

    fn running(&mut self) -> Verdict {
        self.see("Navigation", "GoToDestination", Message::symbols(["ok", "running"]))
    }

    fn start(&mut self) -> Verdict {
        let message = Message::symbols(["start_navigation", "RechargingStation"]);
        self.see("GotoRechargingStation", "Navigation", message)
    }
}

#[test]
fn a_safety_violation_names_the_message() {
    let mut watch = Watch::shipped("phi1");
    watch.tick();
    assert_eq!(watch.level(20.0), Verdict::Inconclusive);
    assert_eq!(watch.property.monitor.location(), "idle");
    assert_eq!(watch.level(19.0), Verdict::False);
    assert_eq!(watch.property.monitor.location(), "failure");
    insta::assert_snapshot!(watch.monitor().witness().unwrap());
}

#[test]
fn a_missed_deadline_names_the_antecedent_and_what_was_missing() {
    let mut watch = Watch::shipped("phi2");
    watch.tick();
    watch.running();
    watch.level(30.0);
    assert_eq!(watch.property.monitor.location(), "C2");
    watch.tick();
    // Only the oldest obligation matters.
    watch.level(25.0);
    assert_eq!(watch.monitor().outcome(), Outcome::Inconclusive);
    let open = watch.monitor().open_obligations();
    assert_eq!((open.len(), open[0].since.map(|since| since.step), open[0].until_tick), (1, Some(2), Some(10)));
    insta::assert_snapshot!(open[0]);
    for _ in 3..=10 {
        assert_eq!(watch.tick(), Verdict::Inconclusive);
    }
    assert_eq!(watch.tick(), Verdict::False);
    assert_eq!(watch.property.monitor.location(), "Err");
    let witness = watch.monitor().witness().unwrap();
    assert_eq!((witness.settled.tick, witness.deadline_tick, witness.messages.len()), (11, Some(10), 2));
    insta::assert_snapshot!(witness);
    // Nothing changes a final verdict.
    assert_eq!(watch.start(), Verdict::False);
}

#[test]
fn an_answer_in_time_ends_the_obligation() {
    let mut watch = Watch::shipped("phi2");
    watch.tick();
    watch.running();
    watch.level(12.0);
    for _ in 1..10 {
        watch.tick();
    }
    assert_eq!(watch.start(), Verdict::Inconclusive);
    assert_eq!(watch.monitor().outcome(), Outcome::Satisfied);
    assert!(watch.monitor().open_obligations().is_empty() && watch.monitor().witness().is_none());
    for _ in 0..30 {
        assert_eq!(watch.tick(), Verdict::Inconclusive);
    }
    // A message on a channel of the antecedent triggers another check: the last messages still count.
    watch.level(11.0);
    assert_eq!(watch.monitor().outcome(), Outcome::Inconclusive);
}

/// The end of a run that is final decides what has no deadline, unless an alternative with a deadline can still meet
/// it.
#[test]
fn what_a_deadline_can_still_meet_has_a_deadline() {
    let [x, y] = ["(BatteryReader, BatteryLevel, level < 5)", "(Navigation, GoToDestination, m[2] = <failure>)"];
    let high = "(BatteryReader, BatteryLevel, level > 50)";
    let soon = format!("time_until {y} < 3");
    for (property, before, after) in [
        (format!("eventually {x} or {soon}"), &[true][..], &[false][..]),
        (format!("timed property q := eventually {x} or {soon} s"), &[true], &[false]),
        (format!("always ({high} implies eventually {x} or {soon})"), &[true], &[false]),
        (format!("eventually ({high} and {soon})"), &[true], &[false]),
        (format!("eventually {x} or time_until {y} >= 3"), &[false], &[false]),
        (format!("always ({high} implies eventually {x})"), &[false], &[false]),
    ] {
        let mut watch = match property.strip_prefix("timed property q := ") {
            Some(formula) => Watch::timed(formula),
            None => Watch::new(&property),
        };
        let owed =
            |watch: &Watch| watch.monitor().open_obligations().iter().map(|owed| owed.has_deadline).collect::<Vec<_>>();
        watch.tick();
        watch.level(80.0);
        assert_eq!(owed(&watch), before, "{property}");
        for _ in 0..3 {
            watch.tick();
        }
        assert_eq!(owed(&watch), after, "{property}");
    }
    let mut both = Watch::new(&format!("eventually {x} and {soon}"));
    both.tick();
    let open = both.monitor().open_obligations();
    assert!(open.len() == 2 && open.iter().any(|owed| !owed.has_deadline), "{open:?}");
}

#[test]
fn being_at_the_station_satisfies_the_variant() {
    let mut watch = Watch::shipped("phi2_or_there");
    watch.running();
    watch.level(12.0);
    assert_eq!(watch.monitor().outcome(), Outcome::Inconclusive);
    watch.see("Localization", "AtRechargingStation", Message::new([Value::symbol("ok"), true.into()]));
    assert_eq!(watch.monitor().outcome(), Outcome::Satisfied);
}

#[test]
fn a_ban_is_violated_by_the_banned_message() {
    let start = "(GotoRechargingStation, Navigation, m[1] = <start_navigation>)";
    let low = "(BatteryReader, BatteryLevel, m[2] < 20)";
    let mut watch = Watch::new(&format!("always ({low} implies not time_until {start} < 3)"));
    watch.level(10.0);
    watch.tick();
    watch.tick();
    watch.tick();
    assert_eq!(watch.start(), Verdict::Inconclusive);
    watch.level(10.0);
    watch.tick();
    assert_eq!(watch.start(), Verdict::False);
    insta::assert_snapshot!(watch.monitor().witness().unwrap());
}

#[test]
fn other_kinds_of_formulas_have_witnesses_too() {
    let low = "(BatteryReader, BatteryLevel, m[2] < 20)";
    let running = "(Navigation, GoToDestination, m[2] = <running>)";
    let mut watch = Watch::new(&format!("always ({low} implies not {running} until {low} and eventually {running})"));
    watch.level(10.0);
    assert_eq!(watch.running(), Verdict::Inconclusive);
    let mut watch = Watch::new(&format!("{running} until {low}"));
    assert_eq!(watch.monitor().outcome(), Outcome::Inconclusive);
    watch.running();
    assert_eq!(watch.monitor().open_obligations().len(), 1);
    insta::assert_snapshot!(watch.monitor().open_obligations()[0]);
    assert_eq!(watch.see("Navigation", "GoToDestination", Message::symbols(["ok", "idle"])), Verdict::False);
    insta::assert_snapshot!(watch.monitor().witness().unwrap());
}

/// Two clauses with deadlines, monitored together by one automaton.
const TWO_ANSWERS: &str = "
    always ((BatteryReader, BatteryLevel, m[2] < 20)
        implies time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation>) < 3)
    and always ((Localization, AtRechargingStation, m[2] = true)
        implies time_until (BatteryReader, BatteryLevel, m[2] > 50) < 5)";

#[test]
fn the_violated_one_of_several_clauses_is_named() {
    let mut watch = Watch::new(TWO_ANSWERS);
    assert!(matches!(watch.monitor().method(), Method::Automaton { .. }));
    watch.tick();
    watch.see("Localization", "AtRechargingStation", Message::new([Value::symbol("ok"), true.into()]));
    watch.tick();
    watch.level(10.0);
    assert_eq!(watch.monitor().open_obligations().len(), 2);
    watch.tick();
    assert_eq!(watch.start(), Verdict::Inconclusive);
    watch.tick();
    watch.tick();
    assert_eq!(watch.tick(), Verdict::False);
    let witness = watch.monitor().witness().unwrap();
    assert_eq!((witness.since.unwrap().tick, witness.deadline_tick, witness.settled.tick), (1, Some(5), 6));
    insta::assert_snapshot!(witness);
}

#[test]
fn contradicting_obligations_are_named_together() {
    let low = "(BatteryReader, BatteryLevel, m[2] < 20)";
    let start = "(GotoRechargingStation, Navigation, m[1] = <start_navigation>)";
    let there = "(Localization, AtRechargingStation, m[2] = true)";
    let mut watch = Watch::new(&format!(
        "always ({low} implies time_until {start} < 3) and always ({there} implies not time_until {start} < 9)"
    ));
    watch.tick();
    watch.level(10.0);
    watch.tick();
    // Before the deadline: whatever comes now, one of the two clauses is violated.
    let at = Message::new([Value::symbol("ok"), true.into()]);
    assert_eq!(watch.see("Localization", "AtRechargingStation", at), Verdict::False);
    let witness = watch.monitor().witness().unwrap();
    assert_eq!((witness.messages.len(), witness.deadline_tick), (2, Some(3)));
    insta::assert_snapshot!(witness);
}

/// The other half of the reason is a clause that demands nothing now. Unrelated clauses are not named.
#[test]
fn a_permanent_ban_is_named_with_the_obligation_that_it_blocks() {
    let low = "(BatteryReader, BatteryLevel, m[2] < 20)";
    let start = "(GotoRechargingStation, Navigation, m[1] = <start_navigation>)";
    let there = "(Localization, AtRechargingStation, m[2] = true)";
    let mut watch = Watch::new(&format!(
        "always ({low} implies time_until {start} < 3) and always (not {start}) and always {there}"
    ));
    watch.tick();
    assert_eq!(watch.level(10.0), Verdict::False);
    let witness = watch.monitor().witness().unwrap();
    assert_eq!(witness.clause, format!("({low} implies time_until {start} < 3) and not {start}"));
    assert_eq!((witness.messages.len(), witness.deadline_tick), (1, Some(3)));
}

#[test]
fn a_formula_that_no_run_satisfies_is_violated_in_the_first_state() {
    for formula in ["eventually false", "always (Navigation, GoToDestination, true) until false", "always false"] {
        let mut watch = Watch::new(formula);
        assert_eq!(watch.tick(), Verdict::False, "{formula}");
        let witness = watch.monitor().witness().unwrap();
        assert_eq!((witness.clause.as_str(), witness.settled.tick), (formula, 1));
    }
}

#[test]
fn an_obligation_due_after_some_time_is_due_eventually() {
    let level = "(BatteryReader, BatteryLevel, m[2] < 20)";
    let running = "(Navigation, GoToDestination, m[2] = <running>)";
    let mut watch = Watch::new(&format!("always ({running} implies time_until {level} >= 2)"));
    let owed = |watch: &Watch| watch.monitor().open_obligations()[0].what.clone();
    watch.tick();
    watch.running();
    assert_eq!(owed(&watch), format!("time_until {level} >= 2"));
    watch.tick();
    watch.tick();
    assert_eq!(owed(&watch), format!("eventually {level}"));
    let mut watch = Watch::new(&format!("always ({running} implies next {level} and time_until {level} <= 2)"));
    watch.tick();
    watch.running();
    let open = watch.monitor().open_obligations();
    let open: Vec<&str> = open.iter().map(|open| open.what.as_str()).collect();
    assert_eq!(open, [format!("next {level}"), format!("time_until {level} <= 2")]);
}

#[test]
fn a_missed_moment_is_named_by_every_monitor() {
    let answer = "time_until (BatteryReader, BatteryLevel, m[2] > 50) =";
    for (ticks, anticipates) in [(3, true), (40, false)] {
        let mut watch =
            Watch::new(&format!("always ((Navigation, GoToDestination, m[2] = <running>) implies {answer} {ticks})"));
        assert_eq!(watch.monitor().method().anticipates(), anticipates);
        watch.tick();
        watch.tick();
        watch.running();
        for _ in 2..ticks + 2 {
            assert_eq!(watch.tick(), Verdict::Inconclusive);
            watch.level(10.0);
        }
        assert_eq!(watch.tick(), Verdict::False);
        let witness = watch.monitor().witness().unwrap();
        assert_eq!((witness.since.unwrap().tick, witness.deadline_tick), (2, Some(ticks + 2)));
        assert_eq!(witness.missing.as_deref(), Some("(BatteryReader, BatteryLevel, m[2] > 50)"));
        assert_eq!(witness.messages[0].message, Message::symbols(["ok", "running"]));
    }
}

#[test]
fn an_antecedent_that_never_held_is_reported_clause_by_clause() {
    let mut watch = Watch::shipped("phi2");
    watch.level(80.0);
    watch.running();
    let vacuous = watch.monitor().vacuous();
    assert_eq!((vacuous.len(), vacuous[0].asked), (1, 2));
    assert!(vacuous[0].antecedent.contains("m[2] <= 30"), "{}", vacuous[0].antecedent);
    watch.level(10.0);
    assert!(watch.monitor().vacuous().is_empty());

    let mut watch = Watch::shipped("phi1");
    watch.see("BatteryReader", "BatteryLevel", Message::new([Value::symbol("error"), "no sensor".into()]));
    assert_eq!(watch.monitor().vacuous()[0].antecedent, "(BatteryReader, BatteryLevel, m[1] = <ok>)");
    watch.level(80.0);
    assert!(watch.monitor().vacuous().is_empty());
}

const RECENTLY_LOW: &str = "always ((GotoRechargingStation, Navigation, m[1] = <start_navigation>)
    implies once[<= 3 s] (BatteryReader, BatteryLevel, level < 30))";
const NEVER_MORE: &str = "always at most 2 (GotoRechargingStation, Navigation, m[1] = <start_navigation>) in 10 s";

#[test]
fn what_did_not_happen_earlier_is_named() {
    let mut watch = Watch::new(RECENTLY_LOW);
    assert!(matches!(watch.monitor().method(), Method::Automaton { .. }), "{:?}", watch.monitor().method());
    watch.tick();
    watch.level(25.0);
    assert_eq!(watch.start(), Verdict::Inconclusive);
    for _ in 0..4 {
        watch.tick();
    }
    assert_eq!(watch.start(), Verdict::False);
    insta::assert_snapshot!(watch.monitor().witness().unwrap());
    let mut watch = Watch::new(NEVER_MORE);
    watch.tick();
    watch.start();
    watch.start();
    assert_eq!(watch.start(), Verdict::False);
    insta::assert_snapshot!(watch.monitor().witness().unwrap());
}

#[test]
fn a_past_event_that_never_happened_is_reported() {
    let low = "(BatteryReader, BatteryLevel, level < 30)";
    let mut watch = Watch::new(&format!("always (once {low} implies (Navigation, GoToDestination, m[2] = <running>))"));
    watch.tick();
    watch.level(50.0);
    watch.running();
    let vacuous = watch.monitor().vacuous();
    let reported: Vec<_> = vacuous.iter().map(|found| (found.antecedent.as_str(), found.asked)).collect();
    assert_eq!(reported, [("once (BatteryReader, BatteryLevel, m.level < 30)", 1)]);
}

#[test]
fn a_property_with_a_long_memory_of_the_past_is_monitored_without_an_automaton() {
    let long = RECENTLY_LOW.replace("3 s", "10 h");
    let mut watch = Watch::new(&long);
    assert_eq!(watch.monitor().method(), Method::Rules);
    assert!(watch.monitor().method().is_prompt() && watch.monitor().export(Format::Dot).is_none());
    watch.tick();
    watch.level(25.0);
    watch.tick += 36_000;
    assert_eq!(watch.start(), Verdict::Inconclusive);
    watch.tick();
    assert_eq!(watch.start(), Verdict::False);
}

const SAME_PLACE: &str = "always ((GoToDestination, Navigation, m[1] = <start_navigation> and place as p)
    implies time_until (GoToDestination, Navigation, m[1] = <get_status> and place = p) < 5 s)";

impl Watch {
    fn timed(formula: &str) -> Self {
        let topology = topology();
        let text = format!("timed property p := {formula}");
        let file = monitors::load("p.scope", &text, &topology, Duration::from_secs(1));
        let property = file.unwrap_or_else(|error| panic!("{:?}", error.problems())).properties.remove(0);
        Self { topology, property, step: 0, tick: 0 }
    }

    fn go(&mut self, request: &str, place: &str) -> Verdict {
        self.see("GoToDestination", "Navigation", Message::symbols([request, place]))
    }
}

#[test]
fn each_remembered_value_is_awaited_separately() {
    let mut watch = Watch::new(SAME_PLACE);
    assert!(watch.monitor().method() == Method::Rules && watch.monitor().export(Format::Dot).is_none());
    watch.tick();
    watch.go("start_navigation", "Destination");
    watch.tick();
    watch.go("start_navigation", "RechargingStation");
    assert_eq!(watch.go("get_status", "Destination"), Verdict::Inconclusive);
    let open = watch.monitor().open_obligations();
    insta::assert_snapshot!(open.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"));
    for _ in 0..4 {
        assert_eq!(watch.tick(), Verdict::Inconclusive);
    }
    assert_eq!(watch.tick(), Verdict::False);
    insta::assert_snapshot!(watch.monitor().witness().unwrap());
}

#[test]
fn the_same_values_remembered_twice_are_one_state() {
    let text =
        "always ((BatteryReader, BatteryLevel, level as l) implies next (BatteryReader, BatteryLevel, level <= l))";
    let mut watches = [Watch::new(text), Watch::new(text), Watch::new(text)];
    for (watch, levels) in watches.iter_mut().zip([[9.0, 8.0, 7.0], [50.0, 8.0, 7.0], [9.0, 8.0, 6.0]]) {
        watch.tick();
        for level in levels {
            assert_eq!(watch.level(level), Verdict::Inconclusive);
        }
        watch.property.monitor.normalize().expect("it has a normal form");
    }
    let [first, same, other] = &watches;
    assert!(first.property.monitor.same_state(same.property.monitor.as_ref()));
    assert!(!first.property.monitor.same_state(other.property.monitor.as_ref()));
    assert_eq!(watches[2].level(6.5), Verdict::False);
    for text in [
        "always ((BatteryReader, BatteryLevel, level as l) implies previous (BatteryReader, BatteryLevel, level >= l))",
    ] {
        let mut watch = Watch::new(text);
        watch.tick();
        let refused = watch.property.monitor.normalize().expect_err("it keeps messages");
        insta::assert_snapshot!(format!("{refused:?}"));
    }
}

#[test]
fn a_timed_deadline_is_exact_between_ticks() {
    let answered = "always ((GoToDestination, Navigation, m[1] = <start_navigation>)
        implies time_until (Navigation, GoToDestination, true) < 2.5 s)";
    let mut watch = Watch::timed(answered);
    watch.tick();
    watch.go("start_navigation", "Destination");
    insta::assert_snapshot!(watch.monitor().open_obligations()[0]);
    watch.tick();
    watch.tick();
    assert_eq!(watch.property.monitor.verdict(), Verdict::Inconclusive);
    watch.step = 499;
    // 1.001 s + 2.5 s is later than tick 3 and 500 ms.
    assert_eq!(watch.go("get_status", "Destination"), Verdict::Inconclusive);
    assert_eq!(watch.tick(), Verdict::False);
    insta::assert_snapshot!(watch.monitor().witness().unwrap());
    insta::assert_snapshot!(explain(watch.monitor().formula(), &watch.topology));
    assert!(watch.property.monitor.normalize().is_err());
}

#[test]
fn properties_that_look_back_read_as_english() {
    let [a, b] = ["(BatteryReader, BatteryLevel, level < 20)", "(Navigation, GoToDestination, m[2] = <idle>)"];
    let formulas = [
        RECENTLY_LOW.to_owned(),
        NEVER_MORE.to_owned(),
        format!("always ({a} implies at least 2 {b} in 5)"),
        format!("always ({a} implies not {b} since {a})"),
        format!("always ({a} implies {b} since[> 2] {a})"),
        format!("always ({a} implies historically {b})"),
        format!("always ({a} implies historically[!= 2] once {b})"),
        format!("always ({a} implies previous {a} and previous[< 2] {b})"),
        SAME_PLACE.to_owned(),
        "always ((BatteryReader, BatteryLevel, level as l) implies next (BatteryReader, BatteryLevel, not level > (l + 3) * 2))".to_owned(),
    ];
    let reported = formulas.iter().map(|formula| {
        let watch = Watch::new(formula);
        explain(watch.monitor().formula(), &watch.topology)
    });
    insta::assert_snapshot!(reported.collect::<Vec<_>>().join("\n"));
}

#[test]
fn a_clause_that_only_forbids_is_never_vacuous() {
    for ban in [
        "always not (Navigation, GoToDestination, state = <failure>)",
        "always not ((Navigation, GoToDestination, state = <failure>) and (BatteryReader, BatteryLevel, level < 5))",
    ] {
        let mut watch = Watch::new(ban);
        watch.running();
        watch.level(80.0);
        assert!(watch.monitor().vacuous().is_empty(), "{ban}: {:?}", watch.monitor().vacuous());
    }
}

/// Silence keeps what only forbids, however it is written; what has a condition that never occurred demanded nothing.
#[test]
fn silence_satisfies_a_ban_and_makes_a_condition_vacuous() {
    let [e, f] = ["(BatteryReader, BatteryLevel, level < 5)", "(Navigation, GoToDestination, m[2] = <failure>)"];
    for (property, is_vacuous) in [
        (format!("always not {e}"), false),
        (format!("not eventually {e}"), false),
        (format!("always ({e} implies false)"), false),
        (format!("always not fresh {e}"), false),
        (format!("always not once {e}"), false),
        (format!("always historically not {e}"), false),
        (format!("always at most 0 {e} in 10 s"), false),
        (format!("always not time_until {e} >= 0"), false),
        (format!("always not ({e} or {f})"), false),
        (format!("always not ({e} and {f})"), false),
        (format!("always (not {e} and not {f})"), false),
        (format!("always {e}"), true),
        (format!("always fresh {e}"), true),
        (format!("always ({e} or {f})"), true),
        (format!("always ({e} implies not {f})"), true),
        (format!("always ({e} implies {f})"), true),
        (format!("always ({e} implies time_until {f} < 5)"), true),
        (format!("always ({e} implies next {f})"), true),
    ] {
        let mut watch = Watch::new(&property);
        for _ in 0..3 {
            watch.tick();
        }
        let monitor = watch.monitor();
        assert_eq!(monitor.outcome(), Outcome::Satisfied, "{property}");
        assert_eq!(!monitor.vacuous().is_empty(), is_vacuous, "{property}: {:?}", monitor.vacuous());
    }
    let mut never_came = Watch::new(&format!("eventually {e}"));
    never_came.tick();
    assert_eq!(never_came.monitor().outcome(), Outcome::Inconclusive);
}

/// A condition is what is on the left of an implication, whatever it looks like and whatever is demanded: a property of
/// which no condition occurred is vacuous, and it is not if one did.
#[test]
fn a_condition_that_never_occurred_is_vacuous_whatever_it_looks_like() {
    // Of e, the level 4, messages come if `occurs`; others come anyway.
    let [e, f] = ["(BatteryReader, BatteryLevel, level < 5)", "(Navigation, GoToDestination, m[2] = <failure>)"];
    let high = "(BatteryReader, BatteryLevel, level > 50)";
    for (condition, demand) in [
        (format!("fresh {e}"), format!("not {f}")),
        (format!("previous {e}"), format!("not {f}")),
        (format!("once {e}"), format!("not {f}")),
        (format!("once[< 30] {e}"), format!("not {f}")),
        (format!("({high} since {e})"), format!("not {f}")),
        (format!("not {high}"), format!("not {f}")),
        (format!("not {high}"), format!("time_until {e} < 9")),
        (format!("not not {e}"), format!("not eventually {f}")),
        (format!("next {e}"), format!("not next {f}")),
        (format!("time_until {e} < 2"), format!("not {f}")),
    ] {
        for occurs in [false, true] {
            let mut watch = Watch::new(&format!("always ({condition} implies {demand})"));
            watch.tick();
            for level in [80.0, if occurs { 4.0 } else { 80.0 }, if occurs { 4.0 } else { 80.0 }, 80.0] {
                watch.level(level);
                watch.running();
                watch.tick();
            }
            let vacuous = watch.monitor().vacuous();
            assert_eq!(watch.monitor().outcome(), Outcome::Satisfied, "{condition} implies {demand}");
            assert_eq!(vacuous.is_empty(), occurs, "{condition} implies {demand}: {vacuous:?}");
        }
    }
    for property in [
        format!("eventually {e} implies (not {f} until {e})"),
        format!("next {e} implies next {f}"),
        format!("always historically {e}"),
        format!("always not once not {e}"),
    ] {
        let mut watch = Watch::new(&property);
        watch.tick();
        watch.tick();
        assert_eq!(watch.monitor().outcome(), Outcome::Satisfied, "{property}");
        assert_eq!(watch.monitor().vacuous().len(), 1, "{property}");
    }
}

/// The deadline itself, though nothing happens then, and whatever the relation.
#[test]
fn the_time_of_a_missed_deadline_is_the_deadline() {
    let (high, failure) =
        ("(BatteryReader, BatteryLevel, level > 50)", "(Navigation, GoToDestination, m[2] = <failure>)");
    for relation in ["<", "<=", "="] {
        for (property, due) in [
            (format!("time_until {failure} {relation} 1.5 s"), 2.5),
            (format!("always ({high} implies time_until {failure} {relation} 1.5 s)"), 2.501),
            (format!("time_until {failure} {relation} 2 s and time_until {high} {relation} 1.5 s"), 2.5),
        ] {
            let mut watch = Watch::timed(&property);
            watch.tick();
            if !property.contains(" and ") {
                watch.level(80.0);
            }
            watch.tick();
            watch.tick();
            watch.tick();
            let due = Duration::from_secs_f64(due);
            let violations = watch.monitor().violations().unwrap_or_else(|| panic!("{property} is violated"));
            let witness = watch.monitor().witness().expect("it is violated");
            assert_eq!((violations.first[0].from.time, witness.settled.time), (due, due), "{property}");
            assert_eq!(violations.first[0].from.tick, 2, "{property}");
        }
    }
}

/// The condition of `a implies not b` is a; whether b came without it does not matter.
#[test]
fn the_condition_of_a_ban_is_what_is_on_the_left() {
    let mut watch = Watch::new(
        "always ((BatteryReader, BatteryLevel, level < 5) implies not (Navigation, GoToDestination, m[2] = <running>))",
    );
    watch.running();
    watch.level(80.0);
    assert_eq!(watch.monitor().vacuous()[0].antecedent, "(BatteryReader, BatteryLevel, m.level < 5)");
    assert_eq!(watch.level(4.0), Verdict::False);
    assert!(watch.monitor().vacuous().is_empty(), "it is violated");
}

/// A log that goes back is refused by its reader; a monitor that is fed by other code gives no verdict.
#[test]
fn time_that_goes_back_gives_no_verdict() {
    let mut watch = Watch::new("always not (BatteryReader, BatteryLevel, level < 5)");
    watch.tick();
    watch.tick();
    let low = Message::new([Value::symbol("ok"), 1.0.into()]);
    let channel = watch.topology.find_channel("BatteryReader", "BatteryLevel").expect("it exists");
    let earlier = crate::support::event(9, 1, EventKind::Received { channel, message: low });
    watch.property.monitor.observe(&crate::support::event(8, 7, EventKind::Tick));
    watch.property.monitor.observe(&earlier);
    assert_eq!(watch.property.monitor.verdict(), Verdict::Inconclusive);
    assert_eq!(watch.monitor().outcome(), Outcome::Inconclusive);
}

#[test]
fn properties_with_different_meanings_read_differently() {
    let level = |condition: &str| format!("(BatteryReader, BatteryLevel, {condition})");
    let (a, b, c) = ("(Navigation, GoToDestination, true)", level("level < 30"), level("level > 90"));
    let pairs = [
        (
            format!("always {}", level("not status = <ok> or level > 20")),
            format!("always {}", level("not (status = <ok> or level > 20)")),
        ),
        (
            format!("always {}", level("m[1] = <ok> or m[2] < 3 and m[2] > 1")),
            format!("always {}", level("(m[1] = <ok> or m[2] < 3) and m[2] > 1")),
        ),
        (format!("always ({a} or {b} and {c})"), format!("always (({a} or {b}) and {c})")),
        (format!("(not always not {a}) or always {b}"), format!("not always (not {a} or always {b})")),
        (format!("(eventually {a}) until {b}"), format!("eventually ({a} until {b})")),
        (format!("always (({a} implies {b}) implies {c})"), format!("always ({a} implies ({b} implies {c}))")),
        (format!("always (next {a} and {b})"), format!("always next ({a} and {b})")),
    ];
    for (one, other) in pairs {
        let [reported, of_other] =
            [&one, &other].map(|formula| explain(Watch::new(formula).monitor().formula(), &topology()));
        assert_ne!(reported, of_other, "{one} / {other}");
    }
}

#[test]
fn properties_read_as_english() {
    let [low, idle] = ["(BatteryReader, BatteryLevel, level < 20)", "(Navigation, GoToDestination, m[2] = <idle>)"];
    let formulas = [
        ("phi1", Watch::shipped("phi1")),
        ("phi2", Watch::shipped("phi2")),
        (
            "ban",
            Watch::new(
                "always ((BatteryReader, BatteryLevel, level < 20) implies not time_until (GoToDestination, Navigation, true) <= 3)",
            ),
        ),
        ("fresh", Watch::new(&format!("always (fresh {low} implies not fresh {idle} or {idle})"))),
        ("lasting", Watch::new(&format!("always ({low} implies {idle})"))),
        ("edge", Watch::new(&format!("always (becomes fresh {low} implies next {idle})"))),
        (
            "other",
            Watch::new(
                "next (BatteryReader, BatteryLevel, level != 3) until eventually not (Navigation, GoToDestination, m[2] = <running> or m[1] = <error>)",
            ),
        ),
    ];
    let reported: Vec<String> = formulas
        .iter()
        .map(|(name, watch)| format!("{name}: {}", explain(watch.monitor().formula(), &watch.topology)))
        .collect();
    insta::assert_snapshot!(reported.join("\n"));
    let both = Watch::new(TWO_ANSWERS);
    insta::assert_snapshot!(explain(both.monitor().formula(), &both.topology));
    assert_eq!(explain(&Formula::True, &topology()), "Nothing is required.");
}

#[test]
fn graphs_are_exported() {
    for (name, _) in SHIPPED.into_iter().take(2) {
        let watch = Watch::shipped(name);
        for (format, ending) in [(Format::Text, "txt"), (Format::Dot, "dot"), (Format::Scxml, "scxml")] {
            insta::assert_snapshot!(format!("{name}.{ending}"), watch.monitor().export(format).unwrap());
        }
    }
}

#[test]
fn each_location_of_an_exported_graph_has_a_unique_name() {
    let formulas = [
        "always (not (Navigation, GoToDestination, m[2] = <failure>)
             and not (Navigation, GotoRechargingStation, m[2] = <failure>))",
        "always ((Navigation, GoToDestination, m[2] = <running>) implies
             (time_until (Navigation, GoToDestination, m[2] = <idle>) < 3
              or time_until (Navigation, GotoRechargingStation, m[2] = <idle>) < 3))",
        TWO_ANSWERS,
    ];
    for formula in formulas {
        let watch = Watch::new(formula);
        let document = watch.monitor().export(Format::Scxml).unwrap();
        let states: Vec<&str> =
            document.split("<state id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        let names: BTreeSet<&str> = states.iter().copied().collect();
        assert!(states.len() > 2 && names.len() == states.len(), "{states:?} in {document}");
        let mut targets = document.split("target=\"").skip(1).filter_map(|rest| rest.split('"').next());
        assert!(targets.all(|target| names.contains(target)), "{document}");
    }
}

/// When a property was violated, by tick, and until which tick.
fn stretches(watch: &Watch) -> Vec<(u64, Option<u64>)> {
    let violations = watch.monitor().violations().expect("it was violated");
    assert_eq!(violations.count as usize, violations.first.len());
    violations.first.iter().map(|one| (one.from.tick, one.until.map(|until| until.tick))).collect()
}

#[test]
fn a_missed_deadline_is_missed_again() {
    let mut watch = Watch::new(
        "always ((BatteryReader, BatteryLevel, level < 20) implies time_until (BatteryLevel, BatteryReader, true) <= 2)",
    );
    for tick in 0..20 {
        watch.tick();
        // Twice, nobody asks in time; in between, and at last, somebody does.
        if [1, 6, 11].contains(&tick) {
            watch.level(10.0);
        }
        if [7, 15].contains(&tick) {
            watch.see("BatteryLevel", "BatteryReader", Message::new([Value::symbol("get_level")]));
            watch.level(50.0);
        }
    }
    // `tick` counts from 1. The message of tick 8 comes too late for tick 2, and in time for tick 7.
    assert_eq!(stretches(&watch), [(5, Some(8)), (15, Some(16))]);
    assert!(watch.monitor().violations().is_some_and(|all| all.goes_on && all.since.is_none()));
}

/// How often a deadline was missed does not depend on how long it is, nor on what was missed before.
#[test]
fn each_unanswered_request_is_one_missed_deadline() {
    for (theta, timed) in [(1, false), (2, false), (5, false), (10, false), (1, true), (10, true)] {
        let bound = if timed { format!("{theta} s") } else { theta.to_string() };
        let text = format!(
            "always ((BatteryReader, BatteryLevel, true) implies time_until (BatteryLevel, BatteryReader, true) < {bound})"
        );
        let mut watch = if timed { Watch::timed(&text) } else { Watch::new(&text) };
        for _ in 0..40 {
            watch.tick();
            watch.level(10.0);
        }
        for _ in 0..20 {
            watch.tick();
        }
        watch.see("BatteryLevel", "BatteryReader", Message::new([Value::symbol("get_level")]));
        let all = watch.monitor().violations().expect("it was violated");
        assert_eq!(all.count, 40, "{bound}");
        let [first, .., last] = &all.first[..] else { panic!("they are kept") };
        assert_eq!((last.from.time - first.from.time).as_secs(), 39, "{bound}");
        let answered = all.first.iter().all(|one| one.until == first.until && one.until.is_some());
        assert!(answered && all.since.is_none(), "one answer ends all of them");
        let until = first.until.expect("it was answered").time;
        assert_eq!(all.lasting(Duration::MAX), until - first.from.time, "{bound}");
    }
}

#[test]
fn a_demand_is_missed_once_even_if_a_property_makes_it_twice() {
    let demand = "((BatteryReader, BatteryLevel, true) implies time_until (BatteryLevel, BatteryReader, true) <= 1)";
    let other = "(BatteryReader, BatteryLevel, level <= 100)";
    let mut watch = Watch::new(&format!("always {demand} and always ({demand} and {other})"));
    for _ in 0..5 {
        watch.tick();
        watch.level(10.0);
    }
    watch.tick();
    watch.tick();
    assert_eq!(watch.monitor().violations().map(|all| all.count), Some(5));
}

/// More is demanded than the states that are kept before they are followed.
#[test]
fn however_much_is_demanded_before_a_violation_all_that_is_missed_counts() {
    let deadline = 3000;
    let answered = format!("time_until (BatteryLevel, BatteryReader, true) <= {deadline}");
    let mut watch = Watch::new(&format!("always ((BatteryReader, BatteryLevel, true) implies {answered})"));
    for _ in 0..=deadline + 10 {
        watch.tick();
        watch.level(10.0);
        watch.level(20.0);
    }
    assert_eq!(watch.monitor().violations().map(|all| all.count), Some(2 * 10));
    let until = "(BatteryReader, BatteryLevel, level > 20) until (BatteryLevel, BatteryReader, true)";
    let mut watch = Watch::new(&format!("always ((BatteryReader, BatteryLevel, level = 50) implies {until})"));
    for _ in 0..5000 {
        watch.tick();
        watch.level(50.0);
    }
    watch.level(10.0);
    assert_eq!(watch.monitor().violations().map(|all| all.count), Some(5000));
}

/// By progression, which does not foresee that the demand cannot be met.
#[test]
fn a_demand_that_no_message_can_meet_is_missed_each_time() {
    let never = "time_until (BatteryReader, BatteryLevel, level > 20 and level < 10) <= 1";
    let mut watch = Watch::new(&format!("always ((BatteryReader, BatteryLevel, true) implies {never})"));
    let formula = watch.monitor().formula().clone();
    let monitor = ScopeMonitor::with("p", formula, &watch.topology, Choice::Progression);
    watch.property.monitor = Box::new(monitor.expect("it is small"));
    watch.tick();
    assert_eq!([(); 3].map(|()| watch.level(10.0)), [Verdict::Inconclusive; 3]);
    assert_eq!([(); 2].map(|()| watch.tick()), [Verdict::Inconclusive, Verdict::False]);
    assert_eq!(watch.monitor().violations().map(|all| all.count), Some(3));
}

#[test]
fn what_was_seen_before_a_violation_still_counts_after_it() {
    let mut watch = Watch::new(
        "always ((BatteryReader, BatteryLevel, level >= 20) and once (BatteryReader, BatteryLevel, level > 90))",
    );
    for level in [95.0, 50.0, 10.0, 15.0, 60.0, 5.0] {
        watch.tick();
        watch.level(level);
    }
    // At the first tick, nothing has been seen yet.
    assert_eq!(stretches(&watch), [(1, Some(1)), (3, Some(5)), (6, None)]);
    let all = watch.monitor().violations().expect("it was violated");
    let [within_a_tick_ms, two_ticks_ms, to_the_end_ms] = [1, 2_002, 2_994];
    let lasted = Duration::from_millis(within_a_tick_ms + two_ticks_ms + to_the_end_ms);
    assert_eq!(all.lasting(Duration::from_secs(9)), lasted);
    let words = all.in_words(Duration::from_secs(9)).expect("more than one");
    assert_eq!(words, "violated 3 times, for 5.00 s in all, without a break from 6.01 s to the end");
}

#[test]
fn what_cannot_be_violated_again_is_violated_once() {
    let mut watch =
        Watch::new("(BatteryReader, BatteryLevel, level > 20) until (BatteryReader, BatteryLevel, level > 90)");
    for level in [95.0, 10.0, 10.0] {
        watch.tick();
        watch.level(level);
    }
    let all = watch.monitor().violations();
    assert!(all.is_none_or(|all| all.count == 1 && !all.goes_on), "{all:?}");
    let mut watch = Watch::new("next (BatteryReader, BatteryLevel, level > 20)");
    for level in [10.0, 95.0, 10.0] {
        watch.tick();
        watch.level(level);
    }
    let all = watch.monitor().violations().expect("it was violated");
    assert_eq!((all.count, all.goes_on, all.in_words(Duration::MAX)), (1, false, None));
}

#[test]
fn each_open_obligation_has_its_own_beginning() {
    let running = "(Navigation, GoToDestination, m[2] = <running>)";
    let level = "(BatteryReader, BatteryLevel, m[2] > 50)";
    let start = "(GotoRechargingStation, Navigation, m[1] = <start_navigation>)";
    let texts = [
        format!("timed property p := always ({running} implies time_until {level} = 5002 ms)"),
        format!("timed property p := next {running} and always ({running} implies time_until {level} = 5002 ms)"),
        format!("property p := always ({running} implies time_until {level} = 5)"),
        format!("property p := next {running} and always ({running} implies time_until {level} = 5)"),
        // Without an automaton, which would be too large.
        format!("property p := always ({running} implies time_until {level} = 5 and time_until {start} != 40)"),
    ];
    for text in texts {
        let mut watch = Watch::of(&text);
        watch.start();
        let begun = |watch: &Watch| -> Vec<u64> {
            let open = watch.monitor().open_obligations().into_iter();
            let open = open.filter(|open| !open.what.contains("start_navigation"));
            open.map(|open| open.since.expect("it began").step).collect()
        };
        watch.tick();
        watch.running();
        watch.tick();
        watch.tick();
        watch.running();
        assert_eq!(begun(&watch), [2, 3], "{text}");
        (0..3).for_each(|_| assert_eq!(watch.tick(), Verdict::Inconclusive));
        watch.level(80.0);
        assert_eq!(begun(&watch), [3], "{text}: the answer to the first says nothing of the second");
        (0..3).for_each(|_| {
            watch.tick();
        });
        assert_eq!(
            watch.monitor().witness().and_then(|witness| witness.since).map(|since| since.step),
            Some(3),
            "{text}"
        );
    }
}

#[test]
fn an_obligation_that_one_of_two_answers_can_meet_began_before_the_deadline_of_the_other() {
    let running = "(Navigation, GoToDestination, m[2] = <running>)";
    let level = "(BatteryReader, BatteryLevel, m[2] > 50)";
    let start = "(GotoRechargingStation, Navigation, m[1] = <start_navigation>)";
    for (timed, bound) in [("", "= 2"), ("timed ", "= 2 s"), ("timed ", "< 2 s")] {
        let mut watch = Watch::of(&format!(
            "{timed}property p := always ({running} implies time_until {level} {bound} or eventually {start})"
        ));
        watch.tick();
        watch.running();
        (0..4).for_each(|_| assert_eq!(watch.tick(), Verdict::Inconclusive));
        let open = watch.monitor().open_obligations();
        assert_eq!((open.len(), open[0].since.map(|since| since.step), open[0].has_deadline), (1, Some(1), false));
    }
}
