//! Navigation among people, doors and boxes, and a trip that is given up.

use recording::Detail;
use reports::{Outputs, html};
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::{report, report_of, start};

/// The report of a run and its page.
fn report_and_page(scenario: &str, set: &[&str]) -> (Value, String) {
    let out = tempdir().unwrap();
    let outputs = Outputs { folder: Some(out.path().to_owned()), ..Outputs::default() };
    let report = json!(report_of(start(scenario, set), Detail::Full, &outputs, None).unwrap());
    (report, std::fs::read_to_string(out.path().join(html::FILE)).unwrap())
}

#[test]
fn the_errand_succeeds_among_people_doors_and_boxes() {
    let (report, page) = report_and_page("populated", &[]);
    assert_eq!(report["outcome"], "as_expected", "{}", report["differences"]);
    for part in ["Ann", "Cleo", "kitchen door", "parcel", "stands still"] {
        assert!(page.contains(part), "{part} is not on the page");
    }
}

#[test]
fn navigation_gives_up_at_a_closed_door_with_a_reason_and_the_tree_retries() {
    let (report, page) = report_and_page("faults/door_closes", &["execution.max_time_s=450"]);
    let given_up = report["robot"]["given_up"].as_array().unwrap();
    assert!(given_up.len() >= 2, "{given_up:?}");
    assert!(given_up.iter().all(|trip| trip["reason"] == "there is no path to the goal"), "{given_up:?}");
    assert_eq!(report["robot"]["collisions"], 0);
    assert!(page.contains("there is no path to the goal"));
}

#[test]
fn a_kidnapped_robot_relocalizes_and_finishes_its_errand() {
    for (at_s, to) in [(15, "[1.5, 6.3, 180]"), (70, "[0.0, 0.0, 45]")] {
        let fault = format!("faults=[{{ kind = \"kidnap\", at_s = {at_s}, to = {to} }}]");
        let report = report("errand", &[&fault]);
        assert_eq!(report["outcome"], "as_expected", "{}", report["differences"]);
        let lost_m = report["robot"]["localization"]["max_m"].as_f64().unwrap();
        assert!(lost_m > 1.0, "carried away at {at_s} s, it was off by {lost_m} m only");
        let reached = report["places"].as_array().unwrap().iter().find(|place| place["name"] == "Destination").unwrap();
        assert!(reached["reached_at_s"].as_f64() > Some(f64::from(at_s) + 10.0), "{reached}");
    }
}

#[test]
fn a_robot_that_drives_through_a_place_has_been_there_without_coming_to_rest() {
    let folder = tempdir().unwrap();
    let places = include_str!("../../../maps/house.places.toml").to_owned();
    let band = "\n[OnTheWay]\ncorners_m = [[-14, 3.0], [14, 3.0], [14, 3.2], [-14, 3.2]]\n";
    std::fs::write(folder.path().join("places.toml"), places + band).unwrap();
    let scenario = folder.path().join("through.toml");
    let text = "base = \"errand\"\nplaces = \"places.toml\"\nexpect.not_reached = [\"OnTheWay\"]\n";
    std::fs::write(&scenario, text).unwrap();
    let report = report(&scenario, &[]);
    assert_eq!(report["outcome"], "not_as_expected");
    let said = report["differences"][0].as_str().unwrap();
    assert!(said.starts_with("the robot was expected never to be at OnTheWay and was there at "), "{said}");
    let place = report["places"].as_array().unwrap().iter().find(|place| place["name"] == "OnTheWay").unwrap();
    assert!(place["reached_at_s"].is_null() && place["entered_at_s"].as_f64() > Some(1.0), "{place}");
}
