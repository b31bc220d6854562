//! The list of faults, and the matrix of faults and properties.

use scenarios::faults::KINDS;
use scenarios::files::scenario_names;
use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{refusal, steward};

#[test]
fn the_list_of_faults_describes_each_fully() {
    let output = steward(&["faults", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let kinds: Vec<Value> = serde_json::from_slice(&output.stdout).expect("the list is JSON");
    assert!(kinds.len() >= 40);
    assert_eq!(kinds.len(), KINDS.len());
    let text = String::from_utf8(steward(&["faults"]).stdout).unwrap();
    for (kind, known) in kinds.iter().zip(KINDS) {
        let name = kind["kind"].as_str().unwrap();
        assert_eq!((name, &kind["place"]), (known.name, &known.subsystem.name().into()));
        // This scenario shows it: `every_fault_meets_its_expectations_and_changes_nothing_before_its_onset`.
        assert_eq!(kind["scenario"], format!("faults/{name}"));
        assert!(scenario_names().any(|scenario| kind["scenario"] == scenario), "{name}");
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
