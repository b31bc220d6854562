//! People who follow the robot.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;
use std::time::Duration;

use maps::{OccupancyGrid, Point, Pose, Shape, heading, house, pose};
use proptest::prelude::*;
use robot::{Robot, Streams, VelocityCommand};
use sim::{Building, Door, Follow, ObstacleConfig, ObstacleMotion, Opening, SimConfig, Simulation};

use crate::{drive, in_a_room};

/// Radius of a person, in meters.
const ANN_M: f64 = 0.25;

/// The distance of robot and person at which they touch, in meters.
const TOUCH_M: f64 = 0.3 + ANN_M;

fn seconds(spans: &[[u64; 2]]) -> Vec<(Duration, Duration)> {
    spans.iter().map(|span| span.map(Duration::from_secs).into()).collect()
}

fn ann(at: Point, stands_s: &[[u64; 2]]) -> ObstacleConfig {
    let follow = Follow { stands: seconds(stands_s), ..Follow::default() };
    body("Ann", Shape::Disc { radius_m: ANN_M }, pose(at.x, at.y, 0.0), ObstacleMotion::Follower(follow))
}

fn body(name: &str, shape: Shape, pose: Pose, motion: ObstacleMotion) -> ObstacleConfig {
    ObstacleConfig { name: name.to_owned(), shape, pose, motion }
}

/// A door across the way along x, open unless it is commanded otherwise.
fn door(x_m: f64) -> ObstacleConfig {
    let door = Door { opening: Opening::Slide, moving: Duration::from_secs(1), closed: Vec::new(), every: None };
    body("door", Shape::Box { length_m: 2.0, width_m: 0.06 }, pose(x_m, 3.0, FRAC_PI_2), ObstacleMotion::Door(door))
}

fn among(obstacles: Vec<ObstacleConfig>, robot: Pose) -> Simulation {
    in_a_room(&SimConfig { obstacles, ..SimConfig::default() }, robot)
}

fn place_of_ann(sim: &Simulation) -> Point {
    sim.truth().obstacles().find(|body| body.name == "Ann").expect("Ann is there").pose.translation.vector.into()
}

fn place_of_robot(sim: &Simulation) -> Point {
    sim.truth().pose().translation.vector.into()
}

fn apart_m(sim: &Simulation) -> f64 {
    (place_of_ann(sim) - place_of_robot(sim)).norm()
}

fn turn_to(sim: &mut Simulation, heading_rad: f64) {
    while (heading(&sim.truth().pose()) - heading_rad).abs() > 0.02 {
        drive(sim, 0.0, 0.3, 1);
    }
    drive(sim, 0.0, 0.0, 20);
}

#[test]
fn a_person_stands_until_the_robot_comes_near_and_then_keeps_a_distance() {
    let at = Point::new(4.0, 4.2);
    let mut sim = among(vec![ann(at, &[])], pose(1.0, 3.0, 0.0));
    while apart_m(&sim) > 2.0 {
        assert_eq!(place_of_ann(&sim), at);
        drive(&mut sim, 0.45, 0.0, 1);
    }
    drive(&mut sim, 0.45, 0.0, 400);
    assert!((apart_m(&sim) - 1.2).abs() < 0.02, "{}", apart_m(&sim));
    drive(&mut sim, 0.0, 0.0, 200);
    assert!((apart_m(&sim) - 1.2).abs() < 1e-3, "{}", apart_m(&sim));
}

#[test]
fn nobody_meets_a_robot_behind_a_closed_door() {
    let at = Point::new(4.8, 3.0);
    let mut sim = among(vec![ann(at, &[]), door(4.0)], pose(2.0, 3.0, 0.0));
    sim.command_door("door", false);
    drive(&mut sim, 0.4, 0.0, 200);
    assert!(apart_m(&sim) < 2.0 && place_of_ann(&sim) == at, "{}", apart_m(&sim));
    sim.command_door("door", true);
    drive(&mut sim, 0.0, 0.0, 100);
    assert!(apart_m(&sim) < 1.21, "{}", apart_m(&sim));
}

#[test]
fn a_follower_who_stands_still_for_a_while_finds_the_robot_by_its_trail() {
    let table = pose(2.5, 4.6, 0.0);
    let shape = Shape::Box { length_m: 1.5, width_m: 1.5 };
    let at = Point::new(1.0, 4.6);
    let obstacles = vec![ann(at, &[[0, 20]]), body("table", shape, table, ObstacleMotion::Fixed)];
    let mut sim = among(obstacles, pose(1.0, 3.0, 0.0));
    drive(&mut sim, 0.45, 0.0, 400);
    turn_to(&mut sim, FRAC_PI_2);
    drive(&mut sim, 0.45, 0.0, 180);
    assert!(place_of_robot(&sim).y > 4.3 && place_of_robot(&sim).x > 4.3, "{}", place_of_robot(&sim));
    while sim.time() < Duration::from_secs(20) {
        assert_eq!(place_of_ann(&sim), at);
        drive(&mut sim, 0.0, 0.0, 1);
    }
    for _ in 0..500 {
        let before = place_of_ann(&sim);
        drive(&mut sim, 0.0, 0.0, 1);
        let here = table.inverse_transform_point(&place_of_ann(&sim));
        let gap_m = Point::new((here.x.abs() - 0.75).max(0.0), (here.y.abs() - 0.75).max(0.0)).coords.norm();
        assert!(gap_m > ANN_M && (place_of_ann(&sim) - before).norm() < 0.02 + 1e-9, "{gap_m}");
    }
    assert!(apart_m(&sim) < 1.21, "{}", apart_m(&sim));
}

#[test]
fn a_door_that_closes_behind_the_robot_stops_its_follower() {
    let mut sim = among(vec![ann(Point::new(1.6, 3.0), &[[0, 12]]), door(4.0)], pose(2.8, 3.0, 0.0));
    drive(&mut sim, 0.45, 0.0, 400);
    sim.command_door("door", false);
    drive(&mut sim, 0.0, 0.0, 700);
    let waits = place_of_ann(&sim);
    assert!(waits.x > 3.6 && waits.x <= 4.0 - 0.03 - ANN_M, "{waits}");
    sim.command_door("door", true);
    drive(&mut sim, 0.0, 0.0, 400);
    assert!(apart_m(&sim) < 1.21, "{}", apart_m(&sim));
}

#[test]
fn a_follower_lets_the_robot_pass_and_follows_it_again() {
    let mut sim = among(vec![ann(Point::new(2.5, 3.0), &[])], pose(4.0, 3.0, 0.0));
    drive(&mut sim, 0.0, 0.0, 100);
    assert!((apart_m(&sim) - 1.2).abs() < 1e-3, "{}", apart_m(&sim));
    turn_to(&mut sim, PI - 0.03);
    let before = place_of_ann(&sim);
    drive(&mut sim, 0.0, 0.0, 300);
    let beside_m = (place_of_ann(&sim).y - 3.0).abs();
    assert!((before.y - 3.0).abs() < 0.05 && beside_m > TOUCH_M, "{before}, {beside_m}");
    drive(&mut sim, 0.45, 0.0, 380);
    assert!(place_of_robot(&sim).x < 1.2 && sim.truth().collisions() == 0, "{}", place_of_robot(&sim));
    drive(&mut sim, 0.0, 0.0, 300);
    assert!(apart_m(&sim) < 1.21 && (place_of_ann(&sim).y - 3.0).abs() < 0.5, "{}", place_of_ann(&sim));
}

#[test]
fn a_follower_who_loses_the_robot_waits_until_it_comes_near_again() {
    let mut sim = among(vec![ann(Point::new(1.0, 3.0), &[])], pose(2.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 100);
    let lost = place_of_ann(&sim);
    sim.kidnap(pose(7.0, 5.0, 0.0)).expect("room there");
    drive(&mut sim, -0.2, 0.0, 200);
    assert_eq!(place_of_ann(&sim), lost);
    sim.kidnap(pose(lost.x + 1.5, 3.0, 0.0)).expect("room there");
    drive(&mut sim, 0.4, 0.0, 200);
    assert!((apart_m(&sim) - 1.2).abs() < 0.02 && place_of_ann(&sim).x > lost.x + 0.5, "{}", apart_m(&sim));
}

static HOUSE: LazyLock<(OccupancyGrid, Building)> = LazyLock::new(|| {
    let map = house::map();
    let building = Building::new(&map);
    (map, building)
});

/// A place of the house for the robot, with room for somebody 1 m to the side, and between them.
fn meeting() -> impl Strategy<Value = Point> {
    let has_room =
        |at: &Point| (0..=10).all(|n| HOUSE.0.has_room(&(at + Point::new(0.0, 0.1).coords * f64::from(n)), 0.32));
    (-14.0..14.0, -5.0..17.0).prop_map(|(x, y)| Point::new(x, y)).prop_filter("no room", has_room)
}

/// Drives with a command for a while, and backs off from whatever it touches. Checks Ann after each step.
fn roam(sim: &mut Simulation, command: (f64, f64), steps: u32) -> Result<(), TestCaseError> {
    let mut backs_off = 0;
    for _ in 0..steps {
        backs_off = if sim.truth().is_touching() { 60 } else { backs_off - 1 };
        let (linear_mps, angular_radps) = if backs_off > 0 { (-0.2, 0.7) } else { command };
        sim.drive(VelocityCommand { linear_mps, angular_radps });
        let (robot, before) = (place_of_robot(sim), place_of_ann(sim));
        sim.step();
        let at = place_of_ann(sim);
        prop_assert!(HOUSE.0.has_room(&at, ANN_M - 0.02), "Ann touches a wall at {at}");
        prop_assert!(apart_m(sim) > TOUCH_M - 0.01, "Ann and the robot overlap at {at}");
        let far_m = (at - robot).norm();
        prop_assert!(at == before || far_m >= TOUCH_M || far_m >= (before - robot).norm(), "into the robot at {at}");
        prop_assert!((at - before).norm() < 0.02 + 1e-9, "Ann jumped to {at}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_follower_touches_neither_wall_nor_robot_and_finds_it_again(
        robot in meeting(), stands_s in 5..20_u64, for_s in 1..30_u64,
        commands in prop::collection::vec((0.0..0.45_f64, -0.8..0.8_f64, 50..200_u32), 30)
    ) {
        let mut config = SimConfig::default();
        config.model.lasers.clear();
        config.obstacles.push(ann(robot + Point::new(0.0, 1.0).coords, &[[stands_s, stands_s + for_s]]));
        let start = pose(robot.x, robot.y, 0.0);
        let mut sim = Simulation::within(&HOUSE.1, &config, start, start, &Streams::new(1)).expect("room for both");
        for (linear_mps, angular_radps, steps) in commands {
            roam(&mut sim, (linear_mps, angular_radps), steps)?;
        }
        // A robot that turns on the spot does not wait for anybody to make way.
        roam(&mut sim, (0.0, 1.0), 4000)?;
        // Somebody who has stepped aside is not back yet if the robot waits right there.
        prop_assert!(apart_m(&sim) < 2.6, "Ann is at {}, the robot at {}", place_of_ann(&sim), place_of_robot(&sim));
    }
}
