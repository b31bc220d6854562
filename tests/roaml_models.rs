//! RoAML models on the command line.

use std::path::Path;

use serde_json::Value;

use crate::steward::{refusal, steward};

/// A model of this project's own.
const LIFT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/roaml/tests/models/lift/main.xml");

fn said(arguments: &[&str]) -> String {
    let output = steward(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_model_is_checked_run_and_estimated() {
    let checked = said(&["check", LIFT]);
    assert!(checked.contains("a RoAML model: 5 machines, 3 properties"), "{checked}");
    let run = |seed: &str| serde_json::from_str::<Value>(&said(&["run", LIFT, "--json", "--seed", seed])).unwrap();
    assert_eq!(run("3"), run("3"));
    assert_eq!(run("3")["properties"][1]["holds"], true);
    assert_eq!(run("3")["errors"], serde_json::json!([]));
    let summary = said(&["run", LIFT]);
    assert!(
        summary.contains("never_above_three") && summary.contains("the model's time is over after 60.0 s"),
        "{summary}"
    );
    // 0.75²: the rides up and down.
    let estimate = said(&["campaign", LIFT, "--runs", "60"]);
    let counted = (0..60).filter(|seed| run(&seed.to_string())["properties"][0]["holds"] == true).count();
    assert!(estimate.contains(&format!("true in {counted} of 60")), "{counted}: {estimate}");
}

#[test]
fn what_a_model_cannot_have_is_refused() {
    let said = refusal(&["run", LIFT, "--gif", "run.gif"]);
    assert!(said.contains("`--gif` is for scenarios, and this is a RoAML model"), "{said}");
    let said = refusal(&["campaign", LIFT, "--only", "3"]);
    assert!(said.contains("`--only` is for scenarios"), "{said}");
    let machine = Path::new(LIFT).with_file_name("lift.ascxml");
    let said = refusal(&["skill", "check", machine.to_str().unwrap()]);
    assert!(said.contains("runs only in its model"), "{said}");
}
