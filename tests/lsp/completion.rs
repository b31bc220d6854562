//! What may be written, and what is written there.

use serde_json::Value;

use super::Editor;
use super::client::{SCENARIO, SCOPE, TREE, application};

/// An editor with the files of an application, all open.
fn opened() -> Editor {
    let mut editor = Editor::new();
    application(&editor);
    for (file, text) in [("hospital.toml", SCENARIO), ("tree.xml", TREE), ("said.scope", SCOPE)] {
        editor.open(file, text);
    }
    let machine = std::fs::read_to_string(editor.path("skills/AnnounceArrival.scxml")).unwrap();
    editor.open("skills/AnnounceArrival.scxml", &machine);
    assert_eq!(editor.with_problems(), [""; 0]);
    editor
}

/// The names that are proposed after a text.
fn proposed(editor: &mut Editor, file: &str, after: &str) -> Vec<String> {
    let items = editor.ask_after("textDocument/completion", file, after);
    items.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap().to_owned()).collect()
}

/// The explanation of the text before a place.
fn explained(editor: &mut Editor, file: &str, after: &str) -> String {
    let hover = editor.ask_after("textDocument/hover", file, after);
    hover["contents"]["value"].as_str().unwrap_or_else(|| panic!("{hover}")).to_owned()
}

fn has(names: &[String], wanted: &[&str]) {
    for name in wanted {
        assert!(names.iter().any(|known| known == name), "no {name} in {names:?}");
    }
}

#[test]
fn a_key_that_has_its_value_is_completed_without_another() {
    let mut editor = Editor::new();
    editor.open("a.toml", "[battery]\ninit = 80\n");
    let keys = editor.ask_after("textDocument/completion", "a.toml", "init");
    let key = keys.as_array().unwrap().iter().find(|item| item["label"] == "initial_pct").unwrap();
    assert_eq!(key["textEdit"]["newText"], "initial_pct");
    // A fault has the parameters of its kind, in either form.
    for text in
        ["[[faults]]\nlevel_p\nkind = \"battery_level\"\n", "faults = [{ kind = \"battery_level\", level_p }]\n"]
    {
        editor.open("c.toml", text);
        let keys = editor.ask_after("textDocument/completion", "c.toml", "level_p");
        assert!(keys.as_array().unwrap().iter().any(|item| item["label"] == "level_pct"), "{keys}");
        editor.close("c.toml");
    }
    editor.open("d.scope", "const theta := 30\nproperty low := always (BatteryReader, BatteryLevel, m[2] > th)\n");
    let constants = editor.ask_after("textDocument/completion", "d.scope", "m[2] > th");
    assert!(constants.as_array().unwrap().iter().any(|item| item["label"] == "theta"), "{constants}");
    editor.open("b.toml", "[expect]\nreached = []\n");
    let hover = editor.ask_after("textDocument/hover", "b.toml", "reac").to_string();
    assert!(!hover.contains("verdict") && hover.contains("reached"), "{hover}");
}

#[test]
fn keys_and_values_of_scenarios_are_proposed() {
    let mut editor = opened();
    editor.replace(
        "hospital.toml",
        "initial_pct = 80\n",
        "initial_pct = 80\n\n[execution]\ntree = \"\"\n[sites]\nstart = ",
    );
    let of_battery = proposed(&mut editor, "hospital.toml", "initial_pct = 80\n");
    has(&of_battery, &["drain_pct_per_s"]);
    assert!(!of_battery.contains(&"initial_pct".to_owned()));
    has(&proposed(&mut editor, "hospital.toml", "[execution]\ntree = \""), &["whole", "nodes"]);
    has(&proposed(&mut editor, "hospital.toml", "start = "), &["Destination", "RechargingStation"]);
    let item = editor.ask_after("textDocument/completion", "hospital.toml", "initial_pct = 80\n");
    let drain = item.as_array().unwrap().iter().find(|item| item["label"] == "drain_pct_per_s").unwrap();
    assert_eq!(drain["textEdit"]["newText"], "drain_pct_per_s = ");
    assert!(drain["documentation"]["value"].as_str().unwrap().contains("default"), "{drain}");
}

#[test]
fn a_key_is_explained_with_its_range_and_default() {
    let mut editor = opened();
    let text = explained(&mut editor, "hospital.toml", "initial_pct");
    assert!(text.starts_with("`battery.initial_pct`") && text.contains("from 0 to 100; default"), "{text}");
}

#[test]
fn nodes_ports_and_leaves_of_trees_are_proposed_and_explained() {
    let mut editor = opened();
    editor.replace("tree.xml", "      <GoToDestination/>\n", "      <\n      <GoToDestination/>\n      <Repeat />\n");
    has(
        &proposed(&mut editor, "tree.xml", "      <"),
        &["Sequence", "RetryUntilSuccessful", "AnnounceArrival", "SubTree"],
    );
    has(&proposed(&mut editor, "tree.xml", "<Repeat "), &["num_cycles", "name", "_skipIf"]);
    has(&proposed(&mut editor, "tree.xml", "<"), &["root"]);
    assert!(explained(&mut editor, "tree.xml", "<Repeat").contains("`num_cycles`: an integer; required"));
    assert!(explained(&mut editor, "tree.xml", "<GoToDest").contains("a leaf"));
}

#[test]
fn elements_attributes_and_targets_of_machines_are_proposed() {
    let mut editor = opened();
    let file = "skills/AnnounceArrival.scxml";
    editor.replace(file, "    <state id=\"idle\"/>", "    <state id=\"idle\"/>\n    <\n    <send  target=\"\"/>");
    has(&proposed(&mut editor, file, "    <state id=\"idle\"/>\n    <"), &["transition", "onentry"]);
    has(&proposed(&mut editor, file, "<send "), &["delay", "id"]);
    has(&proposed(&mut editor, file, "<send  target=\""), &["Speaker", "BT", "Navigation"]);
    has(&proposed(&mut editor, file, "event=\"BT.tick\" target=\""), &["idle", "saying"]);
}

#[test]
fn processes_fields_and_words_of_properties_are_proposed_and_explained() {
    let mut editor = opened();
    has(&proposed(&mut editor, "said.scope", "said := alw"), &["always", "eventually"]);
    has(&proposed(&mut editor, "said.scope", "not ("), &["Speaker", "BT", "AnnounceArrival"]);
    assert_eq!(proposed(&mut editor, "said.scope", "Speaker, "), ["AnnounceArrival"]);
    has(&proposed(&mut editor, "said.scope", "m[1] = <"), &["ok", "error"]);
    let meaning = explained(&mut editor, "said.scope", "property sai");
    assert!(meaning.contains("Speaker") && !meaning.contains(":="), "{meaning}");
    assert!(explained(&mut editor, "said.scope", "always").contains("```\n"));
}

#[test]
fn broken_texts_are_answered() {
    let mut editor = opened();
    for file in ["hospital.toml", "tree.xml", "said.scope", "skills/AnnounceArrival.scxml"] {
        let text = editor.text(file).to_owned();
        for end in (0..text.len()).step_by(37).filter(|end| text.is_char_boundary(*end)) {
            editor.edit(file, 0..editor.text(file).len(), &text[..end]);
            for method in ["completion", "hover", "definition", "references"] {
                let mut params = serde_json::json!({ "textDocument": { "uri": editor.address(file) } });
                params["position"] = super::client::position(&text, end);
                if method == "references" {
                    params["context"] = serde_json::json!({ "includeDeclaration": true });
                }
                let _: Value = editor.request(&format!("textDocument/{method}"), params);
            }
        }
        editor.edit(file, 0..editor.text(file).len(), &text);
    }
    assert_eq!(editor.with_problems(), [""; 0]);
}
