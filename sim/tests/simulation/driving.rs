//! Driving, walls, odometry, the joypad.

use maps::{CellIndex, OccupancyGrid, Pose, Shape, heading, pose};
use rand::RngExt;
use robot::{Reading, Streams, VelocityCommand};
use sim::{DriftNoise, ObstacleConfig, ObstacleMotion, SimConfig, Simulation};

use crate::{drive, in_a_room, room, scans};

#[test]
fn drives_straight_for_a_meter() {
    let mut sim = in_a_room(&SimConfig::default(), pose(1.0, 3.0, 0.0));
    // 0.2 m while accelerating to 0.4 m/s, 0.6 m at that speed, 0.2 m while braking (and half a step's worth each).
    drive(&mut sim, 0.4, 0.0, 40 + 75);
    drive(&mut sim, 0.0, 0.0, 100);
    let at = sim.truth().pose();
    assert!((at.translation.x - 1.92).abs() < 0.01, "{at}");
    assert_eq!((at.translation.y, at.rotation.im), (3.0, 0.0));
    assert!((sim.truth().distance_m() - (at.translation.x - 1.0)).abs() < 1e-9);
    assert_eq!(sim.truth().linear_mps(), 0.0);
}

#[test]
fn turns_on_the_spot_and_drives_circles() {
    let mut sim = in_a_room(&SimConfig::default(), pose(4.0, 3.0, 0.0));
    drive(&mut sim, 0.0, 1.0, 100);
    let at = sim.truth().pose();
    assert_eq!((at.translation.x, at.translation.y), (4.0, 3.0));
    assert!((heading(&at) - 1.76).abs() < 0.02, "{}", heading(&at));
    let mut sim = in_a_room(&SimConfig::default(), pose(4.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.4, 50);
    let center = sim.truth().pose() * maps::Point::new(0.0, 1.0);
    drive(&mut sim, 0.4, 0.4, 600);
    assert!((sim.truth().pose() * maps::Point::new(0.0, 1.0) - center).norm() < 1e-9);
}

#[test]
fn a_wall_stops_the_robot_and_counts_as_one_collision() {
    let mut sim = in_a_room(&SimConfig::default(), pose(7.0, 3.0, 0.0));
    drive(&mut sim, 0.45, 0.0, 500);
    let truth = sim.truth();
    assert!((truth.pose().translation.x - 7.7).abs() < 0.01, "{}", truth.pose());
    assert!(truth.linear_mps().abs() < 0.01, "{}", truth.linear_mps());
    assert_eq!((truth.collisions(), truth.is_touching()), (1, true));
    drive(&mut sim, -0.3, 0.0, 100);
    assert!(!sim.truth().is_touching());
    drive(&mut sim, 0.3, 0.0, 400);
    assert_eq!(sim.truth().collisions(), 2);
}

#[test]
fn wheels_stopped_by_a_wall_do_not_continue_to_count() {
    let mut sim = in_a_room(&SimConfig::default(), pose(7.0, 3.0, 0.0));
    drive(&mut sim, 0.45, 0.0, 500);
    let truth = sim.truth();
    assert!((truth.odometry().pose.translation.x - (truth.pose().translation.x - 1.0 - 6.0)).abs() < 1e-3);
}

#[test]
fn sliding_along_walls_and_around_a_corner_is_one_contact() {
    let mut sim = in_a_room(&SimConfig::default(), pose(6.0, 5.0, 0.6));
    drive(&mut sim, 0.45, 0.0, 2000);
    let at = sim.truth().pose().translation;
    assert!(at.x <= 7.71 && at.y <= 5.71, "{at}");
    assert_eq!(sim.truth().collisions(), 1);
}

#[test]
fn odometry_without_noise_is_exact() {
    let start = pose(4.0, 1.5, 0.3);
    let mut sim = in_a_room(&SimConfig::default(), start);
    for n in 0..60 {
        drive(&mut sim, 0.35, 0.5 + 0.1 * f64::from(n % 5), 50);
    }
    let (truth, odometry) = (sim.truth().pose(), sim.truth().odometry());
    let off = (start * odometry.pose).inv_mul(&truth);
    assert_eq!(sim.truth().collisions(), 0, "the way is free");
    assert!(off.translation.vector.norm() < 1e-9 && off.rotation.angle().abs() < 1e-9, "{off}");
    assert!((odometry.linear_mps - 0.35).abs() < 1e-12);
}

#[test]
fn odometry_without_noise_is_exact_far_from_the_origin_as_well() {
    let plain = OccupancyGrid::new(200, 200, 0.05, pose(100.0, -120.0, 0.0));
    let start = pose(105.0, -115.0, 0.2);
    let mut sim =
        Simulation::new(&SimConfig::default(), &plain, start, start, &Streams::new(1)).expect("nothing there");
    drive(&mut sim, 0.4, 0.3, 5000);
    let off = (start * sim.truth().odometry().pose).inv_mul(&sim.truth().pose());
    assert!(off.translation.vector.norm() < 1e-9 && off.rotation.angle().abs() < 1e-9, "{off}");
}

/// A drive in a room at a given pose: the robot drives past a pillar, hits a wall, slides along it and stops in the
/// corner. Returns its poses relative to the room and the ranges of its lasers, each second, and its collisions.
fn along_the_wall(room_at: Pose) -> (Vec<Pose>, Vec<Vec<f32>>, u64) {
    let here = room(8.0, 6.0);
    let mut there = OccupancyGrid::new(here.width(), here.height(), here.resolution_m(), room_at * here.origin());
    for (offset, cell) in here.cells().iter().enumerate() {
        there.set(CellIndex { column: offset % here.width(), row: offset / here.width() }, *cell);
    }
    let pillar = ObstacleConfig {
        name: "pillar".to_owned(),
        shape: Shape::Disc { radius_m: 0.2 },
        pose: room_at * pose(3.0, 2.0, 0.0),
        motion: ObstacleMotion::Fixed,
    };
    let config = SimConfig { obstacles: vec![pillar], ..SimConfig::default() };
    let (start, station) = (room_at * pose(1.0, 3.0, 0.4), room_at * pose(7.0, 5.0, 0.0));
    let mut sim = Simulation::new(&config, &there, start, station, &Streams::new(1)).expect("a good start");
    let (mut poses, mut ranges) = (Vec::new(), Vec::new());
    for _ in 0..20 {
        let readings = drive(&mut sim, 0.4, 0.0, 50);
        poses.push(room_at.inv_mul(&sim.truth().pose()));
        ranges.extend(scans(&readings).last().map(|scan| scan.ranges_m.clone()));
    }
    (poses, ranges, sim.truth().collisions())
}

#[test]
fn a_robot_drives_the_same_way_far_from_the_origin() {
    let (near, near_ranges, collisions) = along_the_wall(Pose::identity());
    assert!(collisions > 0 && near[0].translation.x > 1.2, "it sets out, and meets the wall");
    for (x_m, y_m) in [(5_000.0, -5_000.0), (688_000.0, 5_335_000.0)] {
        let (far, far_ranges, far_collisions) = along_the_wall(pose(x_m, y_m, 0.0));
        for (second, (near, far)) in near.iter().zip(&far).enumerate() {
            let off = near.inv_mul(far);
            let off = (off.translation.vector.norm(), off.rotation.angle().abs());
            assert!(off.0 < 0.002 && off.1 < 0.002, "at ({x_m}, {y_m}), {second} s: off by {off:?}");
        }
        assert_eq!(far_collisions, collisions);
        // Beams that pass an edge may see what is behind it.
        let pairs = near_ranges.iter().flatten().zip(far_ranges.iter().flatten());
        let (same, all) = pairs.fold((0, 0), |(same, all), (near, far)| {
            (same + usize::from((near - far).abs() < 0.02 || near == far), all + 1)
        });
        assert!(same * 100 >= all * 98, "{same} of {all} beams");
    }
}

#[test]
fn walls_stop_the_robot_whatever_the_commands() {
    let mut sim = in_a_room(&SimConfig::default(), pose(4.0, 3.0, 0.0));
    let mut rng = Streams::new(5).stream("commands");
    for _ in 0..200 {
        let (linear_mps, angular_radps) = (rng.random_range(-0.45..0.45), rng.random_range(-1.0..1.0));
        for _ in 0..50 {
            drive(&mut sim, linear_mps, angular_radps, 1);
            let at = sim.truth().pose().translation;
            let gap_m = at.x.min(at.y).min(8.0 - at.x).min(6.0 - at.y) - 0.3;
            assert!(gap_m > -0.001, "{at} is {gap_m} m from the wall");
        }
    }
    assert!(sim.truth().collisions() > 3, "the robot is meant to bump into walls");
}

#[test]
fn odometry_with_bias_is_off_by_the_configured_amount() {
    let mut config = SimConfig::default();
    config.odometry.distance_bias = 0.05;
    let mut sim = in_a_room(&config, pose(1.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 500);
    let (driven, measured) = (sim.truth().distance_m(), sim.truth().odometry().pose.translation.x);
    assert!((measured / driven - 1.05).abs() < 1e-9, "{measured} for {driven}");
}

#[test]
fn motion_noise_moves_the_robot_and_its_odometry_alike() {
    let mut config = SimConfig::default();
    config.drive.noise = DriftNoise { angle_per_sqrt_m: 0.05, distance_per_sqrt_m: 0.02, ..DriftNoise::default() };
    let mut sim = in_a_room(&config, pose(1.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 400);
    let truth = sim.truth();
    assert!(truth.pose().rotation.angle().abs() > 1e-4);
    let off = (pose(1.0, 3.0, 0.0) * truth.odometry().pose).inv_mul(&truth.pose());
    assert!(off.translation.vector.norm() < 1e-9, "{off}");
}

#[test]
fn the_joypad_overrides_commands_until_it_is_released() {
    let mut sim = in_a_room(&SimConfig::default(), pose(4.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 50);
    sim.faults_mut().base.velocity_override = Some(VelocityCommand { linear_mps: -0.4, angular_radps: 0.0 });
    drive(&mut sim, 0.4, 0.0, 100);
    assert_eq!(sim.truth().odometry().linear_mps.signum(), -1.0);
    sim.faults_mut().base.velocity_override = None;
    drive(&mut sim, 0.4, 0.0, 100);
    assert!((sim.truth().linear_mps() - 0.4).abs() < 1e-12);
}

#[test]
fn an_empty_battery_stops_the_robot() {
    let mut sim = in_a_room(&SimConfig::default(), pose(1.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 50);
    sim.set_battery_charge(0.0);
    drive(&mut sim, 0.4, 0.0, 50);
    let stopped_at = sim.truth().pose();
    drive(&mut sim, 0.4, 0.0, 50);
    assert_eq!(sim.truth().pose(), stopped_at);
    assert_eq!(sim.truth().battery().charge_pct, 0.0);
}

#[test]
fn readings_come_at_their_periods_from_time_0_on() {
    let mut sim = in_a_room(&SimConfig::default(), pose(1.0, 3.0, 0.0));
    let mut readings = Vec::new();
    robot::Robot::read(&mut sim, &mut readings);
    assert_eq!(readings.len(), 1 + 2 + 1);
    assert!(readings.iter().all(|reading| reading.time().is_zero()));
    let readings = drive(&mut sim, 0.0, 0.0, 50);
    let count = |kind: fn(&Reading) -> bool| readings.iter().filter(|reading| kind(reading)).count();
    assert_eq!(count(|r| matches!(r, Reading::Odometry(_))), 50);
    assert_eq!(count(|r| matches!(r, Reading::Scan(_))), 20);
    assert_eq!(count(|r| matches!(r, Reading::Battery(_))), 10);
    assert!(readings.is_sorted_by_key(Reading::time));
}
