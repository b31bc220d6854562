//! Areas to keep out of, and areas to be slow in.

use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{refusal, steward};

/// The wet floor before the door of the hall, and the slow part of the corridor, with every zone in force.
const RESPECTED: &str = "base = \"faults/zone_ignored\"\nfaults = []\nproperties = []\n[expect]\n";

/// The report of a run of a scenario with this text.
fn run(folder: &Path, text: &str, arguments: &[&str]) -> Value {
    let (file, out) = (folder.join("own.toml"), folder.join("out"));
    std::fs::write(&file, text).unwrap();
    let common = ["run", file.to_str().unwrap(), "--no-snapshots", "--quiet", "--out", out.to_str().unwrap()];
    let output = steward(&[&common, arguments].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap()
}

fn verdict<'r>(report: &'r Value, property: &str) -> &'r str {
    let mut monitors = report["monitors"].as_array().unwrap().iter();
    monitors.find(|monitor| monitor["name"] == property).unwrap()["verdict"].as_str().unwrap()
}

fn has_reached(report: &Value, name: &str) -> bool {
    let places = report["places"].as_array().unwrap();
    places.iter().any(|place| place["name"] == name && place["reached_at_s"].is_number())
}

/// Runs with these seeds respect both zones on the way to the kitchen, with noise on all sensors.
fn respect_zones(seeds: std::ops::RangeInclusive<u64>) {
    let folder = tempdir().unwrap();
    let noisy = format!(
        "{RESPECTED}[[faults]]\nkind = \"laser_noise\"\nat_s = 0\nsigma_m = 0.05\n\
         [[faults]]\nkind = \"wheel_slip\"\nat_s = 0\nshare = 0.1\n"
    )
    .replace("faults = []\n", "");
    for seed in seeds {
        let report = run(folder.path(), &noisy, &["--seed", &seed.to_string()]);
        for property in ["respects_WetFloor", "respects_Narrow"] {
            assert_eq!(verdict(&report, property), "satisfied", "{property}, seed {seed}");
        }
        assert!(has_reached(&report, "Destination"), "seed {seed}: {}", report["places"]);
    }
}

#[test]
fn zones_are_respected() {
    respect_zones(1..=3);
}

#[test]
#[ignore = "100 runs"]
fn zones_are_respected_over_a_hundred_seeds_on_demand() {
    respect_zones(1..=100);
}

#[test]
fn a_robot_inside_an_area_to_keep_out_of_finds_its_way_out() {
    let folder = tempdir().unwrap();
    let moved = RESPECTED.replace("faults = []", "faults = [{ kind = \"kidnap\", at_s = 3, to = [2.5, 4.9, -90] }]");
    let report = run(folder.path(), &moved, &[]);
    assert_eq!(verdict(&report, "respects_WetFloor"), "violated");
    assert!(has_reached(&report, "Destination"), "{}", report["places"]);
}

#[test]
fn what_a_zone_makes_impossible_is_refused() {
    let folder = tempdir().unwrap();
    let check = |places: &str, scenario: &str| {
        let text =
            std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/house.places.toml")).unwrap();
        std::fs::write(folder.path().join("own.places.toml"), text + places).unwrap();
        let file = folder.path().join("own.toml");
        let base = "base = \"errand\"\nplaces = \"own.places.toml\"\n";
        std::fs::write(&file, format!("{base}{scenario}")).unwrap();
        refusal(&["check", file.to_str().unwrap()])
    };
    let zone = |corners: &str| format!("\n[Zone]\ncorners_m = {corners}\nkeep_out = true\n");
    let station = zone("[[-8, 8.5], [-7, 8.5], [-7, 9.5], [-8, 9.5]]");
    assert!(check(&station, "").contains("the robot would be in `Zone`"));
    let start = zone("[[-1, -1], [1, -1], [1, 1], [-1, 1]]");
    assert!(check(&start, "").contains("at the start (0.00, 0.00), the robot would be in `Zone`"));
    let corridor = zone("[[-2, 5], [-1, 5], [-1, 9], [-2, 9]]");
    assert!(check(&corridor, "").contains("no path around the areas to keep out of"));
    let small = zone("[[5, 5], [5.2, 5], [5.2, 5.2]]");
    let ignored = "faults = [{ kind = \"zone_ignored\", at_s = 0, zone = \"Zome\" }]\n";
    assert!(check(&small, ignored).contains("did you mean `Zone`?"));
    assert!(check(&small, "monitors = [{ zone = \"Zome\" }]\n").contains("did you mean `Zone`?"));
    assert!(check("", "faults = [{ kind = \"zone_ignored\", at_s = 0 }]\n").contains("there are no zones"));
    assert!(check("", "monitors = [{ zone = \"Destination\" }]\n").contains("zone"));
}

/// A loaded robot that drives at the limit is faster by the last bit of a number when its load falls off.
#[test]
fn rounding_is_no_violation() {
    let folder = tempdir().unwrap();
    let report = run(folder.path(), RESPECTED, &["--set", "execution.max_time_s=2"]);
    let mut monitors = report["monitors"].as_array().unwrap().iter();
    let narrow = monitors.find(|monitor| monitor["name"] == "respects_Narrow").unwrap();
    assert!(narrow["property"].as_str().unwrap().contains("speed_mps <= 0.201"), "{narrow}");
}
