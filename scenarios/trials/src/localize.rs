//! Localization of recorded robots: a log is played back through the robot interface into the same localization that
//! scenarios use, and the estimates are compared with the poses of a SLAM program.
//!
//! [`replay`] returns a [`Course`]: the estimated and the correct pose at each scan. A [`Score`] contains the errors of
//! the estimates, and [`starts`] tries many beginnings. [`fit`] checks whether a map shows the place where a log was
//! recorded.

pub mod fit;
mod score;
pub mod starts;

use std::sync::Arc;
use std::time::Duration;

use maps::{Pose, heading, wrap_angle};
use nalgebra::Matrix3;
use nav::{Atlas, InitialPose, Localization};
use robot::recorded::{OdometryErrors, RecordedRobot, Recording};
use robot::{Reading, Robot, Streams};

pub use score::{Score, Stretch};

/// How a log is played back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Whether localization starts without a pose, instead of from the first corrected pose.
    pub global: bool,
    /// Systematic error of odometry in driving and turning, as a fraction of the motion.
    pub odometry_drift: f64,
    /// Standard deviation of odometry's random error in driving and turning, as a fraction of the motion.
    pub odometry_noise: f64,
    /// Root seed of the particles and of odometry's noise.
    pub seed: u64,
}

/// The estimated and the correct pose at a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Line in the log.
    pub line: usize,
    /// Time since the log's start.
    pub time: Duration,
    /// The pose found by a SLAM program, in the `map` frame.
    pub corrected: Pose,
    /// The estimated pose after the scan, in the `map` frame.
    pub estimate: Pose,
    /// Covariance of the estimate: x, y in meters, heading in radians.
    pub covariance: Matrix3<f64>,
    /// Odometry as given to localization, shifted so that it starts at the first corrected pose.
    pub odometry: Pose,
}

impl Waypoint {
    /// Error of the estimated position, in meters.
    #[must_use]
    pub fn error_m(&self) -> f64 {
        (self.estimate.translation.vector - self.corrected.translation.vector).norm()
    }

    /// Absolute error of the estimated heading, in radians.
    #[must_use]
    pub fn error_rad(&self) -> f64 {
        wrap_angle(heading(&self.estimate) - heading(&self.corrected)).abs()
    }
}

/// A log played back: one waypoint per scan that has a corrected pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// The waypoints, in order.
    pub waypoints: Vec<Waypoint>,
    /// How often localization updated its estimate.
    pub updates: u64,
    /// Whether localization started without a pose.
    pub from_nothing: bool,
}

/// Plays a recording back into localization on a map.
#[must_use]
pub fn replay(recording: &Arc<Recording>, atlas: &Arc<Atlas>, conditions: &Conditions) -> Course {
    replay_part(recording, atlas, conditions, RecordingPart { first: 0, driven_m: f64::INFINITY })
}

/// A part of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordingPart {
    /// The scan at which it begins, among those with a corrected pose, counted from 0.
    pub first: usize,
    /// It ends when the robot has driven this far, in meters.
    pub driven_m: f64,
}

/// Plays a part of a recording back into localization on a map.
#[must_use]
pub fn replay_part(
    recording: &Arc<Recording>,
    atlas: &Arc<Atlas>,
    conditions: &Conditions,
    part: RecordingPart,
) -> Course {
    let streams = Streams::new(conditions.seed);
    let Some((start, _, first_pose)) = recording.corrected_scans().nth(part.first) else { return Course::default() };
    let initial = if conditions.global { InitialPose::Anywhere } else { InitialPose::at(first_pose) };
    let mut localization = Localization::on(atlas, &initial, streams.stream("nav/localization"));
    let errors = streams.stream("localize/odometry");
    let errors = OdometryErrors::new(conditions.odometry_drift, conditions.odometry_noise, errors);
    let mut robot = RecordedRobot::new(Arc::clone(recording), errors).from_line(start.line);
    let mut readings = Vec::new();
    let mut odom_to_map = None;
    let mut course = Course { from_nothing: conditions.global, ..Course::default() };
    let mut driven_m = 0.0;
    while let Some(record) = robot.advance() {
        let (line, time, corrected) = (record.line, record.time, record.corrected);
        robot.read(&mut readings);
        let odometry = take(&mut localization, &mut readings);
        if let (Some(corrected), Some(odometry)) = (corrected, odometry) {
            let before = course.waypoints.last().map_or(corrected, |before| before.corrected);
            driven_m += (corrected.translation.vector - before.translation.vector).norm();
            if driven_m > part.driven_m {
                break;
            }
            // For comparison: where the robot would be by odometry alone, from the first corrected pose on.
            let odom_to_map = odom_to_map.get_or_insert_with(|| corrected * odometry.inverse());
            let estimate = localization.estimate();
            let (covariance, odometry) = (estimate.covariance, *odom_to_map * odometry);
            course.waypoints.push(Waypoint { line, time, corrected, estimate: estimate.pose, covariance, odometry });
        }
    }
    course.updates = localization.updates();
    course
}

/// Passes readings on. Returns the pose of the odometry among them.
fn take(localization: &mut Localization, readings: &mut Vec<Reading>) -> Option<Pose> {
    let mut odometry = None;
    for reading in readings.drain(..) {
        match reading {
            Reading::Odometry(reading) => {
                localization.odometry(&reading);
                odometry = Some(reading.pose);
            }
            Reading::Scan(scan) => {
                localization.scan(&scan);
            }
            Reading::Battery(_) => {}
        }
    }
    odometry
}
