//! RoAML models: used directly as scenarios, or named in a scenario's file.

mod as2fm;
mod lift;

use std::path::Path;
use std::sync::Arc;

use monitors::Outcome;
use reports::report::Report;
use scenarios::scenario::{Scenario, find};
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::steward::{refusal, report, steward};

/// A model of this project's own.
const LIFT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/roaml/tests/models/lift/main.xml");

fn load(path: &Path, set: &[&str]) -> Arc<Scenario> {
    let found = find::find(&path.display().to_string()).expect("a model");
    let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
    Arc::new(Scenario::load(&found, &set).expect("a sound model"))
}

fn run(model: &Arc<Scenario>, seed: u64) -> Report {
    campaigns::report_of(Arc::clone(model), seed).expect("a run that ends")
}

/// Whether the property with this name holds.
fn holds(report: &Report, property: &str) -> bool {
    let found = report.monitors.iter().find(|monitor| monitor.name == property).expect(property);
    found.verdict == Outcome::Satisfied
}

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
    let model = load(Path::new(LIFT), &[]);
    let counted = (0..60).filter(|seed| holds(&run(&model, *seed), "up_and_down")).count();
    assert!(estimate.contains(&format!("true in {counted} of 60")), "{counted}: {estimate}");
    let only = said(&["campaign", LIFT, "--runs", "60", "--out", &out, "--only", "7"]);
    assert!(only.contains("seed 7"), "{only}");
}

#[test]
fn a_scenario_puts_faults_into_a_model() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("lift.toml");
    let run = |lines: &str| {
        std::fs::write(&path, format!("model = {LIFT:?}\nexecution.policy = \"round-robin\"\n{lines}\n")).unwrap();
        report(path.to_str().unwrap(), folder.path(), &["--no-snapshots", "--seed", "4"])
    };
    let verdict = |report: &Value| report["monitors"][0]["verdict"].clone();
    let sound = run("expect.up_and_down = \"satisfied\"");
    assert_eq!((verdict(&sound), &sound["outcome"]), (json!("satisfied"), &json!("as_expected")));
    for fault in [
        "kind = \"component_frozen\"\nat_s = 0\ncomponent = \"Lift\"",
        "kind = \"component_crash\"\nat_s = 0.9\nlasts_s = 1\ncomponent = \"Lift\"",
        "kind = \"message_lost\"\nat_s = 0\nfrom = \"up\"\nto = \"Lift\"",
        "kind = \"skill_state_stuck\"\nat_s = 0\nskill = \"Lift\"\nstate = \"moving\"",
        "kind = \"skill_state_stuck\"\nin_state = \"Lift.moving\"\nskill = \"Lift\"\nstate = \"idle\"",
        "kind = \"tick_missed\"\nat_s = 0",
        "kind = \"leaf_inverted\"\nat_s = 0\nleaf = \"up\"",
    ] {
        let report = run(&format!("expect.up_and_down = \"violated\"\n[[faults]]\n{fault}"));
        assert_eq!((verdict(&report), &report["outcome"]), (json!("violated"), &json!("as_expected")), "{fault}");
        assert_eq!(report["faults"].as_array().unwrap().len(), 1, "{fault}");
    }
    let machine = Path::new(LIFT).with_file_name("lift.ascxml");
    let own = std::fs::read_to_string(machine).unwrap().replace("prob=\"0.75\"", "prob=\"0\"");
    std::fs::write(folder.path().join("Broken.ascxml"), own).unwrap();
    let broken = "[[faults]]\nkind = \"skill_replaced\"\nat_s = 0\nskill = \"Lift\"\nmachine = \"Broken.ascxml\"";
    assert_eq!(verdict(&run(broken)), "violated");
}

#[test]
fn a_model_without_a_tree_has_a_page_too() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("counter.ascxml", COUNTER);
    write("main.xml", MAIN);
    write("p.jani", PROPERTY);
    let report = report(folder.path().join("main.xml").to_str().unwrap(), &folder.path().join("out"), &[]);
    assert_eq!((&report["monitors"][0]["verdict"], &report["ticks"]), (&json!("satisfied"), &json!(0)));
    // The timer fires at 0.4 s, 0.8 s and 1.2 s.
    assert_eq!((&report["steps"], &report["sim_time_s"]), (&json!(6), &json!(1.2)));
}

const COUNTER: &str = r#"<ascxml name="Counter" initial="counting">
<ros_topic_publisher topic="count" type="std_msgs/Int32"/>
<ros_time_rate name="beat" rate_hz="2.5"/>
<datamodel><data id="count" type="int32" expr="0"/></datamodel>
<state id="counting"><ros_rate_callback name="beat" target="counting">
<assign location="count" expr="count + 1"/>
<ros_topic_publish name="count"><field name="data" expr="count"/></ros_topic_publish>
</ros_rate_callback></state></ascxml>"#;

const MAIN: &str = r#"<roaml><parameters><max_time value="1200" unit="ms"/></parameters>
<node_models><input type="node-ascxml" src="counter.ascxml"/></node_models>
<properties><input type="jani" src="p.jani"/></properties></roaml>"#;

const PROPERTY: &str = r#"{"properties": [{"name": "three", "expression": {"op": "filter", "fun": "values",
  "states": {"op": "initial"}, "values": {"op": "Pmin", "exp": {"op": "F", "exp":
  {"op": "=", "left": "topic_count_msg__ros_fields__data", "right": 3}}}}}]}"#;

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
