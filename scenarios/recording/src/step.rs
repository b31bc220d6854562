//! A step of a run: what it brought, and what has changed in it.

use std::sync::Arc;
use std::time::Duration;

use channels::{Event, Verdict};
use maps::{Point, Pose};
use monitors::Witness;
use robot::LaserScan;
use serde::{Deserialize, Serialize};

use crate::{MonitorState, plain};

/// How much is told of each step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// What decides what comes of the run: for reports alone.
    #[default]
    Verdicts,
    /// [Details], too, with a scene wherever a [`SceneClock`](crate::SceneClock) wants one: for everything that shows a
    /// run.
    Full,
    /// The same with a scene in each step.
    Scenes,
}

/// A step of a run. The first one is the state in which the run begins, before anything has happened.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Step {
    /// Since the start of the run, at the end of the step.
    pub time: Duration,
    /// How many ticks have been generated.
    pub ticks: u64,
    /// How many of them could not be delivered.
    pub overruns: u64,
    /// How many communications there have been.
    pub communications: u64,
    /// The robot.
    pub robot: RobotState,
    /// What has happened, in order.
    pub happenings: Vec<Happening>,
    /// What more there is to tell of the step.
    pub details: Option<Box<Details>>,
}

/// The robot at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotState {
    /// Where it really is, in the `map` frame.
    #[serde(with = "plain::pose")]
    pub pose: Pose,
    /// Where localization believes it to be, in the `map` frame.
    #[serde(with = "plain::pose")]
    pub estimate: Pose,
    /// The battery's charge, in percent.
    pub charge_pct: f64,
    /// Whether the battery is being charged.
    pub charging: bool,
    /// How far it has driven, in metres.
    pub distance_m: f64,
    /// How many contacts have begun between it and anything else.
    pub collisions: u64,
}

/// Something that has happened in a step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Happening {
    /// A fault took hold.
    FaultBegan {
        /// Its place in the [header](crate::Header::faults).
        fault: usize,
        /// When.
        time: Duration,
        /// The last tick that had been generated; none if none had.
        tick: Option<u64>,
        /// Where the robot was, in the `map` frame.
        #[serde(with = "plain::point")]
        position: Point,
    },
    /// A fault let go.
    FaultEnded {
        /// Its place in the [header](crate::Header::faults).
        fault: usize,
        /// When.
        time: Duration,
    },
    /// A fault was due and could not be done.
    FaultLeftUndone {
        /// Its place in the [header](crate::Header::faults).
        fault: usize,
        /// When.
        time: Duration,
        /// Why it could not be done, in words.
        reason: String,
    },
    /// Something went wrong in a node of the tree that had not before.
    TreeError {
        /// The node's place in the [header](crate::Header::tree).
        node: usize,
        /// What, in words.
        message: String,
        /// The tick.
        tick: u64,
    },
    /// Navigation gave a trip up.
    GivenUp {
        /// Why, in words.
        reason: String,
    },
    /// A monitor gave its verdict.
    Verdict {
        /// Its place in the [header](crate::Header::monitors).
        monitor: usize,
        /// The verdict, and why.
        decision: Decision,
    },
    /// The robot came to rest at a place for the first time.
    Arrival {
        /// Its place in the [header](crate::Header::places).
        place: usize,
    },
}

/// A monitor's verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// The verdict: true or false.
    pub verdict: Verdict,
    /// The event at which it fell.
    pub event: Event,
    /// Why the property is violated, where the monitor can say so.
    pub witness: Option<Witness>,
}

/// What a step tells to those who show a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Details {
    /// The events of the step, in order.
    pub events: Vec<Event>,
    /// What last happened to each node of the tree; none if that is as it was.
    pub outcomes: Option<Vec<Option<bt::Outcome>>>,
    /// The skills and components that are now elsewhere: their place in the topology, and their location.
    pub locations: Vec<(usize, String)>,
    /// The monitors that now stand elsewhere: their place in the [header](crate::Header::monitors), and how they stand.
    pub monitors: Vec<(usize, MonitorState)>,
    /// What navigation is doing; none if that is as it was.
    pub navigation: Option<Navigation>,
    /// What can be seen, where a picture may be taken.
    pub scene: Option<Scene>,
}

/// What navigation is doing, and why, each by its name or in words.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Navigation {
    /// Its status: `waiting_obstacle`.
    pub status: String,
    /// Why it has given up, or has no way, in words.
    pub reason: Option<String>,
    /// By what behaviour it is trying to get a way: `back_up`.
    pub recovery: Option<String>,
}

impl Navigation {
    /// The status with the reason and the behaviour, in words: `failing (back up): there is no path to the goal`.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words = self.status.replace('_', " ");
        if let Some(recovery) = &self.recovery {
            words += &format!(" ({})", recovery.replace('_', " "));
        }
        if let Some(reason) = &self.reason {
            words += &format!(": {reason}");
        }
        words
    }
}

/// What can be seen at a moment of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// The last scan of each laser that is not dead.
    #[serde(with = "plain::scans")]
    pub scans: Vec<Arc<LaserScan>>,
    /// Where localization's particles are, thinned to [some hundreds](Scene::MAX_PARTICLES), in the `map` frame.
    #[serde(with = "plain::points")]
    pub particles: Vec<Point>,
    /// What is left of the path that is being followed, in the `map` frame.
    #[serde(with = "plain::points")]
    pub path: Vec<Point>,
    /// People, doors, boxes.
    pub bodies: Vec<Body>,
}

impl Scene {
    /// More particles than this tell no more in a picture.
    pub const MAX_PARTICLES: usize = 600;
}

/// A body in the world besides the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Its outline about its centre.
    pub shape: BodyShape,
    /// Where its centre is, in the `map` frame.
    #[serde(with = "plain::pose")]
    pub pose: Pose,
}

/// A body's outline about its centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum BodyShape {
    /// A disc.
    Disc {
        /// Its radius, in metres.
        radius_m: f64,
    },
    /// A rectangle.
    Box {
        /// Its length along x, in metres.
        length_m: f64,
        /// Its width along y, in metres.
        width_m: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_tell_the_reason_and_the_behaviour() {
        let mut navigation = Navigation { status: "preparing_before_move".to_owned(), reason: None, recovery: None };
        assert_eq!(navigation.words(), "preparing before move");
        navigation.status = "failing".to_owned();
        navigation.reason = Some("there is no path to the goal".to_owned());
        navigation.recovery = Some("back_up".to_owned());
        assert_eq!(navigation.words(), "failing (back up): there is no path to the goal");
    }
}
