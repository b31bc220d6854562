//! RoAML models: used directly as scenarios, or named in a scenario's file.

mod as2fm;
mod lift;

use std::path::Path;
use std::sync::Arc;

use monitors::Outcome;
use recording::Detail;
use reports::Outputs;
use reports::report::Report;
use runs::Run;
use scenarios::scenario::Scenario;
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::{report, report_of, start};

/// A model of this project's own.
const LIFT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../roaml/tests/models/lift/main.xml");

fn run(model: &Arc<Scenario>, seed: u64) -> Report {
    let run = Run::new(Arc::clone(model), seed, true).expect("a system");
    report_of(run, Detail::Verdicts, &Outputs::default(), None).expect("a run that ends")
}

/// Whether the property with this name holds.
fn holds(report: &Report, property: &str) -> bool {
    let found = report.monitors.iter().find(|monitor| monitor.name == property).expect(property);
    found.verdict == Outcome::Satisfied
}

#[test]
fn a_scenario_puts_faults_into_a_model() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("lift.toml");
    let run = |lines: &str| {
        std::fs::write(&path, format!("model = {LIFT:?}\nexecution.policy = \"round-robin\"\n{lines}\n")).unwrap();
        report(&path, &["seed=4"])
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
    let outputs = Outputs { folder: Some(folder.path().join("out")), snapshots: true, ..Outputs::default() };
    let run = start(folder.path().join("main.xml"), &[]);
    let report = json!(report_of(run, Detail::Full, &outputs, None).unwrap());
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
