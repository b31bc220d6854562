//! `steward live --groot`: the tree of a program with BehaviorTree.CPP, whose answers were captured, in the browser.

use std::collections::VecDeque;
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use groot::{Client, GrootError};
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

#[path = "../bt/groot/tests/program.rs"]
mod program;

use program::{captured, program};

use crate::live::browser::{Page, ask, hear, until};
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
        property goes := eventually (\"there/Drive\", BT, reply = <running>)";
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

#[test]
fn a_session_that_begins_anew_is_another_tree_for_its_clients() {
    let mut child = Command::new(binary())
        .args(["live", "nominal", "--no-open", "--serve-groot", "0"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut notes = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let address = notes.find_map(|note| {
        let (_, address) = note.split_once("Groot2 can connect to ")?;
        address.split(';').next().map(str::to_owned)
    });
    let address = address.expect("the address is told");
    let mut printed = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    let [pilot, viewer] = [(); 2].map(|()| printed.next().unwrap());
    let page = Page::new(&pilot, &viewer);
    let mut pilot = page.socket(&page.pilot);
    until(&mut pilot, |known| known["time"].as_f64() > Some(1.5));
    let connect = || Client::connect(&address, Duration::from_secs(10)).unwrap();
    let mut before = connect();
    let tree = before.tree().unwrap();
    assert!(before.start_recording().unwrap() >= 1_500_000);
    ask(&mut pilot, &json!({ "do": "restart" }));
    assert!(matches!(before.statuses(), Err(GrootError::OtherTree { .. })));
    let mut after = connect();
    assert_eq!(after.tree().unwrap(), tree);
    let began_us = after.start_recording().unwrap();
    let until_us = began_us + 2_000_000;
    until(&mut pilot, |known| known["time"].as_f64().is_some_and(|time_s| time_s > until_us as f64 / 1e6));
    let transitions = after.transitions(began_us).unwrap();
    assert!(!transitions.is_empty() && transitions.iter().all(|change| change.at_us >= began_us), "{transitions:?}");
    let entries = after.blackboards(tree.blackboards()).unwrap();
    assert_eq!(entries.boards.len(), tree.blackboards().len());
    child.kill().unwrap();
    child.wait().unwrap();
}
