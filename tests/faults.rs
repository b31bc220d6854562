//! Every kind of fault has a scenario that shows it.

use std::path::Path;
use std::sync::Mutex;
use std::thread;

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{refusal, report, steward};

/// Checks all items in parallel and fails with everything that is wrong with any of them.
pub(crate) fn check_each<T: Send>(items: Vec<T>, check: impl Fn(T) -> Result<(), String> + Sync) {
    let items = Mutex::new(items);
    let wrong = Mutex::new(Vec::new());
    let next = || items.lock().unwrap().pop();
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(item) = next() {
                    let found = check(item).err();
                    wrong.lock().unwrap().extend(found);
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn kinds() -> Vec<Value> {
    let output = steward(&["faults", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    serde_json::from_slice(&output.stdout).expect("the list is JSON")
}

/// The report of a run and the messages of its event log, each with its time.
pub(crate) fn recorded(scenario: &str, arguments: &[&str]) -> (Value, Vec<(f64, String)>) {
    let out = tempdir().unwrap();
    let log = out.path().join("log.jsonl");
    let mut all = vec!["--no-snapshots", "--record", log.to_str().unwrap()];
    all.extend(arguments);
    let report = report(scenario, out.path(), &all);
    (report, messages(&log))
}

pub(crate) fn messages(log: &Path) -> Vec<(f64, String)> {
    let text = std::fs::read_to_string(log).unwrap();
    let lines = text.lines().skip(1).map(|line| (serde_json::from_str::<Value>(line).unwrap(), line));
    let lines = lines.filter(|(value, _)| value["end"].is_null());
    lines.filter_map(|(value, line)| Some((value["time_s"].as_f64()?, line.to_owned()))).collect()
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn every_fault_meets_its_expectations_and_changes_nothing_before_its_onset() {
    let (_, errand) = recorded("errand", &["--set", "stop.after_s=300"]);
    let (announced, parcel) = recorded("parcel", &[]);
    let (_, zones) = recorded("faults/zone_ignored", &["--set", "faults=[]", "--set", "expect={}"]);
    check_each(kinds(), |kind| {
        let name = kind["kind"].as_str().unwrap();
        let sound = match name {
            // Only this one needs zones.
            "zone_ignored" => &zones,
            _ if kind["place"] == "devices" => &parcel,
            _ => &errand,
        };
        let (report, faulty) = recorded(kind["scenario"].as_str().unwrap(), &[]);
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
                *sound != faulty || kind["place"] == "devices" && report["said"] != announced["said"],
                format!("{name} shows in no message, and nothing else is reported"),
            ),
        ];
        let wrong: Vec<&str> = checks.iter().filter(|(right, _)| !right).map(|(_, words)| words.as_str()).collect();
        if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
    });
}

#[test]
fn a_scenario_without_its_fault_is_bit_identical_to_the_fault_free_run() {
    let hash = |scenario: &str, faults: &[&str]| {
        let out = tempdir().unwrap();
        let same_end = ["--no-snapshots", "--set", "execution.max_time_s=400", "--set", "stop.after_s=2"];
        report(scenario, out.path(), &[&same_end, faults].concat())["trace_hash"].clone()
    };
    let sound = hash("errand", &[]);
    let kinds = vec!["laser_noise", "joypad", "message_lost", "skill_threshold", "people", "component_crash"];
    check_each(kinds, |kind| {
        let same = sound == hash(&format!("faults/{kind}"), &["--set", "faults=[]"]);
        if same { Ok(()) } else { Err(format!("{kind} leaves something behind")) }
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
    let run = |seed| recorded("errand", &["--seed", seed, "--set", combined, "--set", "expect={}"]);
    let (first, again, other) = (run("3"), run("3"), run("4"));
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
fn the_list_of_faults_describes_each_fully() {
    let kinds = kinds();
    assert!(kinds.len() >= 40);
    let text = String::from_utf8(steward(&["faults"]).stdout).unwrap();
    for kind in &kinds {
        let name = kind["kind"].as_str().unwrap();
        assert!(
            text.lines().any(|line| line.starts_with("  ") && line.split_whitespace().next() == Some(name)),
            "{name}"
        );
        assert!(kind["example"].as_str().unwrap().starts_with("[[faults]]\n"));
    }
    let joypad = String::from_utf8(steward(&["faults", "joypad"]).stdout).unwrap();
    for word in ["linear_mps", "Forward speed, in m/s", "every_s", "kind = \"joypad\""] {
        assert!(joypad.contains(word), "{joypad}");
    }
    assert!(refusal(&["faults", "joipad"]).contains("did you mean `joypad`?"));
}

#[test]
fn the_matrix_shows_which_property_detects_which_fault() {
    let out = tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let faults = ["faults/battery_level", "faults/battery_sensor_offset"];
    let run = |more: &[&str]| steward(&[&["matrix", "--runs", "3", "--out", folder], &faults[..], more].concat());
    let output = run(&["--json", "--live", "--no-open"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("the progress is shown at http://127.0.0.1:"), "{said}");
    let matrix: Value = serde_json::from_slice(&output.stdout).unwrap();
    let phi1 = matrix["properties"].as_array().unwrap().iter().position(|name| name == "phi1").unwrap();
    let notices = |row: usize| &matrix["rows"][row]["notices"][phi1];
    assert_eq!(notices(0)["verdict"], "violated");
    assert!(notices(0)["ticks_after_onset"].as_u64().unwrap() <= 1);
    assert_eq!(notices(1)["verdict"], "satisfied");
    assert_eq!(matrix["fault_free"]["runs"], 3);
    assert_eq!(matrix["fault_free"]["alarms"].as_array().unwrap().len(), 0);
    let text = String::from_utf8(run(&[]).stdout).unwrap();
    assert!(text.contains("No false alarm in 3 runs of errand without a fault."), "{text}");
    assert!(text.contains("No property detects faults/battery_sensor_offset."), "{text}");
    assert!(std::fs::read_to_string(out.path().join("index.html")).unwrap().contains("faults/battery_level"));
}

/// `Plan` has an output port, which the pretended answer does not fill, and `FollowPath` has none.
#[test]
fn the_matrix_has_lost_halts_of_leaves_with_and_without_output_ports() {
    let out = tempdir().unwrap();
    let [plan, follow] = ["Plan", "FollowPath"].map(|leaf| {
        let file = out.path().join(format!("{leaf}.toml"));
        let fault = format!("[[faults]]\nkind = \"halt_lost\"\nat_s = 0\nleaf = \"{leaf}\"\n");
        std::fs::write(&file, format!("base = \"nav2/canceled_goal\"\n{fault}")).unwrap();
        file.to_str().unwrap().to_owned()
    });
    let folder = out.path().join("matrix");
    let fixed = ["--fault-free", "nav2/canceled_goal", "--runs", "1", "--json", "--out", folder.to_str().unwrap()];
    let output = steward(&[&["matrix", &plan, &follow][..], &fixed].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    // A fault may make a run not as expected.
    assert!(matches!(output.status.code(), Some(0 | 1)), "{said}");
    let matrix: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = matrix["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2, "{matrix}");
    assert!(rows.iter().all(|row| row["fault"].is_string()), "{matrix}");
}

/// `silent` is violated with the fault and without it. The robot arrives, although the scenario stops nowhere.
#[test]
fn a_property_that_is_violated_without_a_fault_detects_none() {
    let out = tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = out.path().join(name);
        std::fs::write(&file, text).unwrap();
        file.to_str().unwrap().to_owned()
    };
    write("silent.scope", "property silent := always not (BatteryReader, BatteryLevel, m[1] = <ok>)");
    let sound = write("sound.toml", "base = \"errand\"\nproperties = [\"silent.scope\"]\n[stop]\nat = []\n");
    let fault = "[[faults]]\nkind = \"battery_sensor_offset\"\nat_s = 0\noffset_pct = 1\n";
    let faulty = write("faulty.toml", &format!("base = \"sound.toml\"\n{fault}"));
    let folder = out.path().join("matrix");
    let folder = folder.to_str().unwrap();
    let output = steward(&["matrix", &faulty, "--fault-free", &sound, "--runs", "1", "--out", folder]);
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("0 of 1 fault is detected") && said.contains("(+") && said.contains("  arrived"), "{said}");
    assert!(said.contains("(+n): the same, but it is also violated without a fault"), "{said}");
}

#[test]
fn a_false_alarm_in_a_run_without_a_fault_ends_with_status_1() {
    let out = tempdir().unwrap();
    let strict = out.path().join("strict.scope");
    std::fs::write(
        &strict,
        "property never_low := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 30)",
    )
    .unwrap();
    let scenario = out.path().join("sound.toml");
    std::fs::write(&scenario, "base = \"scenarios/errand.toml\"\nproperties = [\"properties/phi1.scope\", \"properties/phi2.scope\", \"properties/phi3.scope\", \"strict.scope\"]\n").unwrap();
    let scenario = scenario.to_str().unwrap();
    let folder = out.path().join("matrix");
    let output = steward(&[
        "matrix",
        "faults/battery_level",
        "--fault-free",
        scenario,
        "--runs",
        "1",
        "--out",
        folder.to_str().unwrap(),
    ]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("never_low is violated"), "{said}");
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
    let said = refusal(&["--scenario", "errand", "--set", faults]);
    for word in ["BatteryLevl", "a wrong map lasts for the whole run"] {
        assert!(said.contains(word), "{word} is missing in\n{said}");
    }
    let said = refusal(&[
        "--scenario",
        "errand",
        "--set",
        &faults.replace("BatteryLevl\"", "BatteryLevel\"").replace("at_s = 5, map", "at_s = 0, map"),
    ]);
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

#[test]
fn a_scenario_without_faults_is_neither_a_detected_fault_nor_a_false_alarm() {
    let out = tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let low = "property low := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 30.7)";
    std::fs::write(out.path().join("low.scope"), low).unwrap();
    let scenario = out.path().join("low.toml");
    let text = "base = \"errand\"\nproperties = [\"low.scope\"]\nexpect.low = \"violated\"\nexpect.reached = []\n";
    std::fs::write(&scenario, text.to_owned() + "execution.max_time_s = 15\n").unwrap();
    let scenario = scenario.to_str().unwrap();
    let output = steward(&["matrix", scenario, "faults/battery_level", "--runs", "1", "--out", folder]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("1 of 1 fault is detected by a property. 1 scenario has no faults"), "{text}");
    assert!(text.contains("No false alarm") && !text.contains("early"), "{text}");
    let refused = refusal(&["matrix", "faults/battery_level", "--fault-free", "faults/battery_level", "--out", folder]);
    assert!(refused.contains("has faults, so it cannot show what happens without any"), "{refused}");
}
