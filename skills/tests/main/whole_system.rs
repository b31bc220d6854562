//! The wiring of a tree with all its skills.

use channels::{Capacity, Domain, FieldKind, Role, Shape, Topology};
use skills::{Chart, LeafOfSystem, SkillError, check_system};

use crate::stage::file;

fn topology() -> Topology {
    let mut topology = Topology::default();
    let [tree, skill, reader] = ["BT", "Look", "Reader"].map(|name| topology.process(name).unwrap());
    let head = |symbols: [&str; 2]| Domain::new([Shape::new([("m", FieldKind::symbols(symbols))])]);
    topology.channel(tree, skill, Capacity::One, head(["tick", "halt"])).unwrap();
    topology.channel(skill, tree, Capacity::One, head(["success", "halted"]).in_role(Role::Reply)).unwrap();
    topology.channel(skill, reader, Capacity::One, head(["get", "stop"])).unwrap();
    // Two shapes begin with the same symbol.
    let level = Shape::new([("m", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
    let answers = [Shape::new([("m", FieldKind::symbols(["ok", "error"]))]), level];
    topology.channel(reader, skill, Capacity::One, Domain::new(answers).in_role(Role::Reply)).unwrap();
    topology
}

fn complaints(content: &str, leaves: &[&str]) -> Vec<String> {
    let leaves: Vec<LeafOfSystem<'_>> = leaves.iter().map(|name| LeafOfSystem { name, is_halted: true }).collect();
    complaints_of_leaves(content, &leaves)
}

fn complaints_of_leaves(content: &str, leaves: &[LeafOfSystem<'_>]) -> Vec<String> {
    let chart = Chart::load("Look.scxml", &file("", content)).unwrap();
    let errors = check_system(leaves, &[("Look", &chart, &[])], &topology());
    let mut reported = Vec::new();
    for error in errors {
        match error {
            SkillError::Wiring { problems, .. } => reported.extend(problems.iter().map(ToString::to_string)),
            other => reported.push(other.to_string()),
        }
    }
    reported
}

const ASKS: &str = "<onentry><send type='channel' target='Reader' event='get'/></onentry>";
const ANSWERS: &str =
    "<transition event='BT.tick BT.halt'><send type='channel' target='BT' event='success'/></transition>";

#[test]
fn a_skill_that_listens_and_answers_fits() {
    let content = format!("<state id='s'>{ASKS}{ANSWERS}<transition event='Reader.ok'/></state>");
    assert_eq!(complaints(&content, &["Look"]), Vec::<String>::new());
}

#[test]
fn a_leaf_without_a_skill_is_named() {
    let content = format!("<state id='s'>{ANSWERS}<transition event='Reader'/></state>");
    assert_eq!(complaints(&content, &["Look", "Loook"]), ["there is no skill for the leaf Loook"]);
}

#[test]
fn answers_that_nobody_reads_and_requests_that_nobody_receives_are_reported() {
    let content = format!("<state id='s'>{ASKS}<transition event='BT.tick'/></state>");
    assert_eq!(
        complaints(&content, &["Look"]),
        [
            "Look never answers BT",
            "no transition reads `BT.halt`",
            "no transition reads `Reader.ok`",
            "no transition reads `Reader.error`"
        ]
    );
}

#[test]
fn unknown_services_are_reported() {
    let content = format!(
        "<state id='s'><onentry><send type='channel' target='Writer' event='get'/></onentry>{ANSWERS}<transition event='Reader'/></state>"
    );
    assert_eq!(complaints(&content, &["Look"]), ["there is no process Writer"]);
}

#[test]
fn a_condition_need_not_take_halts() {
    let answers = ANSWERS.replace(" BT.halt", "");
    let content = format!("<state id='s'>{ASKS}{answers}<transition event='Reader.ok'/></state>");
    let leaf = |is_halted| [LeafOfSystem { name: "Look", is_halted }];
    assert_eq!(complaints_of_leaves(&content, &leaf(false)), Vec::<String>::new());
    assert_eq!(complaints_of_leaves(&content, &leaf(true)), ["no transition reads `BT.halt`"]);
}

#[test]
fn a_skill_may_compute_the_receiver_of_its_answer() {
    let answers = ANSWERS.replace("target='BT'", "targetexpr='_event.origin'");
    let content = format!("<state id='s'>{ASKS}{answers}<transition event='Reader.ok'/></state>");
    assert_eq!(complaints(&content, &["Look"]), Vec::<String>::new());
}

#[test]
fn an_invoked_machine_may_receive_and_answer() {
    let inner =
        format!("<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id='i'>{ANSWERS}</state></scxml>");
    let invoke = |autoforward| format!("<invoke autoforward='{autoforward}'><content>{inner}</content></invoke>");
    let content =
        |autoforward| format!("<state id='s'>{ASKS}{}<transition event='Reader'/></state>", invoke(autoforward));
    assert_eq!(complaints(&content("true"), &["Look"]), Vec::<String>::new());
    assert_eq!(
        complaints(&content("false"), &["Look"]),
        ["no transition reads `BT.tick`", "no transition reads `BT.halt`"]
    );
}

#[test]
fn a_skill_with_mistakes_of_both_kinds_gives_one_error() {
    let chart =
        Chart::load("Look.scxml", &file("", &format!("<state id='s'>{ASKS}<transition event='Reader.okay'/></state>")));
    let leaf = LeafOfSystem { name: "Look", is_halted: false };
    let errors = check_system(&[leaf], &[("Look", &chart.unwrap(), &[])], &topology());
    assert!(matches!(&errors[..], [SkillError::Wiring { problems, .. }] if problems.len() == 5), "{errors:?}");
}
