//! Recorded robots: logs of real ones, played back.
//!
//! A [`Recording`] is read from a log in CARMEN's format, which most published logs use, plain or gzipped. A
//! [`RecordedRobot`] plays it back as a [`Robot`], so software can be tried on real sensor data; [`OdometryErrors`]
//! make its odometry as bad as desired.
//!
//! Fields of a line are separated by spaces:
//!
//! - `FLASER n r1 … rn x y theta odom_x odom_y odom_theta time host logger_time`: a scan of the front laser, the pose
//!   of the laser according to a SLAM program, and the robot's odometry. `RLASER` is the same for the rear laser.
//!   Further fields are ignored.
//! - `ODOM x y theta tv rv accel time host logger_time`: odometry.
//! - `PARAM name value …`: `robot_frontlaser_offset` and `robot_rearlaser_offset` are the lasers' positions on the x
//!   axis, `robot_front_laser_max` is the range that stands for "no hit".
//! - Comments (`#`) and lines that begin with another word in capitals are ignored.
//!
//! Beams go from −90° counter-clockwise over 180°: with an odd number there is one at either end, with an even number
//! there is none at +90°.
//!
//! The [`Complaint`]s about a log name what is wrong with it and what was done about it.

mod clock;
mod complaint;
mod jumps;
mod lines;
mod odometry_errors;
mod ranges;
mod text;
mod writer;

use std::sync::Arc;
use std::time::Duration;

use maps::{Pose, pose};

use crate::{LaserScan, LaserSpec, Odometry, Reading, Robot, RobotModel, VelocityCommand};
use complaint::Complaints;
use lines::{Lines, LogLine};

pub use complaint::{Complaint, Flaw, RecordingError};
pub use odometry_errors::OdometryErrors;
pub use writer::LogWriter;

/// The largest share of unusable scans. A log with more of them is probably not what it seems to be.
const MOST_UNUSABLE: f64 = 0.5;

/// The sensor data of a robot, from a log.
///
/// ```
/// use robot::recorded::Recording;
///
/// let log = "FLASER 3 1.0 2.0 1.5 0.0 0.0 0.0 0.5 0.0 0.0 10.0 host 10.0\n\
///            FLASER 3 1.0 2.1 0.0 0.0 0.0 0.6 0.0 0.0 10.1 host 10.1\n\
///            FLASER 3 1.0 2.2 1.5 0.0 0.0 0.0 0.7 0.0 0.0 10.2 host 10.2\n";
/// let recording = Recording::read(log.as_bytes())?;
/// assert_eq!(recording.records().len(), 2);
/// assert_eq!(recording.complaints()[0].line, 2); // a number is missing
/// # Ok::<(), robot::recorded::RecordingError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    model: RobotModel,
    records: Vec<Record>,
    complaints: Vec<Complaint>,
}

/// A line of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its number, from 1.
    pub line: usize,
    /// Time since the first line with a clock. It never decreases.
    pub time: Duration,
    /// Pose of `base_link` in the `odom` frame.
    pub odometry: Pose,
    /// Forward speed in m/s and turning rate in rad/s; zero if the line does not contain them.
    pub velocity: VelocityCommand,
    /// The scan, if the line has one.
    pub scan: Option<Arc<LaserScan>>,
    /// Pose of `base_link` in the `map` frame according to a SLAM program, for scans of the front laser.
    pub corrected: Option<Pose>,
}

impl Recording {
    /// Reads a log, plain or gzipped.
    ///
    /// Lines are used in the order of the file, regardless of their clocks. Unusable data is left out and listed as
    /// [complaints](Self::complaints).
    ///
    /// # Errors
    /// [`RecordingError`] if the file is not a log, or if so much of it is unusable that the rest is meaningless.
    pub fn read(bytes: &[u8]) -> Result<Self, RecordingError> {
        let mut complaints = Complaints::default();
        let text = text::decompressed(bytes, &mut complaints)?;
        let lines = Lines::parse(&text, &mut complaints)?;
        let lines = lines.with_usual_beams(&mut complaints).in_one_frame(&mut complaints);
        lines.check(MOST_UNUSABLE, &complaints)?;
        let times = clock::settled(&lines.lines, &mut complaints);
        let model = model_of(&lines);
        let lines = lines.lines.into_iter().zip(times).filter_map(|(line, time)| Some((line, time?)));
        let (mut lines, times): (Vec<LogLine>, Vec<Duration>) = lines.unzip();
        jumps::bridge_odometry(&mut lines, &mut complaints);
        jumps::leave_out_stray_poses(&mut lines, &mut complaints);
        let records = lines.into_iter().zip(times).map(|(line, time)| record(line, time, &model.lasers[0])).collect();
        Ok(Self { model, records, complaints: complaints.into_sorted() })
    }

    /// A recording of data in a format other than a log, in order. The records' line numbers must increase.
    #[must_use]
    pub fn of(model: RobotModel, records: Vec<Record>) -> Self {
        Self { model, records, complaints: Vec::new() }
    }

    /// What is known about the robot: its lasers. Everything else is as in the default robot.
    #[must_use]
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The recorded data, in order.
    #[must_use]
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Problems in the log, and what was done about each, by line.
    #[must_use]
    pub fn complaints(&self) -> &[Complaint] {
        &self.complaints
    }

    /// Scans of the front laser with their poses according to a SLAM program.
    pub fn corrected_scans(&self) -> impl Iterator<Item = (&Record, &Arc<LaserScan>, Pose)> {
        self.records.iter().filter_map(|record| Some((record, record.scan.as_ref()?, record.corrected?)))
    }
}

/// A line as a record. The log gives the laser's pose; its mount on the robot gives the robot's pose.
fn record(line: LogLine, time: Duration, front: &LaserSpec) -> Record {
    let range_max_m = front.range_max_m as f32;
    let scan = line.scan.map(|scan| {
        let limited = |range_m: f32| if range_m >= range_max_m { f32::INFINITY } else { range_m };
        let ranges_m = scan.ranges_m.into_iter().map(limited).collect();
        Arc::new(LaserScan { time, laser: scan.laser, ranges_m })
    });
    let LogLine { number, odometry, velocity, corrected, .. } = line;
    let corrected = corrected.map(|laser| laser * front.mount.inverse());
    Record { line: number, time, odometry, velocity, scan, corrected }
}

/// A robot with the lasers of the log.
fn model_of(lines: &Lines) -> RobotModel {
    let range_max_m = ranges::nothing_hit_from_m(lines);
    let laser = |index: usize, name: &str, mount| {
        let beams = lines.beams[index];
        // With an odd number of beams, there is one at either end.
        let steps = if beams % 2 == 1 { beams - 1 } else { beams }.max(1);
        LaserSpec {
            name: name.to_owned(),
            mount,
            angle_min_rad: -std::f64::consts::FRAC_PI_2,
            angle_increment_rad: std::f64::consts::PI / steps as f64,
            beams,
            period: clock::period(lines, index),
            range_min_m: ranges::LEAST_M,
            range_max_m,
        }
    };
    let mut lasers = vec![laser(0, "front", pose(lines.front_offset_m, 0.0, 0.0))];
    if lines.beams[1] > 0 {
        lasers.push(laser(1, "rear", pose(lines.rear_offset_m, 0.0, std::f64::consts::PI)));
    }
    RobotModel { lasers, ..RobotModel::default() }
}

/// A recording, played back. Commands change nothing.
#[derive(Clone, Debug)]
pub struct RecordedRobot {
    recording: Arc<Recording>,
    errors: OdometryErrors,
    next: usize,
    unread: Vec<Reading>,
}

impl RecordedRobot {
    /// A robot that senses the recorded data, with these errors added to its odometry.
    #[must_use]
    pub fn new(recording: Arc<Recording>, errors: OdometryErrors) -> Self {
        Self { recording, errors, next: 0, unread: Vec::new() }
    }

    /// The same robot, starting at this line of the log.
    #[must_use]
    pub fn from_line(mut self, line: usize) -> Self {
        self.next = self.recording.records.partition_point(|record| record.line < line);
        self
    }

    /// Advances by one line, whose readings can then be [read](Robot::read). `None` at the end.
    pub fn advance(&mut self) -> Option<&Record> {
        let record = self.recording.records.get(self.next)?;
        self.next += 1;
        let VelocityCommand { linear_mps, angular_radps } = record.velocity;
        let pose = self.errors.apply(&record.odometry);
        self.unread.push(Reading::Odometry(Odometry { time: record.time, pose, linear_mps, angular_radps }));
        self.unread.extend(record.scan.iter().map(|scan| Reading::Scan(Arc::clone(scan))));
        Some(record)
    }
}

impl Robot for RecordedRobot {
    fn model(&self) -> &RobotModel {
        &self.recording.model
    }

    fn read(&mut self, readings: &mut Vec<Reading>) {
        readings.append(&mut self.unread);
    }

    fn drive(&mut self, _command: VelocityCommand) {}
}

#[cfg(test)]
mod tests;
