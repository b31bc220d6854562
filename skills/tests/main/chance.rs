//! Transitions that are left to chance, in machines that were translated from another language.

use std::time::Duration;

use skills::{Chart, Machine, SkillError, Transcript};

/// The state that a machine ends in.
fn ends_in(chart: &std::sync::Arc<Chart>, seed: u64) -> String {
    let mut machine = Machine::new(chart.clone());
    machine.set_seed(seed);
    machine.start(Duration::ZERO, &mut Transcript::default());
    machine.active_ids().collect()
}

fn load(content: &str) -> Result<std::sync::Arc<Chart>, SkillError> {
    let text = format!(
        "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" xmlns:s=\"urn:steward:chance\" version=\"1.0\">{content}</scxml>"
    );
    Chart::load_translated("dice.txt", "as written", &text, &|_| 3..10)
}

#[test]
fn each_transition_with_a_chance_is_taken_as_often_as_it_says() {
    let chart = load(
        "<state id=\"throw\"><transition target=\"one\" s:chance=\"0.2\"/><transition target=\"two\" s:chance=\"0.5\"/>
         <transition target=\"three\"/></state><state id=\"one\"/><state id=\"two\"/><state id=\"three\"/>",
    );
    let chart = chart.expect("a sound machine");
    let ends: Vec<String> = (0..10_000).map(|seed| ends_in(&chart, seed)).collect();
    let count = |state: &str| ends.iter().filter(|end| *end == state).count();
    // 0.2, and half of the rest each; within five standard deviations.
    for (state, expected) in [("one", 2000_usize), ("two", 4000), ("three", 4000)] {
        assert!(count(state).abs_diff(expected) < 250, "{state}: {}", count(state));
    }
    assert_eq!(ends_in(&chart, 7), ends_in(&chart, 7));
}

#[test]
fn the_position_in_the_sequence_is_part_of_the_state() {
    let chart = load(
        "<state id=\"a\"><transition event=\"go\" target=\"b\" s:chance=\"0.5\"/></state>
         <state id=\"b\"><transition event=\"go\" target=\"a\"/></state>",
    );
    let mut machine = Machine::new(chart.expect("a sound machine"));
    machine.start(Duration::ZERO, &mut Transcript::default());
    let mut copy = machine.clone();
    for _ in 0..50 {
        let go = || skills::Event::external("go");
        machine.handle(go(), Duration::ZERO, &mut Transcript::default());
        copy.handle(go(), Duration::ZERO, &mut Transcript::default());
        assert!(machine == copy);
    }
}

#[test]
fn problems_are_located_in_the_original_text() {
    let Err(SkillError::Load { text, problems, .. }) =
        load("<state id=\"a\"><transition s:chance=\"2\" event=\"e\"/></state>")
    else {
        panic!("a chance of 2");
    };
    assert_eq!((text.name(), text.text()), ("dice.txt", "as written"));
    assert_eq!((problems[0].message(), problems[0].offset()), ("`2` is not a probability", 3));
    let parallel =
        "<parallel id=\"p\"><transition event=\"e\" target=\"p\" s:chance=\"0.5\"/><state id=\"a\"/></parallel>";
    assert!(load(parallel).is_err());
}
