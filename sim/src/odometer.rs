//! Wheel odometry: the encoders' measurements of the wheels' motion.
//!
//! The wheels grip the floor, so they measure the true motion of the body in their direction: a robot stopped by a wall
//! measures that it stands still. They cannot measure motion across them, when the robot is pushed or slides along a
//! wall. Without noise, bias and faults, this is the only difference between odometry and truth.

use bevy_ecs::prelude::*;
use maps::Pose;
use robot::{Odometry, Reading};

use crate::arc::moved;
use crate::clock::{Clock, Periodic};
use crate::config::OdometryConfig;
use crate::faults::{Faults, OdometryFaults};
use crate::motion::Motion;
use crate::noise::Drift;
use crate::readings::Readings;

/// The encoders. The `odom` frame is the robot's start pose.
#[derive(Component, Clone, Debug)]
pub(crate) struct Odometer {
    config: OdometryConfig,
    drift: Drift,
    due: Periodic,
    /// The latest measurement: there is one per step, regardless of the period of the readings.
    pub(crate) latest: Odometry,
}

impl Odometer {
    pub(crate) fn new(config: &OdometryConfig, drift: Drift) -> Self {
        let latest =
            Odometry { time: std::time::Duration::ZERO, pose: Pose::identity(), linear_mps: 0.0, angular_radps: 0.0 };
        Self { config: *config, drift, due: Periodic::new(config.period), latest }
    }

    /// Processes the motion of one step.
    fn measure(&mut self, motion: &Motion, faults: &OdometryFaults, clock: &Clock) {
        let (rolled_m, rolled_rad) = motion.rolled;
        // Frozen encoders draw their noise as well, so that it continues unchanged.
        let (forward_m, turn_rad) = self.drift.disturb(rolled_m, rolled_rad);
        if faults.frozen {
            self.latest = Odometry { time: clock.now, pose: self.latest.pose, linear_mps: 0.0, angular_radps: 0.0 };
            return;
        }
        let distance_bias = self.config.distance_bias + faults.distance_bias;
        let angle_bias = self.config.angle_bias + faults.angle_bias;
        let angle_bias_rad_per_m = self.config.angle_bias_rad_per_m + faults.angle_bias_rad_per_m;
        let forward_m = forward_m + distance_bias * rolled_m;
        let turn_rad = turn_rad + (angle_bias * rolled_rad + angle_bias_rad_per_m * rolled_m);
        self.latest = Odometry {
            time: clock.now,
            pose: moved(&self.latest.pose, forward_m, turn_rad),
            linear_mps: forward_m / clock.dt_s(),
            angular_radps: turn_rad / clock.dt_s(),
        };
    }
}

/// Measures, and reports if a reading is due.
pub(crate) fn measure_odometry(
    clock: Res<Clock>,
    faults: Res<Faults>,
    mut readings: ResMut<Readings>,
    robot: Single<(&Motion, &mut Odometer)>,
) {
    let (motion, mut odometer) = robot.into_inner();
    odometer.measure(motion, &faults.odometry, &clock);
    if odometer.due.is_due(clock.now) {
        readings.push(Reading::Odometry(odometer.latest));
    }
}
