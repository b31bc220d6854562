//! Events that were recorded elsewhere, judged by monitors.

use std::time::Duration;

use channels::{Event, EventKind, Flaw, Gap, Ground, Message, Value, Verdict};
use monitors::{Outcome, Property};
use recording::{Certainty, Doubts, Ended, Happening, Judge, Origin, RunView};

use crate::drive::{level, tick, topology};

const TICK: Duration = Duration::from_secs(1);

/// Requires levels of at least 20 %, and an answer to a level below 30 % within three ticks.
const PROPERTIES: &str = "
    property phi1 := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 20)
    property phi2 := always ((BatteryReader, BatteryLevel, m[2] < 30) implies
        time_until (BatteryLevel, BT, m[1] = <failure>) < 3)";

fn properties() -> Vec<Property> {
    monitors::load("own.scope", PROPERTIES, &topology(), TICK).unwrap().properties
}

fn judged(properties: &[Property]) -> (Judge, RunView) {
    judged_with(properties, Doubts::new(properties, &topology()).on(&Ground::Complete))
}

fn judged_with(properties: &[Property], doubts: Doubts) -> (Judge, RunView) {
    let names = ["log".to_owned(), "a log".to_owned()];
    let (judge, header, start) = Judge::begin(names, Origin::default(), &topology(), TICK, properties, doubts);
    (judge, RunView::new(header, start).unwrap())
}

fn verdicts(view: &RunView) -> Vec<(usize, Verdict)> {
    let verdict = |happening: &Happening| match happening {
        Happening::Verdict { monitor, decision } => Some((*monitor, decision.verdict)),
        _ => None,
    };
    view.happenings().iter().filter_map(verdict).collect()
}

#[test]
fn a_verdict_is_recorded_once_with_the_event_and_the_reason() {
    let mut properties = properties();
    let (mut judge, mut view) = judged(&properties);
    let mut recorded = Vec::new();
    for second in 1..8 {
        let time = Duration::from_secs(second);
        for event in [tick(time), level(time, 35.0 - 10.0 * second as f64)] {
            view.apply(judge.step(event, &mut properties)).unwrap();
            recorded.extend(verdicts(&view).into_iter().map(|verdict| (second, verdict)));
        }
    }
    assert_eq!(recorded, [(2, (0, Verdict::False)), (4, (1, Verdict::False))]);
    let phi1 = view.monitor(0).violation().unwrap();
    assert_eq!(phi1.event.tick, 2);
    assert_eq!(phi1.witness.as_ref().unwrap().messages.len(), 1);
    view.finish(judge.finish(&properties)).unwrap();
    let end = view.end().unwrap();
    assert_eq!((&end.ended, view.ticks(), view.communications()), (&Ended::Recorded, 7, 7));
    assert_eq!(view.monitors().map(|monitor| monitor.outcome()).collect::<Vec<_>>(), [Outcome::Violated; 2]);
}

#[test]
fn verdicts_that_missing_messages_could_change_are_unsure() {
    let mut properties = properties();
    let (mut judge, mut view) = judged(&properties);
    view.apply(judge.step(level(TICK, 50.0), &mut properties)).unwrap();
    judge.miss(&Gap::of_anything("a gap of 2 s"), &mut properties);
    // A message can violate a property by itself, whatever is missing; a missing answer may be in the gap.
    for second in 2..8 {
        let time = Duration::from_secs(second);
        for event in [tick(time), level(time, 10.0)] {
            view.apply(judge.step(event, &mut properties)).unwrap();
        }
    }
    assert!(judge.doubts().all().eq([None, Some("a gap of 2 s")]));
    view.finish(judge.finish(&properties)).unwrap();
    let outcomes: Vec<Outcome> = view.monitors().map(|monitor| monitor.outcome()).collect();
    assert_eq!(outcomes, [Outcome::Violated, Outcome::Inconclusive]);
    assert_eq!(view.monitor(1).ending().evidence.certainty(), &Certainty::Unsure("a gap of 2 s".to_owned()));
    assert!(view.monitor(1).decision.is_none());
}

#[test]
fn only_timed_properties_ask_when_a_message_was_sent_and_nothing_is_sure_of_messages_that_may_be_others() {
    let text = "
        property order := always (BatteryReader, BatteryLevel, m[2] >= 20)
        timed property soon := always ((BatteryReader, BatteryLevel, m[2] < 30) implies
            time_until (BatteryReader, BatteryLevel, m[2] > 80) < 3 s)";
    for (flaw, unsure) in [(Flaw::Late, [false, true]), (Flaw::Missing, [false, true]), (Flaw::Mixed, [true, true])] {
        let mut properties = monitors::load("own.scope", text, &topology(), TICK).unwrap().properties;
        let (mut judge, mut view) = judged(&properties);
        view.apply(judge.step(level(TICK, 50.0), &mut properties)).unwrap();
        judge.miss(&Gap { flaw, ..Gap::of_anything("something") }, &mut properties);
        view.apply(judge.step(level(2 * TICK, 10.0), &mut properties)).unwrap();
        view.apply(judge.step(level(9 * TICK, 50.0), &mut properties)).unwrap();
        assert!(judge.doubts().all().map(|why| why.is_some()).eq(unsure), "{flaw:?}");
    }
}

#[test]
fn a_verdict_that_follows_from_the_domains_is_unsure_if_messages_outside_of_them_are_missing() {
    let text = "
        property known := always (BatteryReader, BatteryLevel, m[1] = <ok>)
        property odd := eventually (BatteryReader, BatteryLevel, m[2] > 1 and m[2] < 0)";
    let load = || monitors::load("own.scope", text, &topology(), TICK).unwrap().properties;
    for (doubts, expected) in [
        (Doubts::new(&load(), &topology()), [Outcome::Satisfied, Outcome::Violated]),
        (Doubts::about_any_messages(&load(), &topology()), [Outcome::Inconclusive, Outcome::Violated]),
    ] {
        let mut properties = load();
        let (mut judge, mut view) = judged_with(&properties, doubts.on(&Ground::Complete));
        view.apply(judge.step(level(TICK, 50.0), &mut properties)).unwrap();
        assert_eq!(view.monitors().map(|monitor| monitor.decision.is_some()).collect::<Vec<_>>(), [true, true]);
        judge.miss(&Gap::of_anything("a message with another status"), &mut properties);
        view.apply(judge.step(tick(TICK), &mut properties)).unwrap();
        view.finish(judge.finish(&properties)).unwrap();
        assert_eq!(view.monitors().map(|monitor| monitor.outcome()).collect::<Vec<_>>(), expected);
        let decided = view.monitors().map(|monitor| monitor.decision.is_some());
        assert_eq!(decided.collect::<Vec<_>>(), expected.map(|outcome| outcome != Outcome::Inconclusive));
    }
}

#[test]
fn a_second_monitor_judges_only_where_domains_make_a_difference() {
    let judges = |condition: &str| {
        let text = format!("property p := always (BatteryReader, BatteryLevel, {condition})");
        let properties = monitors::load("own.scope", &text, &topology(), TICK).unwrap().properties;
        Doubts::about_any_messages(&properties, &topology()).judges()
    };
    assert_eq!(judges("m[2] >= 20"), 0);
    assert_eq!(judges("m[1] = <ok>"), 1);
    assert_eq!(judges("m[2] > 1 and m[2] < 0"), 0, "no message at all satisfies this");
    assert_eq!(judges("m[2] * 2 > 1"), 1, "what may come is not known exactly");
}

#[test]
fn the_hash_depends_on_every_event() {
    let hash = |levels: &[f64]| {
        let mut properties = properties();
        let (mut judge, _) = judged(&properties);
        levels.iter().for_each(|level_pct| drop(judge.step(level(TICK, *level_pct), &mut properties)));
        judge.finish(&properties).trace_hash
    };
    assert_eq!(hash(&[50.0, 49.0]), hash(&[50.0, 49.0]));
    let others = [hash(&[50.0, 49.0]), hash(&[49.0, 50.0]), hash(&[50.0])];
    assert!(others[0] != others[1] && others[0] != others[2]);
}

#[test]
fn a_source_that_vouches_for_nothing_gives_no_verdict() {
    let mut properties = properties();
    let (mut judge, mut view) = judged_with(&properties, Doubts::about_losses(&properties, &topology()));
    for second in 1..8 {
        let time = Duration::from_secs(second);
        for event in [tick(time), level(time, 25.0)] {
            view.apply(judge.step(event, &mut properties)).unwrap();
        }
    }
    view.finish(judge.finish(&properties)).unwrap();
    for monitor in view.monitors() {
        assert_eq!(
            (monitor.outcome(), monitor.decision.is_some()),
            (Outcome::Inconclusive, false),
            "{}",
            monitor.name()
        );
        assert!(matches!(monitor.ending().evidence.certainty(), Certainty::Groundless(_)), "{}", monitor.name());
    }
}

#[test]
fn a_violation_by_a_message_is_sure_whatever_vouches_for_it() {
    let mut properties = properties();
    let (mut judge, mut view) = judged_with(&properties, Doubts::new(&properties, &topology()));
    view.apply(judge.step(level(TICK, 10.0), &mut properties)).unwrap();
    view.finish(judge.finish(&properties)).unwrap();
    assert_eq!(view.monitor(0).ending().evidence.certainty(), &Certainty::Sure);
    assert_eq!(
        view.monitors().map(|monitor| monitor.outcome()).collect::<Vec<_>>(),
        [Outcome::Violated, Outcome::Inconclusive]
    );
}

#[test]
fn a_violation_by_silence_holds_unless_the_last_message_was_lost_until_the_next_one_comes() {
    let mut properties = properties();
    let mut doubts = Doubts::about_losses(&properties, &topology()).on(&Ground::Numbered);
    let mut see = |event: Event, properties: &mut [Property]| {
        properties.iter_mut().for_each(|property| property.monitor.observe(&event));
        doubts.observe(&event, properties);
        doubts.evidence(1, &properties[1]).certainty().clone()
    };
    let answer = |time| {
        let channel = topology().channels().nth(1).unwrap();
        Event { kind: EventKind::Received { channel, message: Message::new([Value::symbol("success")]) }, ..tick(time) }
    };
    see(answer(TICK), &mut properties);
    see(level(TICK, 25.0), &mut properties);
    let late = (2..9).map(|second| see(tick(second * TICK), &mut properties)).last();
    let why = "a message from BatteryLevel to BT was lost after 1 s".to_owned();
    assert_eq!((properties[1].monitor.verdict(), late), (Verdict::False, Some(Certainty::Unless(why))));
    assert_eq!(see(answer(9 * TICK), &mut properties), Certainty::Sure, "none has been lost");
}
