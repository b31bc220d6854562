//! Errors in nodes of a running tree are in the report, on its page and in the summary.

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::bad_input::copy_of_battery_fault;
use crate::steward::steward;

/// Runs a few ticks of a copy of `battery_fault` whose tree reads an entry that the blackboard does not have.
fn run(form: &str) -> (Value, String, String) {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let tree = scenario.with_file_name("trees").join("recharge.xml");
    let text = std::fs::read_to_string(&tree).unwrap();
    let spoilt = text.replacen("<ReactiveFallback>", "<ReactiveFallback><ScriptCondition code=\"missing == 1\"/>", 1);
    assert_ne!(spoilt, text);
    std::fs::write(&tree, spoilt).unwrap();
    let out = folder.path().join("out");
    let form = format!("execution.tree={form}");
    let output = steward(&[
        "--scenario",
        scenario.to_str().unwrap(),
        "--no-snapshots",
        "--out",
        out.to_str().unwrap(),
        "--set",
        "execution.max_time_s=5",
        "--set",
        &form,
    ]);
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let report = serde_json::from_str(&read("report.json")).unwrap();
    (report, read("report.html"), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn a_failing_script_is_reported_once_in_either_form_of_the_tree() {
    for form in ["whole", "nodes"] {
        let (report, page, summary) = run(form);
        let errors = &report["tree_errors"];
        let message = "the blackboard has no entry `missing`";
        let expected = json!([{
            "node": 2, "label": "ScriptCondition", "message": message, "tick": 0, "time_s": errors[0]["time_s"],
        }]);
        assert_eq!(*errors, expected, "as {form}");
        assert!(page.contains("ScriptCondition (node 2)"), "as {form}");
        assert!(
            summary.contains(&format!("  tree     ScriptCondition (node 2): {message}; first at tick 0")),
            "{summary}"
        );
    }
}
