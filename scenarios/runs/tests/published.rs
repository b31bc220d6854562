//! The paper's experiment 1 from files as its authors published them: their tree, places and monitors.

use std::path::Path;

use tempfile::tempdir;

use crate::ready_made_monitors::MACHINES;
use crate::{problems, reached, report, verdicts};

/// A scenario for the files in `tests/published`, which have the form of the authors' files.
const SCENARIO: &str = r#"
folder = "."
map = "maps/house.yaml"
places = "places.ini"
tree = "tree.xml"
skills = "skills"

[leaves]
AtDock = { machine = "AtRechargingStation.scxml", data = { place = "dock" } }
GoToDock = { machine = "GotoRechargingStation.scxml", data = { place = "dock" } }
Wait = { machine = "WaitForUser.scxml" }
AtKitchen = { machine = "AtDestination.scxml", data = { place = "kitchen" } }
GoToKitchen = { machine = "GoToDestination.scxml", data = { place = "kitchen" } }

[sites]
start = [0.0, 0.0, 0.0]
station = "dock"
destination = "kitchen"

[battery]
initial_pct = 80

[[faults]]
kind = "battery_level"
at_s = 20.5
level_pct = 10

[stop]
at = "dock"
"#;

#[test]
fn files_in_the_authors_format_run_experiment_1() {
    let folder = tempdir().unwrap();
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/published");
    let scenario = folder.path().join("ours.toml");
    // Machines without a name in the scenario keep their own names.
    let machines = MACHINES.replace("name = \"charge\"\n", "").replace("name = \"trip\"\n", "");
    let machines = machines.replace("GoToDestination", "GoToKitchen").replace("GotoRechargingStation", "GoToDock");
    std::fs::write(&scenario, format!("{SCENARIO}{machines}")).unwrap();
    let folder_of_files = format!("folder={:?}", published.display().to_string());
    let report = report(&scenario, &[&folder_of_files]);
    assert_eq!(
        verdicts(&report),
        [("ChargeWatchStateMachine", "violated"), ("TripWatchStateMachine", "satisfied")],
        "{report}"
    );
    assert_eq!(report["monitors"][0]["tick"], 21);
    assert!(reached(&report, "dock").is_some() && reached(&report, "kitchen").is_none());

    let elsewhere = problems(&scenario, &[]).concat();
    assert!(elsewhere.contains("there is no tree.xml in this folder") && elsewhere.contains("--set folder=DIR"));
}

#[test]
fn the_authors_own_files_run_experiment_1() {
    let Some(checkout) = std::env::var_os("STEWARD_PUBLISHED") else {
        println!("not run here: STEWARD_PUBLISHED names no checkout of SCOPE-ROBMOSYS/IROS2021-experiments");
        return;
    };
    let folder = format!("folder={:?}", Path::new(&checkout).display().to_string());
    let report = report("published", &[&folder]);
    assert_eq!(report["outcome"], "as_expected", "{}", report["differences"]);
    assert_eq!(report["monitors"][3]["name"], "BatteryLevelMonitor");
    assert_eq!(report["monitors"][3]["tick"], report["monitors"][0]["tick"], "as soon as phi1");
    println!("ran: {:?}", verdicts(&report));
}

#[test]
fn the_scenario_of_the_authors_files_reports_missing_files() {
    let said = problems("published", &[]).concat();
    assert!(said.contains("there is no src/BT/test_battery_BT.xml in this folder"), "{said}");
}
