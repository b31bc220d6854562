//! AS2FM's own examples and tests, if `STEWARD_AS2FM` names a checkout of AS2FM.

use std::path::PathBuf;

use super::{holds, run};
use crate::load;

/// AS2FM's examples, with the probabilities that its tests and its tutorial give.
const CERTAIN: [(&str, &str, bool); 18] = [
    ("examples/quick_start_battery_monitor/main.xml", "battery_depleted", false),
    ("examples/quick_start_battery_monitor/main.xml", "battery_below_20", false),
    ("examples/quick_start_battery_monitor/main.xml", "battery_alarm_on", true),
    ("examples/quick_start_battery_monitor/main.xml", "battery_charged", true),
    ("examples/tutorial_fetch_and_carry/main.xml", "snack_at_table", true),
    ("T/array_of_data_structs/main.xml", "success", true),
    ("T/array_model_multi_dim/main.xml", "array_check", true),
    ("T/blackboard_test/main.xml", "tree_success", true),
    ("T/bt_test_models/main_test_ifthenelse_then.xml", "counter_then_10", true),
    ("T/bt_test_models/main_test_ifthenelse_else.xml", "counter_else_10", true),
    ("T/different_rate_senders/main.xml", "counter_check", true),
    ("T/fibonacci_action_single_thread/main.xml", "client1_ok", true),
    ("T/nested_data_ros/main.xml", "success", true),
    ("T/ros_add_int_srv_example/main.xml", "happy_clients", true),
    ("T/ros_example/main.xml", "battery_depleted", true),
    ("T/ros_example/main.xml", "battery_over_depleted", false),
    ("T/ros_example/main.xml", "alarm_on", true),
    ("T/string_msg_comparison/main.xml", "success", true),
];

/// The checkout; without one, prints why nothing is tested.
fn checkout() -> Option<PathBuf> {
    let folder = std::env::var_os("STEWARD_AS2FM").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("not run here: STEWARD_AS2FM does not name a checkout of AS2FM");
    }
    folder
}

#[test]
fn certain_outcomes_have_their_documented_verdict_in_every_run() {
    let Some(folder) = checkout() else { return };
    for (main, property, expected) in CERTAIN {
        let main = folder.join(main.replace("T/", "test/jani_generator/_test_data/"));
        for (set, seeds) in [(&["execution.policy=round-robin"][..], 0..1), (&[], 1..5)] {
            let scenario = load(main.to_str().expect("UTF-8"), set).expect("a sound model");
            for seed in seeds {
                let report = run(&scenario, seed);
                assert!(report.skill_errors.is_empty(), "{main:?}, seed {seed}: {:?}", report.skill_errors);
                assert_eq!(holds(&report, property), expected, "{main:?}, {property}, seed {seed}");
            }
        }
    }
}

#[test]
fn two_leaves_with_the_same_id_and_name_are_two_processes() {
    let Some(folder) = checkout() else { return };
    let main = folder.join("examples/tutorial_fetch_and_carry/main.xml");
    let scenario = load(main.to_str().expect("UTF-8"), &[]).expect("a sound model");
    let names: Vec<&str> = scenario.machine_processes().map(|(name, _)| name).collect();
    assert_eq!(names.len(), 5, "{names:?}");
    assert_eq!(names.iter().filter(|name| name.starts_with("navigate")).count(), 2, "{names:?}");
}

/// Fetch and carry: 0.7 · 0.6 · 0.7 in one attempt, and five attempts, each of which continues with what is left to do.
#[test]
fn the_probabilistic_world_has_its_documented_probability() {
    let Some(folder) = checkout() else { return };
    let happened = |main: &str, runs: u64| {
        let main = folder.join("examples/tutorial_fetch_and_carry").join(main);
        let scenario = load(main.to_str().expect("UTF-8"), &["stop.when_settled=true"]).expect("a sound model");
        (0..runs).filter(|seed| holds(&run(&scenario, *seed), "snack_at_table")).count()
    };
    // The 99 % interval for 20,000 runs has a half-width of 0.0083.
    let runs = 20_000;
    let rate = happened("main_probabilistic.xml", runs) as f64 / runs as f64;
    eprintln!("{rate} of {runs}");
    assert!((rate - 0.294).abs() < 2.576 * (0.294 * 0.706 / runs as f64).sqrt(), "{rate}");
    let runs = 4000;
    let rate = happened("main_probabilistic_extended_bt.xml", runs) as f64 / runs as f64;
    eprintln!("{rate} of {runs} with five attempts");
    assert!((rate - 0.954).abs() < 0.011, "{rate}");
}
