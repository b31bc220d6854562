//! The scans of the lasers.

use maps::{Cell, CellIndex, OccupancyGrid, Pose, Shape, pose};
use robot::{LaserSpec, Robot, RobotModel, Streams};
use sim::{ObstacleConfig, ObstacleMotion, RouteEnd, SimConfig, Simulation};

use crate::{drive, in_a_room, room, scans};

/// A laser in the middle of the robot that looks all around with eight beams, 45° apart.
fn eight_beams() -> SimConfig {
    let laser = LaserSpec {
        name: "around".to_owned(),
        mount: Pose::identity(),
        angle_min_rad: -std::f64::consts::PI,
        angle_increment_rad: std::f64::consts::FRAC_PI_4,
        beams: 8,
        ..RobotModel::default().lasers[0].clone()
    };
    SimConfig { model: RobotModel { lasers: vec![laser], ..RobotModel::default() }, ..SimConfig::default() }
}

fn first_ranges(config: &SimConfig, grid: &OccupancyGrid, start: Pose) -> Vec<f32> {
    let mut sim = Simulation::new(config, grid, start, start, &Streams::new(1)).expect("a good start");
    let mut readings = Vec::new();
    sim.read(&mut readings);
    scans(&readings).next().expect("a scan at time 0").ranges_m.clone()
}

fn assert_ranges(ranges: &[f32], expected: &[f64]) {
    assert_eq!(ranges.len(), expected.len());
    for (range, expected) in ranges.iter().zip(expected) {
        assert!((f64::from(*range) - expected).abs() < 1e-5, "{ranges:?} instead of {expected:?}");
    }
}

#[test]
fn a_scan_in_an_empty_room_agrees_with_geometry() {
    let root2 = 2_f64.sqrt();
    let ranges = first_ranges(&eight_beams(), &room(8.0, 6.0), pose(2.0, 1.5, 0.0));
    assert_ranges(&ranges, &[2.0, 1.5 * root2, 1.5, 1.5 * root2, 6.0, 4.5 * root2, 4.5, 2.0 * root2]);
}

#[test]
fn a_map_may_be_rotated() {
    let mut turned = OccupancyGrid::new(200, 200, 0.05, pose(3.0, -2.0, 0.7));
    for row in 0..200 {
        turned.set(CellIndex { column: 150, row }, Cell::Occupied);
    }
    let start = turned.origin() * pose(4.0, 5.0, 0.0);
    assert_ranges(&first_ranges(&eight_beams(), &turned, start)[4..5], &[3.5]);
}

#[test]
fn ranges_out_of_limits_are_infinite_and_unknown_cells_transparent() {
    let unknown = OccupancyGrid::new(100, 100, 0.05, pose(0.0, 0.0, 0.0));
    assert_eq!(first_ranges(&eight_beams(), &unknown, pose(2.0, 2.0, 0.0)), [f32::INFINITY; 8]);
    let mut config = eight_beams();
    config.model.lasers[0].range_min_m = 1.6;
    let ranges = first_ranges(&config, &room(8.0, 6.0), pose(2.0, 1.5, 0.0));
    assert_eq!(ranges[2], f32::NEG_INFINITY);
}

#[test]
fn both_lasers_scan_from_their_mounts() {
    let mut sim = in_a_room(&SimConfig::default(), pose(4.0, 3.0, 0.0));
    let mut readings = Vec::new();
    sim.read(&mut readings);
    // No beam points straight ahead: the two in the middle are half an increment to either side.
    let half_increment_rad = 0.5 * (270.0 / 359.0_f64).to_radians();
    let ahead = 3.755 / libm::cos(half_increment_rad);
    for scan in scans(&readings) {
        assert_ranges(&scan.ranges_m[179..181], &[ahead, ahead]);
    }
    assert_eq!(scans(&readings).map(|scan| scan.laser).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn a_scan_sees_a_disc_approach() {
    let mut config = eight_beams();
    config.obstacles.push(ObstacleConfig {
        name: "person".to_owned(),
        shape: Shape::Disc { radius_m: 0.25 },
        pose: pose(7.0, 3.0, 0.0),
        motion: ObstacleMotion::Route {
            waypoints: vec![maps::Point::new(3.0, 3.0)],
            speed_mps: 1.0,
            end: RouteEnd::Stop,
        },
    });
    let mut sim = in_a_room(&config, pose(2.0, 3.0, 0.0));
    let readings = drive(&mut sim, 0.0, 0.0, 150);
    for scan in scans(&readings) {
        let expected = 4.75 - scan.time.as_secs_f64();
        let ahead = f64::from(scan.ranges_m[4]);
        assert!((ahead - expected).abs() < 1e-5, "{ahead} instead of {expected} after {:?}", scan.time);
        assert!((f64::from(scan.ranges_m[0]) - 2.0).abs() < 1e-5, "the wall behind is still there");
    }
}

#[test]
fn a_box_is_seen_with_its_heading_and_hidden_behind_a_wall() {
    let crate_at = |x_m: f64| ObstacleConfig {
        name: "crate".to_owned(),
        shape: Shape::Box { length_m: 2.0, width_m: 0.5 },
        pose: pose(x_m, 3.0, std::f64::consts::FRAC_PI_2),
        motion: ObstacleMotion::Fixed,
    };
    let seen = SimConfig { obstacles: vec![crate_at(5.0)], ..eight_beams() };
    assert_ranges(&first_ranges(&seen, &room(8.0, 6.0), pose(2.0, 3.0, 0.0))[4..5], &[2.75]);
    let hidden = SimConfig { obstacles: vec![crate_at(9.0)], ..eight_beams() };
    assert_ranges(&first_ranges(&hidden, &room(8.0, 6.0), pose(2.0, 3.0, 0.0))[4..5], &[6.0]);
}
