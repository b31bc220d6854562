//! Areas to keep out of, and areas to be slow in.

use serde_json::Value;
use tempfile::tempdir;

use crate::{monitor, problems, reached, report};

/// The report of a run with these settings: with a wet floor before the door of the hall, and a corridor to be slow in.
fn run(set: &[&str]) -> Value {
    report("faults/zone_ignored", &[&["properties=[]", "expect={}"], set].concat())
}

/// Runs with these seeds respect both zones on the way to the kitchen, with noise on all sensors.
fn respect_zones(seeds: std::ops::RangeInclusive<u64>) {
    let noisy = "faults=[{ kind = \"laser_noise\", at_s = 0, sigma_m = 0.05 }, \
                 { kind = \"wheel_slip\", at_s = 0, share = 0.1 }]";
    for seed in seeds {
        let report = run(&[noisy, &format!("seed={seed}")]);
        for property in ["respects_WetFloor", "respects_Narrow"] {
            assert_eq!(monitor(&report, property)["verdict"], "satisfied", "{property}, seed {seed}");
        }
        assert!(reached(&report, "Destination").is_some(), "seed {seed}: {}", report["places"]);
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
    let report = run(&["faults=[{ kind = \"kidnap\", at_s = 3, to = [2.5, 4.9, -90] }]"]);
    assert_eq!(monitor(&report, "respects_WetFloor")["verdict"], "violated");
    assert!(reached(&report, "Destination").is_some(), "{}", report["places"]);
}

#[test]
fn what_a_zone_makes_impossible_is_refused() {
    let folder = tempdir().unwrap();
    let check = |places: &str, scenario: &str| {
        let text = include_str!("../../../maps/house.places.toml");
        std::fs::write(folder.path().join("own.places.toml"), text.to_owned() + places).unwrap();
        let file = folder.path().join("own.toml");
        let base = "base = \"errand\"\nplaces = \"own.places.toml\"\n";
        std::fs::write(&file, format!("{base}{scenario}")).unwrap();
        problems(&file, &[]).concat()
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
    let report = run(&["faults=[]", "execution.max_time_s=2"]);
    let narrow = monitor(&report, "respects_Narrow");
    assert!(narrow["property"].as_str().unwrap().contains("speed_mps <= 0.201"), "{narrow}");
}
