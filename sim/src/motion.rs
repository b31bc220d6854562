//! The true pose and motion of the robot.

use bevy_ecs::prelude::*;
use maps::Pose;

use crate::wheels::Roll;

/// The robot's true pose: `base_link` in the `map` frame.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct RobotPose(pub(crate) Pose);

/// The robot's true motion in the last step.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    /// The distance along its arc, in meters.
    pub(crate) forward_m: f64,
    pub(crate) turn_rad: f64,
    /// The motion of the wheels: the same, unless they slipped.
    pub(crate) rolled: Roll,
    /// Distance traveled by the robot's center since the start of the run, in meters.
    pub(crate) travelled_m: f64,
    /// Whether the robot was at rest.
    pub(crate) at_rest: bool,
}
