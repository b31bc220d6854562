//! Faults that are active at the same time, and repeated faults.

use recording::Detail;
use reports::Outputs;
use scenarios::Error;
use serde_json::Value;

use crate::faults::{messages, recorded};
use crate::{problems, report_of, start};

/// The errand with these faults: its report, and every message with its tick.
fn run(faults: &str, set: &[&str]) -> (Value, Vec<(u64, Value)>) {
    let faults = format!("faults=[{faults}]");
    let (report, log) = recorded("errand", &[&[faults.as_str(), "expect={}"], set].concat());
    let tick = |(_, line): (f64, String)| {
        let message: Value = serde_json::from_str(&line).unwrap();
        Some((message["tick"].as_u64()?, message))
    };
    (report, log.into_iter().filter_map(tick).collect())
}

/// The ticks in which one process sent something to another.
fn ticks_of(log: &[(u64, Value)], from: &str) -> Vec<u64> {
    log.iter().filter(|(_, message)| message["from"] == from).map(|(tick, _)| *tick).collect()
}

#[test]
fn a_component_is_suspended_while_any_of_its_faults_is_active() {
    let frozen = r#"{ kind = "component_frozen", at_s = 5, component = "BatteryReader", lasts_s = 10 }"#;
    let crash = |at_s, lasts_s| {
        format!("{{ kind = \"component_crash\", at_s = {at_s}, component = \"BatteryReader\", lasts_s = {lasts_s} }}")
    };
    // The second fault lies within the first, or outlasts it: the reader is silent from 5 s to 15 s, or to 20 s.
    for (other, until) in [(crash(8, 3), 15), (crash(8, 12), 20), (frozen.replace("10 }", "4 }"), 15)] {
        let (_, log) = run(&format!("{frozen}, {other}"), &["execution.max_time_s=30"]);
        let said = ticks_of(&log, "BatteryReader");
        assert!(said.iter().any(|tick| *tick < 5), "{said:?}");
        assert!(!said.iter().any(|tick| (5..until).contains(tick)), "{other}: {said:?}");
        assert!(said.contains(&until), "{other}: {said:?}");
    }
}

/// BatteryLevel's answers to the tree in each tick, for a battery that stays at 25 %, where the skill accepts 30 %.
fn verdicts(faults: &str) -> Vec<(u64, bool)> {
    let battery =
        [("initial_pct", 25), ("charge_pct_per_s", 0), ("drain_pct_per_s", 0), ("standstill_drain_pct_per_s", 0)];
    let battery = battery.map(|(key, value)| format!("battery.{key}={value}"));
    let mut set: Vec<&str> = battery.iter().map(String::as_str).collect();
    set.push("execution.max_time_s=20");
    let (_, log) = run(faults, &set);
    let answers = log.iter().filter(|(_, message)| message["from"] == "BatteryLevel" && message["to"] == "BT");
    answers.map(|(tick, message)| (*tick, message["message"][0]["sym"] == "success")).collect()
}

#[test]
fn a_skill_makes_the_mistakes_of_all_active_faults() {
    let threshold = r#"{ kind = "skill_threshold", at_s = 4, skill = "BatteryLevel", value = "20", lasts_s = 12 }"#;
    let negated = r#"{ kind = "skill_guard_negated", at_s = 8, skill = "BatteryLevel", state = "get", event = "BatteryReader.ok", lasts_s = 4 }"#;
    for faults in [format!("{threshold}, {negated}"), format!("{negated}, {threshold}")] {
        let verdicts = verdicts(&faults);
        assert!(verdicts.len() >= 19, "{verdicts:?}");
        for (tick, content) in verdicts {
            // With the threshold at 20 %, the skill succeeds, except while its guard is negated as well.
            let expected = (4..8).contains(&tick) || (12..16).contains(&tick);
            assert_eq!(content, expected, "tick {tick}, with {faults}");
        }
    }
}

#[test]
fn a_mistake_applies_to_the_machine_that_the_skill_runs() {
    let faults = r#"
        { kind = "skill_threshold", at_s = 4, skill = "BatteryLevel", value = "20", lasts_s = 8 },
        { kind = "skill_replaced", at_s = 8, skill = "BatteryLevel", machine = "skills/BatteryLevel.scxml", lasts_s = 8 },
    "#;
    for (tick, content) in verdicts(faults) {
        assert_eq!(content, (4..12).contains(&tick), "tick {tick}");
    }
}

#[test]
fn contradictory_mistakes_are_refused_if_they_may_overlap() {
    let threshold = |value, timing| {
        format!("{{ kind = \"skill_threshold\", skill = \"BatteryLevel\", value = \"{value}\", {timing} }}")
    };
    let faults = |first, second| format!("faults=[{}, {}]", threshold(20, first), threshold(40, second));
    for (first, second) in [
        ("at_s = 0", "at_s = 5"),
        ("at_s = 0, lasts_s = 5.01", "at_s = 5"),
        ("at_s = 0, lasts_s = 1", "at_tick = 100"),
        ("at_s = 0, lasts_s = 1, every_s = 10", "at_s = 5"),
    ] {
        let said = problems("errand", &[&faults(first, second)]).concat();
        for part in ["cannot be active together", "has threshold = 20", "they change the same place differently"] {
            assert!(said.contains(part), "{part} is missing in\n{said}");
        }
    }
    let apart = faults("at_s = 0, lasts_s = 5", "at_s = 5");
    let (_, log) = recorded("errand", &[&apart, "expect={}", "execution.max_time_s=10"]);
    assert!(!log.is_empty());
}

#[test]
fn a_share_is_drawn_again_each_time_a_fault_takes_effect() {
    let lost = r#"{ kind = "message_lost", at_s = 0, every_s = 1, lasts_s = 0.5, times = 1000,
                    from = "BatteryReader", to = "BatteryLevel", share = 0.5 }"#;
    let (report, _) = run(lost, &["execution.max_time_s=60"]);
    let faults = report["faults"].as_array().unwrap();
    // One message each time: if the draws were the same, all of them would be lost, or none.
    assert!(faults.len() > 50, "{}", faults.len());
    let lost = faults[0]["messages"].as_u64().unwrap() as usize;
    assert!((faults.len() / 4..faults.len() * 3 / 4).contains(&lost), "{lost} of {}", faults.len());
}

#[test]
fn a_repeated_fault_counts_all_messages_that_it_hit() {
    let lost = |more| {
        format!("{{ kind = \"message_lost\", at_s = 0, from = \"BatteryReader\", to = \"BatteryLevel\", {more} }}")
    };
    let hit = |faults: &str| {
        let (report, log) = run(faults, &["execution.max_time_s=20"]);
        assert_eq!(ticks_of(&log, "BatteryReader").len(), 0);
        report["faults"][0]["messages"].clone()
    };
    assert_eq!(hit(&lost("every_s = 0.1, lasts_s = 0.1")), hit(&lost("times = 1")));
}

#[test]
fn a_robot_is_carried_only_to_where_it_fits() {
    let said = problems("errand", &["faults=[{ kind = \"kidnap\", at_s = 3, to = [900, 0, 0] }]"]).concat();
    for part in ["the pose to which the robot is moved", "[900, 0, 0]", "no room for the robot"] {
        assert!(said.contains(part), "{part} is missing in\n{said}");
    }
    let box_there = r#"{ kind = "obstacle_appears", at_s = 10, at = [-0.25, 0.15, 0] }"#;
    let kidnap = |at_s| format!("{{ kind = \"kidnap\", at_s = {at_s}, to = [-0.25, 0.15, 10] }}");
    let faults = format!("{}, {box_there}, {}", kidnap(9), kidnap(15));
    let (report, _) = run(&faults, &["execution.max_time_s=20"]);
    let kinds: Vec<&str> =
        report["faults"].as_array().unwrap().iter().map(|fault| fault["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["kidnap", "obstacle_appears"], "what took effect");
    let undone = report["undone_faults"].as_array().unwrap();
    assert_eq!(undone.len(), 1);
    assert_eq!((&undone[0]["kind"], undone[0]["time_s"].as_f64()), (&"kidnap".into(), Some(15.0)));
    assert!(undone[0]["reason"].as_str().unwrap().contains("box at (-0.25, 0.15) m"), "{}", undone[0]);
}

#[test]
fn a_fault_reports_the_last_tick_before_it_even_if_ticks_were_missed() {
    let faults = r#"
        { kind = "joypad", at_s = 0, linear_mps = 0, lasts_s = 1 },
        { kind = "tick_missed", at_s = 2.5, lasts_s = 3 },
        { kind = "battery_level", at_s = 10, level_pct = 50 },
    "#;
    let (report, _) = run(faults, &["execution.max_time_s=12"]);
    let ticks: Vec<&Value> = report["faults"].as_array().unwrap().iter().map(|fault| &fault["tick"]).collect();
    // Ticks at 0, 1, 2, 6, 7, 8 and 9 s.
    assert_eq!(ticks, [&Value::Null, &2.into(), &6.into()]);
}

#[test]
fn the_log_of_a_livelocked_run_contains_its_last_message() {
    let out = tempfile::tempdir().unwrap();
    let log = out.path().join("log.jsonl");
    let run = start("errand", &["execution.step_budget=12"]);
    let said = report_of(run, Detail::Full, &Outputs::default(), Some(&log)).unwrap_err();
    assert!(
        matches!(said.downcast_ref::<Error>(), Some(Error::Run(_))) && said.to_string().contains("12 transitions"),
        "{said}"
    );
    let messages = messages(&log);
    assert!(messages[0].1.contains("\"generated\":\"tick\""), "{messages:?}");
    assert!(messages.iter().any(|(_, line)| line.contains("\"from\"")), "{messages:?}");
}
