//! Navigation with localization in the loop, and without.

use std::time::Duration;

use maps::{Cell, OccupancyGrid, Place, Point, Pose, heading, pose, wrap_angle};
use nalgebra::Matrix3;
use nav::{
    GiveUpReason, Goal, InitialPose, Localization, LocalizationParameters, NavigationParameters, NavigationStatus,
    Navigator, PlanError, PoseEstimate,
};
use rand::RngExt;
use robot::Streams;

use crate::floor::{fill, hall, office, two_rooms};
use crate::unicycle::{Noise, Unicycle};

/// A robot with its software.
struct Drive {
    robot: Unicycle,
    localization: Localization,
    navigator: Navigator,
    statuses: Vec<NavigationStatus>,
    /// The least distance between the body and anything solid.
    closest_m: f64,
}

impl Drive {
    /// In a world that matches the map.
    fn new(map: OccupancyGrid, at: Pose) -> Self {
        let world = map.clone();
        Self::in_world(&map, world, at)
    }

    fn in_world(map: &OccupancyGrid, world: OccupancyGrid, at: Pose) -> Self {
        let robot = Unicycle::new(world, at, Noise::default());
        let rng = Streams::new(1).stream("localization");
        let parameters = LocalizationParameters::default();
        let localization = Localization::new(map, &robot.model, parameters, &InitialPose::at(at), rng)
            .expect("the parameters are valid");
        let navigator = Navigator::new(map, &robot.model, NavigationParameters::of(&robot.model))
            .expect("the parameters are valid");
        Self { robot, localization, navigator, statuses: Vec::new(), closest_m: f64::INFINITY }
    }

    fn step(&mut self) {
        let odometry = self.robot.odometry();
        self.localization.odometry(&odometry);
        for scan in self.robot.scans() {
            self.localization.scan(&scan);
            self.navigator.scan(&scan, &self.localization.estimate());
        }
        let command = self.navigator.update(self.robot.time, &self.localization.estimate(), &odometry);
        if self.statuses.last() != Some(&self.navigator.status()) {
            self.statuses.push(self.navigator.status());
        }
        self.robot.step(command);
        self.closest_m = self.closest_m.min(self.robot.clearance_m());
    }

    /// Drives until there is an outcome, at most for this time; returns the outcome and the time taken.
    fn go(&mut self, goal: Goal, at_most_s: u64) -> (NavigationStatus, Duration) {
        self.statuses.clear();
        self.navigator.start(goal);
        self.statuses.push(self.navigator.status());
        let start = self.robot.time;
        while self.navigator.status().is_under_way() && self.robot.time - start < Duration::from_secs(at_most_s) {
            self.step();
        }
        (self.navigator.status(), self.robot.time - start)
    }

    fn off_by(&self, goal: &Goal) -> (f64, f64) {
        let off_m = (Point::from(self.robot.truth.translation.vector) - goal.position).norm();
        let off_rad = goal.heading_rad.map_or(0.0, |wanted| wrap_angle(wanted - heading(&self.robot.truth)).abs());
        (off_m, off_rad)
    }
}

fn goal(x: f64, y: f64, heading_rad: f64) -> Goal {
    Goal::at(Point::new(x, y), Some(heading_rad))
}

#[test]
fn a_hundred_goals_in_the_open_are_reached() {
    let mut drive = Drive::new(hall(7.0, 6.0), pose(3.0, 3.0, 0.0));
    let mut rng = Streams::new(4).stream("goals");
    let mut random = |least: f64, most: f64| least + (most - least) * rng.random::<f64>();
    let mut worst = (0.0_f64, 0.0_f64, Duration::ZERO);
    for number in 0..100 {
        // Every third goal is just beside where the robot stands.
        let around = drive.robot.truth.translation;
        let near = number % 3 == 0;
        let x = if near { (around.x + random(-0.25, 0.25)).clamp(0.6, 6.4) } else { random(0.6, 6.4) };
        let y = if near { (around.y + random(-0.25, 0.25)).clamp(0.6, 5.4) } else { random(0.6, 5.4) };
        let goal = goal(x, y, random(-3.1, 3.1));
        let (status, took) = drive.go(goal.clone(), 60);
        assert_eq!(status, NavigationStatus::GoalReached, "goal {number}: {:?}", drive.navigator.reason());
        let off = drive.off_by(&goal);
        assert!(off.0 < 0.06 && off.1 < 0.02, "goal {number} missed by {off:?}");
        worst = (worst.0.max(off.0), worst.1.max(off.1), worst.2.max(took));
    }
    println!("worst: {worst:?}, closest {:.3} m, {:?} simulated", drive.closest_m, drive.robot.time);
    assert!(drive.closest_m > 0.05, "{} m from a wall", drive.closest_m);
    assert!(worst.2 < Duration::from_secs(45), "hunting for the goal: {:?}", worst.2);
}

#[test]
fn doorways_are_passed_without_contact() {
    for (doorway_m, trips) in [(1.0, 10), (0.8, 10)] {
        let mut drive = Drive::new(two_rooms(doorway_m), pose(1.0, 1.0, 0.0));
        let mut rng = Streams::new(5).stream("goals");
        let mut random = |least: f64, most: f64| least + (most - least) * rng.random::<f64>();
        for trip in 0..trips {
            let left = if trip % 2 == 0 { 4.8 } else { 0.6 };
            let goal = goal(left + random(0.0, 2.6), random(0.6, 4.4), random(-3.1, 3.1));
            let (status, took) = drive.go(goal.clone(), 90);
            assert_eq!(status, NavigationStatus::GoalReached, "{doorway_m} m, trip {trip} after {took:?}");
            assert!(drive.off_by(&goal).0 < 0.06);
        }
        println!("{doorway_m} m: closest {:.3} m, {:?} simulated", drive.closest_m, drive.robot.time);
        assert!(drive.closest_m > 0.01, "{doorway_m} m: {} m from a wall", drive.closest_m);
    }
}

#[test]
fn a_trip_across_the_office_goes_through_the_statuses_in_order() {
    let mut drive = Drive::new(office(), pose(2.7, 3.5, 0.0));
    let goal = goal(25.1, 13.0, 1.0);
    let (status, took) = drive.go(goal.clone(), 300);
    use NavigationStatus::{GoalReached, Moving, PreparingBeforeMove, Thinking};
    println!("{:.1} m in {took:?}, closest {:.3} m", drive.robot.driven_m, drive.closest_m);
    assert_eq!(drive.statuses, [Thinking, PreparingBeforeMove, Moving, GoalReached]);
    assert_eq!(status, GoalReached);
    assert!(drive.off_by(&goal).0 < 0.06 && drive.off_by(&goal).1 < 0.02, "{:?}", drive.off_by(&goal));
    assert!(drive.closest_m > 0.1);
    for _ in 0..100 {
        drive.step();
    }
    assert_eq!(drive.navigator.status(), GoalReached, "the outcome stays");
    drive.navigator.stop();
    assert_eq!(drive.navigator.status(), NavigationStatus::Idle);
}

#[test]
fn an_unmapped_obstacle_is_avoided() {
    let map = hall(10.0, 5.0);
    let mut world = map.clone();
    fill(&mut world, [4.5, 1.6, 5.2, 3.4], Cell::Occupied);
    let mut drive = Drive::in_world(&map, world, pose(1.0, 2.5, 0.0));
    let goal = goal(9.0, 2.5, 0.0);
    let (status, took) = drive.go(goal, 120);
    println!("{took:?}, closest {:.3}, {:?}", drive.closest_m, drive.statuses);
    assert_eq!(status, NavigationStatus::GoalReached, "{:?}", drive.navigator.reason());
    assert!(drive.closest_m > 0.02, "{} m", drive.closest_m);
}

#[test]
fn a_blocked_corridor_causes_a_detour() {
    // Two corridors from left to right; the shorter one is blocked.
    let mut map = hall(14.0, 8.0);
    fill(&mut map, [3.0, 1.8, 11.0, 6.0], Cell::Occupied);
    let mut world = map.clone();
    fill(&mut world, [7.0, 0.0, 7.5, 1.8], Cell::Occupied);
    let mut drive = Drive::in_world(&map, world, pose(1.0, 1.0, 0.0));
    let (status, took) = drive.go(goal(13.0, 1.0, 0.0), 180);
    println!("{took:?}, closest {:.3}, {:?}", drive.closest_m, drive.statuses);
    assert_eq!(status, NavigationStatus::GoalReached, "{:?}", drive.navigator.reason());
    assert!(drive.statuses.contains(&NavigationStatus::WaitingObstacle), "it waits before it takes such a long detour");
    assert!(drive.closest_m > 0.02);
}

#[test]
fn the_robot_waits_for_a_person_who_steps_aside() {
    let map = hall(12.0, 1.6);
    let mut world = map.clone();
    fill(&mut world, [5.0, 0.5, 5.4, 1.1], Cell::Occupied);
    let mut drive = Drive::in_world(&map, world, pose(1.0, 0.8, 0.0));
    drive.navigator.start(goal(11.0, 0.8, 0.0));
    while drive.navigator.status() != NavigationStatus::WaitingObstacle {
        drive.step();
        assert!(drive.robot.time < Duration::from_secs(30));
    }
    (0..100).for_each(|_| drive.step());
    let stopped_at = drive.robot.truth.translation.x;
    assert!(stopped_at < 4.7 && stopped_at > 3.0, "{stopped_at}");
    drive.robot.world = map;
    while drive.navigator.status().is_under_way() {
        drive.step();
        assert!(drive.robot.time < Duration::from_secs(60));
    }
    assert_eq!(drive.navigator.status(), NavigationStatus::GoalReached);
    assert!(!drive.statuses.contains(&NavigationStatus::Failing));
}

#[test]
fn a_redirected_robot_stops_as_fast_as_it_can() {
    let mut drive = Drive::new(hall(10.0, 5.0), pose(1.0, 2.5, 0.0));
    drive.navigator.start(goal(9.0, 2.5, 0.0));
    (0..200).for_each(|_| drive.step());
    let (speed_mps, driven_m) = (drive.robot.velocity.linear_mps, drive.robot.driven_m);
    assert!(speed_mps > 0.44);
    drive.navigator.start(goal(1.0, 1.0, 3.0));
    while drive.robot.velocity.linear_mps > 0.0 {
        let before_mps = drive.robot.velocity.linear_mps;
        drive.step();
        assert!(drive.robot.velocity.linear_mps < before_mps, "drives on at {before_mps} m/s");
    }
    let braking_m = speed_mps * speed_mps / (2.0 * drive.robot.model.max_linear_acceleration_mps2);
    let rolled_m = drive.robot.driven_m - driven_m;
    assert!(rolled_m < braking_m + 0.02, "{rolled_m} m, but {braking_m} m are enough");
}

#[test]
fn a_closed_door_ends_in_a_reason_in_bounded_time() {
    let mut world = two_rooms(1.0);
    fill(&mut world, [4.0, 0.0, 4.2, 5.0], Cell::Occupied);
    let mut drive = Drive::in_world(&two_rooms(1.0), world, pose(1.0, 1.0, 0.0));
    let (status, took) = drive.go(goal(7.0, 2.5, 0.0), 180);
    println!("{took:?}, closest {:.3}, {:?}", drive.closest_m, drive.statuses);
    assert_eq!(status, NavigationStatus::Aborted);
    assert_eq!(drive.navigator.reason(), Some(GiveUpReason::NoPlan(PlanError::NoPath)));
    assert!(drive.statuses.contains(&NavigationStatus::Failing));
    assert!(took < Duration::from_secs(130));
}

#[test]
fn unreachable_goals_are_refused_at_once_with_a_reason() {
    let mut map = hall(6.0, 5.0);
    fill(&mut map, [3.0, 0.0, 3.2, 5.0], Cell::Occupied);
    fill(&mut map, [1.0, 4.0, 2.0, 5.0], Cell::Unknown);
    let reason = |x, y| {
        let mut drive = Drive::new(map.clone(), pose(1.0, 1.0, 0.0));
        let (status, took) = drive.go(goal(x, y, 0.0), 60);
        assert_eq!(status, NavigationStatus::Aborted);
        assert!(took < Duration::from_millis(100));
        assert_eq!(drive.navigator.trips_given_up(), 1);
        drive.navigator.reason().unwrap().to_string()
    };
    assert_eq!(reason(4.5, 2.5), "there is no path to the goal");
    assert_eq!(reason(1.5, 4.5), "the goal is in unknown space of the map");
    assert_eq!(reason(9.0, 2.5), "the goal is outside the map");
    assert_eq!(reason(2.875, 2.5), "the goal is 0.125 m from an obstacle, but the robot needs 0.325 m");
}

#[test]
fn an_area_is_entered_even_if_its_centroid_is_blocked() {
    let mut map = hall(8.0, 5.0);
    fill(&mut map, [5.7, 2.0, 6.3, 3.0], Cell::Occupied);
    let corners = [(4.5, 1.0), (7.5, 1.0), (7.5, 4.0), (4.5, 4.0)].map(|(x, y)| Point::new(x, y)).to_vec();
    let area = Place::Area { corners };
    let mut drive = Drive::new(map, pose(1.0, 2.5, 0.0));
    let (status, _) = drive.go(Goal::to(&area), 60);
    assert_eq!(status, NavigationStatus::GoalReached);
    assert!(area.contains(&drive.robot.truth));
    assert!(drive.closest_m > 0.0);
}

#[test]
fn a_pushed_robot_replans() {
    let mut drive = Drive::new(hall(10.0, 6.0), pose(1.0, 3.0, 0.0));
    drive.navigator.start(goal(9.0, 3.0, 0.0));
    (0..300).for_each(|_| drive.step());
    let before = drive.navigator.path().to_vec();
    for _ in 0..300 {
        // A person drives it by joypad; the navigator's commands are not followed.
        let odometry = drive.robot.odometry();
        drive.localization.odometry(&odometry);
        for scan in drive.robot.scans() {
            drive.localization.scan(&scan);
            drive.navigator.scan(&scan, &drive.localization.estimate());
        }
        drive.navigator.update(drive.robot.time, &drive.localization.estimate(), &odometry);
        drive.robot.step(robot::VelocityCommand { linear_mps: 0.3, angular_radps: 0.4 });
    }
    assert_ne!(drive.navigator.path(), before);
    while drive.navigator.status().is_under_way() {
        drive.step();
        assert!(drive.robot.time < Duration::from_secs(90));
    }
    assert_eq!(drive.navigator.status(), NavigationStatus::GoalReached);
}

#[test]
fn silent_lasers_and_unknown_poses_are_errors() {
    let mut drive = Drive::new(hall(6.0, 5.0), pose(1.0, 1.0, 0.0));
    drive.navigator.start(goal(4.0, 4.0, 0.0));
    (0..100).for_each(|_| drive.step());
    let estimate = drive.localization.estimate();
    for _ in 0..60 {
        let command = drive.navigator.update(drive.robot.time, &estimate, &drive.robot.odometry());
        drive.robot.step(command);
    }
    assert_eq!(drive.navigator.status(), NavigationStatus::Error);
    assert!(matches!(drive.navigator.reason(), Some(GiveUpReason::NoScans(_))));
    drive.navigator.start(goal(4.0, 4.0, 0.0));
    let lost = PoseEstimate { pose: pose(f64::NAN, 0.0, 0.0), covariance: Matrix3::zeros(), ..estimate };
    drive.navigator.update(drive.robot.time, &lost, &drive.robot.odometry());
    assert_eq!(drive.navigator.reason(), Some(GiveUpReason::BadEstimate));
    drive.navigator.start(goal(f64::INFINITY, 4.0, 0.0));
    assert_eq!(drive.navigator.reason(), Some(GiveUpReason::BadGoal));
}

/// A drive with a laser that falls silent after 2 s.
fn drive_with_a_silent_laser(laser: usize) -> Drive {
    let mut drive = Drive::new(hall(10.0, 5.0), pose(1.0, 2.5, 0.0));
    drive.navigator.start(goal(9.0, 2.5, 0.0));
    while drive.navigator.status().is_under_way() {
        let odometry = drive.robot.odometry();
        drive.localization.odometry(&odometry);
        for scan in drive.robot.scans() {
            if scan.laser != laser || drive.robot.time < Duration::from_secs(2) {
                drive.localization.scan(&scan);
                drive.navigator.scan(&scan, &drive.localization.estimate());
            }
        }
        let command = drive.navigator.update(drive.robot.time, &drive.localization.estimate(), &odometry);
        drive.robot.step(command);
        assert!(drive.robot.time < Duration::from_secs(60));
    }
    drive
}

#[test]
fn a_robot_stops_if_it_is_blind_ahead_but_not_if_it_is_blind_behind() {
    let blind = drive_with_a_silent_laser(0);
    assert_eq!(blind.navigator.status(), NavigationStatus::Error);
    let Some(GiveUpReason::NoScans(silent)) = blind.navigator.reason() else {
        panic!("{:?}", blind.navigator.reason())
    };
    assert!(silent > Duration::from_secs(1) && silent < Duration::from_millis(1100), "{silent:?}");
    assert!(blind.robot.time < Duration::from_millis(3100));
    let seeing = drive_with_a_silent_laser(1);
    assert_eq!(seeing.navigator.status(), NavigationStatus::GoalReached);
}

#[test]
fn noisy_encoder_speeds_do_not_carry_the_robot_past_its_goal() {
    let mut rng = Streams::new(6).stream("speeds");
    let mut drive = Drive::new(hall(6.0, 5.0), pose(1.0, 2.5, 0.0));
    // 5 cm from the wall.
    drive.navigator.start(goal(5.55, 2.5, 0.0));
    while drive.navigator.status().is_under_way() {
        let mut odometry = drive.robot.odometry();
        if odometry.linear_mps > 0.05 {
            odometry.linear_mps += 0.3 * (rng.random::<f64>() - 0.5) + 0.3 * (rng.random::<f64>() - 0.5);
        }
        drive.localization.odometry(&odometry);
        for scan in drive.robot.scans() {
            drive.localization.scan(&scan);
            drive.navigator.scan(&scan, &drive.localization.estimate());
        }
        let command = drive.navigator.update(drive.robot.time, &drive.localization.estimate(), &odometry);
        drive.robot.step(command);
        drive.closest_m = drive.closest_m.min(drive.robot.clearance_m());
        assert!(drive.robot.time < Duration::from_secs(60));
    }
    assert_eq!(drive.navigator.status(), NavigationStatus::GoalReached);
    assert!(drive.closest_m > 0.01, "{} m from the wall", drive.closest_m);
}

#[test]
fn a_robot_without_a_path_tries_all_recovery_behaviors() {
    use nav::Recovery::{BackUp, ClearCostmap, Spin, Wait};
    let map = two_rooms(1.0);
    let mut world = map.clone();
    fill(&mut world, [4.0, 0.0, 4.2, 5.0], Cell::Occupied);
    let mut drive = Drive::in_world(&map, world, pose(1.0, 1.0, 0.0));
    drive.navigator.start(goal(7.0, 2.5, 0.0));
    let mut seen = Vec::new();
    let mut backwards_m: f64 = 0.0;
    while !seen.contains(&Spin) && drive.robot.time < Duration::from_secs(60) {
        let before = drive.robot.truth;
        drive.step();
        if let Some(recovery) = drive.navigator.recovery() {
            backwards_m += (-before.inv_mul(&drive.robot.truth).translation.x).max(0.0);
            if seen.last() != Some(&recovery) {
                seen.push(recovery);
            }
        }
    }
    assert_eq!(seen, [ClearCostmap, Wait, BackUp, ClearCostmap, Spin]);
    assert!(backwards_m > 0.25 && backwards_m < 0.4, "{backwards_m} m");
    // The door opens.
    drive.robot.world = map;
    while drive.navigator.status().is_under_way() {
        drive.step();
        assert!(drive.robot.time < Duration::from_secs(120));
    }
    assert_eq!((drive.navigator.status(), drive.navigator.recovery()), (NavigationStatus::GoalReached, None));
    assert!(drive.closest_m > 0.0);
}
