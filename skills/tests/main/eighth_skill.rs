//! The example of a skill that asks a service: one that announces arrival.

use std::time::Duration;

use channels::{Capacity, Domain, FieldKind, Role, Shape, Topology};
use skills::{Chart, Cues, SkillProcess, rehearse};

const ANNOUNCE_ARRIVAL: &str = include_str!("../../examples/AnnounceArrival.scxml");

#[test]
fn the_example_fits_channels_to_the_tree_and_to_a_speaker() {
    let mut topology = Topology::default();
    let [tree, skill, speaker] = ["BT", "AnnounceArrival", "Speaker"].map(|name| topology.process(name).unwrap());
    let call = Domain::new([Shape::new([("call", FieldKind::symbols(["tick", "halt"]))])]);
    let results = FieldKind::symbols(["success", "failure", "halted"]);
    let result = Domain::new([Shape::new([("result", results)])]).in_role(Role::Reply);
    let say = Shape::new([("request", FieldKind::symbols(["say"])), ("text", FieldKind::Text)]);
    let reply = Domain::new([Shape::new([("status", FieldKind::symbols(["ok", "error"]))])]).in_role(Role::Reply);
    topology.channel(tree, skill, Capacity::One, call).unwrap();
    topology.channel(skill, tree, Capacity::One, result).unwrap();
    topology.channel(skill, speaker, Capacity::One, Domain::new([say])).unwrap();
    topology.channel(speaker, skill, Capacity::One, reply).unwrap();
    let chart = Chart::load("AnnounceArrival.scxml", ANNOUNCE_ARRIVAL).unwrap();
    assert!(chart.warnings().is_empty());
    let process = SkillProcess::new("AnnounceArrival", &chart, &topology, [("text", "I am here.".into())]);
    assert!(process.is_ok(), "{process:?}");
}

#[test]
fn the_example_announces_and_answers() {
    let chart = Chart::load("AnnounceArrival.scxml", ANNOUNCE_ARRIVAL).unwrap();
    let lines = |events: &str| {
        let cues = Cues::parse("events.jsonl", events).unwrap();
        let mut lines = Vec::new();
        rehearse(&chart, &cues, Duration::from_secs(60), &mut |line| lines.push(line.to_string()));
        lines.retain(|line| line.contains("sends"));
        lines
    };
    let tick = r#"{"event": "BT.tick", "time_s": 1}"#;
    let asked = r#"1.000 s  sends say to Speaker {"text": "We have arrived."}"#;
    let done = r#"{"event": "Speaker.ok", "time_s": 1.5}"#;
    assert_eq!(lines(&format!("{tick}\n{done}")), [asked, "1.500 s  sends success to BT"]);
    assert_eq!(lines(tick), [asked, "3.000 s  sends failure to BT"]);
    let halt = r#"{"event": "BT.halt", "time_s": 1.2}"#;
    assert_eq!(lines(&format!("{tick}\n{halt}")), [asked, "1.200 s  sends halted to BT"]);
}
