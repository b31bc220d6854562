//! Somebody outside the program who drives the robot.

use std::time::Duration;

use components::Software;
use nav::{Goal, InitialPose};
use robot::{Reading, Robot, RobotModel, VelocityCommand};
use sim::Simulation;

/// Whoever drives the robot of a run in place of its tree and its navigation.
pub trait Pilot {
    /// Sees what the robot has sensed, and says what it does until the next step. Waits for a moment until that is
    /// known; none if it is not, and it is then asked again, with the same.
    fn drive(&mut self, sensed: &Sensed<'_>) -> Option<Orders>;

    /// The run goes on: its time has stood still since the last call.
    fn resume(&mut self) {}

    /// The run is over.
    fn leave(&mut self) {}
}

/// A robot after a step of its run.
#[derive(Clone, Copy, Debug)]
pub struct Sensed<'a> {
    /// Time since the start of the run.
    pub now: Duration,
    /// What has read its sensors, and what that has made of it.
    pub software: &'a Software,
    /// What its body has begun to touch in the step: `walls`, or the name of a body.
    pub touched: &'a [&'a str],
}

/// What a robot does until the next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Orders {
    /// The velocity of its base; without one, its own navigation drives.
    pub velocity: Option<VelocityCommand>,
    /// What its own navigation is told.
    pub trip: Option<TripOrder>,
    /// Where its own localization is told that it is.
    pub pose: Option<InitialPose>,
    /// What else has happened, in words.
    pub happened: Vec<String>,
}

/// What a navigation is told.
#[derive(Clone, Debug, PartialEq)]
pub enum TripOrder {
    /// To drive to a goal, and nowhere else.
    Start(Goal),
    /// To drive nowhere.
    End,
}

/// A robot for its own software, which senses, and only says how it would drive.
pub(crate) struct Passenger<'s> {
    pub(crate) sim: &'s mut Simulation,
    pub(crate) advice: VelocityCommand,
}

impl Robot for Passenger<'_> {
    fn model(&self) -> &RobotModel {
        self.sim.model()
    }

    fn read(&mut self, readings: &mut Vec<Reading>) {
        self.sim.read(readings);
    }

    fn drive(&mut self, command: VelocityCommand) {
        self.advice = command;
    }
}
