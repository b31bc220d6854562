//! `steward navigate`: the benchmark of navigation.

use maps::{CellIndex, ImageFormat, OccupancyGrid, pose};
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::steward::{refusal, steward};

/// The benchmark's output for a few trips through the house.
fn benchmark(arguments: &[&str]) -> (Option<i32>, Value) {
    let out = tempdir().unwrap();
    let mut all = vec!["navigate", "--json", "--pictures", "none", "--out", out.path().to_str().unwrap()];
    all.extend(arguments);
    let output = steward(&all);
    let written = std::fs::read(out.path().join("navigate.json")).unwrap();
    assert_eq!(written, output.stdout);
    (output.status.code(), serde_json::from_slice(&output.stdout).unwrap())
}

#[test]
fn the_benchmark_has_no_contacts_in_the_house() {
    let (status, benchmark) = benchmark(&["--goals", "6", "--at-least", "99"]);
    let house = &benchmark["maps"][0];
    assert_eq!((status, &house["arrived_pct"]), (Some(0), &Value::from(100.0)), "{}", benchmark["trips"]);
    assert_eq!((&house["wall_contacts"], &house["trips"]), (&Value::from(0), &Value::from(6)));
    let ratio = house["way_ratio"].as_f64().unwrap();
    assert!(ratio > 0.9 && ratio < 1.3, "{ratio}");
}

#[test]
fn a_map_with_a_rotated_origin_gives_the_same_trips() {
    let folder = tempdir().unwrap();
    let house = maps::house::map();
    let turn = pose(4.0, -7.0, 0.7);
    let mut turned = OccupancyGrid::new(house.width(), house.height(), house.resolution_m(), turn * house.origin());
    for (offset, cell) in house.cells().iter().enumerate() {
        turned.set(CellIndex { column: offset % house.width(), row: offset / house.width() }, *cell);
    }
    let map = folder.path().join("turned.yaml");
    maps::save_map(&turned, &map, ImageFormat::Pgm).unwrap();
    let run = |map: &[&str]| benchmark(&[&["--goals", "4", "--people", "2", "--at-least", "100"], map].concat());
    let (status, turned) = run(&["--map", map.to_str().unwrap()]);
    assert_eq!(status, Some(0), "{}", turned["trips"]);
    let ratio = |benchmark: &Value| benchmark["maps"][0]["way_ratio"].as_f64().unwrap();
    let upright = run(&[]).1;
    assert!((ratio(&turned) - ratio(&upright)).abs() < 0.1, "{turned} against {upright}");
}

#[test]
fn a_trip_of_the_benchmark_can_be_repeated_alone() {
    let among = ["--people", "5", "--boxes", "2"];
    let (_, three) = benchmark(&[&among[..], &["--goals", "3", "--seed", "7"]].concat());
    let alone = ["7", "8", "9"].map(|seed| benchmark(&[&among[..], &["--goals", "1", "--seed", seed]].concat()).1);
    let trips: Vec<Value> = alone.iter().map(|benchmark| benchmark["trips"][0].clone()).collect();
    for (trip, seed) in trips.iter().zip(7..) {
        assert!(trip["seed"] == seed && trip["time_s"].as_f64() > Some(3.0), "{trip}");
        assert!(trip["driven_m"].as_f64() > Some(1.0) && trip["end"] != trip["start"], "{trip}");
    }
    assert_ne!(trips[0]["start"], trips[1]["start"]);
    assert_eq!(three["trips"], Value::from(trips));
}

#[test]
fn people_and_boxes_that_could_be_placed_are_counted() {
    let (_, with) = benchmark(&["--goals", "2", "--people", "3", "--boxes", "2"]);
    assert_eq!(with["wanted"], json!({ "people": 3, "boxes": 2 }));
    let found = |key: &str| {
        with["trips"].as_array().unwrap().iter().map(|trip| trip["about"][key].as_f64().unwrap()).sum::<f64>() / 2.0
    };
    assert_eq!(
        (with["mean_people"].as_f64(), with["mean_boxes"].as_f64()),
        (Some(found("people")), Some(found("boxes")))
    );
    assert!(found("boxes") > 0.0);
}

#[test]
fn maps_with_the_same_name_are_distinguished() {
    let folder = tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).join("map.yaml");
    for (name, shift_m) in [("here", 0.0), ("there", 3.0)] {
        let house = maps::house::map();
        let origin = pose(shift_m, 0.0, 0.0) * house.origin();
        let mut moved = OccupancyGrid::new(house.width(), house.height(), house.resolution_m(), origin);
        for (offset, cell) in house.cells().iter().enumerate() {
            moved.set(CellIndex { column: offset % house.width(), row: offset / house.width() }, *cell);
        }
        std::fs::create_dir(folder.path().join(name)).unwrap();
        maps::save_map(&moved, &file(name), ImageFormat::Pgm).unwrap();
    }
    let out = folder.path().join("out");
    let (here, there) = (file("here"), file("there"));
    let (here, there) = (here.to_str().unwrap(), there.to_str().unwrap());
    let run = ["navigate", "--json", "--goals", "1", "--pictures", "all", "--out", out.to_str().unwrap(), "--map"];
    let output = steward(&[&run[..], &[here, there]].concat());
    let benchmark: Value = serde_json::from_slice(&output.stdout).unwrap();
    let named =
        |number: usize| (benchmark["trips"][number]["map"].clone(), benchmark["trips"][number]["map_file"].clone());
    assert_eq!(named(0), ("map".into(), here.into()));
    assert_eq!(named(1), ("map_2".into(), there.into()));
    assert_eq!(benchmark["maps"][1]["map"], "map_2");
    assert!(out.join("map_1.png").exists() && out.join("map_2_1.png").exists());
    assert_ne!(benchmark["trips"][0]["start"], benchmark["trips"][1]["start"]);
}

#[test]
fn a_missing_or_cramped_map_is_refused() {
    let said = refusal(&["navigate", "--map", "nowhere.yaml"]);
    assert!(said.contains("nowhere.yaml"), "{said}");
}

#[test]
fn too_few_seeds_and_impossible_shares_are_refused() {
    let said = refusal(&["navigate", "--seed", "18446744073709551615", "--goals", "2"]);
    assert!(said.contains("there are no 2 seeds beginning with 18446744073709551615"), "{said}");
    for share in ["101", "NaN", "all"] {
        let said = refusal(&["navigate", "--at-least", share]);
        assert!(said.contains("--at-least") && said.contains(share), "{said}");
    }
    let said = refusal(&["navigate", "--people", "100000"]);
    assert!(said.contains("--people"), "{said}");
    let (status, last) = benchmark(&["--seed", "18446744073709551615", "--goals", "1", "--at-least", "100"]);
    assert_eq!((status, &last["trips"][0]["seed"]), (Some(0), &Value::from(u64::MAX)));
}

#[test]
fn the_summary_names_the_place_where_the_robot_has_stayed() {
    let out = tempdir().unwrap();
    let settings = ["sites.start=RechargingStation", "stop.at=RechargingStation", "expect.reached=[]"];
    let settings = settings.iter().flat_map(|setting| ["--set", setting]);
    let folder = out.path().to_str().unwrap();
    let run = ["run", "errand", "--no-snapshots", "--out", folder].into_iter().chain(settings);
    let text = String::from_utf8(steward(&run.collect::<Vec<_>>()).stdout).unwrap();
    assert!(text.contains("only RechargingStation, where it started"), "{text}");
    assert!(text.contains("the robot came to rest at RechargingStation"), "{text}");
}
