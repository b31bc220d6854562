//! The two driven wheels: what becomes of a velocity command.
//!
//! Physics computes in f32, in which the pose of a robot far from the origin moves in steps of micrometres. So the wheels
//! say, in f64, where the robot is at the end of a step; the body is given the velocity that takes it there; and if it
//! arrives, that is where the robot is. If something was in the way, the robot is where physics left it, the wheels have
//! turned only as far as the body has moved (they grip, the motors stall), and they start again from the speed that is
//! left. So a wall really stops the robot, and what the motors can do to an obstacle is what their acceleration allows.

use bevy_ecs::prelude::*;
use maps::Pose;
use robot::{RobotModel, VelocityCommand};

use crate::arc::{moved, rolled};
use crate::battery::Battery;
use crate::clock::Clock;
use crate::config::DriveConfig;
use crate::faults::Faults;
use crate::noise::Drift;
use crate::physics::{Body, Physics};

/// A body within this of where its wheels take it was not hindered, in metres and in radians. Physics' rounding stays
/// below 15 µm and 20 µrad as long as coordinates stay below 128 m and turning rates below 5 rad/s; beyond, only its own
/// precision is left.
const HINDERED_BY: f64 = 5e-5;

/// Slower than this is at rest, in m/s and in rad/s.
const REST_SPEED: f64 = 1e-3;

/// The robot's true pose: `base_link` in the `map` frame.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct RobotPose(pub(crate) Pose);

/// How the robot really moved in the last step.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    /// What the wheels rolled along their arc, in metres.
    pub(crate) forward_m: f64,
    /// By how much the robot turned, in radians.
    pub(crate) turn_rad: f64,
    /// Way of the robot's centre since the start of the run, in metres.
    pub(crate) travelled_m: f64,
    /// Whether the robot was at rest.
    pub(crate) at_rest: bool,
}

/// The wheels and their motors.
#[derive(Component, Clone, Debug)]
pub(crate) struct Drive {
    model: RobotModel,
    config: DriveConfig,
    drift: Drift,
    /// What the software asked for last.
    pub(crate) command: VelocityCommand,
    /// The velocity that the motors keep up.
    velocity: VelocityCommand,
    /// What the wheels do in this step, unless something is in the way: distance and turn.
    intended: (f64, f64),
    /// Where that leads.
    target: Pose,
    /// Whether current flows.
    powered: bool,
}

impl Drive {
    pub(crate) fn new(model: &RobotModel, config: &DriveConfig, drift: Drift, start: Pose) -> Self {
        Self {
            model: model.clone(),
            config: *config,
            drift,
            command: VelocityCommand::STOP,
            velocity: VelocityCommand::STOP,
            intended: (0.0, 0.0),
            target: start,
            powered: false,
        }
    }

    /// Whether driving current flows: the wheels turn or are told to.
    pub(crate) fn is_powered(&self) -> bool {
        self.powered
    }

    /// Sets out from `from` for one step.
    fn set_out(&mut self, command: VelocityCommand, from: &Pose, dt_s: f64) {
        self.velocity = self.within_wheels(self.toward(self.within_model(command), dt_s));
        self.powered = command != VelocityCommand::STOP || self.velocity != VelocityCommand::STOP;
        self.intended = self.drift.disturb(self.velocity.linear_mps * dt_s, self.velocity.angular_radps * dt_s);
        self.target = moved(from, self.intended.0, self.intended.1);
    }

    /// The command within the limits of the whole body. What is not a number counts as 0.
    fn within_model(&self, command: VelocityCommand) -> VelocityCommand {
        let limited = |value: f64, limit: f64| if value.is_nan() { 0.0 } else { value.clamp(-limit, limit) };
        VelocityCommand {
            linear_mps: limited(command.linear_mps, self.model.max_linear_mps),
            angular_radps: limited(command.angular_radps, self.model.max_angular_radps),
        }
    }

    /// As near to the wanted velocity as the accelerations allow within a step.
    fn toward(&self, wanted: VelocityCommand, dt_s: f64) -> VelocityCommand {
        let approach = |from: f64, to: f64, step: f64| {
            if (to - from).abs() <= step { to } else { from + step.copysign(to - from) }
        };
        let model = &self.model;
        let (linear, angular) = (model.max_linear_acceleration_mps2, model.max_angular_acceleration_radps2);
        VelocityCommand {
            linear_mps: approach(self.velocity.linear_mps, wanted.linear_mps, linear * dt_s),
            angular_radps: approach(self.velocity.angular_radps, wanted.angular_radps, angular * dt_s),
        }
    }

    /// The velocity slowed so far that the faster wheel keeps its limit, on the same curve.
    fn within_wheels(&self, velocity: VelocityCommand) -> VelocityCommand {
        let rim_mps = 0.5 * self.config.wheel_separation_m * velocity.angular_radps.abs();
        let fastest_mps = velocity.linear_mps.abs() + rim_mps;
        if fastest_mps <= self.config.max_wheel_mps {
            return velocity;
        }
        let slower = self.config.max_wheel_mps / fastest_mps;
        VelocityCommand { linear_mps: velocity.linear_mps * slower, angular_radps: velocity.angular_radps * slower }
    }

    /// Takes note that the wheels rolled only so far. Being pushed is not driving: the motors keep no more than they
    /// had, and none of it backwards.
    fn stall(&mut self, (forward_m, turn_rad): (f64, f64), dt_s: f64) {
        let left = |had: f64, has: f64| has.clamp(had.min(0.0), had.max(0.0));
        self.velocity.linear_mps = left(self.velocity.linear_mps, forward_m / dt_s);
        self.velocity.angular_radps = left(self.velocity.angular_radps, turn_rad / dt_s);
    }
}

/// Turns the command into the velocity of the robot's body.
pub(crate) fn drive_robot(
    clock: Res<Clock>,
    faults: Res<Faults>,
    mut physics: ResMut<Physics>,
    robot: Single<(&Body, &RobotPose, &Battery, &mut Drive)>,
) {
    let (body, pose, battery, mut drive) = robot.into_inner();
    let asked = faults.base.velocity_override.unwrap_or(drive.command);
    let command = if battery.is_empty() { VelocityCommand::STOP } else { asked };
    drive.set_out(command, &pose.0, clock.dt_s());
    physics.steer(*body, &drive.target, clock.dt_s());
}

/// Takes over where the step has brought the robot.
pub(crate) fn settle_robot(
    clock: Res<Clock>,
    physics: Res<Physics>,
    robot: Single<(&Body, &mut RobotPose, &mut Drive, &mut Motion)>,
) {
    let (body, mut pose, mut drive, mut motion) = robot.into_inner();
    let reached = physics.pose(*body);
    let off = drive.target.inv_mul(&reached);
    let way_m;
    if off.translation.vector.norm() <= HINDERED_BY && off.rotation.angle().abs() <= HINDERED_BY {
        (motion.forward_m, motion.turn_rad) = drive.intended;
        way_m = motion.forward_m.abs();
        pose.0 = drive.target;
    } else {
        let moved = pose.0.inv_mul(&reached);
        (motion.forward_m, motion.turn_rad) = rolled(&moved);
        way_m = moved.translation.vector.norm();
        drive.stall((motion.forward_m, motion.turn_rad), clock.dt_s());
        pose.0 = reached;
    }
    motion.travelled_m += way_m;
    let rest = REST_SPEED * clock.dt_s();
    motion.at_rest = way_m <= rest && motion.turn_rad.abs() <= rest;
}

#[cfg(test)]
mod tests {
    use robot::Streams;

    use super::*;
    use crate::config::DriftNoise;

    fn drive() -> Drive {
        let drift = Drift::new(DriftNoise::NONE, Streams::new(1).stream("sim/motion"));
        Drive::new(&RobotModel::default(), &DriveConfig::default(), drift, Pose::identity())
    }

    fn command(linear_mps: f64, angular_radps: f64) -> VelocityCommand {
        VelocityCommand { linear_mps, angular_radps }
    }

    #[test]
    fn speed_rises_with_the_acceleration_and_ends_exactly_at_the_limit() {
        let mut drive = drive();
        let speeds: Vec<f64> = (0..50)
            .map(|_| {
                drive.set_out(command(9.0, -9.0), &Pose::identity(), 0.02);
                drive.velocity.linear_mps
            })
            .collect();
        assert!((speeds[9] - 0.1).abs() < 1e-12, "{}", speeds[9]);
        assert_eq!(drive.velocity, command(0.45, -1.0));
    }

    #[test]
    fn the_faster_wheel_keeps_its_limit_on_the_same_curve() {
        let mut drive = drive();
        drive.config.max_wheel_mps = 0.325;
        assert_eq!(drive.within_wheels(command(0.45, 1.0)), command(0.225, 0.5));
        assert_eq!(drive.within_wheels(command(0.1, -0.5)), command(0.1, -0.5));
    }

    #[test]
    fn what_is_not_a_number_is_no_command() {
        assert_eq!(drive().within_model(command(f64::NAN, f64::NEG_INFINITY)), command(0.0, -1.0));
    }

    #[test]
    fn stalled_motors_keep_what_speed_is_left_and_pushed_ones_gain_none() {
        let mut drive = drive();
        drive.velocity = command(0.4, -0.5);
        drive.stall((0.002, 0.01), 0.02);
        assert_eq!(drive.velocity, command(0.1, 0.0));
        drive.stall((0.02, 0.0), 0.02);
        assert_eq!(drive.velocity, command(0.1, 0.0));
    }
}
