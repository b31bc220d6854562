//! The tour guide: the tour, and what can go wrong in it.

use std::collections::{BTreeMap, BTreeSet};

use scenarios::files::{Kind, scenario_names};
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::programs::has_python;
use crate::steward::report;

fn faulty() -> Vec<&'static str> {
    scenario_names().filter(|name| name.starts_with("guide/")).collect()
}

fn run(scenario: &str, arguments: &[&str]) -> Value {
    let out = tempdir().unwrap();
    report(scenario, out.path(), &[&["--no-snapshots"], arguments].concat())
}

fn violated(report: &Value) -> BTreeSet<String> {
    let monitors = report["monitors"].as_array().unwrap().iter();
    let violated = monitors.filter(|monitor| monitor["verdict"] == "violated");
    violated.map(|monitor| monitor["name"].as_str().unwrap().to_owned()).collect()
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn every_tour_ends_as_expected_and_every_property_is_violated_in_one() {
    if !has_python() {
        return;
    }
    // One of the policies for each, in turn.
    let policies = [
        "execution.policy=random",
        "execution.policy=round-robin",
        "execution.tree=nodes",
        "execution.starve=TourPlanner",
    ];
    let tours: Vec<_> = [faulty(), vec!["guide"]].concat().into_iter().zip(policies.into_iter().cycle()).collect();
    let reports = batch::run(&tours, |(name, policy)| run(name, &["--seed", "2", "--set", policy]), |_| {});
    let differ = tours.iter().zip(&reports).filter(|(_, report)| report["outcome"] != "as_expected");
    let wrong: Vec<_> = differ.map(|(tour, report)| format!("{tour:?}: {}", report["differences"])).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let broken: BTreeMap<_, _> = tours.iter().map(|(name, _)| name).zip(reports.iter().map(violated)).collect();
    let by_some: BTreeSet<&str> = broken.values().flatten().map(String::as_str).collect();
    let properties: BTreeSet<&str> = Kind::Properties.names().filter_map(|name| name.strip_prefix("guide/")).collect();
    assert_eq!(by_some, properties, "each property detects something");
    let kinds: BTreeSet<&BTreeSet<String>> = broken.values().collect();
    assert!(kinds.len() >= 12, "different problems are distinguished: {broken:?}");
    let tolerated = broken.values().filter(|violated| violated.is_empty()).count();
    assert!(tolerated >= 4, "the guide copes with some problems: {broken:?}");
}

#[test]
fn the_failure_of_the_planner_program_is_reported() {
    if !has_python() {
        return;
    }
    // The planner receives a name that it does not expect.
    let report = run("guide", &["--set", "components.TourPlanner.data.stops=\"Dinosaurs\""]);
    let [error] = report["skill_errors"].as_array().unwrap().as_slice() else { panic!("{report}") };
    assert_eq!(error["skill"], "TourPlanner");
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("KeyError: 'Dinosaurs'"), "{message}");
}

#[test]
fn the_guide_has_skills_components_and_properties_of_its_own() {
    let names = |kind: Kind| kind.names().filter(|name| name.starts_with("guide/")).count();
    assert!((names(Kind::Skill), names(Kind::Properties)) >= (9, 8));
    let scenario = include_str!("../scenarios/guide.toml");
    assert!(scenario.matches("[components.").count() >= 5 && scenario.matches("[leaves.").count() >= 4);
    assert!(faulty().len() >= 12);
}

#[test]
fn programs_and_devices_keep_up_with_100_ticks_per_second() {
    if !has_python() {
        return;
    }
    let out = tempdir().unwrap();
    let set =
        ["--no-snapshots", "--set", "execution.tick_s=0.01", "--set", "execution.max_time_s=3", "--set", "expect={}"];
    let report = report("guide", out.path(), &set);
    assert_eq!((&report["ticks"], &report["overruns"]), (&json!(300), &json!(0)), "{report}");
}
