//! A recorded run can be shown again: the recording alone gives the files that the run wrote.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use recording::Recording;
use scenarios::scenario::{Scenario, find};
use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{binary, refusal, steward};

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

/// All files of a folder; the report without its timing.
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

/// The properties of a scenario, as files in a folder.
fn property_files(scenario: &str, folder: &Path) -> Vec<String> {
    let loaded = Scenario::load(&find::find(scenario).unwrap(), &[]).unwrap();
    let write = |(place, (_, text)): (usize, &(String, String))| {
        let path = folder.join(format!("{place}.scope"));
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    loaded.properties.iter().enumerate().map(write).collect()
}

/// Checks that `verify` gives the same results for a recording as the run did: verdict, tick, witness.
fn check_verdicts(scenario: &str, recording: &str, report: &Value, folder: &Path) {
    let files = property_files(scenario, folder);
    if files.is_empty() {
        return;
    }
    let properties = files.iter().flat_map(|file| ["--property", file.as_str()]);
    let verify: Vec<&str> = ["verify", recording, "--json"].into_iter().chain(properties).collect();
    let verified = steward(&verify);
    let said = String::from_utf8_lossy(&verified.stderr);
    assert!(matches!(verified.status.code(), Some(0 | 1)), "{scenario}: {said}");
    let verified: Value = serde_json::from_slice(&verified.stdout).unwrap();
    let named = |monitors: &Value| -> BTreeMap<String, Value> {
        let monitors = monitors["monitors"].as_array().unwrap().iter();
        monitors.map(|monitor| (monitor["name"].as_str().unwrap().to_owned(), monitor.clone())).collect()
    };
    let (expected, found) = (named(report), named(&verified));
    for (name, found) in found {
        // A run without monitors has no verdicts, and one with other monitors has other verdicts.
        let Some(expected) = expected.get(&name) else { continue };
        for key in ["verdict", "state"] {
            assert_eq!(found[key], expected[key], "{scenario}: {name}: {key}");
        }
        let (found, expected) = (&found["witness"], &expected["witness"]);
        for key in ["step", "tick", "time_s", "clause", "messages", "since_tick", "deadline_tick", "missing", "words"] {
            assert_eq!(found[key], expected[key], "{scenario}: {name}: {key}");
        }
    }
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_recording_in_either_format_gives_the_report_page_and_pictures_of_its_run() {
    for (scenario, more) in RUNS {
        let folder = tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let gif =
            |name: &str| if scenario == "already_there" { vec!["--gif".to_owned(), at(name)] } else { Vec::new() };
        let (run_gif, report_gif) = (gif("run.gif"), gif("report.gif"));
        let run = ["--scenario", scenario, "--quiet", "--out", &at("run"), "--record", &at("run.rec")];
        let run: Vec<&str> =
            run.into_iter().chain(more.iter().copied()).chain(run_gif.iter().map(String::as_str)).collect();
        let ran = steward(&run);
        let reported = |from: &str, to: &str, out: &str, more: &[&str]| {
            let report = ["report", &at(from), "--record", &at(to), "--quiet", "--out", &at(out)];
            let reported = steward(&[&report[..], more].concat());
            let said = String::from_utf8_lossy(&reported.stderr).into_owned();
            assert_eq!(reported.status.code(), ran.status.code(), "{scenario}: {said}");
            files(&folder.path().join(out))
        };
        let plain = reported("run.rec", "run.mcap", "plain", &["--no-snapshots"]);
        let more: Vec<&str> = report_gif.iter().map(String::as_str).collect();
        let (expected, found) = (files(&folder.path().join("run")), reported("run.mcap", "again.rec", "report", &more));
        assert!(std::fs::read(at("run.rec")).unwrap() == std::fs::read(at("again.rec")).unwrap(), "{scenario}");
        assert_eq!(plain.keys().collect::<Vec<_>>(), ["report.html", "report.json"], "{scenario}");
        assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>(), "{scenario}");
        assert!(expected.keys().any(|name| name.ends_with(".png")), "{scenario} takes no pictures");
        for (name, bytes) in &expected {
            assert!(found[name] == *bytes, "{scenario}: {name} differs");
        }
        if !run_gif.is_empty() {
            assert!(std::fs::read(at("run.gif")).unwrap() == std::fs::read(at("report.gif")).unwrap(), "{scenario}");
        }
        let report = serde_json::from_slice(&expected["report.json"]).unwrap();
        check_verdicts(scenario, &at("run.mcap"), &report, folder.path());
    }
}

/// All scenarios that come with the program, except `published`, which needs the authors' files.
#[test]
#[ignore = "takes minutes: on demand"]
fn verdicts_of_recordings_are_those_of_their_runs_on_demand() {
    let mut names = Vec::new();
    for folder in ["", "faults/", "guide/", "nav2/"] {
        let files = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(folder)).unwrap();
        let files = files.map(|file| file.unwrap().file_name().into_string().unwrap());
        let files = files.filter_map(|file| Some(format!("{folder}{}", file.strip_suffix(".toml")?)));
        names.extend(files.filter(|name| !["published", "Cargo"].contains(&name.as_str())));
    }
    names.sort();
    for name in &names {
        for seed in 1..=5 {
            let folder = tempdir().unwrap();
            let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
            let seed = seed.to_string();
            let run = ["run", name, "--seed", &seed, "--quiet", "--no-snapshots", "--out", &at("run")];
            let ran = steward(&[&run[..], &["--record", &at("run.mcap")]].concat());
            let said = String::from_utf8_lossy(&ran.stderr).into_owned();
            let report = std::fs::read(at("run/report.json")).unwrap_or_else(|_| panic!("{name}: {said}"));
            check_verdicts(name, &at("run.mcap"), &serde_json::from_slice(&report).unwrap(), folder.path());
            let status = steward(&["report", &at("run.mcap"), "--quiet", "--no-snapshots", "--out", &at("report")]);
            assert_eq!(status.status.code(), ran.status.code(), "{name}");
            assert!(files(&folder.path().join("run")) == files(&folder.path().join("report")), "{name}, seed {seed}");
        }
    }
    println!("{} scenarios, 5 seeds each", names.len());
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
    let bytes = recorded("a.mcap");
    assert!(bytes == recorded("b.mcap"));
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    steward(&["report", &at("a.rec"), "--quiet", "--out", &at("report"), "--record", &at("c.mcap")]);
    assert!(bytes == std::fs::read(at("c.mcap")).unwrap(), "a recording can be written in the other format");
}

/// The other reasons why a file is refused are tested in the crate `recording`.
#[test]
fn an_incomplete_recording_gives_no_report_but_can_be_judged_up_to_its_end() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let run = ["--scenario", "battery_fault", "--quiet", "--no-snapshots", "--set", "execution.max_time_s=40"];
    steward(&[&run[..], &["--out", &at("out"), "--record", &at("run.mcap")]].concat());
    let whole = std::fs::read(at("run.mcap")).unwrap();
    std::fs::write(at("part.mcap"), &whole[..whole.len() / 2]).unwrap();
    let has = |message: String, words: &str| assert!(message.contains(words), "{message}");
    has(refusal(&["report", &at("part.mcap"), "--out", &at("report")]), "ends before its run does, at ");
    assert!(!Path::new(&at("report/report.json")).exists());
    let verified = steward(&["verify", &at("part.mcap"), "--property", "phi1"]);
    has(String::from_utf8_lossy(&verified.stderr).into_owned(), "ends before its run does, at ");
    has(String::from_utf8_lossy(&verified.stdout).into_owned(), "phi1");
}

/// Whether a recording that is being written already has more than the start of its run.
fn has_a_step(path: &Path) -> bool {
    let Ok(mut recording) = Recording::open(path) else { return false };
    recording.begin().is_ok_and(|mut view| recording.advance(&mut view).is_ok())
}

#[test]
fn a_killed_run_leaves_what_it_had_recorded() {
    for name in ["run.rec", "run.mcap"] {
        let folder = tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        std::fs::create_dir(at("records")).unwrap();
        let mut child = Command::new(binary())
            .args(["--scenario", "nominal", "--quiet", "--no-snapshots", "--out", &at("out")])
            .args(["--set", "stop.after_s=36000", "--set", "execution.max_time_s=40000"])
            .args(["--record", &at(&format!("records/{name}"))])
            .spawn()
            .unwrap();
        let part = loop {
            assert!(child.try_wait().unwrap().is_none(), "it ends before it is killed");
            let part = std::fs::read_dir(at("records")).unwrap().next().map(|entry| entry.unwrap().path());
            if let Some(part) = part.filter(|part| has_a_step(part)) {
                break part;
            }
        };
        child.kill().unwrap();
        child.wait().unwrap();
        let said = refusal(&["report", part.to_str().unwrap(), "--out", &at("report")]).replace("\n  | ", " ");
        assert!(said.contains("ends before its run does, at "), "{said}");
    }
}

#[test]
fn several_logs_are_a_table_a_page_and_test_cases() {
    let out = tempdir().unwrap();
    let at = |name: &str| out.path().join(name).to_str().unwrap().to_owned();
    let record = |scenario: &str, file: &str| {
        let recorded = ["run", scenario, "--no-snapshots", "--record", file, "--out", &at("run")];
        assert!(steward(&recorded).status.success());
    };
    std::fs::create_dir(out.path().join("other #1")).unwrap();
    let logs = [at("night.mcap"), at("other #1/night.rec"), at("none.jsonl")];
    record("battery_fault", &logs[0]);
    record("already_there", &logs[1]);
    let [first, second, none] = logs.each_ref().map(String::as_str);
    let output = steward(&["verify", first, second, none, "--out", &at("all"), "--results", &at("all.xml")]);
    assert_eq!(output.status.code(), Some(2));
    let text = String::from_utf8(output.stdout).unwrap();
    let (_, table) = text.split_once("\n\n").unwrap();
    assert!(
        table.starts_with("3 logs: 0 with all properties satisfied, 2 with a property violated, unsure or without a verdict, 1 that could \
             not be checked\n"),
        "{table}"
    );
    assert!(table.contains(&format!("  {first}  51.1 s: phi1 violated, 2 satisfied\n")), "{table}");
    assert!(table.contains(&format!("  {none}  not checked: cannot read the log {none}")), "{table}");
    // Logs with one name have a folder each, and the page leads to both.
    let page = std::fs::read_to_string(at("all/index.html")).unwrap();
    assert!(page.contains("href=\"night/report.html\"") && page.contains("href=\"night-2/report.html\""), "{page}");
    assert!(out.path().join("all/night-2/report.html").exists());
    let junit = std::fs::read_to_string(at("all.xml")).unwrap();
    assert!(junit.starts_with("<?xml") && junit.contains("failures=\"2\" errors=\"1\""), "{junit}");
    let json = steward(&["verify", first, none, "--json"]);
    let json: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((json.as_array().unwrap().len(), json[1]["refused"].is_string()), (2, true));
}

#[test]
fn no_report_of_several_logs_is_written_over_one_of_them() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let log = "{\"scenario\":\"nominal\"}\n{\"step\":0,\"tick\":0,\"time_s\":0,\"generated\":\"tick\"}\n";
    std::fs::create_dir_all(at("vy/log")).unwrap();
    for (other, is_refused) in
        [("vy/log/report.json", true), ("vy/log/report.html", true), ("vy/index.html", true), ("vy/other.jsonl", false)]
    {
        [at("vy/log.jsonl"), at(other)].iter().for_each(|file| std::fs::write(file, log).unwrap());
        let logs = ["vy/log.jsonl", other];
        for logs in [logs, [logs[1], logs[0]]] {
            let arguments = [&["verify"], &logs[..], &["--property", "phi1", "--out", "vy"]].concat();
            let done = Command::new(binary()).args(&arguments).current_dir(folder.path()).output().unwrap();
            let said = String::from_utf8_lossy(&done.stderr);
            assert_eq!(said.contains("overwritten"), is_refused, "{arguments:?} {said}");
            assert_eq!(done.stdout.is_empty(), is_refused, "nothing is judged before");
            assert_eq!(std::fs::read_to_string(at(other)).unwrap(), log);
        }
        std::fs::remove_file(at(other)).unwrap();
    }
}

#[test]
fn a_recording_is_judged_by_its_own_properties() {
    let out = tempdir().unwrap();
    let scenario = out.path().join("own.toml");
    let text = "base = \"errand\"\nabout = \"own\"\nproperties = [\"low.scope\"]\n[execution]\nmax_time_s = 15\n";
    std::fs::write(&scenario, text).unwrap();
    let low = "property low := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 30.7)";
    std::fs::write(out.path().join("low.scope"), low).unwrap();
    for file in ["run.rec", "run.mcap"] {
        let file = out.path().join(file);
        let (scenario, file) = (scenario.to_str().unwrap(), file.to_str().unwrap());
        let folder = out.path().join("out");
        steward(&["run", scenario, "--no-snapshots", "--record", file, "--out", folder.to_str().unwrap()]);
        let output = steward(&["verify", file]);
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{text}{}", String::from_utf8_lossy(&output.stderr));
        assert!(text.contains("low          violated"), "{text}");
    }
}
