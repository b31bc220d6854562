//! A run that was recorded can be shown again: from the recording alone come the files that the run left.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use recording::Recording;
use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{refusal, steward};

/// Scenarios with something of everything: faults of all kinds, people, other monitors, a tree in parts, no monitors.
const RUNS: [(&str, &[&str]); 13] = [
    ("nominal", &["--set", "execution.max_time_s=24"]),
    ("battery_fault", &["--set", "snapshots.every_s=10", "--set", "snapshots.at_s=[3.333, 21]"]),
    ("early_release", &["--set", "execution.max_time_s=8", "--set", "execution.tree=nodes"]),
    ("errand", &["--set", "execution.max_time_s=15", "--set", "monitors=[{figure=\"5 (a)\"}, {figure=\"5 (b)\"}]"]),
    ("corridor", &["--set", "execution.max_time_s=15"]),
    ("populated", &["--set", "execution.max_time_s=12"]),
    ("already_there", &["--set", "execution.max_time_s=10"]),
    ("skill_bug", &["--set", "execution.max_time_s=24", "--no-monitors"]),
    ("late_halt", &["--set", "execution.max_time_s=10"]),
    ("never_arrives", &["--set", "execution.max_time_s=10"]),
    ("pick", &["--set", "leaves.PickUp.data.slips=3"]),
    ("faults/message_lost", &["--set", "execution.max_time_s=15"]),
    ("faults/kidnap", &["--set", "execution.max_time_s=15"]),
];

/// All files of a folder; of the report everything but how long the computer took.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let mut bytes = std::fs::read(&path).unwrap();
        if name == "report.json" {
            let mut report: Value = serde_json::from_slice(&bytes).unwrap();
            assert!(report.as_object_mut().unwrap().remove("timing").is_some());
            bytes = report.to_string().into_bytes();
        }
        (name, bytes)
    };
    std::fs::read_dir(folder).unwrap().map(file).collect()
}

#[test]
fn a_recording_gives_the_report_page_and_pictures_of_its_run() {
    for (scenario, more) in RUNS {
        let folder = tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let gif =
            |name: &str| if scenario == "battery_fault" { vec!["--gif".to_owned(), at(name)] } else { Vec::new() };
        let (run_gif, report_gif) = (gif("run.gif"), gif("report.gif"));
        let run = ["--scenario", scenario, "--quiet", "--out", &at("run"), "--record", &at("run.rec")];
        let run: Vec<&str> =
            run.into_iter().chain(more.iter().copied()).chain(run_gif.iter().map(String::as_str)).collect();
        let ran = steward(&run);
        let report = ["report", &at("run.rec"), "--quiet", "--out", &at("report")];
        let report: Vec<&str> = report.into_iter().chain(report_gif.iter().map(String::as_str)).collect();
        let reported = steward(&report);
        let said = String::from_utf8_lossy(&reported.stderr).into_owned();
        assert_eq!(reported.status.code(), ran.status.code(), "{scenario}: {said}");
        let (expected, found) = (files(&folder.path().join("run")), files(&folder.path().join("report")));
        assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>(), "{scenario}");
        assert!(expected.keys().any(|name| name.ends_with(".png")), "{scenario} takes no pictures");
        for (name, bytes) in &expected {
            assert!(found[name] == *bytes, "{scenario}: {name} differs");
        }
        if !run_gif.is_empty() {
            assert!(std::fs::read(at("run.gif")).unwrap() == std::fs::read(at("report.gif")).unwrap(), "{scenario}");
        }
    }
}

#[test]
fn recording_a_run_again_gives_the_same_bytes() {
    let folder = tempdir().unwrap();
    let recorded = |name: &str| {
        let path = folder.path().join(name);
        let out = folder.path().join("out");
        let run = ["--scenario", "battery_fault", "--quiet", "--no-snapshots", "--set", "execution.max_time_s=10"];
        let to = ["--out", out.to_str().unwrap(), "--record", path.to_str().unwrap()];
        steward(&[&run[..], &to].concat());
        std::fs::read(path).unwrap()
    };
    assert!(recorded("a.rec") == recorded("b.rec"));
}

#[test]
fn an_incomplete_recording_is_refused_with_one_message() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let run = ["--scenario", "battery_fault", "--quiet", "--no-snapshots", "--set", "execution.max_time_s=40"];
    steward(&[&run[..], &["--out", &at("out"), "--record", &at("run.rec")]].concat());
    let whole = std::fs::read(at("run.rec")).unwrap();
    let said_of = |bytes: &[u8]| {
        std::fs::write(at("bad.rec"), bytes).unwrap();
        let said = refusal(&["report", &at("bad.rec"), "--out", &at("report")]);
        assert!(!Path::new(&at("report/report.json")).exists());
        said
    };
    let has = |said: String, words: &str| assert!(said.contains(words), "{said}");
    has(said_of(&whole[..whole.len() - 1]), "ends before its run does, at ");
    has(said_of(&whole[..15]), "ends before its run does, and tells nothing of it");
    has(said_of(b""), "is not a recording of a run");
    has(said_of(b"{\"scenario\":\"nominal\"}\n"), "is not a recording of a run");
    let mut other = whole.clone();
    other[8] = 77;
    has(said_of(&other), "has version 77 of the format");
    let mut damaged = whole.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 0x40;
    has(said_of(&damaged), "is damaged");
    has(refusal(&["report", &at("none.rec"), "--out", &at("report")]), "cannot read");
}

/// Whether a recording that is being written has more than the start of its run already.
fn tells_of_a_step(path: &Path) -> bool {
    let Ok(mut recording) = Recording::open(path) else { return false };
    recording.begin().is_ok_and(|mut view| recording.advance(&mut view).is_ok())
}

#[test]
fn a_killed_run_leaves_what_it_had_recorded() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(at("records")).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_steward"))
        .args(["--scenario", "nominal", "--quiet", "--no-snapshots", "--out", &at("out")])
        .args(["--record", &at("records/run.rec")])
        .spawn()
        .unwrap();
    let part = loop {
        assert!(child.try_wait().unwrap().is_none(), "it ends before it is killed");
        let part = std::fs::read_dir(at("records")).unwrap().next().map(|entry| entry.unwrap().path());
        if let Some(part) = part.filter(|part| tells_of_a_step(part)) {
            break part;
        }
    };
    child.kill().unwrap();
    child.wait().unwrap();
    let said = refusal(&["report", part.to_str().unwrap(), "--out", &at("report")]);
    assert!(said.contains("ends before its run does, at "), "{said}");
}
