//! A schedule that was written can be read again.

use super::*;

const EVERY_KIND: &str = r#"about = "a run"
steps = [
  { environment = "the level is 31 %", level_pct = 31.5, charging = false, place = "start", trip = "running" },
  { environment = "" },
  { wait_s = 0.02 },
  { tick = "taken" },
  { process = "BT", transition = 3 },
  { process = "BT", transition = 3, to = "BatteryLevel" },
  { process = "BT", transition = 3, to = "BatteryLevel", held_s = 2 },
  { process = "BT", transition = 3, to = "BatteryLevel", lost = true },
  { process = "BatteryLevel", transition = 0, from = "BT" },
  { process = "BT/1", transition = 3, to = "BT/2", receiving = 4 },
]
"#;

#[test]
fn a_schedule_is_read_as_it_is_written() {
    let schedule = Schedule::parse("run.toml", EVERY_KIND).expect("a sound schedule");
    let lines: Vec<String> = schedule.steps.iter().map(|step| format!("  {},\n", line(&step.value))).collect();
    assert_eq!(format!("about = \"a run\"\nsteps = [\n{}]\n", lines.concat()), EVERY_KIND);
}

#[test]
fn a_step_with_too_little_or_too_much_is_refused() {
    for (step, expected) in [
        ("{ to = 'BT' }", "`process` and `transition` are missing"),
        ("{ process = 'BT' }", "`transition` is missing"),
        ("{ tick = 'early' }", "early"),
        ("{ process = 'BT', transition = 0, lost = true }", "only a message that is sent"),
        ("{ process = 'A', transition = 0, to = 'B', lost = true, repeated = true }", "at once"),
        ("{ wait_s = 1, tick = 'taken' }", "tick"),
    ] {
        let problems = Schedule::parse("run.toml", &format!("steps = [{step}]")).expect_err(step);
        let all: Vec<String> = problems.problems().iter().map(ToString::to_string).collect();
        assert!(all.len() == 1 && all[0].contains(expected), "{step}: {all:?}");
    }
}
