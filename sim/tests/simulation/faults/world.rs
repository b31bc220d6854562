//! Doors, people, a moved station, a kidnapped robot.

use maps::{Point, Pose, Shape, pose};
use sim::{ObstacleConfig, ObstacleMotion, Placement, RouteEnd, SimConfig, SimError, Simulation};

use crate::{drive, in_a_room, scans};

fn at_the_left() -> Simulation {
    in_a_room(&SimConfig::default(), pose(2.0, 3.0, 0.0))
}

/// A door across the robot's way.
fn door(x_m: f64) -> ObstacleConfig {
    ObstacleConfig {
        name: "door".to_owned(),
        shape: Shape::Box { length_m: 0.1, width_m: 2.0 },
        pose: pose(x_m, 3.0, 0.0),
        motion: ObstacleMotion::Fixed,
    }
}

/// A person who walks up and down beside the robot's path.
fn person(name: &str, x_m: f64) -> ObstacleConfig {
    ObstacleConfig {
        name: name.to_owned(),
        shape: Shape::Disc { radius_m: 0.25 },
        pose: pose(x_m, 1.0, 0.0),
        motion: ObstacleMotion::Route {
            waypoints: vec![Point::new(x_m, 1.8), Point::new(x_m, 1.0)],
            speed_mps: 0.5,
            end: RouteEnd::Loop,
        },
    }
}

/// The names of all obstacles, in order.
fn names(sim: &Simulation) -> Vec<String> {
    sim.truth().obstacles().map(|obstacle| obstacle.name.to_owned()).collect()
}

fn place_of(sim: &Simulation, name: &str) -> Pose {
    sim.truth().obstacles().find(|obstacle| obstacle.name == name).expect("it is there").pose
}

#[test]
fn a_closing_door_is_visible_and_stops_the_robot_until_it_opens() {
    let mut sim = at_the_left();
    sim.faults_mut().bodies.push(door(4.0));
    let readings = drive(&mut sim, 0.4, 0.0, 5);
    let ahead_m = f64::from(scans(&readings).filter(|scan| scan.laser == 0).last().expect("a scan").ranges_m[180]);
    assert!((ahead_m - (3.95 - 2.245)).abs() < 0.01, "{ahead_m}");
    drive(&mut sim, 0.4, 0.0, 500);
    assert!((sim.truth().pose().translation.x - 3.65).abs() < 0.01, "{}", sim.truth().pose());
    assert_eq!((sim.truth().collisions(), names(&sim)), (1, vec!["door".to_owned()]));
    sim.faults_mut().bodies.clear();
    drive(&mut sim, 0.4, 0.0, 300);
    assert!(names(&sim).is_empty() && !sim.truth().is_touching());
    assert!(sim.truth().pose().translation.x > 5.0, "{}", sim.truth().pose());
}

#[test]
fn a_door_closes_behind_the_robot_but_not_on_it() {
    let mut sim = at_the_left();
    sim.faults_mut().bodies.push(door(2.2));
    drive(&mut sim, 0.0, 0.0, 100);
    assert!(names(&sim).is_empty(), "no room yet");
    assert_eq!(sim.truth().pose(), pose(2.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 250);
    assert_eq!(names(&sim), ["door"]);
    assert!(sim.truth().pose().translation.x > 3.0, "nothing held it back: {}", sim.truth().pose());
    assert_eq!(sim.truth().collisions(), 0);
    drive(&mut sim, -0.4, 0.0, 500);
    assert!((sim.truth().pose().translation.x - 2.55).abs() < 0.01, "{}", sim.truth().pose());
}

#[test]
fn people_continue_while_others_come_and_go() {
    let mut alone = at_the_left();
    alone.faults_mut().bodies = vec![person("Ann", 5.0)];
    let mut among = at_the_left();
    among.faults_mut().bodies = vec![person("Ann", 5.0)];
    for step in 0..300 {
        match step {
            50 => among.faults_mut().bodies.insert(0, person("Bob", 6.0)),
            120 => among.faults_mut().bodies.push(door(7.0)),
            200 => drop(among.faults_mut().bodies.remove(0)),
            250 => drop(among.faults_mut().bodies.pop()),
            _ => {}
        }
        drive(&mut alone, 0.0, 0.0, 1);
        drive(&mut among, 0.0, 0.0, 1);
        assert_eq!(place_of(&among, "Ann"), place_of(&alone, "Ann"), "step {step}");
        let there = match step {
            0..50 => vec!["Ann"],
            50..120 => vec!["Ann", "Bob"],
            120..200 => vec!["Ann", "Bob", "door"],
            200..250 => vec!["Ann", "door"],
            _ => vec!["Ann"],
        };
        assert_eq!(names(&among), there, "step {step}");
    }
    let walked = place_of(&alone, "Ann");
    drive(&mut alone, 0.0, 0.0, 10);
    assert_ne!(place_of(&alone, "Ann"), walked, "Ann walks");
}

#[test]
fn a_body_with_a_new_description_is_placed_again() {
    let mut sim = at_the_left();
    sim.faults_mut().bodies = vec![door(4.0)];
    drive(&mut sim, 0.0, 0.0, 10);
    sim.faults_mut().bodies[0].pose = pose(6.0, 2.0, 0.5);
    drive(&mut sim, 0.0, 0.0, 1);
    assert_eq!((names(&sim), place_of(&sim, "door")), (vec!["door".to_owned()], pose(6.0, 2.0, 0.5)));
}

#[test]
fn bodies_come_after_those_of_the_configuration() {
    let config = SimConfig { obstacles: vec![person("Ann", 5.0)], ..SimConfig::default() };
    let mut sim = in_a_room(&config, pose(2.0, 3.0, 0.0));
    sim.faults_mut().bodies = vec![door(4.0), person("Bob", 6.0)];
    drive(&mut sim, 0.0, 0.0, 1);
    assert_eq!(names(&sim), ["Ann", "door", "Bob"]);
    sim.faults_mut().bodies.clear();
    drive(&mut sim, 0.0, 0.0, 1);
    assert_eq!(names(&sim), ["Ann"]);
}

#[test]
fn a_box_added_by_a_fault_can_be_pushed() {
    let mut sim = at_the_left();
    let crate_there =
        ObstacleConfig { motion: ObstacleMotion::Movable { mass_kg: 5.0 }, name: "crate".to_owned(), ..door(3.0) };
    sim.faults_mut().bodies.push(crate_there);
    drive(&mut sim, 0.4, 0.0, 300);
    assert!(place_of(&sim, "crate").translation.x > 3.3, "{}", place_of(&sim, "crate"));
}

#[test]
fn docking_happens_at_the_moved_station() {
    let mut config = SimConfig::default();
    config.battery.initial_pct = 50.0;
    let mut sim = in_a_room(&config, pose(7.0, 5.0, 0.0));
    sim.faults_mut().station = Some(pose(2.0, 3.0, 0.0));
    drive(&mut sim, 0.0, 0.0, 100);
    assert!(!sim.truth().is_docked());
    sim.kidnap(pose(2.1, 3.0, 0.0)).expect("room there");
    drive(&mut sim, 0.0, 0.0, 40);
    assert!(!sim.truth().is_docked(), "it has not rested there for a second");
    drive(&mut sim, 0.0, 0.0, 60);
    assert!(sim.truth().is_docked() && sim.truth().battery().charging);
    sim.faults_mut().station = None;
    drive(&mut sim, 0.0, 0.0, 100);
    assert!(!sim.truth().is_docked());
    sim.kidnap(pose(7.0, 5.0, 0.0)).expect("room there");
    drive(&mut sim, 0.0, 0.0, 100);
    assert!(sim.truth().is_docked(), "the station is where it was");
}

#[test]
fn a_kidnapped_robot_is_at_rest_elsewhere_without_its_wheels_noticing() {
    let mut sim = at_the_left();
    drive(&mut sim, 0.4, 0.0, 100);
    let (odometry, distance_m) = (sim.truth().odometry().pose, sim.truth().distance_m());
    let elsewhere = pose(6.0, 2.0, 1.0);
    sim.kidnap(elsewhere).expect("room there");
    assert_eq!((sim.truth().pose(), sim.truth().linear_mps()), (elsewhere, 0.0));
    let readings = drive(&mut sim, 0.0, 0.0, 5);
    assert_eq!((sim.truth().pose(), sim.truth().odometry().pose), (elsewhere, odometry));
    assert_eq!(sim.truth().distance_m(), distance_m);
    let seen = scans(&readings).next().expect("a scan").ranges_m.clone();
    let mut built_there = in_a_room(&SimConfig::default(), elsewhere);
    let expected = scans(&drive(&mut built_there, 0.0, 0.0, 5)).nth(2).expect("a scan").ranges_m.clone();
    assert_eq!(seen, expected);
    drive(&mut sim, 0.4, 0.0, 50);
    let off = (elsewhere * odometry.inv_mul(&sim.truth().odometry().pose)).inv_mul(&sim.truth().pose());
    assert!(off.translation.vector.norm() < 1e-9 && sim.truth().distance_m() > distance_m + 0.1, "{off}");
}

#[test]
fn a_robot_cannot_be_moved_into_walls_or_bodies_or_off_the_map() {
    let mut sim = at_the_left();
    sim.faults_mut().bodies.push(door(4.0));
    drive(&mut sim, 0.0, 0.0, 1);
    let before = sim.truth().pose();
    let error = sim.kidnap(pose(7.8, 3.0, 0.0)).expect_err("a wall");
    assert!(matches!(error, SimError::InWall { what: Placement::Kidnapping, .. }), "{error}");
    assert!(
        error.to_string().starts_with("the pose to which the robot is moved (7.8, 3) is 0.200 m from the wall"),
        "{error}"
    );
    let error = sim.kidnap(pose(4.2, 3.0, 0.0)).expect_err("a door");
    assert!(matches!(&error, SimError::InObstacle { obstacle, .. } if obstacle == "door"), "{error}");
    let error = sim.kidnap(pose(20.0, 3.0, 0.0)).expect_err("off the map");
    assert!(matches!(error, SimError::OutsideMap { what: Placement::Kidnapping, .. }), "{error}");
    let error = sim.kidnap(pose(f64::NAN, 3.0, 0.0)).expect_err("nowhere");
    assert!(matches!(error, SimError::OutsideMap { .. }), "{error}");
    assert!(sim.kidnap(pose(2.0, 3.0, f64::NAN)).is_err());
    assert_eq!(sim.truth().pose(), before);
}

#[test]
fn a_robot_that_is_moved_away_from_a_wall_no_longer_touches_it() {
    let mut sim = at_the_left();
    drive(&mut sim, -0.4, 0.0, 500);
    assert!(sim.truth().is_touching());
    sim.kidnap(pose(4.0, 3.0, 0.0)).expect("room there");
    drive(&mut sim, 0.0, 0.0, 1);
    assert_eq!((sim.truth().is_touching(), sim.truth().collisions()), (false, 1));
    assert_eq!(sim.truth().pose(), pose(4.0, 3.0, 0.0));
}
