//! What a user sees of the command line.

use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{report, steward};

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
        let picture = image::open(out.path().join(snapshot["file"].as_str().unwrap())).unwrap();
        assert_eq!((picture.width(), picture.height()), (1600, 900));
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
fn quiet_says_nothing() {
    let out = tempdir().unwrap();
    let output =
        steward(&["--scenario", "battery_fault", "--no-snapshots", "--quiet", "--out", out.path().to_str().unwrap()]);
    assert_eq!((output.status.code(), output.stdout.len(), output.stderr.len()), (Some(0), 0, 0));
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

#[test]
fn an_event_log_has_a_communication_a_line() {
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
    use image::AnimationDecoder;
    let out = tempdir().unwrap();
    let gif = out.path().join("run.gif");
    report("battery_fault", out.path(), &["--no-snapshots", "--gif", gif.to_str().unwrap()]);
    let bytes = std::io::Cursor::new(std::fs::read(gif).unwrap());
    let frames = image::codecs::gif::GifDecoder::new(bytes).unwrap().into_frames();
    assert!(frames.take(3).filter(Result::is_ok).count() == 3);
}
