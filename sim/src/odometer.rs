//! Wheel odometry: what the encoders make of the wheels' motion.
//!
//! The wheels grip the floor, so they measure what the body really does along them: a robot that is stopped by a wall
//! measures that it stands. What they cannot feel is motion across them, when the robot is pushed or slides along a wall;
//! without noise and bias that is all that odometry and truth differ by.

use bevy_ecs::prelude::*;
use maps::Pose;
use robot::{Odometry, Reading};

use crate::arc::moved;
use crate::clock::{Clock, Periodic};
use crate::config::OdometryConfig;
use crate::drive::Motion;
use crate::noise::Drift;
use crate::simulation::Readings;

/// The encoders. The `odom` frame is where the robot started.
#[derive(Component, Clone, Debug)]
pub(crate) struct Odometer {
    config: OdometryConfig,
    drift: Drift,
    due: Periodic,
    latest: Odometry,
}

impl Odometer {
    pub(crate) fn new(config: &OdometryConfig, drift: Drift) -> Self {
        let latest =
            Odometry { time: std::time::Duration::ZERO, pose: Pose::identity(), linear_mps: 0.0, angular_radps: 0.0 };
        Self { config: *config, drift, due: Periodic::new(config.period), latest }
    }

    /// The latest measurement, one a step whatever the period of the readings.
    pub(crate) fn latest(&self) -> Odometry {
        self.latest
    }

    /// Takes in one step's motion.
    fn measure(&mut self, motion: &Motion, clock: &Clock) {
        let (forward_m, turn_rad) = self.drift.disturb(motion.forward_m, motion.turn_rad);
        let bias_rad = self.config.angle_bias * motion.turn_rad + self.config.angle_bias_rad_per_m * motion.forward_m;
        let forward_m = forward_m + self.config.distance_bias * motion.forward_m;
        let turn_rad = turn_rad + bias_rad;
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
    mut readings: ResMut<Readings>,
    robot: Single<(&Motion, &mut Odometer)>,
) {
    let (motion, mut odometer) = robot.into_inner();
    odometer.measure(motion, &clock);
    if odometer.due.is_due(clock.now) {
        readings.push(Reading::Odometry(odometer.latest));
    }
}
