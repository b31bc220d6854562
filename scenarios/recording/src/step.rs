//! A step of a run: what happened, and what has changed.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, Gap, Verdict};
use maps::{Point, Pose, Shape};
use monitors::{EventTime, Witness};
use robot::LaserScan;
use serde::{Deserialize, Serialize};

use crate::{Fault, MonitorState, Navigation, plain};

/// How much detail each step contains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// Only what determines the results of the run: enough for reports.
    #[default]
    Verdicts,
    /// Also [details](Details), with a scene where a [`SceneClock`](crate::SceneClock) needs one: for everything
    /// that shows a run.
    Full,
    /// The same, with a scene in each step.
    Scenes,
}

/// A step of a run. The first one is the initial state, before anything has happened.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Step {
    /// Since the start of the run, at the end of the step.
    pub time: Duration,
    /// How many ticks have been generated.
    pub ticks: u64,
    /// How many of them could not be delivered.
    pub overruns: u64,
    /// How many communications there have been.
    pub communications: u64,
    /// What has changed in the state of the robot.
    pub robot: RobotState,
    /// Events, in order.
    pub happenings: Vec<Happening>,
    /// Further details of the step; none if there are none.
    pub details: Option<Box<Details>>,
}

/// The state of the robot at the end of a step, as far as it is known; empty if there is no robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotState {
    /// Facts that are known only in a simulation.
    pub truth: Option<Truth>,
    /// The pose estimated by localization, in the `map` frame.
    #[serde(with = "plain::pose_if_any")]
    pub estimate: Option<Pose>,
    /// The battery.
    pub battery: Option<Battery>,
}

impl RobotState {
    /// Where the robot is, in the `map` frame: where it really is if that is known, or else where its software has it.
    #[must_use]
    pub fn pose(&self) -> Option<Pose> {
        self.truth.map(|truth| truth.pose).or(self.estimate)
    }

    /// The parts that differ from those of an earlier state. What is known once remains known.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            truth: self.truth.filter(|_| self.truth != earlier.truth),
            estimate: self.estimate.filter(|_| self.estimate != earlier.estimate),
            battery: self.battery.filter(|_| self.battery != earlier.battery),
        }
    }

    /// The state after these changes.
    pub(crate) fn with(&self, changes: &Self) -> Self {
        Self {
            truth: changes.truth.or(self.truth),
            estimate: changes.estimate.or(self.estimate),
            battery: changes.battery.or(self.battery),
        }
    }

    /// Whether the battery is known to be charging.
    #[must_use]
    pub fn is_charging(&self) -> bool {
        self.battery.is_some_and(|battery| battery.charging)
    }
}

/// The true state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Where the robot is, in the `map` frame.
    #[serde(with = "plain::pose")]
    pub pose: Pose,
    /// How far it has driven, in meters.
    pub distance_m: f64,
    /// The number of contacts with anything else so far.
    pub collisions: u64,
}

/// The state of the battery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Battery {
    /// Its charge, in percent.
    pub charge_pct: f64,
    /// Whether it is charging.
    pub charging: bool,
}

/// Something that has happened in a step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Happening {
    /// A user intervened: this fault is appended to those of the [header](crate::Header::faults).
    FaultAdded(Arc<Fault>),
    /// A fault took effect.
    FaultBegan {
        /// Its index in the [header](crate::Header::faults).
        fault: usize,
        /// When.
        time: Duration,
        /// The last tick that had been generated, if any.
        tick: Option<u64>,
        /// Where the robot was, in the `map` frame, if that is known.
        #[serde(with = "plain::point_if_any")]
        position: Option<Point>,
    },
    /// A fault ended.
    FaultEnded {
        /// Its index in the [header](crate::Header::faults).
        fault: usize,
        /// When.
        time: Duration,
    },
    /// A fault was due but could not be injected.
    FaultLeftUndone {
        /// Its index in the [header](crate::Header::faults).
        fault: usize,
        /// When.
        time: Duration,
        /// Why it could not be injected, in words.
        reason: String,
    },
    /// A new error in a node of the tree.
    TreeError {
        /// The node's index in the [header](crate::Header::tree).
        node: usize,
        /// The error, in words.
        message: String,
        /// The tick.
        tick: u64,
    },
    /// Navigation gave up a trip.
    GivenUp {
        /// Why, in words.
        reason: String,
    },
    /// A monitor gave its verdict.
    Verdict {
        /// Its index in the [header](crate::Header::monitors).
        monitor: usize,
        /// The verdict and its reason.
        decision: Decision,
    },
    /// A speaker began a text.
    Said {
        /// Its index in the topology.
        by: usize,
        /// The text.
        text: String,
    },
    /// Something happened around the processes: by the schedule of the run, or to the driver of the robot.
    Moved {
        /// What, in words.
        words: String,
    },
    /// The robot came to rest at a place for the first time, or for the first time after it stood there from the start.
    Arrival {
        /// Its index in the [header](crate::Header::places).
        place: usize,
    },
    /// Messages are missing: what depends on those in the gap may be wrong from here on.
    Lost(Gap),
    /// From here on, nothing more is missing on a channel: the gaps in its messages that end are over.
    Resumed(ChannelId),
}

/// A monitor's verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// The verdict: true or false.
    pub verdict: Verdict,
    /// The event that decided it.
    pub event: Event,
    /// Why the property is violated, if the monitor can explain it.
    pub witness: Option<Witness>,
}

impl Decision {
    /// When the verdict was reached: of a missed deadline in a timed property, the deadline itself, which may lie
    /// before the event that showed it.
    #[must_use]
    pub fn at(&self) -> EventTime {
        self.witness.as_ref().map_or_else(|| EventTime::of(&self.event), |witness| witness.settled)
    }
}

/// The details of a step, for everything that shows a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Details {
    /// The events of the step, in order.
    pub events: Vec<Event>,
    /// The nodes of the tree whose last outcome has changed: their index in the [header](crate::Header::tree), and the
    /// outcome; none if what it was is no longer known.
    pub outcomes: Vec<(usize, Option<bt::Outcome>)>,
    /// For each tick among the events, the same of the nodes whose last outcome had changed before it: a tick may end
    /// in the step in which the next one begins. Empty if that is not known.
    pub before_ticks: Vec<Vec<(usize, Option<bt::Outcome>)>>,
    /// The changes of status in the tree, in order: the node's index in the [header](crate::Header::tree), and the
    /// status in BehaviorTree.CPP's sense, none if it is idle. Empty unless the header has the
    /// [tree's XML](crate::Header::tree_xml).
    pub transitions: Vec<(usize, Option<bt::Status>)>,
    /// The entries of the tree's blackboards that have changed: the index of the blackboard in the
    /// [header](crate::Header::blackboards), the key, and the value, none if there is no longer any.
    pub entries: Vec<(usize, String, Option<EntryValue>)>,
    /// The skills and components that have changed their location: their index in the topology, and the location.
    pub locations: Vec<(usize, String)>,
    /// The monitors that have changed their state: their index in the [header](crate::Header::monitors), and the state.
    pub monitors: Vec<(usize, MonitorState)>,
    /// The status of navigation; none if nothing has changed.
    pub navigation: Option<Navigation>,
    /// The visible scene, where a picture may be taken.
    pub scene: Option<Arc<Scene>>,
}

impl Details {
    /// Whether there are no details.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.events.is_empty() && !self.has_new_states() && self.scene.is_none() && self.transitions.is_empty()
    }

    /// Whether outcomes, entries, locations, monitors or navigation have changed.
    pub(crate) fn has_new_states(&self) -> bool {
        let Self { outcomes, before_ticks, entries, locations, monitors, navigation, .. } = self;
        let is_still = outcomes.is_empty() && before_ticks.iter().all(Vec::is_empty);
        let is_still = is_still && entries.is_empty() && locations.is_empty() && monitors.is_empty();
        !is_still || navigation.is_some()
    }
}

/// The value of an entry of a blackboard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EntryValue {
    /// A whole number, or 0 and 1 for false and true.
    Whole(i64),
    /// A real number.
    Real(f64),
    /// A string.
    Text(String),
    /// The items of a queue, as text.
    List(Vec<String>),
    /// Anything else, as text.
    Other(String),
}

impl fmt::Display for EntryValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(number) => number.fmt(f),
            Self::Real(number) => number.fmt(f),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::List(items) => write!(f, "[{}]", items.join("; ")),
            Self::Other(text) => text.fmt(f),
        }
    }
}

impl From<&bt::Value> for EntryValue {
    fn from(value: &bt::Value) -> Self {
        match value {
            bt::Value::Int(number) => Self::Whole(*number),
            bt::Value::Real(number) => Self::Real(*number),
            bt::Value::Text(text) => Self::Text(text.to_string()),
            bt::Value::List(items) => Self::List(items.iter().map(ToString::to_string).collect()),
        }
    }
}

/// The visible scene at one moment of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// The last scan of each working laser.
    #[serde(with = "plain::scans")]
    pub scans: Vec<Arc<LaserScan>>,
    /// The positions of localization's particles, thinned to [some hundreds](Scene::MAX_PARTICLES), in the `map` frame.
    #[serde(with = "plain::points")]
    pub particles: Vec<Point>,
    /// The rest of the path that the robot is following, in the `map` frame.
    #[serde(with = "plain::points")]
    pub path: Vec<Point>,
    /// People, doors, boxes.
    pub bodies: Vec<Body>,
    /// What speakers are saying.
    pub speeches: Vec<String>,
}

impl Scene {
    /// More particles than this do not improve a picture.
    pub const MAX_PARTICLES: usize = 600;
}

/// A body in the world besides the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Its outline around its center.
    #[serde(with = "plain::ShapeRecord")]
    pub shape: Shape,
    /// The pose of its center, in the `map` frame.
    #[serde(with = "plain::pose")]
    pub pose: Pose,
}
