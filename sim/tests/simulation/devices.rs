//! The actions and measurements of devices in the world: doors on command, boxes that are carried, lines of sight.

use std::time::Duration;

use maps::{Point, Pose, Shape, pose};
use proptest::prelude::*;
use sim::{BoxError, Door, ObstacleConfig, ObstacleMotion, Obstruction, Opening, RouteEnd, SimConfig, Simulation};

use crate::{drive, in_a_room, scans};

const CRATE: Shape = Shape::Box { length_m: 0.4, width_m: 0.6 };

fn body(name: &str, shape: Shape, pose: Pose, motion: ObstacleMotion) -> ObstacleConfig {
    ObstacleConfig { name: name.to_owned(), shape, pose, motion }
}

fn crate_at(name: &str, pose: Pose) -> ObstacleConfig {
    body(name, CRATE, pose, ObstacleMotion::Movable { mass_kg: 5.0 })
}

/// A door across the room's middle that is closed between these times, in seconds.
fn door(closed_s: [u64; 2]) -> ObstacleConfig {
    let door = Door {
        opening: Opening::Slide,
        moving: Duration::from_secs(2),
        closed: vec![closed_s.map(Duration::from_secs).into()],
        every: None,
    };
    let leaf = Shape::Box { length_m: 2.0, width_m: 0.06 };
    body("door", leaf, pose(4.0, 3.0, std::f64::consts::FRAC_PI_2), ObstacleMotion::Door(door))
}

/// A robot at the left, facing these obstacles.
fn among(obstacles: Vec<ObstacleConfig>) -> Simulation {
    in_a_room(&SimConfig { obstacles, ..SimConfig::default() }, pose(2.0, 3.0, 0.0))
}

fn place_of(sim: &Simulation, name: &str) -> Option<Pose> {
    sim.truth().obstacles().find(|obstacle| obstacle.name == name).map(|obstacle| obstacle.pose)
}

fn x_of(sim: &Simulation) -> f64 {
    sim.truth().pose().translation.x
}

/// The distance that the front laser measures straight ahead, in meters.
fn ahead_m(sim: &mut Simulation) -> f32 {
    scans(&drive(sim, 0.0, 0.0, 5)).filter(|scan| scan.laser == 0).last().expect("a scan").ranges_m[180]
}

#[test]
fn a_door_opens_and_closes_on_command_and_forgets_its_schedule() {
    let mut sim = among(vec![door([0, 1000]), crate_at("crate", pose(6.0, 1.0, 0.0))]);
    drive(&mut sim, 0.45, 0.0, 500);
    assert!((x_of(&sim) - 3.67).abs() < 0.01 && sim.truth().door_opening("door") == Some(0.0), "{}", x_of(&sim));
    assert!(sim.command_door("door", true));
    drive(&mut sim, 0.0, 0.0, 50);
    let half_m = sim.truth().door_opening("door").expect("a door");
    assert!((half_m - 0.5).abs() < 0.02, "{half_m}");
    drive(&mut sim, 0.0, 0.0, 51);
    assert_eq!(sim.truth().door_opening("door"), Some(1.0));
    assert_eq!(sim.truth().doors().collect::<Vec<_>>(), [("door", 2.0)]);
    drive(&mut sim, 0.45, 0.0, 250);
    assert!(x_of(&sim) > 5.0, "{}", x_of(&sim));
    assert!(sim.command_door("door", false));
    drive(&mut sim, 0.0, 0.0, 101);
    assert_eq!(sim.truth().door_opening("door"), Some(0.0));
    for unknown in ["crate", "gate"] {
        assert!(!sim.command_door(unknown, true) && sim.truth().door_opening(unknown).is_none(), "{unknown}");
    }
}

#[test]
fn a_door_that_is_commanded_to_close_waits_for_the_robot_in_it() {
    let mut sim = among(vec![door([500, 1000])]);
    sim.kidnap(pose(4.0, 3.0, 0.0)).expect("the door is open");
    sim.command_door("door", false);
    drive(&mut sim, 0.0, 0.0, 300);
    let waits = sim.truth().door_opening("door").expect("a door");
    assert!(waits > 0.5 && waits < 1.0 && sim.truth().collisions() == 0, "{waits}");
    drive(&mut sim, 0.45, 0.0, 250);
    assert_eq!(sim.truth().door_opening("door"), Some(0.0));
}

#[test]
fn the_joint_of_a_door_turns_or_slides_as_its_leaf_does() {
    for (opening, joint) in [
        (Opening::Slide, 2.0),
        (Opening::Left, std::f64::consts::FRAC_PI_2),
        (Opening::Right, -std::f64::consts::FRAC_PI_2),
    ] {
        let mut leaf = door([0, 1000]);
        if let ObstacleMotion::Door(door) = &mut leaf.motion {
            door.opening = opening;
        }
        let closed = leaf.pose;
        // The robot is not in its way.
        let config = SimConfig { obstacles: vec![leaf], ..SimConfig::default() };
        let mut sim = in_a_room(&config, pose(1.0, 5.0, 0.0));
        assert_eq!(sim.truth().doors().collect::<Vec<_>>(), [("door", 0.0)]);
        sim.command_door("door", true);
        drive(&mut sim, 0.0, 0.0, 101);
        let (_, moved) = sim.truth().doors().next().expect("a door");
        assert!((moved - joint).abs() < 1e-9, "{opening:?}: {moved}");
        let leaf = closed.inv_mul(&place_of(&sim, "door").expect("its leaf"));
        let has_moved = if opening == Opening::Slide { leaf.translation.x } else { leaf.rotation.angle() };
        assert!((has_moved - joint).abs() < 1e-6, "{opening:?}: {leaf}");
    }
}

#[test]
fn a_contact_is_where_the_robot_touches_and_pushes_it_away() {
    // The last crate is turned a little, to the robot's left.
    for (bodies, at, obstacle, turned_rad) in [
        (vec![], pose(4.0, 5.0, std::f64::consts::FRAC_PI_2), None, 0.0),
        (vec![crate_at("crate", pose(4.0, 4.0, 0.0))], pose(4.0, 3.0, std::f64::consts::FRAC_PI_2), Some("crate"), 0.0),
        (vec![crate_at("crate", pose(4.0, 2.0, 0.1))], pose(3.0, 2.0, 0.0), Some("crate"), 0.1),
    ] {
        let mut sim = in_a_room(&SimConfig { obstacles: bodies, ..SimConfig::default() }, at);
        drive(&mut sim, 0.4, 0.0, 200);
        let [contact] = sim.truth().contacts() else { panic!("{:?}", sim.truth().contacts()) };
        assert_eq!(contact.obstacle.as_deref(), obstacle);
        let expected = pose(0.0, 0.0, turned_rad) * nalgebra::Vector2::new(-1.0, 0.0);
        assert!((contact.normal - expected).norm() < 0.01, "{contact:?}");
        assert!((contact.at.coords + 0.3 * expected).norm() < 0.01, "{contact:?}");
        assert!((0.0..0.02).contains(&contact.depth_m), "{contact:?}");
    }
    // Backwards.
    let mut sim = among(vec![]);
    drive(&mut sim, -0.4, 0.0, 400);
    let [contact] = sim.truth().contacts() else { panic!("{:?}", sim.truth().contacts()) };
    assert!(contact.at.x < -0.1 && contact.normal.x > 0.99, "{contact:?}");
}

#[test]
fn a_stuck_door_obeys_neither_schedule_nor_command_until_it_is_free() {
    let mut sim = among(vec![door([0, 2])]);
    sim.faults_mut().stuck_doors = vec!["door".to_owned()];
    drive(&mut sim, 0.0, 0.0, 200);
    assert_eq!(sim.truth().door_opening("door"), Some(0.0), "its schedule says open");
    sim.faults_mut().stuck_doors = vec!["another door".to_owned()];
    drive(&mut sim, 0.0, 0.0, 50);
    let halfway = sim.truth().door_opening("door");
    sim.faults_mut().stuck_doors = vec!["door".to_owned()];
    sim.command_door("door", false);
    drive(&mut sim, 0.0, 0.0, 200);
    assert!(halfway > Some(0.4) && sim.truth().door_opening("door") == halfway, "{halfway:?}");
    sim.faults_mut().stuck_doors.clear();
    drive(&mut sim, 0.0, 0.0, 101);
    assert_eq!(sim.truth().door_opening("door"), Some(0.0));
}

#[test]
fn a_box_that_is_picked_up_is_out_of_sight_and_out_of_the_way() {
    let mut sim = among(vec![crate_at("crate", pose(4.0, 3.0, 0.0)), crate_at("parcel", pose(6.0, 1.0, 0.0))]);
    let beyond_m = |sim: &mut Simulation| ahead_m(sim) - (3.8 - 2.245);
    assert!(beyond_m(&mut sim).abs() < 0.01);
    assert_eq!(sim.pick_up("crate"), Ok(()));
    assert!(beyond_m(&mut sim) > 4.0);
    assert_eq!(sim.truth().obstacles().map(|obstacle| obstacle.name).collect::<Vec<_>>(), ["parcel"]);
    drive(&mut sim, 0.45, 0.0, 300);
    assert!(x_of(&sim) > 4.5 && sim.truth().collisions() == 0, "{}", x_of(&sim));
}

#[test]
fn a_box_that_is_put_down_is_at_rest_there_and_can_be_pushed() {
    let mut sim = among(vec![crate_at("crate", pose(2.52, 3.0, 0.0)), crate_at("parcel", pose(6.0, 1.0, 0.0))]);
    drive(&mut sim, 0.45, 0.0, 100);
    assert!(sim.truth().is_touching());
    sim.pick_up("crate").expect("it is there");
    drive(&mut sim, 0.0, 0.0, 20);
    assert!(!sim.truth().is_touching(), "nothing is left of it");
    let there = pose(4.5, 3.0, 0.4);
    assert_eq!(sim.put_down("crate", there), Ok(()));
    assert_eq!(sim.truth().obstacles().map(|obstacle| obstacle.name).collect::<Vec<_>>(), ["crate", "parcel"]);
    assert!(f64::from(ahead_m(&mut sim)) < 4.5 - x_of(&sim));
    let settled = place_of(&sim, "crate").expect("it is on the floor").inv_mul(&there);
    assert!(settled.translation.vector.norm() < 1e-5 && settled.rotation.angle().abs() < 1e-5, "{settled}");
    drive(&mut sim, 0.45, 0.0, 400);
    assert!(place_of(&sim, "crate").expect("it is on the floor").translation.x > 4.7);
    assert_eq!(sim.truth().contacts().last().and_then(|contact| contact.obstacle.clone()).as_deref(), Some("crate"));
}

#[test]
fn only_boxes_that_can_be_moved_are_carried_and_only_once() {
    let fixed = body("table", CRATE, pose(6.0, 1.0, 0.0), ObstacleMotion::Fixed);
    let mut sim = among(vec![crate_at("crate", pose(4.0, 3.0, 0.0)), fixed]);
    let named = str::to_owned;
    assert_eq!(sim.put_down("crate", pose(5.0, 5.0, 0.0)), Err(BoxError::OnFloor(named("crate"))));
    assert_eq!(sim.pick_up("crate"), Ok(()));
    assert_eq!(sim.pick_up("crate"), Err(BoxError::Lifted(named("crate"))));
    for unknown in ["table", "parcel"] {
        assert_eq!(sim.pick_up(unknown), Err(BoxError::Unknown(named(unknown))));
        assert_eq!(sim.put_down(unknown, pose(5.0, 5.0, 0.0)), Err(BoxError::Unknown(named(unknown))));
    }
}

#[test]
fn a_box_without_room_stays_lifted_and_the_error_names_what_is_in_the_way() {
    let table = body("table", CRATE, pose(6.0, 1.0, 0.0), ObstacleMotion::Fixed);
    let mut sim = among(vec![crate_at("crate", pose(4.0, 3.0, 0.0)), table]);
    sim.pick_up("crate").expect("it is there");
    let by = |name: &str| Obstruction::Obstacle(name.to_owned());
    for (there, expected) in [
        (pose(7.7, 3.0, 0.8), Obstruction::Wall),
        (pose(2.4, 3.1, 0.0), Obstruction::Robot),
        (pose(6.3, 1.0, 0.0), by("table")),
        (pose(30.0, 1.0, 0.0), Obstruction::Edge),
        (pose(f64::NAN, 1.0, 0.0), Obstruction::Edge),
        (pose(4.0, 3.0, f64::NAN), Obstruction::Edge),
    ] {
        let Err(BoxError::NoRoom { obstruction, .. }) = sim.put_down("crate", there) else { panic!("{there}") };
        assert_eq!(obstruction, expected);
        assert_eq!(place_of(&sim, "crate"), None, "{there}");
    }
    let error = sim.put_down("crate", pose(6.3, 1.0, 0.0)).expect_err("the table is there");
    assert_eq!(error.to_string(), "there is no room for the box 'crate' at (6.30, 1.00): 'table' is in the way");
    assert_eq!(sim.put_down("crate", pose(6.5, 1.0, 0.0)), Ok(()));
}

#[test]
fn a_box_of_a_fault_disappears_with_it_even_from_somebodys_hands() {
    let mut sim = among(Vec::new());
    sim.faults_mut().bodies.push(crate_at("crate", pose(4.0, 3.0, 0.0)));
    drive(&mut sim, 0.0, 0.0, 1);
    sim.pick_up("crate").expect("it is there");
    sim.faults_mut().bodies.clear();
    drive(&mut sim, 0.0, 0.0, 1);
    assert_eq!(sim.put_down("crate", pose(4.0, 3.0, 0.0)), Err(BoxError::Unknown("crate".to_owned())));
}

#[test]
fn walls_doors_and_fixed_bodies_block_the_view_and_nothing_else() {
    let walk =
        ObstacleMotion::Route { waypoints: vec![Point::new(3.0, 5.0)], speed_mps: 0.1, end: RouteEnd::BackAndForth };
    let mut sim = among(vec![
        door([0, 1000]),
        body("table", CRATE, pose(2.0, 1.5, 0.0), ObstacleMotion::Fixed),
        body("Ann", Shape::Disc { radius_m: 0.25 }, pose(3.0, 4.0, 0.0), walk),
        crate_at("crate", pose(3.0, 3.0, 0.0)),
    ]);
    let sees = |sim: &Simulation, x_m, y_m| sim.truth().sees(&Point::new(x_m, y_m));
    assert!(sees(&sim, 2.0, 3.0), "itself");
    assert!(sees(&sim, 3.9, 3.0), "past the crate, up to the door");
    assert!(!sees(&sim, 4.1, 3.0), "through the door");
    assert!(sees(&sim, 4.0, 5.0), "past Ann");
    assert!(sees(&sim, 2.0, 2.0) && !sees(&sim, 2.0, 1.0), "in front of the table and behind it");
    assert!(sees(&sim, 0.05, 3.0) && !sees(&sim, -0.05, 3.0), "in front of the wall and in it");
    sim.command_door("door", true);
    drive(&mut sim, 0.0, 0.0, 101);
    assert!(sees(&sim, 7.0, 3.0), "through the open door");
}

/// The corners of a crate.
fn corners(at: &Pose) -> [Point; 4] {
    [(0.2, 0.3), (-0.2, 0.3), (-0.2, -0.3), (0.2, -0.3)].map(|(x_m, y_m)| at * Point::new(x_m, y_m))
}

/// The gap between a crate and a disc, in meters; negative if they overlap.
fn gap_m(at: &Pose, center: Point, radius_m: f64) -> f64 {
    let center = at.inverse_transform_point(&center);
    let outside = Point::new((center.x.abs() - 0.2).max(0.0), (center.y.abs() - 0.3).max(0.0));
    outside.coords.norm() - radius_m
}

proptest! {
    #[test]
    fn a_box_is_put_down_exactly_where_there_is_room(x_m in -1.0..9.0_f64, y_m in -1.0..7.0_f64, yaw_rad in -3.2..3.2) {
        let pillar = body("pillar", Shape::Disc { radius_m: 0.5 }, pose(5.0, 2.0, 0.0), ObstacleMotion::Fixed);
        let mut sim = among(vec![crate_at("crate", pose(7.0, 5.0, 0.0)), pillar]);
        sim.pick_up("crate").expect("it is there");
        let there = pose(x_m, y_m, yaw_rad);
        let from_walls = corners(&there).map(|corner| corner.x.min(8.0 - corner.x).min(corner.y).min(6.0 - corner.y));
        let gaps = [gap_m(&there, Point::new(2.0, 3.0), 0.3), gap_m(&there, Point::new(5.0, 2.0), 0.5)];
        let room_m = from_walls.into_iter().chain(gaps).fold(f64::INFINITY, f64::min);
        prop_assume!(room_m.abs() > 1e-4);
        prop_assert_eq!(sim.put_down("crate", there).is_ok(), room_m > 0.0, "{}", room_m);
        prop_assert_eq!(place_of(&sim, "crate"), (room_m > 0.0).then_some(there));
    }
}
