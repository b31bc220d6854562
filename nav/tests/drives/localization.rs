//! Localization on drives of about 60 m.

use std::time::Duration;

use maps::{Cell, Pose, heading, pose, wrap_angle};
use nalgebra::{Matrix3, Vector3};
use nav::{InitialPose, Localization, LocalizationParameters, PoseEstimate};
use robot::{LaserScan, Odometry, Streams, VelocityCommand};

use crate::floor::{fill, office, round_trip};
use crate::unicycle::{Noise, Unicycle, towards};

/// The errors of estimates.
#[derive(Debug, Default)]
struct Errors {
    squared_m2: f64,
    squared_rad2: f64,
    greatest_m: f64,
    last_m: f64,
    /// Sum of the squared errors in deviations of the estimate's covariance.
    normalized_squared: f64,
    count: f64,
}

impl Errors {
    fn add(&mut self, truth: &Pose, estimate: &PoseEstimate) {
        let way = truth.translation.vector - estimate.pose.translation.vector;
        let off_rad = wrap_angle(heading(truth) - heading(&estimate.pose));
        let off = way.push(off_rad);
        let information = estimate.covariance.try_inverse().expect("something is always uncertain");
        self.squared_m2 += way.norm_squared();
        self.squared_rad2 += off_rad * off_rad;
        self.greatest_m = self.greatest_m.max(way.norm());
        self.last_m = way.norm();
        self.normalized_squared += off.dot(&(information * off));
        self.count += 1.0;
    }

    fn rmse_m(&self) -> f64 {
        (self.squared_m2 / self.count).sqrt()
    }

    fn rmse_rad(&self) -> f64 {
        (self.squared_rad2 / self.count).sqrt()
    }
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let honesty = self.normalized_squared / self.count;
        let Self { greatest_m, last_m, .. } = self;
        let (rmse_m, rmse_rad) = (self.rmse_m(), self.rmse_rad());
        write!(
            f,
            "rmse {rmse_m:.4} m {rmse_rad:.5} rad, greatest {greatest_m:.4} m, last {last_m:.4} m, NEES {honesty:.2}"
        )
    }
}

fn localization(robot: &Unicycle, initial: &InitialPose, seed: u64) -> Localization {
    let rng = Streams::new(seed).stream("localization");
    let parameters = LocalizationParameters::default();
    Localization::new(&office(), &robot.model, parameters, initial, rng).expect("the parameters are valid")
}

/// Processes all of the robot's sensor data.
fn sense(localization: &mut Localization, robot: &mut Unicycle) {
    localization.odometry(&robot.odometry());
    for scan in robot.scans() {
        localization.scan(&scan);
    }
}

/// Drives the round trip by the true pose and returns the errors of the estimates.
fn drive(robot: &mut Unicycle, localization: &mut Localization) -> Errors {
    let mut errors = Errors::default();
    let (path, mut next) = (round_trip(), 0);
    while next < path.len() {
        let command = towards(&path, &mut next, &robot.truth);
        robot.step(command);
        sense(localization, robot);
        errors.add(&robot.truth, &localization.estimate());
    }
    errors
}

#[test]
fn with_exact_sensors_the_error_is_millimeters() {
    let start = pose(2.7, 3.5, 1.0);
    for seed in 0..3 {
        let mut robot = Unicycle::new(office(), start, Noise::default());
        let mut localization = localization(&robot, &InitialPose::at(start), seed);
        let errors = drive(&mut robot, &mut localization);
        println!("{:.1} m: {errors}", robot.driven_m);
        assert!(robot.driven_m > 50.0);
        assert!(errors.rmse_m() < 0.003 && errors.rmse_rad() < 0.001 && errors.greatest_m < 0.02, "{errors}");
    }
}

#[test]
fn with_bad_odometry_and_noisy_lasers_the_error_is_below_a_centimeter() {
    let start = pose(2.7, 3.5, 1.0);
    for seed in 0..3 {
        let noise = Noise { drift: 0.05, scatter: 0.2, laser_m: 0.01 };
        let mut robot = Unicycle::new(office(), start, noise);
        let off = pose(2.7 + 0.15, 3.5 - 0.1, 1.05);
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.005));
        let initial = InitialPose::Near { pose: off, covariance };
        let mut localization = localization(&robot, &initial, seed);
        let errors = drive(&mut robot, &mut localization);
        println!("{:.1} m: {errors}", robot.driven_m);
        assert!(errors.rmse_m() < 0.012 && errors.rmse_rad() < 0.0055, "{errors}");
        // Three on average if the covariance is exact; more if it is overconfident.
        let honesty = errors.normalized_squared / errors.count;
        assert!((1.5..6.0).contains(&honesty), "{honesty}");
    }
}

#[test]
fn a_robot_with_several_possible_poses_reports_them() {
    let mut robot = Unicycle::new(office(), pose(2.7, 3.5, 1.0), Noise::default());
    let mut localization = localization(&robot, &InitialPose::Anywhere, 1);
    assert_eq!(localization.doubt(), 1.0);
    while localization.updates() == 0 {
        robot.step(VelocityCommand::STOP);
        sense(&mut localization, &mut robot);
    }
    // Rooms look alike.
    let hypotheses = localization.hypotheses();
    assert!(hypotheses.len() > 1, "{hypotheses:?}");
    assert!((hypotheses.iter().map(|one| one.weight).sum::<f64>() - 1.0).abs() < 1e-9);
    assert!(hypotheses.windows(2).all(|pair| pair[0].weight >= pair[1].weight));
    let drive = drive(&mut robot, &mut localization);
    assert!(drive.last_m < 0.1 && localization.hypotheses()[0].weight > 0.95, "{drive}");
}

#[test]
fn unmapped_furniture_does_little_harm() {
    let start = pose(2.7, 3.5, 1.0);
    let mut world = office();
    for box_number in 0..14 {
        let x = 1.0 + 1.9 * f64::from(box_number);
        fill(&mut world, [x, 8.15, x + 0.6, 8.55], Cell::Occupied);
        fill(&mut world, [x + 0.4, 17.5, x + 0.9, 18.0], Cell::Occupied);
        fill(&mut world, [x, 20.9, x + 0.8, 21.6], Cell::Occupied);
    }
    let mut robot = Unicycle::new(world, start, Noise { drift: 0.02, scatter: 0.05, laser_m: 0.01 });
    let mut localization = localization(&robot, &InitialPose::at(start), 1);
    let errors = drive(&mut robot, &mut localization);
    println!("{:.1} m: {errors}", robot.driven_m);
    assert!(errors.rmse_m() < 0.05 && errors.rmse_rad() < 0.01 && errors.greatest_m < 0.2, "{errors}");
    // The effect of furniture on a scan is not noise: it is consistent for meters.
    assert!(errors.normalized_squared / errors.count < 12.0, "{errors}");
}

#[test]
fn a_kidnapped_robot_relocalizes() {
    for (seed, elsewhere) in [pose(25.1, 3.0, -2.0), pose(2.7, 19.9, 0.5), pose(5.0, 19.9, 3.0)].into_iter().enumerate()
    {
        let start = pose(2.7, 3.5, 1.0);
        let mut robot = Unicycle::new(office(), start, Noise::default());
        let mut localization = localization(&robot, &InitialPose::at(start), seed as u64);
        for _ in 0..500 {
            robot.step(VelocityCommand { linear_mps: 0.0, angular_radps: 0.5 });
            sense(&mut localization, &mut robot);
        }
        robot.truth = elsewhere;
        assert!(localization.doubt() < 0.05, "all was well before");
        let (mut found_after_s, mut noticed_after_s) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..2000 {
            robot.step(VelocityCommand { linear_mps: 0.2, angular_radps: 0.4 });
            sense(&mut localization, &mut robot);
            let off = robot.truth.translation.vector - localization.estimate().pose.translation.vector;
            let after_s = (robot.time - Duration::from_secs(10)).as_secs_f64();
            if localization.doubt() > 0.2 {
                noticed_after_s = after_s.min(noticed_after_s);
            }
            found_after_s = if off.norm() < 0.1 { found_after_s.min(after_s) } else { f64::INFINITY };
        }
        println!("noticed after {noticed_after_s:.1} s, found after {found_after_s:.1} s");
        assert!(noticed_after_s < 8.0 && noticed_after_s < found_after_s);
        assert!(found_after_s < 35.0, "{elsewhere}");
    }
}

#[test]
fn failing_lasers_are_no_reason_to_believe_another_pose() {
    let start = pose(2.7, 3.5, 1.0);
    let mut robot = Unicycle::new(office(), start, Noise::default());
    let mut localization = localization(&robot, &InitialPose::at(start), 1);
    let turn = |robot: &mut Unicycle, localization: &mut Localization, steps: u32| {
        for _ in 0..steps {
            robot.step(VelocityCommand { linear_mps: 0.2, angular_radps: 0.4 });
            sense(localization, robot);
        }
    };
    turn(&mut robot, &mut localization, 500);
    robot.noise.laser_m = 0.5;
    turn(&mut robot, &mut localization, 3000);
    let off_m = (robot.truth.translation.vector - localization.estimate().pose.translation.vector).norm();
    assert!(off_m < 0.5, "{off_m} m off");
}

#[test]
fn a_robot_kidnapped_at_rest_notices_and_relocalizes_once_it_drives() {
    for (seed, elsewhere) in [pose(25.1, 3.0, -2.0), pose(2.7, 19.9, 0.5), pose(13.9, 9.3, 0.3)].into_iter().enumerate()
    {
        let start = pose(2.7, 3.5, 1.0);
        let mut robot = Unicycle::new(office(), start, Noise { laser_m: 0.01, ..Noise::default() });
        let mut localization = localization(&robot, &InitialPose::at(start), seed as u64);
        let mut after = |robot: &mut Unicycle, steps: u32, command: VelocityCommand| {
            for _ in 0..steps {
                robot.step(command);
                sense(&mut localization, robot);
            }
            let off = robot.truth.translation.vector - localization.estimate().pose.translation.vector;
            (localization.doubt(), off.norm())
        };
        assert_eq!(after(&mut robot, 500, VelocityCommand::STOP).0, 0.0, "all was well before");
        robot.truth = elsewhere;
        let (doubt, _) = after(&mut robot, 250, VelocityCommand::STOP);
        assert_eq!(doubt, 1.0, "{elsewhere}: not noticed within 5 s");
        let (_, off_m) = after(&mut robot, 1000, VelocityCommand { linear_mps: 0.3, angular_radps: 0.6 });
        assert!(off_m < 0.1, "{elsewhere}: {off_m} m off");
    }
}

#[test]
fn a_robot_without_an_initial_pose_localizes() {
    let mut found = 0;
    for seed in 0..5 {
        let start = pose(2.7, 3.5, 1.0);
        let mut robot = Unicycle::new(office(), start, Noise::default());
        let mut localization = localization(&robot, &InitialPose::Anywhere, seed);
        let errors = drive(&mut robot, &mut localization);
        println!("{:.1} m: {errors}", robot.driven_m);
        found += u32::from(errors.last_m < 0.1);
    }
    assert!(found == 5, "{found} of 5");
}

#[test]
fn a_robot_at_rest_keeps_its_estimate() {
    let start = pose(13.9, 9.3, 0.3);
    let mut robot = Unicycle::new(office(), start, Noise { laser_m: 0.02, ..Noise::default() });
    let mut localization = localization(&robot, &InitialPose::at(start), 1);
    for _ in 0..10 {
        robot.step(VelocityCommand::STOP);
        sense(&mut localization, &mut robot);
    }
    let (before, updates) = (localization.estimate().pose, localization.updates());
    for _ in 0..500 {
        robot.step(VelocityCommand::STOP);
        sense(&mut localization, &mut robot);
        assert_eq!(localization.estimate().pose, before);
    }
    assert_eq!(localization.updates(), updates);
}

#[test]
fn readings_that_are_not_finite_are_harmless() {
    let start = pose(2.7, 3.5, 1.0);
    let mut robot = Unicycle::new(office(), start, Noise::default());
    let mut localization = localization(&robot, &InitialPose::at(start), 1);
    let poses = [f64::NAN, f64::INFINITY].map(|x| pose(x, 0.0, 0.0)).into_iter().chain([pose(0.0, 0.0, f64::NAN)]);
    for (step, broken) in poses.cycle().take(300).enumerate() {
        robot.step(VelocityCommand { linear_mps: 0.2, angular_radps: 0.4 });
        let odometry = robot.odometry();
        localization.odometry(&Odometry { pose: broken, ..odometry });
        localization.odometry(&Odometry { angular_radps: f64::NAN, ..odometry });
        localization.odometry(&odometry);
        for mut scan in robot.scans() {
            let silly = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX];
            scan.ranges_m.iter_mut().skip(step % 7).step_by(7).for_each(|range_m| *range_m = silly[step % 5]);
            localization.scan(&scan);
            scan.ranges_m.fill(f32::NAN);
            localization.scan(&scan);
        }
        let estimate = localization.estimate();
        assert!(estimate.covariance.iter().all(|entry| entry.is_finite()) && heading(&estimate.pose).is_finite());
    }
    assert!(localization.particles().all(|(pose, weight)| pose.translation.x.is_finite() && weight.is_finite()));
    let off = robot.truth.translation.vector - localization.estimate().pose.translation.vector;
    assert!(off.norm() < 0.02, "{} m off", off.norm());
}

#[test]
fn scans_that_are_older_than_the_odometry_or_from_the_future_are_ignored() {
    let start = pose(2.7, 3.5, 1.0);
    let mut robot = Unicycle::new(office(), start, Noise::default());
    let mut localization = localization(&robot, &InitialPose::at(start), 1);
    let mut old = None;
    for _ in 0..500 {
        robot.step(VelocityCommand { linear_mps: 0.2, angular_radps: 0.4 });
        localization.odometry(&robot.odometry());
        for scan in robot.scans() {
            old.get_or_insert_with(|| scan.clone());
            let (before, updates) = (localization.estimate().pose, localization.updates());
            if let Some(old) = old.as_ref().filter(|old| old.time + Duration::from_secs(3) < scan.time) {
                localization.scan(old);
            }
            localization.scan(&LaserScan { time: scan.time + Duration::from_secs(1), ..scan.clone() });
            assert_eq!((before, updates), (localization.estimate().pose, localization.updates()));
            localization.scan(&scan);
        }
    }
    let off = robot.truth.translation.vector - localization.estimate().pose.translation.vector;
    assert!(localization.updates() > 20 && off.norm() < 0.02, "{} m off", off.norm());
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_short_range_laser_works_beside_a_long_range_one() {
    let start = pose(2.7, 3.5, 1.0);
    let mut robot = Unicycle::new(office(), start, Noise { drift: 0.05, scatter: 0.2, laser_m: 0.01 });
    robot.model.lasers[1].range_max_m = 1.5;
    let mut localization = localization(&robot, &InitialPose::at(start), 1);
    let errors = drive(&mut robot, &mut localization);
    println!("{errors}");
    assert!(errors.rmse_m() < 0.03 && errors.rmse_rad() < 0.01, "{errors}");
}
