//! Somebody outside the program who drives the robot.

use std::time::Duration;

use nav::{InitialPose, PoseEstimate};
use robot::{Reading, Robot, RobotModel, VelocityCommand};
use sim::Simulation;

/// Whoever drives the robot of a run in place of its tree and its navigation.
pub trait Pilot {
    /// Sees what the robot has sensed, and says what it does until the next step.
    fn drive(&mut self, sensed: &Sensed<'_>) -> Orders;
}

/// What a robot knows after a step of its run.
#[derive(Clone, Copy, Debug)]
pub struct Sensed<'a> {
    /// Time since the start of the run.
    pub now: Duration,
    /// What its sensors have measured since the last step, oldest first.
    pub readings: &'a [Reading],
    /// Where its own localization believes it to be.
    pub estimate: &'a PoseEstimate,
}

/// What a robot does until the next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Orders {
    /// The velocity of its base.
    pub velocity: VelocityCommand,
    /// Where its own localization is told that it is.
    pub pose: Option<InitialPose>,
    /// What else has happened, in words.
    pub happened: Vec<String>,
}

/// A robot for its own software, which senses, and does not drive.
pub(crate) struct Passenger<'s>(pub(crate) &'s mut Simulation);

impl Robot for Passenger<'_> {
    fn model(&self) -> &RobotModel {
        self.0.model()
    }

    fn read(&mut self, readings: &mut Vec<Reading>) {
        self.0.read(readings);
    }

    fn drive(&mut self, _: VelocityCommand) {}
}
