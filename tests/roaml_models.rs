//! RoAML models on the command line.

use std::path::Path;
use std::sync::Arc;

use monitors::Outcome;
use reports::report::Report;
use scenarios::scenario::{Scenario, find};
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::steward::{refusal, steward};

/// A model of this project's own.
const LIFT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/roaml/tests/models/lift/main.xml");

fn said(arguments: &[&str]) -> String {
    let output = steward(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_model_runs_like_a_scenario() {
    let checked = said(&["check", LIFT]);
    assert!(checked.contains("a scenario with a RoAML model of 5 machines, 3 properties, 0 faults"), "{checked}");
    let folder = tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let (out, junit, gif, recorded) = (file("out"), file("junit.xml"), file("run.gif"), file("run.rec"));
    let arguments =
        ["run", LIFT, "--seed", "3", "--out", &out, "--results", &junit, "--gif", &gif, "--record", &recorded];
    let summary = said(&arguments);
    assert!(summary.contains("never_above_three") && summary.contains("the limit of 60 s was reached"), "{summary}");
    let read = |path: &str| std::fs::read_to_string(path).unwrap();
    let report: Value = serde_json::from_str(&read(&file("out/report.json"))).unwrap();
    assert_eq!(report["monitors"][1]["property"], "G (topic_floor_msg.data ≤ 3)");
    assert_eq!((&report["monitors"][1]["verdict"], &report["skill_errors"]), (&json!("satisfied"), &json!([])));
    let page = read(&file("out/report.html"));
    assert!(page.contains("up_and_down") && page.contains("Lift"), "the page of a run");
    assert!(read(&junit).contains("<testsuite "), "{}", read(&junit));
    assert!(std::fs::read(&gif).unwrap().starts_with(b"GIF89a"));
    said(&["report", &recorded, "--out", &file("again")]);
    let again: Value = serde_json::from_str(&read(&file("again/report.json"))).unwrap();
    assert_eq!(again["trace_hash"], report["trace_hash"]);
}

#[test]
fn a_campaign_estimates_the_probability_of_each_property() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("campaign").display().to_string();
    let estimate = said(&["campaign", LIFT, "--runs", "60", "--out", &out]);
    let model = Arc::new(Scenario::load(&find::find(LIFT).unwrap(), &[]).unwrap());
    let reports = (0..60).map(|seed| campaigns::report_of(Arc::clone(&model), seed).unwrap());
    let holds =
        |report: &Report| report.monitors.iter().any(|it| it.name == "up_and_down" && it.verdict == Outcome::Satisfied);
    let counted = reports.filter(holds).count();
    assert!(estimate.contains(&format!("true in {counted} of 60")), "{counted}: {estimate}");
    let only = said(&["campaign", LIFT, "--runs", "60", "--out", &out, "--only", "7"]);
    assert!(only.contains("seed 7"), "{only}");
}

#[test]
fn keys_that_a_model_determines_itself_are_refused_beside_it() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("own.toml");
    for (lines, key) in [("tree = \"tree.xml\"", "tree"), ("[components.Door]\nmachine = \"Door.scxml\"", "components")]
    {
        std::fs::write(&path, format!("model = {LIFT:?}\n{lines}\n")).unwrap();
        let said = refusal(&["check", path.to_str().unwrap()]);
        assert!(said.contains(&format!("`{key}` is not allowed beside a `model`")), "{said}");
    }
    let machine = Path::new(LIFT).with_file_name("lift.ascxml");
    let said = refusal(&["skill", "check", machine.to_str().unwrap()]);
    assert!(said.contains("runs only within its model"), "{said}");
}
