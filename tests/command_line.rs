//! What a user sees of the command line.

use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{picture_size, report, steward};

#[test]
fn a_run_ends_with_a_summary_a_report_and_pictures() {
    let out = tempdir().unwrap();
    let output = steward(&["--scenario", "battery_fault", "--out", out.path().to_str().unwrap()]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for part in ["battery_fault", "as expected", "phi1", "violated", "phi2", "satisfied", "report.json"] {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
    let report: Value = serde_json::from_slice(&std::fs::read(out.path().join("report.json")).unwrap()).unwrap();
    let snapshots = report["snapshots"].as_array().unwrap();
    assert!(snapshots.len() >= 5, "{snapshots:?}");
    for snapshot in snapshots {
        let picture = out.path().join(snapshot["file"].as_str().unwrap());
        assert_eq!(picture_size(&picture), (1600, 900));
    }
}

#[test]
fn the_report_has_the_promised_keys() {
    let out = tempdir().unwrap();
    let report = report("battery_fault", out.path(), &["--no-snapshots"]);
    for key in [
        "scenario",
        "seed",
        "version",
        "outcome",
        "sim_time_s",
        "ticks",
        "overruns",
        "steps",
        "trace_hash",
        "monitors",
        "faults",
        "battery",
        "robot",
        "places",
        "snapshots",
        "timing",
    ] {
        assert!(!report[key].is_null(), "no {key}");
    }
    for key in ["name", "property", "verdict", "state", "tick", "time_s", "witness"] {
        assert!(report["monitors"][0].get(key).is_some(), "no monitors[].{key}");
    }
    for key in ["final_pose", "distance_m", "collisions", "localization"] {
        assert!(!report["robot"][key].is_null(), "no robot.{key}");
    }
    assert_eq!(report["faults"][0]["kind"], "battery_level");
}

#[test]
fn a_run_that_is_not_as_expected_says_what_differs_and_exits_with_one() {
    let out = tempdir().unwrap();
    let arguments = [
        "--scenario",
        "battery_fault",
        "--no-snapshots",
        "--out",
        out.path().to_str().unwrap(),
        "--set",
        "expect.phi1=satisfied",
    ];
    let output = steward(&arguments);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("phi1 was expected to be satisfied and is violated"), "{said}");
}

#[test]
fn quiet_prints_nothing() {
    let out = tempdir().unwrap();
    let output =
        steward(&["--scenario", "battery_fault", "--no-snapshots", "--quiet", "--out", out.path().to_str().unwrap()]);
    assert_eq!((output.status.code(), output.stdout.len(), output.stderr.len()), (Some(0), 0, 0));
}

#[test]
fn a_failure_is_reported_even_with_quiet() {
    let out = tempdir().unwrap();
    let arguments = ["--scenario", "battery_fault", "--no-snapshots", "-q", "--set", "expect.phi1=satisfied", "--out"];
    let output = steward(&[&arguments[..], &[out.path().to_str().unwrap()]].concat());
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("battery_fault, seed 1: NOT as expected"), "{said}");
    assert!(said.contains("phi1 was expected to be satisfied and is violated"), "{said}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_says_how_far_it_got_and_leaves_no_partial_files() {
    let folder = tempdir().unwrap();
    let (out, log) = (folder.path().join("out"), folder.path().join("log.jsonl"));
    let child = Command::new(env!("CARGO_BIN_EXE_steward"))
        .args(["--scenario", "nominal", "--set", "stop.at=[]", "--set", "execution.max_time_s=1e8"])
        .args(["--out", out.to_str().unwrap(), "--record", log.to_str().unwrap()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // From then on it listens.
    while !out.exists() {
        std::thread::yield_now();
    }
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success());
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!((ended.status.code(), ended.stdout.len()), (Some(130), 0), "{said}");
    assert!(
        said.contains("note: interrupted after ") && said.contains("report and pictures were not written"),
        "{said}"
    );
    assert!(said.contains("phi1 undecided") && said.contains(log.to_str().unwrap()), "{said}");
    assert!(!out.join("report.json").exists() && !out.join("report.html").exists());
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.ends_with('\n'));
    assert!(log.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()), "{log}");
}

#[test]
fn list_names_the_scenarios() {
    let said = String::from_utf8(steward(&["list"]).stdout).unwrap();
    assert!(said.contains("nominal") && said.contains("battery_fault"), "{said}");
}

#[test]
fn a_closed_pipe_ends_quietly() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_steward"))
        .arg("list")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
}

#[test]
fn the_binary_works_from_any_folder_and_writes_to_out() {
    let folder = tempdir().unwrap();
    let status = Command::new(env!("CARGO_BIN_EXE_steward"))
        .args(["--scenario", "battery_fault", "--no-snapshots", "--quiet"])
        .current_dir(folder.path())
        .status()
        .unwrap();
    assert!(status.success());
    assert!(folder.path().join("out/battery_fault/report.json").is_file());
}

#[test]
fn an_initialised_copy_runs_like_the_original() {
    let folder = tempdir().unwrap();
    let copy = crate::bad_input::copy_of_battery_fault(folder.path());
    let [original, copied] = [("battery_fault", "a"), (copy.to_str().unwrap(), "b")]
        .map(|(scenario, out)| report(scenario, &folder.path().join(out), &["--no-snapshots"])["trace_hash"].clone());
    assert_eq!(original, copied);
}

/// A scenario of one's own, with what it names beside it.
#[test]
fn a_scenario_in_a_file_can_be_copied_too() {
    let folder = tempdir().unwrap();
    let original = crate::bad_input::copy_of_battery_fault(folder.path());
    let (beside, copy) = (original.parent().unwrap(), folder.path().join("copy"));
    std::fs::rename(beside.join("maps/house.places.toml"), beside.join("maps/mine.toml")).unwrap();
    let text = "base = \"battery_fault.toml\"\nplaces = \"maps/mine.toml\"\nabout = \"mine\"\n";
    std::fs::write(beside.join("mine.toml"), text).unwrap();
    let mine = beside.join("mine.toml");
    let output = steward(&["init", copy.to_str().unwrap(), "--scenario", mine.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in ["mine.toml", "battery_fault.toml", "maps/mine.toml", "trees/recharge.xml"] {
        assert!(copy.join(file).is_file(), "{file}");
    }
    std::fs::remove_dir_all(beside).unwrap();
    let copied = copy.join("mine.toml");
    let output = steward(&[
        "--scenario",
        copied.to_str().unwrap(),
        "-q",
        "--no-snapshots",
        "--out",
        folder.path().to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn an_event_log_has_one_communication_per_line() {
    let out = tempdir().unwrap();
    let log = out.path().join("log.jsonl");
    let report = report("battery_fault", out.path(), &["--no-snapshots", "--record", log.to_str().unwrap()]);
    let text = std::fs::read_to_string(log).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines[0]["scenario"], "battery_fault");
    let messages = lines.iter().filter(|line| !line["message"].is_null()).count() as u64;
    assert_eq!(report["steps"].as_u64(), Some(messages));
    let ticks = lines.iter().filter(|line| line["generated"] == "tick").count() as u64;
    assert_eq!(report["ticks"].as_u64(), Some(ticks));
    assert!(lines.iter().any(|line| line["tree"].is_object()), "the tree's statuses are in the log");
}

#[test]
fn an_animation_is_a_gif_of_more_than_one_picture() {
    let out = tempdir().unwrap();
    let gif = out.path().join("run.gif");
    report("battery_fault", out.path(), &["--no-snapshots", "--gif", gif.to_str().unwrap()]);
    let frames = gif::Decoder::new(std::fs::File::open(gif).unwrap()).unwrap().into_iter();
    assert!(frames.take(3).filter(Result::is_ok).count() == 3);
}

#[test]
fn exit_statuses_agree_with_the_readme() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("out");
    let occupied = folder.path().join("occupied");
    std::fs::write(&occupied, "").unwrap();
    let log = folder.path().join("log.jsonl");
    let [out, log, below] = [out, log, occupied.join("out")].map(|path| path.to_str().unwrap().to_owned());
    let run = ["--scenario", "battery_fault", "--no-snapshots", "--quiet"];
    let statuses: [(i32, Vec<&str>); 12] = [
        (0, [&run[..], &["--out", &out, "--record", &log]].concat()),
        (1, [&run[..], &["--out", &out, "--set", "expect.phi1=satisfied"]].concat()),
        (2, [&run[..], &["--out", &out, "--set", "execution.step_budget=2"]].concat()),
        (2, [&run[..], &["--out", &out, "--set", "batery=1"]].concat()),
        (3, [&run[..], &["--out", &below]].concat()),
        (3, [&run[..], &["--out", &out, "--record", &below]].concat()),
        (0, vec!["verify", &log, "--property", "phi2"]),
        (1, vec!["verify", &log, "--property", "phi1"]),
        (2, vec!["verify", &below, "--property", "phi1"]),
        (2, vec!["--no-such-argument"]),
        (0, vec!["--version"]),
        (3, vec!["monitor", "export", "phi1", "--out", &below]),
    ];
    for (status, arguments) in statuses {
        let output = steward(&arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
