//! Collisions with obstacles.

use maps::{Point, Shape, pose};
use sim::{ObstacleConfig, ObstacleMotion, RouteEnd, SimConfig};

use crate::{drive, in_a_room};

fn among(obstacles: Vec<ObstacleConfig>) -> SimConfig {
    SimConfig { obstacles, ..SimConfig::default() }
}

fn obstacle(name: &str, shape: Shape, x_m: f64, motion: ObstacleMotion) -> ObstacleConfig {
    ObstacleConfig { name: name.to_owned(), shape, pose: pose(x_m, 3.0, 0.0), motion }
}

const PILLAR: Shape = Shape::Disc { radius_m: 0.2 };
const CRATE: Shape = Shape::Box { length_m: 0.4, width_m: 0.4 };

#[test]
fn a_pillar_stops_the_robot() {
    let mut sim = in_a_room(&among(vec![obstacle("pillar", PILLAR, 4.0, ObstacleMotion::Fixed)]), pose(2.0, 3.0, 0.0));
    drive(&mut sim, 0.45, 0.0, 500);
    assert!((sim.truth().pose().translation.x - 3.5).abs() < 0.01, "{}", sim.truth().pose());
    assert_eq!(sim.truth().collisions(), 1);
}

#[test]
fn a_light_box_is_pushed_until_a_wall_stops_both() {
    let movable = ObstacleMotion::Movable { mass_kg: 5.0 };
    let mut sim = in_a_room(&among(vec![obstacle("crate", CRATE, 4.0, movable)]), pose(2.0, 3.0, 0.0));
    drive(&mut sim, 0.45, 0.0, 300);
    let pushed = sim.truth().obstacles().next().expect("the crate").pose.translation.x;
    assert!(pushed > 4.3, "{pushed}");
    drive(&mut sim, 0.45, 0.0, 3000);
    let (robot, pushed) =
        (sim.truth().pose().translation.x, sim.truth().obstacles().next().expect("the crate").pose.translation.x);
    assert!((pushed - 7.8).abs() < 0.02 && (robot - 7.3).abs() < 0.03, "robot {robot}, crate {pushed}");
}

#[test]
fn a_person_who_walks_on_pushes_a_standing_robot_and_its_wheels_notice() {
    let walk = ObstacleMotion::Route { waypoints: vec![Point::new(5.0, 3.0)], speed_mps: 0.8, end: RouteEnd::Stop };
    let mut sim = in_a_room(&among(vec![obstacle("person", PILLAR, 2.0, walk)]), pose(4.0, 3.0, 0.0));
    drive(&mut sim, 0.0, 0.0, 400);
    let truth = sim.truth();
    assert!((truth.pose().translation.x - 5.5).abs() < 0.03, "{}", truth.pose());
    assert_eq!(truth.collisions(), 1);
    assert!((truth.odometry().pose.translation.x - (truth.pose().translation.x - 4.0)).abs() < 1e-3);
    assert_eq!(truth.linear_mps(), 0.0, "the push is over");
}

#[test]
fn obstacles_keep_their_order_and_names() {
    let fixed = || ObstacleMotion::Fixed;
    let movable = ObstacleMotion::Movable { mass_kg: 5.0 };
    let obstacles = vec![
        obstacle("a", PILLAR, 4.0, fixed()),
        obstacle("b", CRATE, 5.0, movable),
        obstacle("c", PILLAR, 6.0, fixed()),
    ];
    let sim = in_a_room(&among(obstacles), pose(2.0, 3.0, 0.0));
    let seen: Vec<(&str, Shape, f64)> =
        sim.truth().obstacles().map(|truth| (truth.name, truth.shape, truth.pose.translation.x)).collect();
    assert_eq!(seen, [("a", PILLAR, 4.0), ("b", CRATE, 5.0), ("c", PILLAR, 6.0)]);
}
