//! The two driven wheels, which carry out velocity commands.
//!
//! Physics computes in f32, in which a robot moves in steps of micrometers. So the wheels compute, in f64, the robot's
//! pose at the end of a step. The body gets the velocity that takes it there, and if it arrives, this is its pose. If
//! something was in the way, the robot is where physics left it, the wheels have turned only as far as the body has
//! moved (they grip, the motors stall), and they start again from the remaining speed. So a wall really stops the
//! robot, and the motors' acceleration limits their effect on an obstacle.
//!
//! Faults act in between: commands arrive late, wheels turn less than they should, and slipping wheels turn without
//! moving the body. The encoders measure the whole motion of the wheels; only the part without slip moves the body.

use bevy_ecs::prelude::*;
use maps::Pose;
use robot::{RobotModel, VelocityCommand};

use crate::arc::{moved, rolled};
use crate::battery::Battery;
use crate::clock::Clock;
use crate::command_delay::CommandDelay;
use crate::config::DriveConfig;
use crate::faults::{BaseFaults, Faults};
use crate::motion::{Motion, RobotPose};
use crate::noise::Drift;
use crate::physics::{Body, Physics};
use crate::wheels::{Roll, slipped, turned};

/// A body within this distance of the pose to which its wheels take it was not blocked, in meters and in radians. The
/// rounding of physics stays below 15 µm and 20 µrad as long as the robot is within 128 m of the building's frame
/// (`convert`) and turning rates are below 5 rad/s; beyond that, the robot has only the precision of physics.
const HINDERED_BY: f64 = 5e-5;

/// Slower than this counts as at rest, in m/s and in rad/s.
const REST_SPEED: f64 = 1e-3;

/// The wheels and their motors.
#[derive(Component, Clone, Debug)]
pub(crate) struct Drive {
    model: RobotModel,
    config: DriveConfig,
    drift: Drift,
    /// The software's commands.
    pub(crate) commands: CommandDelay,
    /// The velocity that the motors maintain.
    velocity: VelocityCommand,
    /// The wheels' motion in this step, unless something is in the way.
    intended: Roll,
    /// The part of it that slips.
    slipped: Roll,
    /// The target pose of the rest.
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
            commands: CommandDelay::default(),
            velocity: VelocityCommand::STOP,
            intended: (0.0, 0.0),
            slipped: (0.0, 0.0),
            target: start,
            powered: false,
        }
    }

    /// Whether driving current flows: the wheels turn or are commanded to.
    pub(crate) fn is_powered(&self) -> bool {
        self.powered
    }

    /// Radius of the robot's body, in meters.
    pub(crate) fn robot_radius_m(&self) -> f64 {
        self.model.radius_m
    }

    /// Stands at `at` for one step, with the motors off.
    pub(crate) fn put_down(&mut self, at: &Pose) {
        self.velocity = VelocityCommand::STOP;
        self.powered = false;
        (self.intended, self.slipped) = ((0.0, 0.0), (0.0, 0.0));
        self.target = *at;
    }

    /// Starts a step from `from`.
    fn set_out(&mut self, command: VelocityCommand, faults: &BaseFaults, from: &Pose, dt_s: f64) {
        let wanted = self.within_model(command, faults.speed_limit_mps);
        self.velocity = self.within_wheels(self.toward(wanted, dt_s));
        self.powered = command != VelocityCommand::STOP || self.velocity != VelocityCommand::STOP;
        let disturbed = self.drift.disturb(self.velocity.linear_mps * dt_s, self.velocity.angular_radps * dt_s);
        self.intended = turned(faults, disturbed, self.config.wheel_separation_m);
        self.slipped = slipped(faults, self.intended);
        let (forward_m, turn_rad) = self.on_the_floor();
        self.target = moved(from, forward_m, turn_rad);
    }

    /// The motion on the floor, unless something is in the way.
    fn on_the_floor(&self) -> Roll {
        (self.intended.0 - self.slipped.0, self.intended.1 - self.slipped.1)
    }

    /// The motion of the wheels when an obstacle limits the motion of the body: the floor turns them as far as they
    /// grip, the motors as far as they slip.
    fn rolled_by(&self, (forward_m, turn_rad): Roll) -> Roll {
        if self.slipped == (0.0, 0.0) {
            (forward_m, turn_rad)
        } else {
            (forward_m + self.slipped.0, turn_rad + self.slipped.1)
        }
    }

    /// The command within the limits of the whole body. NaN counts as 0.
    fn within_model(&self, command: VelocityCommand, speed_limit_mps: Option<f64>) -> VelocityCommand {
        let limited = |value: f64, limit: f64| if value.is_nan() { 0.0 } else { value.clamp(-limit, limit) };
        let fastest_mps = speed_limit_mps.map_or(self.model.max_linear_mps, |limit_mps| {
            // In this order, NaN is not a limit.
            self.model.max_linear_mps.min(limit_mps).max(0.0)
        });
        VelocityCommand {
            linear_mps: limited(command.linear_mps, fastest_mps),
            angular_radps: limited(command.angular_radps, self.model.max_angular_radps),
        }
    }

    /// The velocity nearest to the desired one that the acceleration limits allow within a step.
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

    /// The velocity, slowed down on the same curve until the faster wheel is within its limit.
    fn within_wheels(&self, velocity: VelocityCommand) -> VelocityCommand {
        let rim_mps = 0.5 * self.config.wheel_separation_m * velocity.angular_radps.abs();
        let fastest_mps = velocity.linear_mps.abs() + rim_mps;
        if fastest_mps <= self.config.max_wheel_mps {
            return velocity;
        }
        let slower = self.config.max_wheel_mps / fastest_mps;
        VelocityCommand { linear_mps: velocity.linear_mps * slower, angular_radps: velocity.angular_radps * slower }
    }

    /// Limits the motors' velocity to the motion that took place. Being pushed is not driving: the motors keep no more
    /// speed than they had, and none backwards.
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
    let arrived = drive.commands.receive(clock.now, faults.base.command_delay);
    let commanded = faults.base.velocity_override.unwrap_or(arrived);
    let command = if battery.is_empty() { VelocityCommand::STOP } else { commanded };
    if faults.base.emergency_stop {
        drive.put_down(&pose.0);
    } else {
        drive.set_out(command, &faults.base, &pose.0, clock.dt_s());
    }
    physics.steer(*body, &drive.target, clock.dt_s());
}

/// Takes over the robot's pose after the step.
pub(crate) fn settle_robot(
    clock: Res<Clock>,
    physics: Res<Physics>,
    robot: Single<(&Body, &mut RobotPose, &mut Drive, &mut Motion)>,
) {
    let (body, mut pose, mut drive, mut motion) = robot.into_inner();
    let reached = physics.pose(*body);
    let off = drive.target.inv_mul(&reached);
    // Physics only decides whether something was in the way. Its numbers have 32 bits; with the wheels' 64, odometry
    // without noise is exact, however far the robot drives.
    let way_m;
    if off.translation.vector.norm() <= HINDERED_BY && off.rotation.angle().abs() <= HINDERED_BY {
        (motion.forward_m, motion.turn_rad) = drive.on_the_floor();
        motion.rolled = drive.intended;
        way_m = motion.forward_m.abs();
        pose.0 = drive.target;
    } else {
        let moved = pose.0.inv_mul(&reached);
        (motion.forward_m, motion.turn_rad) = rolled(&moved);
        way_m = moved.translation.vector.norm();
        motion.rolled = drive.rolled_by((motion.forward_m, motion.turn_rad));
        drive.stall(motion.rolled, clock.dt_s());
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
        let drift = Drift::new(DriftNoise::default(), Streams::new(1).stream("sim/motion"));
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
                drive.set_out(command(9.0, -9.0), &BaseFaults::default(), &Pose::identity(), 0.02);
                drive.velocity.linear_mps
            })
            .collect();
        assert!((speeds[9] - 0.1).abs() < 1e-12, "{}", speeds[9]);
        assert_eq!(drive.velocity, command(0.45, -1.0));
    }

    #[test]
    fn the_faster_wheel_stays_within_its_limit_on_the_same_curve() {
        let mut drive = drive();
        drive.config.max_wheel_mps = 0.325;
        assert_eq!(drive.within_wheels(command(0.45, 1.0)), command(0.225, 0.5));
        assert_eq!(drive.within_wheels(command(0.1, -0.5)), command(0.1, -0.5));
    }

    #[test]
    fn nan_is_not_a_command() {
        assert_eq!(drive().within_model(command(f64::NAN, f64::NEG_INFINITY), None), command(0.0, -1.0));
    }

    #[test]
    fn a_speed_limit_only_ever_slows() {
        for (limit_mps, fastest_mps) in [(0.2, 0.2), (2.0, 0.45), (-1.0, 0.0), (f64::NAN, 0.45)] {
            let limited = drive().within_model(command(9.0, 0.5), Some(limit_mps));
            assert_eq!(limited, command(fastest_mps, 0.5), "limit {limit_mps}");
        }
    }

    #[test]
    fn stalled_motors_keep_the_remaining_speed_and_pushed_ones_gain_none() {
        let mut drive = drive();
        drive.velocity = command(0.4, -0.5);
        drive.stall((0.002, 0.01), 0.02);
        assert_eq!(drive.velocity, command(0.1, 0.0));
        drive.stall((0.02, 0.0), 0.02);
        assert_eq!(drive.velocity, command(0.1, 0.0));
    }
}
