//! A program outside of the run that drives its robot.

use std::time::Duration;

use components::Software;
use maps::Point;
use nav::{Goal, InitialPose};
use remote::{NodeMessage, ServiceRequest};
use robot::{Reading, Robot, RobotModel, VelocityCommand};
use sim::Simulation;

/// Drives the robot of a run in place of its tree and its navigation.
pub trait Controller {
    /// Receives what the robot has sensed, and returns what it does until the next step. Waits for a moment until that
    /// is known; `None` if it is not: the caller then calls again with the same input.
    fn drive(&mut self, input: &ControllerInput<'_>) -> Option<ControllerOutput>;

    /// Whether it also connects nodes of ROS 2 with the scenario's components: it passes on requests, responses and
    /// messages.
    fn serves(&self) -> bool {
        false
    }

    /// Continues after a pause of the run, in which its time stood still.
    fn resume(&mut self) {}

    /// The run is over. The outbox has the components' last responses and messages for nodes of ROS 2.
    fn leave(&mut self, _outbox: &[NodeMessage]) {}
}

/// The state of a robot after a step of its run.
#[derive(Clone, Copy, Debug)]
pub struct ControllerInput<'a> {
    /// Time since the start of the run.
    pub now: Duration,
    /// The robot's software, which has read its sensors: their readings and its estimates.
    pub software: &'a Software,
    /// What its body has begun to touch in the step.
    pub touched: &'a [Touched<'a>],
    /// The doors of the world, each with how far its leaf has moved from where it is closed: one that swings in
    /// radians, counter-clockwise; one that slides in meters.
    pub doors: &'a [(&'a str, f64)],
    /// The components' responses and messages for nodes of ROS 2 since the last step.
    pub outbox: &'a [NodeMessage],
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
pub struct ControllerOutput {
    /// The velocity of its base; without one, its own navigation drives.
    pub velocity: Option<VelocityCommand>,
    /// A command for its own navigation.
    pub trip: Option<TripCommand>,
    /// A pose for its own localization to start from.
    pub pose: Option<InitialPose>,
    /// Requests of nodes of ROS 2 to components.
    pub requests: Vec<ServiceRequest>,
    /// What else has happened, in words.
    pub notes: Vec<String>,
}

/// A command for a robot's navigation.
#[derive(Clone, Debug, PartialEq)]
pub enum TripCommand {
    /// Drive to a goal, which replaces any other.
    Start(Goal),
    /// End the trip.
    End,
}

/// A robot that senses, but does not obey its own software: it only keeps the last command.
pub(crate) struct PassiveRobot<'s> {
    pub(crate) sim: &'s mut Simulation,
    pub(crate) advice: VelocityCommand,
}

impl Robot for PassiveRobot<'_> {
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
