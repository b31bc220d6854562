//! Problems are shown as in `steward check`, and disappear with their causes.

use std::fs;

use serde_json::{Value, json};

use super::Editor;
use super::client::{SCENARIO, SCOPE, TREE, application};
use crate::steward::steward;

#[test]
fn problems_are_those_of_a_check_of_the_files() {
    let mut editor = Editor::new();
    application(&editor);
    editor.open("hospital.toml", SCENARIO);
    assert_eq!(editor.with_problems(), [""; 0]);
    editor.replace("hospital.toml", "initial_pct = 80", "intial_pct = 800");
    let shown = editor.diagnostics("hospital.toml");
    fs::write(editor.path("hospital.toml"), editor.text("hospital.toml")).unwrap();
    let checked = steward(&["check", "--json", editor.path("hospital.toml").to_str().unwrap()]);
    let checked: Value = serde_json::from_slice(&checked.stdout).unwrap();
    let problems = checked[0]["problems"].as_array().unwrap();
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert_eq!(shown.len(), 1, "{shown:?}");
    let message =
        format!("{}\nhelp: {}", problems[0]["message"].as_str().unwrap(), problems[0]["help"].as_str().unwrap());
    assert_eq!(shown[0]["message"], message);
    assert_eq!(shown[0]["range"]["start"], json!({ "line": 8, "character": 0 }));
    assert_eq!(shown[0]["range"]["end"], json!({ "line": 8, "character": 10 }));
    assert_eq!((&shown[0]["severity"], &shown[0]["source"]), (&json!(1), &json!("steward")));
}

#[test]
fn an_unsaved_tree_is_checked_with_the_scenario_that_names_it() {
    let mut editor = Editor::new();
    application(&editor);
    editor.open("tree.xml", TREE);
    assert_eq!(editor.with_problems(), [""; 0]);
    editor.replace("tree.xml", "<AnnounceArrival/>", "<AnnounceArival/>");
    assert_eq!(editor.with_problems(), ["tree.xml"]);
    editor.replace("tree.xml", "<AnnounceArival/>", "<AnnounceArrival/><GoToDestination name=\"GoBack\"/>");
    assert_eq!(editor.with_problems(), [""; 0]);
}

#[test]
fn a_problem_in_another_file_appears_and_disappears_with_its_cause() {
    let mut editor = Editor::new();
    application(&editor);
    editor.write("hospital.toml", &SCENARIO.replace("expect", "leaves.AnnounceArrival.data = {}\nexpect"));
    editor.open("tree.xml", TREE);
    assert_eq!(editor.with_problems(), [""; 0]);
    editor.replace("tree.xml", "      <AnnounceArrival/>\n", "");
    assert_eq!(editor.with_problems(), ["hospital.toml"]);
    editor.replace("tree.xml", "      <GoToDestination/>\n", "      <GoToDestination/>\n      <AnnounceArrival/>\n");
    assert_eq!(editor.with_problems(), [""; 0]);
    // A file that is closed counts as it was saved.
    editor.replace("tree.xml", "<SequenceWithMemory>", "<SequenceWithMemori>");
    assert_eq!(editor.with_problems(), ["tree.xml"]);
    editor.close("tree.xml");
    assert_eq!(editor.with_problems(), [""; 0]);
}

#[test]
fn a_file_that_another_program_changes_is_read_again() {
    let mut editor = Editor::with(json!({ "workspace": { "didChangeWatchedFiles": { "dynamicRegistration": true } } }));
    application(&editor);
    editor.open("hospital.toml", SCENARIO);
    assert_eq!(editor.with_problems(), [""; 0]);
    assert!(editor.is_watching);
    editor.write("tree.xml", &TREE.replace("<SequenceWithMemory>", "<SequenceWithMemori>"));
    let changes = json!({ "changes": [{ "uri": editor.address("tree.xml"), "type": 2 }] });
    editor.notify("workspace/didChangeWatchedFiles", changes);
    assert_eq!(editor.with_problems(), ["tree.xml"]);
}

#[test]
fn properties_belong_to_a_scenario_even_while_it_cannot_be_read() {
    let mut editor = Editor::new();
    application(&editor);
    editor.open("said.scope", SCOPE);
    editor.open("hospital.toml", SCENARIO);
    assert_eq!(editor.with_problems(), [""; 0]);
    editor.replace("said.scope", "Speaker", "Speeker");
    assert_eq!(editor.with_problems(), ["said.scope"]);
    editor.replace("hospital.toml", "expect = {}", "expect = {");
    assert_eq!(editor.with_problems(), ["hospital.toml"]);
    // What no scenario makes right is wrong meanwhile.
    for (file, right, wrong) in [
        ("said.scope", ":= ", ":= and "),
        ("said.scope", "property", "const said := 1\nproperty"),
        ("skills/AnnounceArrival.scxml", "<scxml ", "<scxml initial=\"nowhere\" "),
        ("parts/speaker.toml", "\"text\"", "\"texxt\""),
    ] {
        if file != "said.scope" {
            let text = fs::read_to_string(editor.path(file)).unwrap();
            editor.open(file, &text);
        }
        assert_eq!(editor.with_problems(), ["hospital.toml"]);
        editor.replace(file, right, wrong);
        assert_eq!(editor.with_problems(), ["hospital.toml", file]);
        editor.replace(file, wrong, right);
        assert_eq!(editor.with_problems(), ["hospital.toml"]);
    }
    editor.replace("hospital.toml", "expect = {", "expect = {}");
    // The same if it is refused after it has read the property.
    editor.replace("hospital.toml", "initial_pct = 80", "initial_pct = 800");
    editor.replace("said.scope", ":= always", ":= alwys");
    assert_eq!(editor.with_problems(), ["hospital.toml", "said.scope"]);
    editor.replace("said.scope", ":= alwys", ":= always");
    editor.replace("hospital.toml", "initial_pct = 800", "initial_pct = 80");
    editor.replace("said.scope", "Speeker", "Speaker");
    assert_eq!(editor.with_problems(), [""; 0]);
}

#[test]
fn a_part_of_a_scenario_is_checked_even_if_none_of_its_keys_is_known() {
    let mut editor = Editor::new();
    application(&editor);
    editor.open("parts/speaker.toml", "[qqqqqqqq.say]\nrequest = { text = \"text\" }\n");
    let problems = editor.problems("parts/speaker.toml");
    assert!(problems[0].starts_with("1: unknown key `qqqqqqqq`"), "{problems:?}");
}

#[test]
fn a_byte_order_mark_is_counted_and_kept() {
    let mut editor = Editor::new();
    editor.open("a.scope", "\u{feff}property p := alwys (*, *, true)\n");
    let start = |editor: &mut Editor| editor.diagnostics("a.scope")[0]["range"]["start"].clone();
    assert_eq!(start(&mut editor), json!({ "line": 0, "character": 10 }));
    editor.replace("a.scope", "property", "const c := 1\nproperty");
    assert_eq!(start(&mut editor), json!({ "line": 1, "character": 9 }));
    editor.replace("a.scope", "\u{feff}const c := 1\n", "");
    assert_eq!(start(&mut editor), json!({ "line": 0, "character": 9 }));
    editor.replace("a.scope", "alwys", "always not");
    assert_eq!(editor.with_problems(), [""; 0]);
}

#[cfg(unix)]
#[test]
fn a_folder_may_be_opened_through_a_link() {
    let mut editor = Editor::new();
    application(&editor);
    let link = editor.path("link");
    std::os::unix::fs::symlink(editor.folder.path(), &link).unwrap();
    let added = json!([{ "uri": format!("file://{}", link.display()), "name": "link" }]);
    let removed = json!([{ "uri": editor.address(""), "name": "test" }]);
    let event = json!({ "event": { "added": added, "removed": removed } });
    editor.notify("workspace/didChangeWorkspaceFolders", event);
    let text = fs::read_to_string(editor.path("skills/AnnounceArrival.scxml")).unwrap();
    editor.open("skills/AnnounceArrival.scxml", &text.replace("\"say\"", "\"sai\""));
    assert_eq!(editor.with_problems(), ["skills/AnnounceArrival.scxml"]);
    editor.replace("skills/AnnounceArrival.scxml", "\"sai\"", "\"say\"");
    assert_eq!(editor.with_problems(), [""; 0]);
}

#[test]
fn a_campaign_is_told_everything_at_its_place() {
    let mut editor = Editor::new();
    let text = "scenario = \"errnd\"\nsampling = \"random\"\nruns = 0\nset = [\"seed=2\", \"battery.initial_pct=800\",\n \"sed=3\"]\n\
                parameters = [{ key = \"battery.drain_pct_per_s\", from = 0.1, to = 0.2 }]\n";
    editor.open("c.toml", text);
    let lines = |editor: &mut Editor| {
        let problems = editor.problems("c.toml");
        problems.iter().map(|problem| problem.split(':').next().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(lines(&mut editor), ["1", "3"]);
    editor.replace("c.toml", "errnd", "errand");
    editor.replace("c.toml", "runs = 0", "runs = 2");
    assert_eq!(lines(&mut editor), ["4", "5"]);
    editor.replace("c.toml", "800", "80");
    editor.replace("c.toml", "sed=", "seed=");
    assert_eq!(editor.with_problems(), [""; 0]);
}

#[test]
fn positions_are_in_the_units_of_the_editor() {
    let text = "// 𝄞ä\nproperty p := eventually (*, *, m[1] = \"ä𝄞\") and always not (Nobody, AnnounceArrival, true)\n";
    for (encodings, unit) in [(json!(null), "utf-16"), (json!(["utf-16", "utf-8"]), "utf-8")] {
        let mut editor = Editor::with(json!({ "general": { "positionEncodings": encodings } }));
        assert_eq!(editor.capabilities()["positionEncoding"], unit);
        editor.open("a.scope", text);
        let shown = editor.diagnostics("a.scope");
        let line = text.lines().nth(1).unwrap();
        let before = &line[..line.find("Nobody").unwrap_or_else(|| panic!("{line}"))];
        let expected = if unit == "utf-8" { before.len() } else { before.encode_utf16().count() };
        let found =
            shown.iter().any(|problem| problem["range"]["start"] == json!({ "line": 1, "character": expected }));
        assert!(found, "{shown:?}");
    }
}

#[test]
fn an_unknown_request_and_a_wrong_notification_are_refused() {
    let mut editor = Editor::new();
    assert_eq!(editor.response("steward/unknown", json!({}))["error"]["code"], -32601);
    editor.notify("textDocument/didClose", json!({ "textDocument": { "uri": "untitled:1" } }));
    assert_eq!(editor.quit(), Some(0));
}
