//! Scenarios without a map: tree, skills and components run alone.

use std::path::{Path, PathBuf};
use std::time::Duration;

use recording::Detail;
use runs::Run;
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::{load, problems, report};

/// A scenario based on `pick` with these additional lines: `own.toml` in the folder.
fn own(folder: &Path, lines: &str) -> PathBuf {
    let path = folder.join("own.toml");
    std::fs::write(&path, format!("base = \"pick\"\n{lines}\n")).unwrap();
    path
}

/// The problems of such a scenario.
fn refusal(folder: &Path, lines: &str) -> String {
    problems(own(folder, lines), &[]).join("\n")
}

#[test]
fn the_tree_tries_again_until_the_skill_succeeds() {
    let run = |set: &[&str]| report("pick", set);
    let verdicts = |report: &Value| [0, 1].map(|monitor| report["monitors"][monitor]["verdict"].clone());
    let held = run(&[]);
    assert_eq!((&held["outcome"], &held["ended"]), (&json!("as_expected"), &json!("settled")));
    assert_eq!(verdicts(&held), ["satisfied", "satisfied"]);
    let slipped = run(&["leaves.PickUp.data.slips=3"]);
    assert_eq!(
        verdicts(&slipped),
        ["satisfied", "violated"],
        "help is called after three tries, and the fourth succeeds"
    );
    assert!(slipped["sim_time_s"].as_f64() > held["sim_time_s"].as_f64());
}

#[test]
fn a_missing_map_is_reported_wherever_something_needs_it() {
    let folder = tempdir().unwrap();
    let needs = [
        ("places = \"maps/house.places.toml\"", "`places`"),
        ("sites = { start = \"start\" }", "`sites`"),
        ("battery.initial_pct = 50", "`battery`"),
        ("noise.laser_sigma_m = 0.1", "`noise`"),
        ("people = [{ at = [1, 1] }]", "`people`"),
        ("doors = [{ at = [1, 1, 0] }]", "`doors`"),
        ("boxes = [{ at = [1, 1, 0] }]", "`boxes`"),
        ("stop.at = \"Kitchen\"", "`stop.at`"),
        ("expect.reached = [\"Kitchen\"]", "`expect.reached`"),
        ("expect.not_reached = [\"Kitchen\"]", "`expect.not_reached`"),
        ("expect.max_collisions = 0", "`expect.max_collisions`"),
        ("expect.min_battery_pct = 10", "`expect.min_battery_pct`"),
        ("expect.max_localization_m = 1", "`expect.max_localization_m`"),
        ("snapshots.at = [\"arrival\"]", "a picture of an arrival"),
        ("faults = [{ kind = \"battery_level\", at_s = 1, level_pct = 10 }]", "a fault `battery_level`"),
        ("faults = [{ kind = \"kidnap\", at_s = 1, to = [0, 0, 0] }]", "a fault `kidnap`"),
        ("faults = [{ kind = \"wrong_map\", at_s = 0, map = \"maps/house.yaml\" }]", "a fault `wrong_map`"),
        ("faults = [{ kind = \"tick_late\", near = \"Kitchen\", delay_s = 0.1 }]", "the trigger `near`"),
    ];
    for (lines, what) in needs {
        let said = refusal(folder.path(), lines);
        assert!(said.contains(&format!("{what} needs a map, and this scenario has none")), "{lines}: {said}");
        assert_eq!(said.matches("needs a map, and").count(), 1, "{lines}: {said}");
        assert!(said.contains("own.toml:"), "{lines}: {said}");
    }
    let all: String = needs[..8].iter().map(|(lines, _)| format!("{lines}\n")).collect();
    let said = refusal(folder.path(), &all);
    assert_eq!(said.matches("needs a map, and").count(), 8, "all of them at once: {said}");
    let said = refusal(folder.path(), "mapp = \"maps/house.yaml\"\n[battery]");
    assert!(said.contains("did you mean `map`?") && !said.contains("needs a map, and"), "{said}");
}

#[test]
fn the_robots_components_exist_only_with_a_map() {
    let folder = tempdir().unwrap();
    let lines = "tree = \"trees/recharge.xml\"\nskills = \"skills\"\nproperties = []\nleaves = {}";
    let said = refusal(folder.path(), lines);
    for component in ["BatteryReader", "Localization", "Navigation"] {
        assert!(said.contains(&format!("there is no process {component}")), "{said}");
    }
    let lines = "faults = [{ kind = \"component_frozen\", component = \"Navigation\", at_s = 1 }]";
    let said = refusal(folder.path(), lines);
    assert!(said.contains("Navigation"), "{said}");
}

#[test]
fn a_map_alone_gives_a_robot_without_places() {
    let folder = tempdir().unwrap();
    let path = own(folder.path(), "map = \"maps/house.yaml\"\nsites.start = [0, 0, 90]");
    let report = report(&path, &[]);
    assert_eq!((&report["outcome"], &report["places"]), (&json!("as_expected"), &json!([])));
    assert_eq!(report["robot"]["distance_m"], json!(0.0));
    let said = refusal(folder.path(), "map = \"maps/house.yaml\"");
    assert!(said.contains("`sites` is missing"), "{said}");
}

#[test]
fn a_state_that_only_a_timer_changes_is_recorded_when_it_changes() {
    let folder = tempdir().unwrap();
    let machine = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Rest">
      <state id="idle">
        <transition event="BT.tick" target="resting"><send type="channel" target="BT" event="running"/></transition>
        <transition event="BT.halt"><send type="channel" target="BT" event="halted"/></transition>
      </state>
      <state id="resting">
        <onentry><send event="over" delay="300ms"/></onentry>
        <transition event="over" target="idle"/>
      </state>
    </scxml>"#;
    let tree = r#"<root BTCPP_format="4"><BehaviorTree ID="Main"><Rest/></BehaviorTree>
      <TreeNodesModel><Action ID="Rest"/></TreeNodesModel></root>"#;
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    file("Rest.scxml", machine);
    file("tree.xml", tree);
    let scenario = file("rest.toml", "tree = \"tree.xml\"\nskills = \".\"\n");
    let scenario = load(&scenario, &[]).unwrap();
    let mut run = Run::new(scenario, 1, true).unwrap();
    let mut changes = Vec::new();
    while run.time() < Duration::from_millis(1600) {
        run.step().unwrap();
        let step = run.record(Detail::Full);
        let locations = step.details.into_iter().flat_map(|details| details.locations);
        changes.extend(locations.map(|(_, location)| (step.time.as_millis(), location)));
    }
    let changes: Vec<(u128, &str)> = changes.iter().map(|(time, location)| (*time, location.as_str())).collect();
    assert_eq!(changes, [(20, "resting"), (320, "idle"), (1020, "resting"), (1320, "idle")]);
}
