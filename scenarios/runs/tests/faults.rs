//! Every kind of fault has a scenario that shows it.

use std::path::Path;

use recording::Detail;
use reports::{Outputs, html};
use scenarios::faults::{KINDS, Subsystem};
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::{problems, report, report_of, start};

/// The report of a run and the messages of its event log, each with its time.
pub(crate) fn recorded(scenario: &str, set: &[&str]) -> (Value, Vec<(f64, String)>) {
    let out = tempdir().unwrap();
    let log = out.path().join("log.jsonl");
    (crate::recorded(scenario, set, &log), messages(&log))
}

/// The same for a scenario as it is, whose page is written, too.
fn recorded_with_its_page(scenario: &str) -> (Value, Vec<(f64, String)>) {
    let out = tempdir().unwrap();
    let [log, folder] = ["log.jsonl", "out"].map(|name| out.path().join(name));
    let outputs = Outputs { folder: Some(folder.clone()), ..Outputs::default() };
    let report = report_of(start(scenario, &[]), Detail::Full, &outputs, Some(&log)).unwrap();
    assert!(folder.join(html::FILE).is_file(), "{scenario}");
    (json!(report), messages(&log))
}

pub(crate) fn messages(log: &Path) -> Vec<(f64, String)> {
    let text = std::fs::read_to_string(log).unwrap();
    let lines = text.lines().skip(1).map(|line| (serde_json::from_str::<Value>(line).unwrap(), line));
    let lines = lines.filter(|(value, _)| value["end"].is_null());
    lines.filter_map(|(value, line)| Some((value["time_s"].as_f64()?, line.to_owned()))).collect()
}

/// Checks all items in parallel and fails with everything that is wrong with any of them.
fn check_each<T: Sync>(items: &[T], check: impl Fn(&T) -> Vec<String> + Sync) {
    let wrong = batch::run(items, check, |_| {}).concat();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn every_fault_meets_its_expectations_and_changes_nothing_before_its_onset() {
    let (_, errand) = recorded("errand", &["stop.after_s=300"]);
    let (announced, parcel) = recorded("parcel", &[]);
    let (_, zones) = recorded("faults/zone_ignored", &["faults=[]", "expect={}"]);
    check_each(KINDS, |kind| {
        let name = kind.name;
        let is_device = kind.subsystem == Subsystem::Devices;
        let sound = match name {
            // Only this one needs zones.
            "zone_ignored" => &zones,
            _ if is_device => &parcel,
            _ => &errand,
        };
        let (report, faulty) = recorded_with_its_page(&format!("faults/{name}"));
        let first = &report["faults"][0];
        let onset = first["time_s"].as_f64().unwrap_or(f64::INFINITY);
        let before = |messages: &[(f64, String)]| -> Vec<String> {
            messages.iter().take_while(|(time, _)| *time <= onset).map(|(_, line)| line.clone()).collect()
        };
        let checks = [
            (report["outcome"] == "as_expected", format!("{name}: {}", report["differences"])),
            (first["kind"] == name, format!("{name}: the first fault is {first}")),
            (before(sound) == before(&faulty), format!("{name}: the runs differ before {onset} s")),
            (
                *sound != faulty || is_device && report["said"] != announced["said"],
                format!("{name} shows in no message, and nothing else is reported"),
            ),
        ];
        checks.into_iter().filter(|(right, _)| !right).map(|(_, words)| words).collect()
    });
}

#[test]
fn a_scenario_without_its_fault_is_bit_identical_to_the_fault_free_run() {
    let hash = |scenario: &str, faults: &[&str]| {
        report(scenario, &[&["execution.max_time_s=400", "stop.after_s=2"], faults].concat())["trace_hash"].clone()
    };
    let sound = hash("errand", &[]);
    let kinds = ["laser_noise", "joypad", "message_lost", "skill_threshold", "people", "component_crash"];
    check_each(&kinds, |kind| {
        let same = sound == hash(&format!("faults/{kind}"), &["faults=[]"]);
        if same { Vec::new() } else { vec![format!("{kind} leaves something behind")] }
    });
}

#[test]
fn faults_combine_and_one_seed_gives_the_same_run() {
    let combined = r#"faults=[
        { kind = "laser_noise", at_s = 2, sigma_m = 0.05 },
        { kind = "battery_sensor_noise", at_s = 0, sigma_pct = 0.1 },
        { kind = "message_lost", at_s = 0, from = "BatteryReader", to = "BatteryLevel", share = 0.1 },
        { kind = "tick_jitter", at_s = 5, sigma_s = 0.05, lasts_s = 20 },
        { kind = "joypad", when = "(GotoRechargingStation, Navigation, true)", probability = 0.5, angular_radps = 0.5, lasts_s = 0.4, times = 20 },
        { kind = "wheel_slip", in_state = "GotoRechargingStation.running", share = 0.1, lasts_s = 3 },
    ]"#;
    let run = |seed| recorded("errand", &[seed, combined, "expect={}"]);
    let (first, again, other) = (run("seed=3"), run("seed=3"), run("seed=4"));
    assert_eq!(first.1, again.1);
    assert_ne!(first.1, other.1);
    let kinds: Vec<&str> = first.0["faults"].as_array().unwrap().iter().map(|f| f["kind"].as_str().unwrap()).collect();
    for kind in ["laser_noise", "message_lost", "tick_jitter", "joypad", "wheel_slip"] {
        assert!(kinds.contains(&kind), "{kind} is not among {kinds:?}");
    }
    let joypad = kinds.iter().filter(|kind| **kind == "joypad").count();
    assert!((2..=20).contains(&joypad), "the joypad was held {joypad} times");
    let lost = first.0["faults"].as_array().unwrap().iter().find(|fault| fault["kind"] == "message_lost").unwrap();
    assert!(lost["messages"].as_u64().unwrap() >= 2, "{lost}");
}

#[test]
fn faults_with_unknown_names_are_all_refused_at_once() {
    let faults = r#"faults=[
        { kind = "message_lost", at_s = 0, from = "BatteryReeder", to = "BatteryLevel" },
        { kind = "message_lost", at_s = 0, from = "BatteryReader", to = "Navigation" },
        { kind = "message_corrupted", at_s = 0, from = "BatteryReader", to = "BatteryLevel", value = "<low>" },
        { kind = "skill_threshold", at_s = 0, skill = "BatteryLevl", value = "20" },
        { kind = "joypad", near = "RechargeStation" },
        { kind = "joypad", in_state = "GoToDestination.runing" },
        { kind = "joypad", when = "(BatteryReader, BatteryLevel, m[3] < 30)" },
        { kind = "wrong_map", at_s = 5, map = "maps/house.yaml" },
    ]"#;
    let said = problems("errand", &[faults]).concat();
    for word in ["BatteryLevl", "a wrong map lasts for the whole run"] {
        assert!(said.contains(word), "{word} is missing in\n{said}");
    }
    let faults = faults.replace("BatteryLevl\"", "BatteryLevel\"").replace("at_s = 5, map", "at_s = 0, map");
    let said = problems("errand", &[&faults]).concat();
    for word in [
        "BatteryReeder",
        "there is no channel from BatteryReader to Navigation",
        "<low>",
        "RechargeStation",
        "runing",
        "m[3]",
    ] {
        assert!(said.contains(word), "{word} is missing in\n{said}");
    }
}
