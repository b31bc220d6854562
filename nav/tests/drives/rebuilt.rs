//! Localization with removed walls.

use maps::{Cell, OccupancyGrid, pose};
use nav::{InitialPose, Localization, LocalizationParameters};
use robot::Streams;

use crate::floor::{fill, office, round_trip};
use crate::unicycle::{Noise, Unicycle, towards};

/// Distance between two scans, in meters: as in logs with few scans.
const BETWEEN_SCANS_M: f64 = 1.0;

/// The office after a wall along each of two corridors was removed, with new furniture in the rooms, which look alike.
fn rebuilt_office() -> OccupancyGrid {
    let mut world = office();
    fill(&mut world, [3.5, 10.5, 13.5, 10.65], Cell::Free);
    fill(&mut world, [15.5, 18.0, 27.0, 18.15], Cell::Free);
    for room in 0..5 {
        let left = 5.6 * f64::from(room);
        fill(&mut world, [left + 1.5, 11.2, left + 3.9, 12.2], Cell::Occupied);
        fill(&mut world, [left + 1.5, 5.0, left + 3.0, 6.7], Cell::Occupied);
    }
    world
}

/// The largest error of the estimate on the round trip, in meters, and whether there was a search.
fn drive(robot: &mut Unicycle, localization: &mut Localization) -> (f64, bool) {
    let (path, mut next) = (round_trip(), 0);
    let (mut worst_m, mut is_sought) = (0.0_f64, false);
    let mut seen_at_m = f64::NEG_INFINITY;
    while next < path.len() {
        let command = towards(&path, &mut next, &robot.truth);
        robot.step(command);
        localization.odometry(&robot.odometry());
        if robot.driven_m - seen_at_m >= BETWEEN_SCANS_M {
            for scan in robot.scans() {
                localization.scan(&scan);
                seen_at_m = robot.driven_m;
            }
        }
        let off_m = (robot.truth.translation.vector - localization.estimate().pose.translation.vector).norm();
        worst_m = worst_m.max(off_m);
        is_sought |= localization.doubt() >= 1.0;
    }
    (worst_m, is_sought)
}

#[test]
fn a_robot_is_not_lost_during_a_search_caused_by_removed_walls() {
    let start = pose(2.7, 3.5, 1.0);
    for seed in 0..4 {
        let noise = Noise { drift: 0.05, scatter: 0.2, laser_m: 0.01 };
        let mut robot = Unicycle::new(rebuilt_office(), start, noise);
        let rng = Streams::new(seed).stream("localization");
        let parameters = LocalizationParameters::default();
        let mut localization = Localization::new(&office(), &robot.model, parameters, &InitialPose::at(start), rng)
            .expect("the parameters are valid");
        let (worst_m, is_sought) = drive(&mut robot, &mut localization);
        println!("seed {seed}: {worst_m:.2} m off at most");
        assert!(is_sought, "seed {seed}: this test needs a search");
        assert!(worst_m < 0.5, "seed {seed}: {worst_m} m off");
    }
}
