//! How a robot moves: its model, its odometry and the commands that drive it.

use std::time::Duration;

use maps::{Pose, pose};

use crate::LaserSpec;

/// The data of a differential-drive robot's hardware that its software has.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Radius of the body, in meters: its footprint is a disc.
    pub radius_m: f64,
    /// Largest forward (and backward) speed, in m/s.
    pub max_linear_mps: f64,
    /// Largest turning rate in either direction, in rad/s.
    pub max_angular_radps: f64,
    /// Largest change of the forward speed, in m/s².
    pub max_linear_acceleration_mps2: f64,
    /// Largest change of the turning rate, in rad/s².
    pub max_angular_acceleration_radps2: f64,
    /// The laser scanners; scans refer to them by their index in this list.
    pub lasers: Vec<LaserSpec>,
}

impl Default for RobotModel {
    /// The robot of the paper's experiments: a disc of radius 0.30 m, at most 0.45 m/s, a laser at the front
    /// (x = +0.245 m) and one at the back, each 360 beams over 270° at 10 Hz, 0.1 to 10 m.
    fn default() -> Self {
        Self::with_radius(0.30)
    }
}

impl RobotModel {
    /// The default robot with a body of another size, on which its lasers move in proportion.
    #[must_use]
    pub fn with_radius(radius_m: f64) -> Self {
        let scale = radius_m / 0.30;
        let laser = |name: &str, mount| LaserSpec {
            name: name.to_owned(),
            mount,
            angle_min_rad: -135_f64.to_radians(),
            angle_increment_rad: (270.0 / 359.0_f64).to_radians(),
            beams: 360,
            period: Duration::from_millis(100),
            range_min_m: 0.1,
            range_max_m: 10.0,
        };
        Self {
            radius_m,
            max_linear_mps: 0.45,
            max_angular_radps: 1.0,
            max_linear_acceleration_mps2: 0.5,
            max_angular_acceleration_radps2: 2.0,
            lasers: vec![
                laser("front", pose(0.245 * scale, 0.0, 0.0)),
                laser("back", pose(-0.245 * scale, 0.0, std::f64::consts::PI)),
            ],
        }
    }
}

/// The robot's motion as measured at the wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry {
    /// When it was measured.
    pub time: Duration,
    /// Pose of `base_link` in the `odom` frame: smooth, but its error grows without bound.
    pub pose: Pose,
    /// Forward speed, in m/s.
    pub linear_mps: f64,
    /// Turning rate, in rad/s, counter-clockwise.
    pub angular_radps: f64,
}

/// The commanded velocity of the base.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct VelocityCommand {
    /// Forward speed, in m/s.
    pub linear_mps: f64,
    /// Turning rate, in rad/s, counter-clockwise.
    pub angular_radps: f64,
}

impl VelocityCommand {
    /// Stand still.
    pub const STOP: Self = Self { linear_mps: 0.0, angular_radps: 0.0 };
}
