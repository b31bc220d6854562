//! `steward fmt`: the layout of trees, machines and property files.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::tempdir;

use crate::steward::{binary, refusal, steward};

const TREE: &str = "<root BTCPP_format='4'><BehaviorTree ID='T'><AlwaysSuccess/></BehaviorTree></root>";
const TREE_LAID_OUT: &str =
    "<root BTCPP_format=\"4\">\n  <BehaviorTree ID=\"T\">\n    <AlwaysSuccess/>\n  </BehaviorTree>\n</root>\n";
const MACHINE: &str = "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id='a'/></scxml>";
const MACHINE_LAID_OUT: &str =
    "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\">\n  <state id=\"a\"/>\n</scxml>\n";
const PROPERTIES: &str = "property  p:=always(A,B,true)";
const PROPERTIES_LAID_OUT: &str = "property p := always (A, B, true)\n";

/// The status, and what is on stdout.
#[track_caller]
fn said(output: &Output, status: i32) -> String {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{errors}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// `steward fmt` with this on stdin.
fn piped(arguments: &[&str], input: &str) -> Output {
    let mut command = Command::new(binary());
    command.arg("fmt").args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

#[test]
fn a_folder_is_laid_out_and_other_files_are_untouched() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir_all(path("deep/.hidden")).unwrap();
    let files = [
        ("tree.xml", TREE, TREE_LAID_OUT),
        ("deep/machine.scxml", MACHINE, MACHINE_LAID_OUT),
        ("properties.scope", PROPERTIES, PROPERTIES_LAID_OUT),
        ("done.scope", PROPERTIES_LAID_OUT, PROPERTIES_LAID_OUT),
        ("package.xml", "<package ><a/></package>", "<package ><a/></package>"),
        ("notes.txt", PROPERTIES, PROPERTIES),
        ("deep/.hidden/tree.xml", TREE, TREE),
    ];
    files.iter().for_each(|(name, before, _)| fs::write(path(name), before).unwrap());
    let checked = said(&steward(&["fmt", "--check", text(folder.path())]), 1);
    assert!(checked.ends_with("4 files, 3 of them would change\n"), "{checked}");
    assert!(checked.contains("-property  p:=always(A,B,true)\n") && checked.contains("+property p := "), "{checked}");
    files.iter().for_each(|(name, before, _)| assert_eq!(fs::read_to_string(path(name)).unwrap(), *before));

    let changed = said(&steward(&["fmt", text(folder.path())]), 0);
    assert!(changed.ends_with("4 files, 3 of them changed\n"), "{changed}");
    files.iter().for_each(|(name, _, after)| assert_eq!(fs::read_to_string(path(name)).unwrap(), *after));
    let checked = said(&steward(&["fmt", "--check", text(folder.path())]), 0);
    assert_eq!(checked, "4 files, 0 of them would change\n");
}

#[test]
fn a_file_that_is_refused_stays_as_it_is_and_the_others_are_laid_out() {
    let folder = tempdir().unwrap();
    let [broken, good] = ["broken.xml", "good.scope"].map(|name| folder.path().join(name));
    fs::write(&broken, "<root><BehaviorTree></root>").unwrap();
    fs::write(&good, PROPERTIES).unwrap();
    let output = steward(&["fmt", text(&broken), text(&good)]);
    assert_eq!(said(&output, 2), format!("{} changed\n2 files, 1 of them changed\n", text(&good)));
    assert!(String::from_utf8_lossy(&output.stderr).contains("not well-formed"));
    assert_eq!(fs::read_to_string(&broken).unwrap(), "<root><BehaviorTree></root>");
    assert_eq!(fs::read_to_string(&good).unwrap(), PROPERTIES_LAID_OUT);
}

#[test]
fn a_file_on_stdin_is_printed_and_its_kind_is_known() {
    for (before, after) in
        [(TREE, TREE_LAID_OUT), (MACHINE, MACHINE_LAID_OUT), (PROPERTIES, PROPERTIES_LAID_OUT), ("", "")]
    {
        assert_eq!(said(&piped(&["-"], before), 0), after);
    }
    assert_eq!(said(&piped(&["--stdin-name", "a.scope", "-"], PROPERTIES), 0), PROPERTIES_LAID_OUT);
    let output = piped(&["--stdin-name", "a.scope", "-"], TREE);
    assert_eq!(said(&output, 2), "");
    assert!(String::from_utf8_lossy(&output.stderr).contains("a.scope:1:1"));
    assert!(said(&piped(&["--check", "-"], TREE), 1).starts_with("<stdin> would change:\n"));
    assert_eq!(said(&piped(&["--check", "-"], TREE_LAID_OUT), 0), "");
}

#[test]
fn only_the_first_places_are_shown() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("many.scope");
    let items = |form: fn(usize) -> String| (0..20).map(form).collect::<Vec<_>>().join("// c\n// c\n// c\n");
    fs::write(&file, items(|number| format!("const a{number}:={number}\n"))).unwrap();
    let checked = said(&steward(&["fmt", "--check", text(&file)]), 1);
    assert_eq!(checked.matches("@@ ").count(), 3, "{checked}");
    assert!(checked.ends_with("and 17 more places\n"), "{checked}");
    let marked = format!("\u{feff}{}", items(|number| format!("const a{number} := {number}\n")));
    fs::write(&file, marked).unwrap();
    let checked = said(&steward(&["fmt", "--check", text(&file)]), 1);
    assert_eq!(checked, format!("{} would change: its byte order mark\n", text(&file)));
}

#[test]
fn what_has_no_layout_is_refused() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("scenario.toml");
    fs::write(&file, "").unwrap();
    for (arguments, expected) in [
        (vec![text(&file)], "is not a kind of file that has a layout"),
        (vec![text(folder.path())], "contains no trees, machines or property files"),
        (vec!["missing.xml"], "there is no such file"),
        (vec!["-", "missing.xml"], "`-` is given beside other files"),
        (vec!["missing.xml", "--stdin-name", "a.xml"], "--stdin-name is given, but stdin is not read"),
    ] {
        let said = refusal(&[&["fmt"], &arguments[..]].concat());
        assert!(said.contains(expected), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn links_in_folders_are_not_followed_and_a_named_link_remains_one() {
    let folder = tempdir().unwrap();
    let [inside, outside] = ["inside", "outside"].map(|name| folder.path().join(name));
    [&inside, &outside].into_iter().for_each(|folder| fs::create_dir(folder).unwrap());
    let (file, link) = (outside.join("a.scope"), inside.join("a.scope"));
    fs::write(&file, PROPERTIES).unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    std::os::unix::fs::symlink(&outside, inside.join("folder")).unwrap();
    refusal(&["fmt", text(&inside)]);
    said(&steward(&["fmt", text(&link)]), 0);
    assert!(link.is_symlink());
    assert_eq!(fs::read_to_string(&file).unwrap(), PROPERTIES_LAID_OUT);
}
