//! Files that are typed from nothing, character by character: what is shown at the end of each line is recorded.

use super::Editor;
use super::client::{SCENARIO, SCOPE, TREE, application};

/// Types a file, and returns its lines, each with the problems that are shown after it.
fn typed(editor: &mut Editor, file: &str, text: &str) -> String {
    let mut record = String::new();
    editor.open(file, "");
    for line in text.split_inclusive('\n') {
        for c in line.chars() {
            let end = editor.text(file).len();
            editor.edit(file, end..end, c.encode_utf8(&mut [0; 4]));
        }
        record += line;
        for problem in editor.problems(file) {
            let (first, rest) = problem.split_once('\n').unwrap_or((&problem, ""));
            record += &format!("    | {first}\n");
            record += &rest.lines().map(|line| format!("    |   {line}\n")).collect::<String>();
        }
    }
    record.replace(&editor.folder.path().display().to_string(), "FOLDER")
}

/// Types a file of the application, whose other files are there.
fn session(name: &str, file: &str, text: &str) {
    let mut editor = Editor::new();
    application(&editor);
    let record = typed(&mut editor, file, text);
    insta::assert_snapshot!(format!("session_{name}"), record);
}

#[test]
fn a_scenario() {
    session("scenario", "hospital.toml", SCENARIO);
}

#[test]
fn a_scenario_with_faults() {
    let faults =
        "[[faults]]\nkind = \"message_loss\"\nat_s = 5\n[[faults]]\nkind = \"wheel_slip\"\nfactor = 0.5\nat_s = 2\n";
    session("faults", "hospital.toml", &format!("{SCENARIO}{faults}"));
}

#[test]
fn a_scenario_based_on_another() {
    session("base", "ward.toml", "base = \"hospital.toml\"\nseed = 7\n[people]\n");
}

#[test]
fn a_tree() {
    session("tree", "tree.xml", TREE);
}

#[test]
fn a_tree_with_ports() {
    let repeated = "<Repeat num_cycles=\"x\"><AnnounceArrival/></Repeat>";
    session("ports", "tree.xml", &TREE.replacen("<AnnounceArrival/>", repeated, 1));
}

#[test]
fn a_property() {
    session("property", "said.scope", SCOPE);
}

#[test]
fn several_properties() {
    let more = "const many := 3\nproperty heard := always ((AnnounceArrival, Speaker, true) implies\n  \
                eventually (Speaker, AnnounceArrival, m[1] = <ok>))\nproperty wrong := always (Nobody, BT, true)\n";
    session("properties", "said.scope", &format!("{SCOPE}{more}"));
}

#[test]
fn a_machine() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(folder.join("skills/examples/AnnounceArrival.scxml")).unwrap();
    session("machine", "skills/AnnounceArrival.scxml", &text);
}

#[test]
fn an_interface() {
    session(
        "interface",
        "parts/speaker.toml",
        "[services.say]\nrequest = { text = \"text\" }\n[topics.volume]\nvalue = \"real\"\n",
    );
}

#[test]
fn places() {
    session("places", "floor.places.toml", "[Dock]\nposition_m = [1.0, 2.0]\n[Hall]\ncorners_m = [[0, 0], [1, 0]]\n");
}
