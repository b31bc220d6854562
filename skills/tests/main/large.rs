//! Very large files, or files made to be slow: each test would take minutes or hours if the work grew faster than the
//! file.

use channels::{Capacity, Domain, FieldKind, Role, Shape, Symbol, Topology};
use skills::{Chart, LeafOfSystem, SkillError, check_system};

/// The problems and warnings of a machine with these elements, in short form.
fn problems(inside: &str) -> Vec<String> {
    let text = format!("<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\">{inside}</scxml>");
    match Chart::load("Large.scxml", &text) {
        Ok(chart) => chart.warnings().iter().map(ToString::to_string).collect(),
        Err(SkillError::Load { problems, .. }) => problems.iter().map(ToString::to_string).collect(),
        Err(error) => panic!("{error}"),
    }
}

fn many(count: usize, piece: impl Fn(usize) -> String) -> String {
    (0..count).map(piece).collect()
}

#[test]
fn states_that_are_never_entered_are_found_among_very_many() {
    let unused = many(30_000, |n| format!("<state id=\"s{n}\"/>"));
    assert_eq!(problems(&unused).len(), 29_999, "the first is entered");
    assert_eq!(problems(&"\n<state/>".repeat(40_000)).last().unwrap(), "the state `state@40001` is never entered");
}

#[test]
fn events_that_never_come_are_found_among_very_many() {
    let waiting =
        |n| format!("<state id=\"s.{n}\"><transition event=\"done.state.s done.state.s.{n}\" target=\"s.0\"/></state>");
    let found = problems(&many(20_000, waiting));
    assert!(found.iter().any(|problem| problem == "the state `s` is never done: it has no <final>"));
}

#[test]
fn events_and_transitions_are_matched_among_very_many() {
    let names: Vec<String> = (0..50_000).map(|n| format!("e{n}")).collect();
    let mut topology = Topology::default();
    let [client, skill, peer] = ["BT", "Look", "Peer"].map(|name| topology.process(name).unwrap());
    let head = |names: &[&str]| {
        let symbols = names.iter().map(|name| Symbol::new(name)).collect();
        Domain::new([Shape::new([("m", FieldKind::Symbol(symbols))])])
    };
    topology.channel(client, skill, Capacity::One, head(&["tick"])).unwrap();
    topology.channel(skill, client, Capacity::One, head(&["success"]).in_role(Role::Reply)).unwrap();
    topology.channel(peer, skill, Capacity::One, head(&names.iter().map(String::as_str).collect::<Vec<_>>())).unwrap();
    let heard = many(50_000, |n| format!("<transition event=\"Peer.e{n}\"/>"));
    let answer = "<transition event=\"BT.tick\"><send type=\"channel\" target=\"BT\" event=\"success\"/></transition>";
    let text = format!(
        "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\"><state id=\"a\">{heard}{answer}</state></scxml>"
    );
    let chart = Chart::load("Look.scxml", &text).unwrap();
    let leaf = LeafOfSystem { name: "Look", is_halted: false };
    assert!(check_system(&[leaf], &[("Look", &chart, &[])], &topology).is_empty());
}

#[test]
fn transitions_that_come_too_late_are_found_among_very_many() {
    let different = many(30_000, |n| format!("<transition event=\"e.{n}\" target=\"a\"/>"));
    assert!(problems(&format!("<state id=\"a\">{different}</state>")).is_empty());
    let words = many(100_000, |n| format!("e{n} "));
    let twice = format!("<transition event=\"{words}\" target=\"a\"/>").repeat(2);
    assert_eq!(problems(&format!("<state id=\"a\">{twice}</state>")), ["this transition is never taken"]);
}

#[test]
fn very_many_unknown_states_are_each_reported() {
    let lost =
        many(20_000, |n| format!("<state id=\"state{n}\"><transition event=\"e\" target=\"stale{n}\"/></state>"));
    assert_eq!(problems(&lost).len(), 20_000);
    let long = format!(
        "<state id=\"{}\"><transition event=\"e\" target=\"{}\"/></state>",
        "s".repeat(500_000),
        "t".repeat(500_000)
    );
    assert_eq!(problems(&long).len(), 1);
}

#[test]
fn very_many_targets_can_be_active_at_once() {
    let regions = many(40_000, |n| format!("<state id=\"r{n}\"/>"));
    let targets = many(40_000, |n| format!("r{n} "));
    let machine = |last: &str| {
        let go = format!("<state id=\"a\"><transition event=\"e\" target=\"{targets}{last}\"/></state>");
        format!("{go}<parallel id=\"p\">{regions}</parallel>")
    };
    assert!(problems(&machine("")).is_empty());
    assert_eq!(problems(&machine("a")).len(), 1);
}

#[test]
fn the_number_of_attributes_of_an_element_is_limited() {
    let attributes = many(300_000, |n| format!("a{n}=\"\" "));
    assert_eq!(problems(&format!("<state {attributes}/>")), ["an element may have at most 1000 attributes"]);
}

#[test]
fn very_deep_nesting_is_refused_without_recursion() {
    let deep = "<state>".repeat(40_000) + &"</state>".repeat(40_000);
    assert_eq!(problems(&deep), ["elements may be nested at most 64 deep"]);
}
