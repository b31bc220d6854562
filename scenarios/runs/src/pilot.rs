//! Somebody outside the program who drives the robot.

use std::time::Duration;

use components::Software;
use maps::Point;
use nav::{Goal, InitialPose};
use remote::{Call, FromNode};
use robot::{Reading, Robot, RobotModel, VelocityCommand};
use sim::Simulation;

/// Whoever drives the robot of a run in place of its tree and its navigation.
pub trait Pilot {
    /// Sees what the robot has sensed, and says what it does until the next step. Waits for a moment until that is
    /// known; none if it is not, and it is then asked again, with the same.
    fn drive(&mut self, sensed: &Sensed<'_>) -> Option<Orders>;

    /// Whether it carries what nodes of ROS 2 ask of the scenario's components, and what these say.
    fn serves(&self) -> bool {
        false
    }

    /// The run goes on: its time has stood still since the last call.
    fn resume(&mut self) {}

    /// The run is over. The last that components have said to nodes of ROS 2 has not been heard yet.
    fn leave(&mut self, _said: &[FromNode]) {}
}

/// A robot after a step of its run.
#[derive(Clone, Copy, Debug)]
pub struct Sensed<'a> {
    /// Time since the start of the run.
    pub now: Duration,
    /// What has read its sensors, and what that has made of it.
    pub software: &'a Software,
    /// What its body has begun to touch in the step.
    pub touched: &'a [Touched<'a>],
    /// The doors of the world, each with how far its leaf has moved from where it is closed: one that swings in
    /// radians, counter-clockwise; one that slides in meters.
    pub doors: &'a [(&'a str, f64)],
    /// What components have said to nodes of ROS 2 since the last step.
    pub said: &'a [FromNode],
}

/// What a robot's body has begun to touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touched<'a> {
    /// `walls`, or the name of a body.
    pub body: &'a str,
    /// Where, on the robot's edge, in the frame `base_link`, in meters.
    pub at: Point,
    /// The direction in which the robot is pushed there, in the same frame: a unit vector.
    pub normal: [f64; 2],
    /// How deep the two overlap, in meters; 0 if they only touch.
    pub depth_m: f64,
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
    /// What nodes of ROS 2 ask of components.
    pub calls: Vec<Call>,
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
