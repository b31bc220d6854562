//! Where the robot really is, and how it moves.

use bevy_ecs::prelude::*;
use maps::Pose;

use crate::wheels::Roll;

/// The robot's true pose: `base_link` in the `map` frame.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct RobotPose(pub(crate) Pose);

/// How the robot really moved in the last step.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    /// How far it went along its arc, in metres.
    pub(crate) forward_m: f64,
    /// By how much it turned, in radians.
    pub(crate) turn_rad: f64,
    /// What the wheels rolled: the same, unless they slipped.
    pub(crate) rolled: Roll,
    /// Way of the robot's centre since the start of the run, in metres.
    pub(crate) travelled_m: f64,
    /// Whether the robot was at rest.
    pub(crate) at_rest: bool,
}
