//! The scenarios end as they must, regardless of the schedule.

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{refusal, report};

fn monitor<'a>(report: &'a Value, name: &str) -> &'a Value {
    let monitors = report["monitors"].as_array().expect("a list of monitors");
    monitors.iter().find(|monitor| monitor["name"] == name).expect("a known monitor")
}

fn reached(report: &Value, place: &str) -> Option<f64> {
    let places = report["places"].as_array().expect("a list of places");
    places.iter().find(|entry| entry["name"] == place).expect("a known place")["reached_at_s"].as_f64()
}

#[test]
fn nominal_interrupts_the_errand_charges_resumes_and_arrives() {
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
fn battery_fault_violates_phi1_at_the_first_reading_below_twenty() {
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

/// The report of a scenario with these settings.
fn changed(scenario: &str, changes: &[&str]) -> Value {
    let out = tempdir().unwrap();
    let arguments: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
    report(scenario, out.path(), &[&["--no-snapshots"], arguments.as_slice()].concat())
}

#[test]
fn skill_bug_violates_phi2_after_theta_ticks_and_phi3_later() {
    let run = changed("skill_bug", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    // The battery is set at 20.5 s; the level is read at tick 21.
    assert_eq!(monitor(&run, "phi2")["tick"], 31);
    assert_eq!(monitor(&run, "phi3")["tick"], 141);
    let sound = changed("skill_bug", &[r#"faults=[{ kind = "battery_level", at_s = 20.5, level_pct = 25 }]"#]);
    assert_eq!(monitor(&sound, "phi2")["verdict"], "satisfied");
    assert!(reached(&sound, "RechargingStation").is_some());
}

#[test]
fn joypad_keeps_the_robot_away_until_the_level_is_below_twenty() {
    let run = changed("joypad", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    let level = monitor(&run, "phi1")["witness"]["message"][1].as_f64().unwrap();
    assert!((19.0..20.0).contains(&level), "{level}");
    let verdict = monitor(&run, "phi1")["time_s"].as_f64();
    let faults = run["faults"].as_array().unwrap();
    let before = faults.iter().filter(|fault| fault["time_s"].as_f64() < verdict).count();
    assert!(before >= 3, "the joypad was held {before} times");
    let alone = changed("joypad", &["faults=[]"]);
    assert_eq!(monitor(&alone, "phi1")["verdict"], "satisfied");
    assert!(reached(&alone, "RechargingStation").is_some());
}

#[test]
fn phi2_is_satisfied_with_a_robot_that_never_arrives_and_phi3_is_not() {
    let run = changed("never_arrives", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    assert_eq!(monitor(&run, "phi2")["vacuous"], Value::Array(Vec::new()), "phi2 was asked");
    assert_eq!(monitor(&run, "phi3")["tick"], 151);
    let free = changed("never_arrives", &["faults=[]"]);
    assert_eq!(monitor(&free, "phi3")["verdict"], "satisfied");
}

#[test]
fn phi2_blames_a_robot_that_is_already_there_and_its_variant_does_not() {
    let run = changed("already_there", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    assert_eq!(monitor(&run, "phi2")["tick"], 11);
    assert_eq!(monitor(&run, "phi2_or_there")["vacuous"], Value::Array(Vec::new()), "the variant was asked");
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_undisturbed_run_takes_the_same_course_with_the_published_protocol() {
    for variant in ["seed=1", "seed=2", "execution.policy=round-robin", "execution.tree=nodes"] {
        let run = changed("nominal", &["skills=skills/original", "execution.stops=any-trip", variant]);
        assert_eq!(run["outcome"], "as_expected", "{variant}: {}", run["differences"]);
        assert_eq!(run["overruns"], 0, "{variant}");
    }
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_halt_of_a_finished_trip_loses_the_next_one_if_it_ends_every_trip() {
    for seed in 1..=5 {
        let run = changed("late_halt", &[&format!("seed={seed}")]);
        assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    }
    let own_trips = changed("late_halt", &["execution.stops=own-trip"]);
    assert_eq!(monitor(&own_trips, "phi3")["verdict"], "satisfied");
    assert!(reached(&own_trips, "RechargingStation").is_some());
}

#[test]
fn navigation_that_is_released_before_it_is_halted_loses_the_trip_in_some_orders() {
    let published = changed("early_release", &["faults=[]"]);
    assert_eq!(monitor(&published, "phi3")["verdict"], "satisfied", "the same order, without the mistake");
    assert!(reached(&published, "RechargingStation").is_some());
    let reaches = |seed: u64| {
        let run = changed("early_release", &["execution.order=[]", &format!("seed={seed}")]);
        reached(&run, "RechargingStation").is_some()
    };
    assert!((1..=4).any(reaches), "the station is reached with some seed");
}

#[test]
fn an_order_with_unknown_channels_is_refused() {
    let order = r#"execution.order=[{ first = "(BatteryReader, Navigation, true)", then = "(BatteryReeder, BatteryLevel, true)" }]"#;
    let said = refusal(&["--scenario", "nominal", "--set", order]);
    for word in ["BatteryReeder", "Navigation"] {
        assert!(said.contains(word), "{word} is missing in\n{said}");
    }
}

#[test]
fn the_action_fails_if_the_destination_cannot_be_reached() {
    let out = tempdir().unwrap();
    let scenario = crate::bad_input::copy_of_battery_fault(out.path());
    let places = out.path().join("scenario/maps/house.places.toml");
    let text = std::fs::read_to_string(&places).unwrap();
    // Far outside the house, where the map is unknown.
    let far =
        text.replace("[Destination]", "[Elsewhere]") + "\n[Destination]\ncorners_m = [[90, 90], [91, 90], [91, 91]]\n";
    std::fs::write(&places, far).unwrap();
    // A place that may change: a scenario whose skills always drive to an unreachable place is not loaded.
    let skill = out.path().join("scenario/skills/GoToDestination.scxml");
    let text = std::fs::read_to_string(&skill).unwrap();
    let idle = "<state id=\"idle\"><onexit><assign location=\"place\" expr=\"place\"/></onexit></state>";
    std::fs::write(&skill, text.replace("<state id=\"idle\"/>", idle)).unwrap();
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
        // Nor is one that names it.
        "--set",
        "sites.destination=Elsewhere",
    ];
    let report = report(scenario.to_str().unwrap(), &out.path().join("run"), &arguments);
    assert_eq!(report["outcome"], "as_expected", "{report}");
    assert_eq!(reached(&report, "Destination"), None);
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.contains(r#""from":"GoToDestination","message":[{"sym":"failure"}]"#), "the action fails");
}
