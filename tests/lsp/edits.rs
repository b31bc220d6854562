//! Whatever is edited, what is shown is what a check of the files finds.

use std::fs;
use std::path::Path;

use checks::Toml;
use diagnostics::Disk;
use editor::{CheckedDocuments, Documents, EditedFile, Project};
use serde_json::{Value, json};

use super::Editor;
use super::client::{SCENARIO, SCOPE, TREE, application};

/// A linear congruential generator: the edits are the same each time.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit.max(1)
    }
}

/// Pieces of all the languages.
const PIECES: &[&str] = &[
    "<",
    ">",
    "/",
    "\"",
    "'",
    "=",
    "[",
    "]",
    "{",
    "}",
    "(",
    ")",
    ",",
    ".",
    "\n",
    " ",
    "#",
    "//",
    "ä",
    "𝄞",
    "0",
    "-1",
    "1e999",
    "[[faults]]\n",
    "kind = \"wheel_slip\"\n",
    "at_s = 3\n",
    "[battery]\n",
    "initial_pct = 300\n",
    "base = \"errand\"\n",
    "<Sequence>",
    "</Sequence>",
    "<Repeat num_cycles=\"3\">",
    "<AnnounceArrival name=\"Again\"/>",
    "<SubTree ID=\"Tour\"/>",
    "<!--",
    "-->",
    "always ",
    "(Speaker, AnnounceArrival, true)",
    " and ",
    "property p := ",
    "m[1] = <ok>",
    "until",
    "<state id=\"s\">",
    "</state>",
    "<transition event=\"*\" target=\"idle\"/>",
    "<send target=\"BT\" type=\"channel\" event=\"x\"/>",
];

/// A random edit of a text: a range of bytes, and what replaces it. Half of them are of a single character.
fn random_edit(text: &str, dice: &mut Dice) -> (std::ops::Range<usize>, String) {
    let start = text.floor_char_boundary(dice.below(text.len() + 1));
    let most = [1, 1, 2, 30][dice.below(4)];
    let removed = dice.below(most);
    let end = text.floor_char_boundary((start + removed).min(text.len())).max(start);
    let piece = match dice.below(4) {
        0 => String::new(),
        1 => char::from(32 + dice.below(95) as u8).to_string(),
        2 => PIECES[dice.below(PIECES.len())].to_owned(),
        // A piece of the text itself.
        _ => {
            let from = text.floor_char_boundary(dice.below(text.len() + 1));
            text[from..text.floor_char_boundary((from + dice.below(40)).min(text.len()))].to_owned()
        }
    };
    (start..end, piece)
}

/// Edits the files of an application at random. After each edit, a project that has followed all of them finds what a
/// new one finds in the saved files.
fn edit_at_random(count: usize, seed: u64, compared_every: usize) {
    let editor = Editor::new();
    let folder = application(&editor);
    let files = ["hospital.toml", "tree.xml", "said.scope", "skills/AnnounceArrival.scxml", "parts/speaker.toml"];
    let right: Vec<String> = files.iter().map(|file| fs::read_to_string(folder.join(file)).unwrap()).collect();
    let mut documents = Documents { folders: vec![folder.to_owned()], ..Documents::default() };
    for (file, text) in files.iter().zip(&right) {
        documents.open.insert(folder.join(file), text.as_str().into());
    }
    let mut project = Project::default();
    let mut dice = Dice(seed);
    for edit in 0..count {
        let at = dice.below(files.len());
        let path = folder.join(files[at]);
        let mut text = documents.open[&path].to_string();
        let mut cursor = 0;
        if dice.below(12) == 0 {
            text.clone_from(&right[at]);
        } else {
            let (range, piece) = random_edit(&text, &mut dice);
            cursor = range.start + piece.len();
            text.replace_range(range, &piece);
        }
        documents.open.insert(path.clone(), text.as_str().into());
        let CheckedDocuments { findings: found, contexts, .. } = project.check(&documents);
        let disk = documents.disk();
        let edited = EditedFile { disk: &disk, file: &path, context: &contexts[&path] };
        // Whatever they are, they fit the text.
        for proposal in edited.proposals(&text, cursor) {
            assert!(text.get(proposal.replaces.clone()).is_some(), "{proposal:?} in {text}");
        }
        let explained = edited.explanation(&text, cursor);
        assert!(
            explained.as_ref().is_none_or(|explained| text.get(explained.range.clone()).is_some()),
            "{explained:?}"
        );
        if edit % compared_every == 0 {
            // The same texts, saved.
            for (path, text) in &documents.open {
                fs::write(path, text.as_bytes()).unwrap();
            }
            let anew = Project::default().check(&documents).findings;
            assert_eq!(found, anew, "edit {edit} of seed {seed}");
            for root in project.roots(&documents) {
                same_as_on_disk(&root, &found, &documents);
            }
        }
    }
}

/// What a check of a file on disk finds in it is what is shown.
fn same_as_on_disk(root: &Path, found: &checks::findings::Findings, documents: &Documents) {
    let checked = checks::examine(&Disk::default(), root.to_str().unwrap(), None);
    let mut messages: Vec<String> = match &checked {
        Ok(checked) => {
            let parts = checked.concerns.iter().flat_map(|concern| diagnostics::parts(concern.as_ref()));
            parts.map(|(part, _)| part.to_string()).collect()
        }
        Err(error) => {
            let parts = error.diagnostics().into_iter().flat_map(diagnostics::parts);
            parts.map(|(part, _)| part.to_string()).collect()
        }
    };
    let shown: Vec<&str> =
        found.values().flat_map(|found| &found.findings).map(|finding| finding.message.as_str()).collect();
    messages.retain(|message| !shown.iter().any(|shown| shown == message || shown.ends_with(&format!(": {message}"))));
    assert!(messages.is_empty(), "{}: not shown: {messages:?} of {documents:?}", root.display());
}

#[test]
fn after_random_edits_the_findings_are_those_of_the_saved_files() {
    edit_at_random(2000, 1, 20);
}

#[test]
#[ignore = "takes an hour; STEWARD_EDITS is the number of edits, by default 100,000"]
fn after_very_many_random_edits_the_findings_are_those_of_the_saved_files_on_demand() {
    let count = std::env::var("STEWARD_EDITS").map_or(100_000, |count| count.parse().unwrap());
    let memory = || {
        let status = fs::read_to_string("/proc/self/statm").unwrap_or_default();
        status.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) / 256
    };
    let edit = |seeds: &[u64]| batch::run(seeds, |seed| edit_at_random(count / 10, *seed, 1), |_| {});
    edit(&[2, 3]);
    let before = memory();
    edit(&[4, 5, 6, 7, 8, 9, 10, 11]);
    assert!(memory() < before + 100, "{} MiB instead of {before}", memory());
}

#[test]
fn the_server_survives_random_edits_and_shows_the_last_state() {
    let mut editor = Editor::new();
    application(&editor);
    let files = [("hospital.toml", SCENARIO), ("tree.xml", TREE), ("said.scope", SCOPE)];
    files.iter().for_each(|(file, text)| editor.open(file, text));
    let mut dice = Dice(7);
    for _ in 0..300 {
        let (file, _) = files[dice.below(files.len())];
        let (range, piece) = random_edit(editor.text(file), &mut dice);
        editor.edit(file, range, &piece);
    }
    for (file, right) in files {
        editor.edit(file, 0..editor.text(file).len(), right);
    }
    assert_eq!(editor.with_problems(), [""; 0]);
    assert_eq!(editor.quit(), Some(0));
}

#[test]
fn files_of_other_programs_are_left_alone() {
    assert_eq!(Toml::of("[package]\nname = \"x\"\n"), None);
    let mut editor = Editor::new();
    editor.open("Cargo.toml", "[package]\nname = \"x\"\n");
    editor.open("pom.xml", "<project/>");
    editor.open("session-1.scope", "[Unit]\nDescription=Session 1\n\n[Scope]\nTasksMax=90%\n");
    assert_eq!(editor.with_problems(), [""; 0]);
}

#[test]
fn a_document_gets_its_layout() {
    let mut editor = Editor::new();
    let laid_out = "property told := always not (Ann, Bob, x > 1)\n";
    editor.open("told.scope", "property  told:=always not(Ann,Bob,x>1)\n// é\n");
    let format = |editor: &mut Editor, file: &str| {
        let document = json!({ "uri": editor.address(file) });
        editor.response(
            "textDocument/formatting",
            json!({ "textDocument": document, "options": { "tabSize": 2, "insertSpaces": true } }),
        )
    };
    let edits = format(&mut editor, "told.scope");
    assert_eq!(edits["result"][0]["newText"], format!("{laid_out}// é\n"), "{edits}");
    assert_eq!(edits["result"][0]["range"]["end"], json!({ "line": 2, "character": 0 }));
    editor.open("same.scope", laid_out);
    editor.open("wrong.scope", "property told := always (");
    editor.open("a.toml", "seed  =  1");
    assert_eq!(format(&mut editor, "same.scope")["result"], Value::Null);
    assert_eq!(format(&mut editor, "a.toml")["result"], Value::Null);
    assert!(format(&mut editor, "wrong.scope")["error"]["message"].is_string());
}
