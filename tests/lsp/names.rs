//! Names, where they are defined and used, and changed everywhere.

use std::fs;

use serde_json::{Value, json};

use super::Editor;
use super::client::{SCENARIO, SCOPE, TREE, application, position};
use crate::steward::steward;

/// The capabilities of an editor that also renames files.
fn renames_files() -> Value {
    json!({ "workspace": { "workspaceEdit": { "documentChanges": true, "resourceOperations": ["rename"] } } })
}

fn opened(capabilities: Value) -> Editor {
    let mut editor = Editor::with(capabilities);
    application(&editor);
    for (file, text) in [("hospital.toml", SCENARIO), ("tree.xml", TREE), ("said.scope", SCOPE)] {
        editor.open(file, text);
    }
    assert_eq!(editor.with_problems(), [""; 0]);
    editor
}

/// The files and lines, from 1, of locations.
fn places(editor: &Editor, locations: &Value) -> Vec<String> {
    let folder = editor.address("");
    let place = |location: &Value| {
        let file = location["uri"].as_str().unwrap().trim_start_matches(&folder).to_owned();
        format!("{file}:{}", location["range"]["start"]["line"].as_u64().unwrap() + 1)
    };
    locations.as_array().unwrap_or_else(|| panic!("{locations}")).iter().map(place).collect()
}

fn defined(editor: &mut Editor, file: &str, after: &str) -> Vec<String> {
    let found = editor.ask_after("textDocument/definition", file, after);
    places(editor, &found)
}

#[test]
fn a_name_leads_to_its_definition_in_another_file() {
    let mut editor = opened(json!({}));
    assert_eq!(defined(&mut editor, "said.scope", "(Speak"), ["hospital.toml:5", "parts/Speaker.scxml:3"]);
    let leaf = ["skills/AnnounceArrival.scxml:3", "tree.xml:5"];
    assert_eq!(defined(&mut editor, "said.scope", "Speaker, Announce"), leaf);
    assert_eq!(defined(&mut editor, "hospital.toml", "tree = \"tree"), ["tree.xml:1"]);
    assert_eq!(defined(&mut editor, "hospital.toml", "machine = \"parts"), ["parts/Speaker.scxml:1"]);
    assert_eq!(defined(&mut editor, "tree.xml", "main_tree_to_execute=\"To"), ["tree.xml:2"]);
}

#[test]
fn all_uses_of_a_name_are_found() {
    let mut editor = opened(json!({}));
    let text = editor.text("said.scope").to_owned();
    let params = |declared: bool| {
        json!({
            "textDocument": { "uri": editor.address("said.scope") },
            "position": position(&text, text.find("Announce").unwrap()), "context": { "includeDeclaration": declared }
        })
    };
    let (all, used) = (params(true), params(false));
    let all = editor.request("textDocument/references", all);
    let expected = ["said.scope:1", "skills/AnnounceArrival.scxml:3", "tree.xml:5", "tree.xml:10"];
    assert_eq!(places(&editor, &all), expected);
    let used = editor.request("textDocument/references", used);
    assert_eq!(places(&editor, &used), ["said.scope:1", "tree.xml:10"]);
}

/// Asks for another name of what is after a text.
fn rename(editor: &mut Editor, file: &str, after: &str, name: &str) -> Value {
    let text = editor.text(file);
    let place = position(text, text.find(after).unwrap() + after.len());
    let document = json!({ "uri": editor.address(file) });
    editor.response("textDocument/rename", json!({ "textDocument": document, "position": place, "newName": name }))
}

/// Does in the files what an editor would do.
fn carry_out(editor: &mut Editor, edit: &Value) {
    let folder = editor.address("");
    let file = |address: &Value| address.as_str().unwrap().trim_start_matches(&folder).to_owned();
    for change in edit["documentChanges"].as_array().unwrap() {
        if change["kind"] == "rename" {
            fs::rename(editor.path(&file(&change["oldUri"])), editor.path(&file(&change["newUri"]))).unwrap();
            continue;
        }
        let path = editor.path(&file(&change["textDocument"]["uri"]));
        let mut text = fs::read_to_string(&path).unwrap();
        let mut edits: Vec<&Value> = change["edits"].as_array().unwrap().iter().collect();
        edits.sort_by_key(|edit| {
            (edit["range"]["start"]["line"].as_u64(), edit["range"]["start"]["character"].as_u64())
        });
        for edit in edits.into_iter().rev() {
            let byte = |place: &Value| {
                let line = place["line"].as_u64().unwrap() as usize;
                let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
                start + place["character"].as_u64().unwrap() as usize
            };
            let range = byte(&edit["range"]["start"])..byte(&edit["range"]["end"]);
            text.replace_range(range, edit["newText"].as_str().unwrap());
        }
        fs::write(&path, text).unwrap();
    }
}

#[test]
fn a_leaf_and_a_component_are_renamed_in_all_files() {
    for (after, name) in [("(Speak", "Voice"), ("(Speaker, Announ", "SayHello")] {
        let mut editor = opened(renames_files());
        let response = rename(&mut editor, "said.scope", after, name);
        carry_out(&mut editor, &response["result"]);
        let scope = fs::read_to_string(editor.path("said.scope")).unwrap();
        assert!(scope.contains(name), "{response}");
        let checked = steward(&["check", editor.path("hospital.toml").to_str().unwrap()]);
        assert!(checked.status.success(), "{name}: {}", String::from_utf8_lossy(&checked.stderr));
        let has = |name: &str| editor.path(&format!("skills/{name}.scxml")).exists();
        assert_eq!((has("SayHello"), has("AnnounceArrival")), (name == "SayHello", name == "Voice"));
    }
}

#[test]
fn names_are_changed_in_all_scenarios_that_share_a_definition() {
    let mut editor = opened(renames_files());
    // Another scenario has the same machine, in a tree of its own.
    editor.write("second.toml", &SCENARIO.replace("tree.xml", "b.xml"));
    editor.write("b.xml", TREE);
    let response = rename(&mut editor, "tree.xml", "<GoToDestination/>\n      <Announ", "SayHello");
    carry_out(&mut editor, &response["result"]);
    for scenario in ["hospital.toml", "second.toml"] {
        let checked = steward(&["check", editor.path(scenario).to_str().unwrap()]);
        assert!(checked.status.success(), "{scenario}: {}", String::from_utf8_lossy(&checked.stderr));
    }
    assert!(fs::read_to_string(editor.path("b.xml")).unwrap().contains("<SayHello/>"), "{response}");
}

#[test]
fn a_name_that_would_break_something_is_refused() {
    let mut editor = opened(json!({}));
    let why =
        |response: Value| response["error"]["message"].as_str().unwrap_or_else(|| panic!("{response}")).to_owned();
    assert!(why(rename(&mut editor, "said.scope", "(Speak", "Announce Arrival")).contains("is not a name"));
    assert!(why(rename(&mut editor, "said.scope", "(Speak", "AnnounceArrival")).contains("there is already"));
    assert!(why(rename(&mut editor, "said.scope", "(Speak", "BT")).contains("a check would find"));
    assert!(why(rename(&mut editor, "said.scope", "(Speaker, Ann", "SayHello")).contains("does not rename files"));
    assert_eq!(rename(&mut editor, "said.scope", "property sa", "told")["error"], Value::Null);
    // A machine that nobody uses yet is not overwritten.
    let mut editor = opened(renames_files());
    editor.write("skills/Spare.scxml", "<scxml/>");
    assert!(why(rename(&mut editor, "said.scope", "(Speaker, Ann", "Spare")).contains("there is already a file"));
}

#[test]
fn documents_have_an_outline() {
    let mut editor = opened(json!({}));
    let outline = |editor: &mut Editor, file: &str| -> Vec<String> {
        let document = json!({ "textDocument": { "uri": editor.address(file) } });
        let symbols = editor.request("textDocument/documentSymbol", document);
        let name =
            |symbol: &Value| format!("{} {}", symbol["detail"].as_str().unwrap(), symbol["name"].as_str().unwrap());
        symbols.as_array().unwrap().iter().map(name).collect()
    };
    assert_eq!(outline(&mut editor, "tree.xml"), ["tree Tour", "process GoToDestination", "process AnnounceArrival"]);
    assert_eq!(outline(&mut editor, "said.scope"), ["property said"]);
    assert_eq!(outline(&mut editor, "hospital.toml"), ["process Speaker", "table battery"]);
}

#[test]
fn a_misspelled_name_has_a_quick_fix_that_a_check_confirms() {
    let mut editor = opened(json!({}));
    let mistakes = [
        ("hospital.toml", "initial_pct = 80", "intial_pct = 80", "initial_pct"),
        ("said.scope", "(Speaker", "(Speeker", "Speaker"),
        ("tree.xml", "<SequenceWithMemory>", "<SequenceWithMemori>", ""),
        ("tree.xml", "execute=\"Tour\"", "execute=\"Tuor\"", "Tour"),
        ("hospital.toml", "tree = \"tree.xml\"", "tree = \"trees.xml\"", "tree.xml"),
        ("hospital.toml", "base = \"nominal\"", "base = \"nominl\"", "nominal"),
        ("hospital.toml", "initial_pct = 80", "\"intial_pct\" = 80", "initial_pct"),
        // Another dialect is no misspelling.
        ("tree.xml", "BTCPP_format=\"4\"", "BTCPP_format=\"5\"", ""),
        // A warning.
        ("tree.xml", "<AnnounceArrival/>", "<AnnounceArrival _onSucces=\"\"/>", "_onSuccess"),
        ("skills/AnnounceArrival.scxml", "expr=\"text\"", "expr=\"texd\"", "text"),
        ("skills/AnnounceArrival.scxml", "event=\"say\"", "event=\"sai\"", "say"),
        ("skills/AnnounceArrival.scxml", "target=\"saying\"", "target=\"saing\"", "saying"),
    ];
    let machine = std::fs::read_to_string(editor.path("skills/AnnounceArrival.scxml")).unwrap();
    editor.open("skills/AnnounceArrival.scxml", &machine);
    for (file, right, wrong, meant) in mistakes {
        editor.replace(file, right, wrong);
        let problems = editor.diagnostics(file);
        assert!(!problems.is_empty(), "{file}");
        let params = json!({
            "textDocument": { "uri": editor.address(file) }, "range": problems[0]["range"],
            "context": { "diagnostics": problems }
        });
        let actions = editor.request("textDocument/codeAction", params);
        let (texts, address) = (actions.as_array().unwrap().iter(), editor.address(file));
        let texts = texts.map(|action| action["edit"]["changes"][&address][0]["newText"].as_str().unwrap());
        // Which name of an element is right if its end has another one is not certain.
        assert_eq!(texts.collect::<Vec<_>>(), if meant.is_empty() { vec![] } else { vec![meant] }, "{file}");
        editor.replace(file, wrong, right);
    }
    let end = editor.text("tree.xml").find("</SequenceWithMemory>").unwrap();
    editor.edit("tree.xml", end..end + "</SequenceWithMemory>".len(), "</SequenceWithMemori>");
    editor.replace("tree.xml", "<SequenceWithMemory>", "<SequenceWithMemori>");
    let problems = editor.diagnostics("tree.xml");
    let params = json!({
        "textDocument": { "uri": editor.address("tree.xml") }, "range": problems[0]["range"],
        "context": { "diagnostics": problems }
    });
    let actions = editor.request("textDocument/codeAction", params);
    let text = actions[0]["edit"]["changes"][editor.address("tree.xml")][0]["newText"].as_str().unwrap();
    assert!(text.starts_with("SequenceWithMemory>") && text.ends_with("</SequenceWithMemory"), "{actions}");
    editor.replace("tree.xml", "SequenceWithMemori", "SequenceWithMemory");
    editor.replace("tree.xml", "SequenceWithMemori", "SequenceWithMemory");
    // The same mistake twice.
    let twice = SCOPE.replace("Speaker", "Speeker");
    editor.replace("said.scope", SCOPE, &(twice.clone() + &twice.replace("property said", "property told")));
    let problems = editor.diagnostics("said.scope");
    let params = json!({
        "textDocument": { "uri": editor.address("said.scope") }, "range": problems[0]["range"],
        "context": { "diagnostics": problems }
    });
    let actions = editor.request("textDocument/codeAction", params);
    assert_eq!(actions.as_array().map(Vec::len), Some(1), "{actions}");
}
