//! ARCHITECTURE.md against the code: its figure of the rooms and its table of rules are generated; the files, types
//! and tests that it names exist.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::rooms::Rooms;
use super::rules::RULES;
use super::sources;
use crate::reference::{compare_part_of, table};
use crate::workspace::metadata;

const PAGE: &str = "ARCHITECTURE.md";

/// So many columns fit into a terminal beside other things.
const WIDTH: usize = 110;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page() -> String {
    fs::read_to_string(root().join(PAGE)).expect("the page is there")
}

/// One test, since each part that is blessed writes the whole page.
#[test]
fn the_page_has_the_figure_of_the_rooms_and_the_rules() {
    let figure = Rooms::read().figure();
    assert!(figure.lines().all(|line| line.chars().count() <= WIDTH), "too wide:\n{figure}");
    compare_part_of(PAGE, "rooms", &format!("```text\n{figure}\n```"));
    let rows = RULES.iter().map(|(never, reason)| [never.sentence(), (*reason).to_owned()]);
    compare_part_of(PAGE, "rules", &table(["rule", "reason"], rows));
}

#[test]
fn the_table_of_rooms_has_every_crate() {
    let page = page();
    for package in &metadata(&["--no-deps"]).packages {
        let folder = package.manifest_path.parent().expect("a manifest is in a folder");
        let folder = folder.strip_prefix(root()).expect("a crate is in the workspace").to_string_lossy();
        let folder = if folder.is_empty() { "src" } else { &*folder };
        assert!(page.contains(&format!("\n| {folder} | ")), "there is no row for {folder}");
    }
}

/// The text in backquotes, outside of code blocks.
fn code(text: &str) -> impl Iterator<Item = &str> {
    let prose = text.split("\n```").step_by(2);
    prose.flat_map(|part| part.split('`').skip(1).step_by(2))
}

/// The names of the types, traits and functions that a line of Rust begins to define.
fn defined(line: &str) -> Option<&str> {
    let mut words = line.split_whitespace().skip_while(|word| word.starts_with("pub") || *word == "const");
    let is_definition = ["struct", "enum", "trait", "type", "fn"].contains(&words.next()?);
    words.next()?.split(|c: char| !c.is_alphanumeric() && c != '_').next().filter(|_| is_definition)
}

#[test]
fn files_types_and_tests_that_the_page_names_exist() {
    let (page, sources) = (page(), sources(root()));
    let names: BTreeSet<&str> = sources.iter().flat_map(|(_, text)| text.lines().filter_map(defined)).collect();
    let is_path = |code: &str| code.contains('/') || code.ends_with(".rs") || code.ends_with(".toml");
    let is_type = |code: &str| {
        let is_name = code.chars().all(|c| c.is_alphanumeric() || c == '_' || c == ':');
        is_name && code.starts_with(char::is_uppercase)
    };
    let exists = |code: &str| {
        if is_path(code) {
            root().join(code).exists()
        } else {
            !is_type(code) || code.split("::").all(|name| names.contains(name))
        }
    };
    let mut missing: Vec<&str> = code(&page).filter(|code| !exists(code)).collect();
    let invariants = page.split("\n## ").find(|section| section.starts_with("Invariants")).expect("there is a section");
    let rows: Vec<&str> = invariants.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    for row in &rows {
        let tests: Vec<&str> = row.trim_end_matches([' ', '|']).rsplit('|').take(1).flat_map(code).collect();
        assert!(!tests.is_empty(), "no test is named: {row}");
        missing.extend(tests.into_iter().filter(|test| !names.contains(test)));
    }
    assert!(rows.len() > 10 && missing.is_empty(), "{PAGE} names what does not exist: {missing:#?}");
}
