//! The scenarios come to what they must, whoever schedules.

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::report;

fn monitor<'a>(report: &'a Value, name: &str) -> &'a Value {
    let monitors = report["monitors"].as_array().expect("a list of monitors");
    monitors.iter().find(|monitor| monitor["name"] == name).expect("a known monitor")
}

fn reached(report: &Value, place: &str) -> Option<f64> {
    let places = report["places"].as_array().expect("a list of places");
    places.iter().find(|entry| entry["name"] == place).expect("a known place")["reached_at_s"].as_f64()
}

#[test]
fn nominal_breaks_off_charges_resumes_and_arrives() {
    for seed in ["1", "2", "3"] {
        let out = tempdir().unwrap();
        let report = report("nominal", out.path(), &["--seed", seed, "--no-snapshots"]);
        assert_eq!(report["outcome"], "as_expected", "{report}");
        for name in ["phi1", "phi2"] {
            assert_eq!(monitor(&report, name)["verdict"], "satisfied");
        }
        assert!(report["battery"]["minimum"].as_f64() > Some(20.0));
        assert!(report["battery"]["minimum"].as_f64() < Some(30.0));
        assert_eq!(report["robot"]["collisions"], 0);
        assert!(report["robot"]["localization"]["rmse_m"].as_f64() < Some(0.05));
        assert!(reached(&report, "RechargingStation") < reached(&report, "Destination"));
        assert!(reached(&report, "RechargingStation").is_some());
    }
}

#[test]
fn battery_fault_violates_phi1_at_the_first_level_below_twenty_that_is_read() {
    for seed in ["1", "2", "3"] {
        let out = tempdir().unwrap();
        let log = out.path().join("log.jsonl");
        let arguments = ["--seed", seed, "--no-snapshots", "--record", log.to_str().unwrap()];
        let report = report("battery_fault", out.path(), &arguments);
        assert_eq!(report["outcome"], "as_expected", "{report}");
        assert_eq!(monitor(&report, "phi1")["verdict"], "violated");
        assert_eq!(monitor(&report, "phi1")["state"], "failure");
        assert_eq!(monitor(&report, "phi2")["verdict"], "satisfied");
        assert!(reached(&report, "RechargingStation").is_some());

        let log = std::fs::read_to_string(log).unwrap();
        let events = log.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        let low = |event: &Value| {
            event["from"] == "BatteryReader" && event["message"][1].as_f64().is_some_and(|level| level < 20.0)
        };
        let first = events.into_iter().find(low).expect("a low level is read");
        assert_eq!(monitor(&report, "phi1")["tick"], first["tick"]);
        assert_eq!(monitor(&report, "phi1")["time_s"], first["time_s"]);
        assert_eq!(monitor(&report, "phi1")["witness"]["step"], first["step"]);
    }
}

/// Every way to schedule and both forms of the tree; the seeds are few here, `.ci/seeds` runs twenty.
#[test]
fn verdicts_do_not_depend_on_the_scheduler() {
    let variants = [
        "execution.policy=round-robin",
        "execution.starve=BT",
        "execution.starve=BatteryReader",
        "execution.starve=Navigation",
        "execution.starve=GotoRechargingStation",
        "execution.tree=nodes",
    ];
    for variant in variants {
        let out = tempdir().unwrap();
        let report = report("battery_fault", out.path(), &["--set", variant, "--no-snapshots"]);
        assert_eq!(report["outcome"], "as_expected", "{variant}: {report}");
    }
}

#[test]
fn a_destination_that_cannot_be_reached_is_a_run_in_which_the_action_fails() {
    let out = tempdir().unwrap();
    let scenario = crate::bad_input::copy_of_battery_fault(out.path());
    let places = out.path().join("scenario/maps/house.places.toml");
    let text = std::fs::read_to_string(&places).unwrap();
    // Far outside the house, where the map knows nothing.
    let far =
        text.replace("[Destination]", "[Elsewhere]") + "\n[Destination]\ncorners_m = [[90, 90], [91, 90], [91, 91]]\n";
    std::fs::write(&places, far).unwrap();
    let log = out.path().join("log.jsonl");
    let arguments = [
        "--no-snapshots",
        "--record",
        log.to_str().unwrap(),
        "--set",
        "faults=[]",
        "--set",
        "execution.max_time_s=30",
        "--set",
        "stop={}",
        "--set",
        "expect={}",
    ];
    let report = report(scenario.to_str().unwrap(), &out.path().join("run"), &arguments);
    assert_eq!(report["outcome"], "as_expected", "{report}");
    assert_eq!(reached(&report, "Destination"), None);
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.contains(r#""from":"GoToDestination","message":[{"sym":"failure"}]"#), "the action fails");
}
