//! The interface between a robot's software and its hardware.
//!
//! Sensor data arrives as a stream of [`Reading`]s; the software commands the base with a [`VelocityCommand`]. Software
//! above this interface (localization, navigation, components) cannot distinguish a simulated robot from a recorded or
//! a real one. Units are meters, seconds, radians and percent; frames are those of ROS REP-105 (`map`, `odom`,
//! `base_link`) and axes those of REP-103. Times are since the start of the run.

mod laser;
mod motion;
mod random;
pub mod recorded;

use std::sync::Arc;
use std::time::Duration;

pub use laser::{LaserScan, LaserSpec};
pub use motion::{Odometry, RobotModel, VelocityCommand};
pub use random::{Streams, normal};

/// The reading of the battery's electronics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryState {
    /// When it was measured.
    pub time: Duration,
    /// Charge, in percent of the capacity, 0 to 100.
    pub charge_pct: f64,
    /// Whether charging current flows.
    pub charging: bool,
}

/// One measurement of one sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// A laser scan.
    Scan(Arc<LaserScan>),
    /// Wheel odometry.
    Odometry(Odometry),
    /// The state of the battery.
    Battery(BatteryState),
}

impl Reading {
    /// When the measurement was taken.
    #[must_use]
    pub fn time(&self) -> Duration {
        match self {
            Self::Scan(scan) => scan.time,
            Self::Odometry(odometry) => odometry.time,
            Self::Battery(battery) => battery.time,
        }
    }
}

/// A robot: simulated, recorded or real.
///
/// ```
/// use std::time::Duration;
/// use maps::pose;
/// use robot::{Odometry, Reading, Robot, RobotModel, VelocityCommand};
///
/// /// A base that reaches the commanded speed at once, and senses nothing else.
/// struct Base(RobotModel, Odometry);
///
/// impl Robot for Base {
///     fn model(&self) -> &RobotModel {
///         &self.0
///     }
///     fn read(&mut self, readings: &mut Vec<Reading>) {
///         readings.push(Reading::Odometry(self.1));
///     }
///     fn drive(&mut self, VelocityCommand { linear_mps, angular_radps }: VelocityCommand) {
///         self.1 = Odometry { linear_mps, angular_radps, ..self.1 };
///     }
/// }
///
/// let still = Odometry { time: Duration::ZERO, pose: pose(0.0, 0.0, 0.0), linear_mps: 0.0, angular_radps: 0.0 };
/// let mut base = Base(RobotModel::default(), still);
/// base.drive(VelocityCommand { linear_mps: 0.4, angular_radps: 0.0 });
/// let mut readings = Vec::new();
/// base.read(&mut readings);
/// assert!(matches!(readings[0], Reading::Odometry(odometry) if odometry.linear_mps == 0.4));
/// ```
pub trait Robot {
    /// The data of the robot's hardware that its software has.
    fn model(&self) -> &RobotModel;

    /// Appends the readings received since the last call, oldest first.
    fn read(&mut self, readings: &mut Vec<Reading>);

    /// Sets the velocity of the base until the next command.
    fn drive(&mut self, command: VelocityCommand);
}
