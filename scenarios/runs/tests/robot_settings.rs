//! The robot of a scenario: `[robot]`. Simulation, planning, localization and reports all use it.

use runs::Run;
use serde_json::{Value, json};

use crate::{concerns, load, problems, reached, report};

/// The report of the trip from the start to the destination, with these values set.
fn drive(set: &[&str]) -> Value {
    let common = ["stop.at=Destination", "stop.after_s=0", "battery.initial_pct=100", "execution.max_time_s=400"];
    report("battery_fault", &[&common[..], set, &["properties=[]", "faults=[]", "expect={}"]].concat())
}

fn arrival_s(report: &Value) -> f64 {
    reached(report, "Destination").unwrap_or_else(|| panic!("it does not arrive: {report}"))
}

#[test]
fn repeating_the_defaults_of_the_robot_changes_nothing() {
    let limits =
        "max_linear_mps=0.45,max_angular_radps=1,max_linear_acceleration_mps2=0.5,max_angular_acceleration_radps2=2";
    let docking = "docking={distance_m=0.5,angle_deg=10,rest_s=1}";
    let lasers = "lasers=[{name=\"front\",at=[0.245,0,0]},{name=\"back\",at=[-0.245,0,180]}]";
    let said = format!("robot={{radius_m=0.3,{limits},{docking},{lasers}}}");
    let until = "execution.max_time_s=20";
    assert_eq!(drive(&[&said, until])["trace_hash"], drive(&[until])["trace_hash"]);
}

#[test]
fn a_slow_robot_takes_longer_in_proportion() {
    let [fast, slow] = ["0.45", "0.15"].map(|mps| drive(&[&format!("robot.max_linear_mps={mps}")]));
    let way_m = |report: &Value| report["robot"]["distance_m"].as_f64().unwrap();
    assert!((way_m(&fast) - way_m(&slow)).abs() < 0.5, "{} m and {} m", way_m(&fast), way_m(&slow));
    // Both slow down to 0.15 m/s in curves and turn in place at the same rate.
    let ratio = arrival_s(&slow) / arrival_s(&fast);
    assert!((2.0..3.0).contains(&ratio), "{ratio}");
    for report in [fast, slow] {
        assert_eq!(report["robot"]["collisions"], 0);
    }
}

#[test]
fn a_fast_robot_brakes_in_time() {
    let fast = drive(&["robot.max_linear_mps=1.2", "robot.max_angular_radps=2"]);
    assert_eq!(fast["robot"]["collisions"], 0);
    let usual = drive(&[]);
    assert!(arrival_s(&fast) < 0.75 * arrival_s(&usual), "{} s and {} s", arrival_s(&fast), arrival_s(&usual));
}

#[test]
fn a_wide_robot_does_not_fit_through_the_doors() {
    let wide = |radius: &str| ["execution.max_time_s=1".to_owned(), format!("robot.radius_m={radius}")];
    assert_eq!(report("errand", &wide("0.35").each_ref().map(String::as_str))["ended"], "time_limit");
    let said = problems("errand", &wide("0.7").each_ref().map(String::as_str)).concat();
    assert!(said.contains("there is no path from the start") || said.contains("the robot cannot"), "{said}");
    assert!(said.contains("house.places.toml:"), "{said}");
}

#[test]
fn one_laser_that_looks_ahead_is_enough() {
    let laser = "robot.lasers=[{name=\"nose\",at=[0.2,0,0],field_of_view_deg=180,beams=181,range_m=8,rate_hz=5}]";
    let run = drive(&[laser, "noise.laser_sigma_m=0.02", "noise.odometry.angle_per_sqrt_m=0.02"]);
    assert!(arrival_s(&run) > 0.0);
    assert_eq!(run["robot"]["collisions"], 0);
    let error_m = run["robot"]["localization"]["max_m"].as_f64().unwrap();
    assert!(error_m > 0.0 && error_m < 0.15, "{error_m} m");
    let fault = "faults=[{kind=\"laser_dead\",at_s=1,laser=\"front\"}]";
    let said = problems("errand", &[laser, fault]).concat();
    assert!(said.contains("unknown laser `front`") && said.contains("`nose`"), "{said}");
}

#[test]
fn a_robot_without_room_for_error_in_docking_causes_a_warning() {
    let scenario = load("errand", &["robot.docking={distance_m=0.1,angle_deg=2}"]).unwrap();
    let said = concerns(&scenario).concat();
    assert!(said.contains("but docks only within 0.1 m and 2°"), "{said}");
}

#[test]
fn a_record_of_a_run_says_which_robot_drove() {
    let robot = Run::new(load("errand", &["robot.radius_m=0.25"]).unwrap(), 1, false).unwrap().header().robot.unwrap();
    assert_eq!((robot.radius_m, robot.lasers.len()), (0.25, 2));
    let x_m = robot.lasers[0].mount.translation.x;
    assert!((x_m - 0.245 * 0.25 / 0.30).abs() < 1e-12, "the default lasers stay inside of the body: {x_m}");
}

#[test]
fn invalid_values_are_refused_each_with_one_message() {
    let laser = |rest: &str| format!("robot.lasers=[{{name=\"a\",{rest}}}]");
    let wrong = [
        ("robot.radius_m=0".to_owned(), "`radius_m` must lie between 0.05 and 2"),
        ("robot.max_linear_mps=-1".to_owned(), "`max_linear_mps` must lie between"),
        ("robot.max_angular_radps=0".to_owned(), "`max_angular_radps` must lie between"),
        ("robot.max_linear_acceleration_mps2=0".to_owned(), "`max_linear_acceleration_mps2` must lie between"),
        ("robot.max_angular_acceleration_radps2=99".to_owned(), "`max_angular_acceleration_radps2` must lie between"),
        ("robot.docking.distance_m=0".to_owned(), "`distance_m` must lie between"),
        ("robot.docking.angle_deg=400".to_owned(), "`angle_deg` must lie between"),
        ("robot.docking.rest_s=-1".to_owned(), "rest_s"),
        ("robot.lasers=[]".to_owned(), "`lasers` must not be empty: a robot needs a laser"),
        ("robot.lasers=[{name=\"a\"},{name=\"a\"}]".to_owned(), "there are two lasers named `a`"),
        ("robot.lasers=[{}]".to_owned(), "`name` is missing"),
        (laser("at=[0.4,0,0]"), "this laser is 0.4 m from the robot's center, outside the body"),
        (laser("beams=0"), "`beams` must lie between 2 and 5000"),
        (laser("field_of_view_deg=0"), "`field_of_view_deg` must lie between 1 and 360"),
        (laser("range_m=0"), "`range_m` must lie between"),
        (laser("min_range_m=1"), "`min_range_m` must lie between"),
        (laser("rate_hz=0"), "`rate_hz` must lie between"),
        ("robot.radius=0.2".to_owned(), "unknown key `radius`"),
        ("robot.footprint=[[0,0]]".to_owned(), "unknown key `footprint`"),
    ];
    for (set, message) in wrong {
        let said = problems("errand", &[&set]);
        assert!(said[0].contains(message), "{set}: {said:#?}");
        assert_eq!(said.len(), 1, "{set}: {said:#?}");
    }
    assert_eq!(json!(drive(&["robot.radius_m=0.3", "execution.max_time_s=1"])["outcome"]), "as_expected");
}
