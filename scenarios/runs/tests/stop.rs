//! When a run ends: at an arrival, at a violation, when everything is decided, or at its limit.

use tempfile::tempdir;

use crate::{problems, report};

/// In `battery_fault`, phi1 is violated long before the robot arrives; phi2 never is.
#[test]
fn a_run_ends_at_the_first_violation_on_which_it_should_stop() {
    let run = |set: &[&str]| report("battery_fault", set);
    let until_arrival = run(&[]);
    assert_eq!(until_arrival["ended"], "arrival");
    for stop in ["stop.on_violation=true", "stop.on_violation=phi1", "stop.on_violation=[\"phi2\", \"phi1\"]"] {
        let report = run(&[stop, "stop.after_s=0"]);
        assert_eq!((&report["ended"], &report["ended_because"]), (&"violation".into(), &"phi1 was violated".into()));
        assert_eq!(report["sim_time_s"], report["monitors"][0]["time_s"], "{stop}");
    }
    let later = run(&["stop.on_violation=true"]);
    let time_s = |report: &serde_json::Value| report["sim_time_s"].as_f64().unwrap();
    assert!((time_s(&later) - later["monitors"][0]["time_s"].as_f64().unwrap() - 5.0).abs() < 0.021, "after_s is kept");
    for stop in ["stop.on_violation=phi2", "stop.on_violation=false"] {
        assert_eq!(run(&[stop])["trace_hash"], until_arrival["trace_hash"], "{stop}");
    }
    let limited = run(&["stop.on_violation=true", "execution.max_time_s=10"]);
    assert_eq!((&limited["ended"], time_s(&limited)), (&"time_limit".into(), 10.0));
}

/// The errand passes the charging station before it reaches its destination.
#[test]
fn a_run_ends_at_the_first_of_several_places() {
    let report = report("errand", &["stop.at=[\"Destination\", \"RechargingStation\"]", "stop.after_s=0"]);
    assert_eq!(report["ended_because"], "the robot came to rest at RechargingStation");
}

#[test]
fn a_run_ends_when_every_property_has_a_final_verdict() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("soon.scope");
    let starts = "property starts := eventually (GotoRechargingStation, Navigation, m[1] = <start_navigation>)";
    let stays = "property stays := not eventually (GotoRechargingStation, Navigation, m[1] = <stop_navigation>)";
    std::fs::write(&file, format!("{starts}\n{stays}\n")).unwrap();
    // Without a base, because `errand` expects something of properties that are not watched here.
    let scenario = folder.path().join("settled.toml");
    let files = ["map = \"maps/house.yaml\"", "places = \"maps/house.places.toml\"", "tree = \"trees/recharge.xml\""];
    let rest = "skills = \"skills\"\nproperties = [\"soon.scope\"]\nbattery.initial_pct = 30.8\nstop.when_settled = true\n\
        sites = { start = \"start\", station = \"RechargingStation\", destination = \"Destination\" }\n";
    std::fs::write(&scenario, files.join("\n") + "\n" + rest).unwrap();
    let report = crate::report(&scenario, &["execution.max_time_s=300"]);
    assert_eq!(report["ended"], "settled");
    let monitors = report["monitors"].as_array().unwrap();
    let verdicts: Vec<&str> = monitors.iter().map(|monitor| monitor["verdict"].as_str().unwrap()).collect();
    assert_eq!(verdicts, ["satisfied", "violated"], "{report}");
    assert_eq!(report["sim_time_s"], monitors[1]["time_s"]);
    let open = crate::report("errand", &["stop.when_settled=true", "stop.at=[]", "execution.max_time_s=20"]);
    assert_eq!(open["ended"], "time_limit", "phi1 can be violated to the end");
    // One of them suffices, if it is named.
    let named = crate::report(&scenario, &["stop.when_settled=starts"]);
    assert_eq!(named["ended"], "settled");
    assert!(named["sim_time_s"].as_f64() < monitors[1]["time_s"].as_f64(), "{named}");
}

#[test]
fn invalid_stop_conditions_are_refused() {
    let refused = |set: &str| problems("errand", &[set]).concat();
    assert!(refused("stop.on_violation=phi9").contains("did you mean `phi"));
    assert!(refused("stop.when_settled=phi9").contains("did you mean `phi"));
    assert!(refused("stop.on_violation=3").contains("the name of a property"));
    assert!(refused("stop.at=3").contains("an array of names"));
    assert!(refused("stop.at=[\"Destinatin\"]").contains("did you mean `Destination`?"));
}
