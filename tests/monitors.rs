//! `steward verify` of logs from a pipe, and what it shows of verdicts.

use std::io::Write as _;
use std::process::{Command, Stdio};

use tempfile::tempdir;

use crate::steward::{binary, refusal, steward};

const LOG: &str = r#"{"scenario":"nominal","version":"0.1.0","tick_s":1.0}
{"step":0,"tick":0,"time_s":0.0,"generated":"tick"}
{"step":1,"tick":0,"time_s":0.1,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},10.0]}
{"step":1,"tick":1,"time_s":1.0,"generated":"tick"}
"#;

/// The output of `steward verify` for a log on standard input.
fn verified(log: &str, property: &str) -> (Option<i32>, String) {
    let mut child = Command::new(binary())
        .args(["verify", "-", "--property", property])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(log.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    // The graphical report may break lines anywhere between words.
    let flat = said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ");
    (output.status.code(), flat)
}

#[test]
fn a_log_may_come_from_a_pipe() {
    let (status, said) = verified(LOG, "phi1");
    // It does not list the channels of its run.
    let assumed = "it is assumed that the log has every message of the scenario's channels";
    let expected = format!("1 message, 2 ticks {assumed} phi1 violated");
    assert!(status == Some(1) && said.contains(&expected), "{status:?}: {said}");
}

#[test]
fn a_log_that_cannot_be_judged_is_refused() {
    for (old, new, expected) in [
        ("nominal", "patrol", "to a scenario `patrol` that does not come with the program"),
        ("0.1.0", "99.0.0", "written by version 99.0.0 of steward"),
        (r#""to":"BatteryLevel","#, "", "line 3 of the log, byte 1: this message has no `to`"),
    ] {
        let (status, said) = verified(&LOG.replace(old, new), "phi1");
        assert!(status == Some(2) && said.contains(expected), "{status:?}: {said}");
    }
    let (status, said) = verified(LOG.split_once('\n').unwrap().1, "phi1");
    assert!(status == Some(1) && said.contains("does not say which scenario it belongs to"), "{status:?}: {said}");
}

#[test]
fn a_recurrence_is_open_when_the_run_ends_and_a_contradiction_names_both_halves() {
    let folder = tempdir().unwrap();
    let property = folder.path().join("p.scope");
    let q = "(BatteryReader, BatteryLevel, m[2] > 3)";
    let there = "(Localization, AtRechargingStation, m[2] = true)";
    let judged = |text: &str| {
        std::fs::write(&property, format!("property r := {text}")).unwrap();
        verified(LOG, property.to_str().unwrap())
    };
    for text in [format!("always ({q} implies time_until {q} > 0)"), "always next true".to_owned()] {
        let (status, said) = judged(&text);
        assert!(status == Some(0) && said.contains("r inconclusive still pending"), "{status:?}: {said}");
    }
    let (status, said) = judged(&format!("always ({q} implies time_until {there} < 3) and always (not {there})"));
    assert!(status == Some(1) && said.contains(&format!("and not {there} seen:")), "{status:?}: {said}");
    let (status, said) = judged("eventually false");
    assert!(status == Some(1) && said.contains("violated at step 0, tick 0, 0.00 s: eventually false"), "{said}");
}

#[test]
fn a_name_longer_than_a_line_is_explained() {
    let folder = tempdir().unwrap();
    let property = folder.path().join("long.scope");
    let name = "p".repeat(70_000);
    let text = format!("// Never below 20 %.\nproperty {name} := always (BatteryReader, BatteryLevel, m[2] >= 20)");
    std::fs::write(&property, text).unwrap();
    let output = steward(&["monitor", "explain", property.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let file = folder.path().join("model.jani");
    std::fs::write(&file, "{ \"jani-version\": 1, \"automata\": [] }").unwrap();
    assert!(refusal(&["monitor", "check", file.to_str().unwrap()]).contains("this is a JANI model"));
}
