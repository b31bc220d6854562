//! The scenarios end as they must, regardless of the schedule.

use serde_json::Value;
use tempfile::tempdir;

use crate::{monitor, problems, reached, recorded, report};

#[test]
fn nominal_interrupts_the_errand_charges_resumes_and_arrives() {
    for seed in ["seed=1", "seed=2", "seed=3"] {
        let report = report("nominal", &[seed]);
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
    for seed in ["seed=1", "seed=2", "seed=3"] {
        let out = tempdir().unwrap();
        let log = out.path().join("log.jsonl");
        let report = recorded("battery_fault", &[seed], &log);
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

#[test]
fn skill_bug_violates_phi2_after_theta_ticks_and_phi3_later() {
    let run = report("skill_bug", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    // The battery is set at 20.5 s; the level is read at tick 21.
    assert_eq!(monitor(&run, "phi2")["tick"], 31);
    assert_eq!(monitor(&run, "phi3")["tick"], 141);
    let sound = report("skill_bug", &[r#"faults=[{ kind = "battery_level", at_s = 20.5, level_pct = 25 }]"#]);
    assert_eq!(monitor(&sound, "phi2")["verdict"], "satisfied");
    assert!(reached(&sound, "RechargingStation").is_some());
}

#[test]
fn joypad_keeps_the_robot_away_until_the_level_is_below_twenty() {
    let run = report("joypad", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    let level = monitor(&run, "phi1")["witness"]["message"][1].as_f64().unwrap();
    assert!((19.0..20.0).contains(&level), "{level}");
    let verdict = monitor(&run, "phi1")["time_s"].as_f64();
    let faults = run["faults"].as_array().unwrap();
    let before = faults.iter().filter(|fault| fault["time_s"].as_f64() < verdict).count();
    assert!(before >= 3, "the joypad was held {before} times");
    let alone = report("joypad", &["faults=[]"]);
    assert_eq!(monitor(&alone, "phi1")["verdict"], "satisfied");
    assert!(reached(&alone, "RechargingStation").is_some());
}

#[test]
fn phi2_is_satisfied_with_a_robot_that_never_arrives_and_phi3_is_not() {
    let run = report("never_arrives", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    assert_eq!(monitor(&run, "phi2")["vacuous"], Value::Array(Vec::new()), "phi2 was asked");
    assert_eq!(monitor(&run, "phi3")["tick"], 151);
    let free = report("never_arrives", &["faults=[]"]);
    assert_eq!(monitor(&free, "phi3")["verdict"], "satisfied");
}

#[test]
fn phi2_blames_a_robot_that_is_already_there_and_its_variant_does_not() {
    let run = report("already_there", &[]);
    assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    assert_eq!(monitor(&run, "phi2")["tick"], 11);
    assert_eq!(monitor(&run, "phi2_or_there")["vacuous"], Value::Array(Vec::new()), "the variant was asked");
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_undisturbed_run_takes_the_same_course_with_the_published_protocol() {
    for variant in ["seed=1", "seed=2", "execution.policy=round-robin", "execution.tree=nodes"] {
        let run = report("nominal", &["skills=skills/original", "execution.stops=any-trip", variant]);
        assert_eq!(run["outcome"], "as_expected", "{variant}: {}", run["differences"]);
        assert_eq!(run["overruns"], 0, "{variant}");
    }
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn the_halt_of_a_finished_trip_loses_the_next_one_if_it_ends_every_trip() {
    for seed in 1..=5 {
        let run = report("late_halt", &[&format!("seed={seed}")]);
        assert_eq!(run["outcome"], "as_expected", "{}", run["differences"]);
    }
    let own_trips = report("late_halt", &["execution.stops=own-trip"]);
    assert_eq!(monitor(&own_trips, "phi3")["verdict"], "satisfied");
    assert!(reached(&own_trips, "RechargingStation").is_some());
}

#[test]
fn navigation_that_is_released_before_it_is_halted_loses_the_trip_in_some_orders() {
    let published = report("early_release", &["faults=[]"]);
    assert_eq!(monitor(&published, "phi3")["verdict"], "satisfied", "the same order, without the mistake");
    assert!(reached(&published, "RechargingStation").is_some());
    let reaches = |seed: u64| {
        let run = report("early_release", &["execution.order=[]", &format!("seed={seed}")]);
        reached(&run, "RechargingStation").is_some()
    };
    assert!((1..=4).any(reaches), "the station is reached with some seed");
}

#[test]
fn an_order_with_unknown_channels_is_refused() {
    let order = r#"execution.order=[{ first = "(BatteryReader, Navigation, true)", then = "(BatteryReeder, BatteryLevel, true)" }]"#;
    let said = problems("nominal", &[order]).concat();
    for word in ["BatteryReeder", "Navigation"] {
        assert!(said.contains(word), "{word} is missing in\n{said}");
    }
}

#[test]
fn the_action_fails_if_the_destination_cannot_be_reached() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let text = include_str!("../../../maps/house.places.toml");
    // Far outside the house, where the map is unknown.
    let far =
        text.replace("[Destination]", "[Elsewhere]") + "\n[Destination]\ncorners_m = [[90, 90], [91, 90], [91, 91]]\n";
    write("far.places.toml", &far);
    // A place that may change: a scenario whose skills always drive to an unreachable place is not loaded.
    let text = include_str!("../../../skills/machines/GoToDestination.scxml");
    let idle = "<state id=\"idle\"><onexit><assign location=\"place\" expr=\"place\"/></onexit></state>";
    let skill = text.replace("<state id=\"idle\"/>", idle);
    assert_ne!(skill, text);
    write("GoToDestination.scxml", &skill);
    write("own.toml", "base = \"battery_fault\"\nplaces = \"far.places.toml\"\n");
    let [scenario, machine, log] = ["own.toml", "GoToDestination.scxml", "log.jsonl"].map(|it| folder.path().join(it));
    let machine = format!("leaves.GoToDestination.machine='{}'", machine.display());
    // Nor is one that names it.
    let set = ["sites.destination=Elsewhere", "execution.max_time_s=30", "faults=[]", "stop={}", "expect={}", &machine];
    let report = recorded(&scenario, &set, &log);
    assert_eq!(report["outcome"], "as_expected", "{report}");
    assert_eq!(reached(&report, "Destination"), None);
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.contains(r#""from":"GoToDestination","message":[{"sym":"failure"}]"#), "the action fails");
}
