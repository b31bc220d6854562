//! A robot's messages, described by a mapping, and properties about them.

use std::fs;

use serde_json::{Value, json};

use super::Editor;
use crate::steward::steward;

const MAPPING: &str = r#"# A robot.
tick_s = 0.5

[[messages]]
topic = "/battery_state"
type = "sensor_msgs/msg/BatteryState"
from = "battery"
to = "base"
[messages.fields]
level_pct = { path = "percentage", scale = 100 }

[[messages]]
topic = "/cmd_vel"
type = "geometry_msgs/msg/Twist"
from = "controller"
to = "base"
[messages.fields]
speed_mps = "linear.x"
"#;

const PROPERTY: &str = "property slow := always not (controller, base, speed_mps > 1)\n";

/// An editor with a mapping and properties, both open.
fn opened() -> Editor {
    let mut editor = Editor::new();
    editor.open("robot.toml", MAPPING);
    editor.open("safety.scope", PROPERTY);
    assert_eq!(editor.with_problems(), [""; 0]);
    editor
}

fn labels(items: &Value) -> Vec<&str> {
    items.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap()).collect()
}

#[test]
fn a_mapping_is_checked_against_the_types_that_it_names() {
    let mut editor = opened();
    editor.replace("robot.toml", "\"percentage\"", "\"percent\"");
    let problems = editor.problems("robot.toml");
    assert!(problems.len() == 1 && problems[0].starts_with("10: ") && problems[0].contains("percent"), "{problems:?}");
    editor.replace("robot.toml", "\"percent\"", "\"percentage\"");
    editor.replace("robot.toml", "tick_s = 0.5", "tick_s = 0.5\nreorder_s = 0\n");
    let keys = editor.ask_after("textDocument/completion", "robot.toml", "reorder_s = 0\n");
    assert!(labels(&keys).contains(&"definitions") && !labels(&keys).contains(&"tick_s"), "{keys}");
    let hover = editor.ask_after("textDocument/hover", "robot.toml", "tick_s");
    assert!(hover["contents"]["value"].as_str().unwrap().contains("between ticks"), "{hover}");
}

#[test]
fn properties_without_a_scenario_are_about_the_robot_of_the_mapping_beside_them() {
    let mut editor = opened();
    editor.replace("safety.scope", "(controller,", "(driver,");
    let problems = editor.problems("safety.scope");
    assert!(problems.len() == 1 && problems[0].contains("driver"), "{problems:?}");
    editor.replace("safety.scope", "(driver,", "(controller,");
    let fields = editor.ask_after("textDocument/completion", "safety.scope", "base, ");
    assert!(labels(&fields).contains(&"speed_mps"), "{fields}");
    let hover = editor.ask_after("textDocument/hover", "safety.scope", "property sl");
    assert!(hover["contents"]["value"].as_str().unwrap().contains("controller"), "{hover}");
    let definition = editor.ask_after("textDocument/definition", "safety.scope", "(contr");
    assert!(definition.to_string().contains("robot.toml"), "{definition}");
    // What the mapping says now.
    editor.replace("robot.toml", "speed_mps", "speed");
    let problems = editor.problems("safety.scope");
    assert!(problems.len() == 1 && problems[0].contains("speed_mps"), "{problems:?}");
}

#[test]
fn while_a_mapping_cannot_be_read_names_are_those_that_it_had() {
    let mut editor = opened();
    editor.replace("robot.toml", "tick_s = 0.5", "tick_s = ");
    assert_eq!(editor.with_problems(), ["robot.toml"]);
    let names = editor.ask_after("textDocument/completion", "safety.scope", "not (");
    assert!(labels(&names).contains(&"controller") && !labels(&names).contains(&"BT"), "{names}");
    // Nothing is known of a robot whose mapping could never be read.
    let mut editor = Editor::new();
    editor.open("robot.toml", &MAPPING.replace("tick_s = 0.5", "tick_s = "));
    editor.open("safety.scope", PROPERTY);
    let names = editor.ask_after("textDocument/completion", "safety.scope", "not (");
    assert!(!labels(&names).contains(&"controller") && !labels(&names).contains(&"BT"), "{names}");
}

#[test]
fn a_process_is_renamed_in_the_mapping_and_in_its_properties() {
    let mut editor = opened();
    let text = editor.text("safety.scope");
    let at = super::client::position(text, text.find("controller").unwrap());
    let params = json!({
        "textDocument": { "uri": editor.address("safety.scope") }, "position": at, "newName": "driver"
    });
    let changes = editor.request("textDocument/rename", params);
    let edits = |file: &str| changes["changes"][editor.address(file)].as_array().map_or(0, Vec::len);
    assert_eq!((edits("robot.toml"), edits("safety.scope")), (1, 1), "{changes}");
}

#[test]
fn a_misspelled_type_is_shown_where_it_is() {
    let mut editor = opened();
    for wrong in ["geometry_msgs/msg/Twits", "geometri_msgs/msg/Twist"] {
        editor.replace("robot.toml", "geometry_msgs/msg/Twist", wrong);
        let problems = editor.problems("robot.toml");
        let line = editor.text("robot.toml").lines().position(|line| line.contains(wrong)).unwrap() + 1;
        let is_at_type = problems.len() == 1 && problems[0].starts_with(&format!("{line}: "));
        assert!(is_at_type && problems[0].contains("did you mean `geometry_msgs/msg/Twist`"), "{problems:?}");
        editor.replace("robot.toml", wrong, "geometry_msgs/msg/Twist");
    }
    // It is nobody's business here what other packages define.
    editor.replace("robot.toml", "geometry_msgs/msg/Twist", "acme_msgs/msg/Twitch");
    assert_eq!(editor.problems("robot.toml"), [""; 0]);
}

#[test]
fn types_that_only_a_robot_tells_are_left_open_and_named() {
    let mut editor = opened();
    editor.replace("robot.toml", "type = \"geometry_msgs/msg/Twist\"\n", "");
    assert_eq!(editor.problems("robot.toml"), [""; 0]);
    let problems = editor.problems("safety.scope");
    assert!(problems.len() == 1 && problems[0].contains("/cmd_vel"), "{problems:?}");
    for file in ["robot.toml", "safety.scope"] {
        editor.write(file, editor.text(file));
    }
    let [mapping, property] = ["robot.toml", "safety.scope"].map(|file| editor.path(file).display().to_string());
    let check = |arguments: &[&str]| {
        let output = steward(&[&["check"], arguments].concat());
        (output.status.code(), String::from_utf8(output.stdout).unwrap() + &String::from_utf8_lossy(&output.stderr))
    };
    let (status, said) = check(&[&mapping]);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(status == Some(0) && said.contains("a mapping of 2 topics, without the types of /cmd_vel"), "{said}");
    let (status, said) = check(&[&property, "--scenario", &mapping]);
    assert!(status == Some(2) && said.contains("does not define what the messages of /cmd_vel"), "{said}");
    fs::write(&mapping, MAPPING).unwrap();
    let (status, said) = check(&[&property, "--scenario", &mapping]);
    assert!(status == Some(0) && said.contains("1 property; no problems found"), "{said}");
}

#[test]
fn missing_keys_have_a_quick_fix() {
    let mut editor = Editor::new();
    editor.open("robot.toml", MAPPING);
    editor.open("faults.toml", "base = \"nominal\"\n");
    editor.open("begun.toml", "reorder_s = 1\n[[messages]]\ntopic = 1");
    let cases = [
        // The last line has no end.
        ("begun.toml", "\n[[messages]]\ntopic = 1", "", "Add `messages`", "\n[[messages]]\n"),
        ("robot.toml", "from = \"battery\"\n", "", "Add `from`", "from = \"\"\n"),
        ("robot.toml", "[messages.fields]\nspeed_mps = \"linear.x\"\n", "", "Add `fields`", "fields = {}\n"),
        ("faults.toml", "\n", "\n[[faults]]\nat_s = 3\n", "Add `kind`", "kind = "),
        ("faults.toml", "\n", "\nfaults = [{ at_s = 3 }]\n", "Add `kind`", ", kind = "),
    ];
    for (file, right, wrong, title, added) in cases {
        let before = editor.text(file).to_owned();
        editor.replace(file, right, wrong);
        let problems = editor.diagnostics(file);
        let params = json!({
            "textDocument": { "uri": editor.address(file) }, "range": problems[0]["range"],
            "context": { "diagnostics": problems }
        });
        let actions = editor.request("textDocument/codeAction", params);
        let action = actions.as_array().unwrap().iter().find(|action| action["title"] == title);
        let action = action.unwrap_or_else(|| panic!("{problems:?}: {actions}"));
        let edit = &action["edit"]["changes"][editor.address(file)][0];
        assert!(edit["newText"].as_str().unwrap().starts_with(added), "{action}");
        let all = editor.text(file).len();
        editor.edit(file, 0..all, &before);
    }
    assert_eq!(editor.with_problems(), ["begun.toml"]);
}
