//! `steward live --groot`: the tree of a program with BehaviorTree.CPP, whose answers were captured, in the browser.

use std::collections::VecDeque;
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::process::{Child, Command, Stdio};

use serde_json::Value;
use tempfile::{TempDir, tempdir};

#[path = "../bt/groot/tests/program.rs"]
mod program;

use program::{captured, program};

use crate::live::browser::{Page, hear, until};
use crate::steward::{binary, refusal, steward};

/// The program, which ends after its last transitions. Returns its address.
fn captured_program() -> String {
    let (greeting, replies) = captured();
    let replies = replies.into_iter().filter(|(request, _)| request != "B nobody");
    let mut replies: VecDeque<(u8, Vec<u8>)> = replies.map(|(request, reply)| (request.as_bytes()[0], reply)).collect();
    let answer = move |stream: &mut TcpStream, parts: Vec<Vec<u8>>| {
        let header = &parts[1];
        let last = replies.iter().rposition(|(kind, _)| *kind == header[1]).unwrap();
        let next = replies.iter().position(|(kind, _)| *kind == header[1]).unwrap();
        // Blackboards and statuses may be asked for more often than when they were captured.
        let is_used_up = next == last && header[1] != b't';
        let mut reply = if is_used_up { replies[next].1.clone() } else { replies.remove(next).unwrap().1 };
        reply[6..10].copy_from_slice(&header[2..6]);
        stream.write_all(&reply).unwrap();
        if !replies.iter().any(|(kind, _)| *kind == b't') {
            stream.shutdown(Shutdown::Both).unwrap();
        }
    };
    program(greeting, answer).0
}

/// A running `steward live --groot`, with properties in a folder.
fn live(
    address: &str,
    properties: &str,
    more: &[&str],
) -> (Child, BufReader<std::process::ChildStdout>, Page, TempDir) {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("p.scope"), properties).unwrap();
    let mut child = Command::new(binary())
        .current_dir(folder.path())
        .args(["live", "--groot", address, "--no-open", "--property", "p.scope", "--record", "run.rec"])
        .args(more)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut printed = BufReader::new(child.stdout.take().unwrap());
    let mut line = || {
        let mut line = String::new();
        printed.read_line(&mut line).unwrap();
        line
    };
    let (pilot, viewer, _) = (line(), line(), line());
    (child, printed, Page::new(pilot.trim_end(), viewer.trim_end()), folder)
}

#[test]
fn the_tree_of_a_running_program_is_shown_checked_and_recorded() {
    let properties = "property never_fails := always not (main, BT, reply = <failure>)
        property waits := always not (count, BT, reply = <success>)
        property goes := eventually (Drive, BT, reply = <running>)";
    let (mut child, mut printed, page, folder) = live(&captured_program(), properties, &[]);
    let mut socket = page.socket(&page.pilot);
    let mut notes = BufReader::new(child.stderr.take().unwrap());
    let mut note = String::new();
    while !note.contains("waiting for it") {
        note.clear();
        assert!(notes.read_line(&mut note).unwrap() > 0, "the end of the program is told");
    }
    // What changed last was shown, with the blackboards.
    let shown = until(&mut socket, |frame| {
        frame["happenings"].as_array().is_some_and(|all| {
            all.iter().any(|one| one["words"].as_str().is_some_and(|words| words.contains("changes may be missing")))
        })
    });
    assert!(shown["happenings"].is_array());
    let entries = hear(&mut page.socket(&page.viewer), "entries");
    assert_eq!(entries["Main/goal"], "\"dock\"", "{entries}");
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let mut rest = String::new();
    printed.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{rest}");
    let heard = heard();
    assert!(rest.contains(&format!("{heard} messages")), "{heard}: {rest}");
    // What the program did last, nobody knows: only what cannot change is certain.
    for verdict in ["never_fails  unsure", "waits        violated", "goes         satisfied"] {
        assert!(rest.contains(verdict), "{verdict}: {rest}");
    }
    let recording = folder.path().join("run.rec");
    let again = steward(&["verify", recording.to_str().unwrap(), "--json"]);
    let report: Value = serde_json::from_slice(&again.stdout).unwrap();
    let verdicts: Vec<&str> =
        report["monitors"].as_array().unwrap().iter().map(|one| one["verdict"].as_str().unwrap()).collect();
    assert_eq!(verdicts, ["unsure", "violated", "satisfied"], "of the recording");
}

/// How many answers and halts a logger inside the program heard.
fn heard() -> usize {
    let mut running = std::collections::BTreeSet::new();
    let lines = include_str!("../bt/groot/tests/captured/board.txt").lines().skip(1);
    let is_message = |line: &&str| {
        let (node, status) = line.split_once(' ').and_then(|(_, rest)| rest.split_once(' ')).unwrap();
        let was_running = running.remove(node);
        if status == "1" {
            running.insert(node.to_owned());
        }
        status != "0" || was_running
    };
    lines.filter(is_message).count()
}

#[test]
fn a_program_that_cannot_be_asked_is_refused() {
    let closed = "127.0.0.1:1";
    let said = refusal(&["live", "--groot", closed, "--no-open"]);
    assert!(said.contains("refused") && said.contains("Groot2Publisher"), "{said}");
    let said = refusal(&["live", "--groot", closed, "nominal"]);
    assert!(said.contains("cannot be used with"), "{said}");
    let said = refusal(&["live", "nominal", "--passive"]);
    assert!(said.contains("cannot be used with"), "{said}");
}
