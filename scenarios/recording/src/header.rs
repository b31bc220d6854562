//! The first record of a run: everything that stays the same during it.

use std::sync::Arc;
use std::time::Duration;

use channels::Topology;
use chrono::{DateTime, Utc};
use maps::{OccupancyGrid, Point, Pose};
use monitors::{Formula, Outcome, Property, ScopeMonitor};
use robot::LaserSpec;
use serde::{Deserialize, Serialize};

use crate::{Graph, InputFile, Provenance, plain};

/// The name of the process that represents a run's tree: leaves send their messages to it.
pub const TREE: &str = "BT";

/// What is known about a run before its first step.
///
/// It is one record of a file, and each of its fields is looked up by itself. What belongs together is a struct of its
/// own, such as [`Origin`] and [`Premises`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Header {
    /// The version of the program that ran it.
    pub version: String,
    /// The commit from which that program was built, if it is known.
    pub commit: Option<String>,
    /// The scenario's name.
    pub scenario: String,
    /// What the scenario shows, on one line.
    pub about: String,
    /// Where the scenario comes from.
    pub origin: Origin,
    /// The effective parameters of robot, world and execution.
    pub settings: Vec<SettingGroup>,
    /// The root seed.
    pub seed: u64,
    /// Time between ticks; zero if ticks are unknown.
    pub tick: Duration,
    /// Time between steps; zero if the steps are the events of a model.
    pub dt: Duration,
    /// Whether the scenario has properties that were not watched in this run.
    pub unwatched: bool,
    /// The processes and channels, with the messages that may pass through them.
    #[serde(with = "plain::topology")]
    pub topology: Arc<Topology>,
    /// The nodes of the behavior tree, in document order.
    pub tree: Vec<Node>,
    /// The tree in the form in which BehaviorTree.CPP reports it; none if the changes of status of its nodes are not
    /// known.
    pub tree_xml: Option<String>,
    /// The names of the tree's blackboards: the ID of the main tree, and the paths of the subtrees.
    pub blackboards: Vec<String>,
    /// The processes that are skills, by name.
    pub skills: Vec<String>,
    /// The processes that are components, by name.
    pub components: Vec<String>,
    /// Those of them that were nodes of ROS 2, outside the program: another run need not be the same.
    #[serde(default)]
    pub remote: Vec<String>,
    /// Whether a controller outside the program drove the robot: the same holds.
    #[serde(default)]
    pub is_piloted: bool,
    /// The machines of the skills and components that have one.
    pub machines: Vec<Machine>,
    /// The watched properties, in the order of the scenario.
    pub monitors: Arc<[Monitor]>,
    /// The faults of the scenario, even those that never take effect.
    pub faults: Vec<Arc<Fault>>,
    /// Where the run takes place; none if tree, skills and components run without a map.
    pub premises: Option<Premises>,
    /// The robot's body; none if there is no robot.
    pub robot: Option<RobotBody>,
    /// When pictures are taken.
    pub snapshots: Snapshots,
    /// The expected results of the run.
    pub expected: Expected,
}

impl Header {
    /// Whether partners outside the program took part: another run need not be the same.
    #[must_use]
    pub fn has_partners(&self) -> bool {
        self.is_piloted || !self.remote.is_empty()
    }

    /// Whether it is known when the tree was ticked.
    #[must_use]
    pub fn knows_ticks(&self) -> bool {
        !self.tick.is_zero()
    }

    /// The places on the map, by name; none without a map.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        self.premises.as_ref().map_or(&[], |premises| &premises.places)
    }

    /// The robot's laser scanners; none without a robot.
    #[must_use]
    pub fn lasers(&self) -> &[LaserSpec] {
        self.robot.as_ref().map_or(&[], |robot| &robot.lasers)
    }

    /// What the run was made from.
    #[must_use]
    pub fn provenance(&self) -> Provenance {
        self.origin.provenance(self.commit.clone())
    }
}

/// Where a run takes place.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Premises {
    /// The map of the world.
    #[serde(with = "plain::grid")]
    pub map: Arc<OccupancyGrid>,
    /// The places on the map, by name.
    pub places: Vec<Place>,
    /// Where the robot starts, in the `map` frame.
    #[serde(with = "plain::pose")]
    pub start: Pose,
    /// Where the charging station stands, in the `map` frame, if there is one.
    #[serde(with = "plain::pose_if_any")]
    pub station: Option<Pose>,
    /// The place to which the robot is sent, for pictures.
    pub destination: Option<String>,
}

/// The body of a robot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RobotBody {
    /// The radius of its footprint, in meters.
    pub radius_m: f64,
    /// The laser scanners.
    #[serde(with = "plain::lasers")]
    pub lasers: Vec<LaserSpec>,
}

impl Origin {
    /// The same for a result of a program built from this commit.
    #[must_use]
    pub fn provenance(&self, commit: Option<String>) -> Provenance {
        let Self { argument, overrides, inputs, .. } = self.clone();
        Provenance { commit, scenario: argument, set: overrides, inputs }
    }
}

/// Where a scenario comes from, so that it can be run again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Its name on the command line.
    pub argument: String,
    /// The text of its file.
    pub text: String,
    /// What the command line changed, in the syntax of `--set`.
    pub overrides: Vec<String>,
    /// The files that it consists of, its own included.
    pub inputs: Vec<InputFile>,
    /// If it is not a scenario but a recording of something else: the command line that judges it again. `text` is then
    /// the mapping of its messages, if it has one.
    pub recorded: Option<String>,
    /// When it began, if that is known and it is such a recording.
    #[serde(skip)]
    pub began: Option<DateTime<Utc>>,
    /// Likewise, the robot's path by odometry alone, from where it was first localized on the map.
    #[serde(skip)]
    pub odometry: Vec<Point>,
}

/// The settings in one table of a scenario's file, given or not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SettingGroup {
    /// The table.
    pub title: String,
    /// The meaning of each, and key and value as the file has them or could have them.
    pub rows: Vec<(String, String)>,
}

/// A node of the behavior tree.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Node {
    /// The index of its parent, which comes before it.
    pub parent: Option<usize>,
    /// The name of its process, or its label.
    pub process: String,
    /// Its symbol in pictures; none for kinds that are shown by name.
    pub symbol: Option<String>,
    /// Whether it is a leaf.
    pub is_leaf: bool,
}

impl From<&bt::Node> for Node {
    fn from(node: &bt::Node) -> Self {
        Self {
            parent: node.parent().map(bt::NodeId::index),
            process: node.process().to_owned(),
            symbol: node.kind().symbol().map(str::to_owned),
            is_leaf: node.kind().is_leaf(),
        }
    }
}

/// The machine of a skill or a component, as in the scenario.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// The name of its process.
    pub process: String,
    /// Its states in document order, each after the one around it. The first is the machine itself.
    pub states: Vec<MachineState>,
}

/// A state of a machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineState {
    /// The index of the state around it, which comes before it.
    pub parent: Option<usize>,
    /// Its id, as in the location of the process; the name for the machine itself.
    pub name: String,
    /// Its transitions, in words.
    pub transitions: Vec<String>,
    /// Whether it is entered when the state around it is entered by default.
    pub is_default: bool,
    /// Whether its inner states are active together.
    pub is_parallel: bool,
    /// Whether it ends the state around it.
    pub is_final: bool,
}

/// A watched property.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Monitor {
    /// The property's name.
    pub name: String,
    /// Its formula, as written.
    pub property: String,
    /// What it requires, in a few words.
    pub summary: String,
    /// The formula that the monitor was made from; none for a monitor that was attached directly.
    pub formula: Option<Formula>,
    /// The monitor's graph, if it has one.
    pub graph: Option<Graph>,
}

impl Monitor {
    /// A property of the messages on channels.
    #[must_use]
    pub fn of(property: &Property, topology: &Topology) -> Self {
        Self {
            name: property.name.clone(),
            property: property.formula.clone(),
            summary: property.summary.clone(),
            formula: property.scope_monitor().map(ScopeMonitor::formula).cloned(),
            graph: Graph::of(property.monitor.as_ref(), topology),
        }
    }
}

/// A fault of the scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// The kind of fault.
    pub kind: String,
    /// Whether it happens at one instant and has no duration.
    pub momentary: bool,
    /// What it does, in words.
    pub words: String,
    /// The values of its parameters.
    pub arguments: Vec<(String, Argument)>,
}

/// The value of a fault's parameter, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Argument {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(u64),
    /// A text.
    Text(String),
    /// True or false.
    Flag(bool),
    /// A point or a pose: x and y in meters in the `map` frame, and an optional heading in degrees.
    Place(Vec<f64>),
    /// Several points, each x and y in meters in the `map` frame.
    Places(Vec<Vec<f64>>),
}

impl Argument {
    /// The value in the form that reports use.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        match self {
            Self::Number(number) => (*number).into(),
            Self::Whole(number) => (*number).into(),
            Self::Text(text) => text.as_str().into(),
            Self::Flag(flag) => (*flag).into(),
            Self::Place(numbers) => numbers.as_slice().into(),
            Self::Places(places) => places.iter().map(|numbers| serde_json::Value::from(numbers.as_slice())).collect(),
        }
    }
}

/// A named place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Its name.
    pub name: String,
    /// The corners of an area, or the single point of the place, in the `map` frame.
    #[serde(with = "plain::points")]
    pub corners: Vec<Point>,
    /// How far from a single point the robot may be and still be at the place, in meters; 0 for an area.
    pub tolerance_m: f64,
    /// Whether it is an area to keep out of.
    pub keep_out: bool,
    /// The highest speed in an area, in m/s.
    pub speed_mps: Option<f64>,
}

impl Place {
    /// Whether a robot at this position is at the place, whatever its heading.
    #[must_use]
    pub fn covers(&self, position: &Point) -> bool {
        match self.corners[..] {
            [point] => (position - point).norm() <= self.tolerance_m,
            _ => maps::is_inside(&self.corners, position),
        }
    }
}

/// An occasion for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SnapshotOccasion {
    /// The first step.
    Start,
    /// A fault takes effect.
    Fault,
    /// A monitor gives its verdict.
    Verdict,
    /// The robot comes to rest at a place.
    Arrival,
    /// The last step.
    End,
}

/// When pictures are taken.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Snapshots {
    /// On these occasions.
    pub at: Vec<SnapshotOccasion>,
    /// At these times.
    pub at_times: Vec<Duration>,
    /// At this interval.
    pub every: Option<Duration>,
}

/// The expected results of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Expected {
    /// The expected outcome of each property.
    pub outcomes: Vec<(String, Outcome)>,
    /// Properties that are questions, and not requirements: any verdict is as expected.
    pub open: Vec<String>,
    /// Whether all others are questions, too: those of a RoAML model are.
    pub others_are_open: bool,
    /// Places where the robot must have come to rest.
    pub reached: Vec<String>,
    /// Places where the robot must never have been, not even on its way.
    pub not_reached: Vec<String>,
    /// Skills, components and nodes of the tree in which an error must occur; in no other may one.
    pub errors: Vec<String>,
    /// The greatest permitted number of collisions.
    pub max_collisions: Option<u64>,
    /// The lowest permitted charge of the battery, in percent.
    pub min_battery_pct: Option<f64>,
    /// The greatest permitted localization error, in meters.
    pub max_localization_m: Option<f64>,
}

impl Expected {
    /// The expected outcome of a property, if there is one.
    #[must_use]
    pub fn of(&self, property: &str) -> Option<Outcome> {
        self.outcomes.iter().find(|(name, _)| name == property).map(|(_, outcome)| *outcome)
    }

    /// Whether nothing depends on the verdict of a property.
    #[must_use]
    pub fn is_open(&self, property: &str) -> bool {
        self.of(property).is_none() && (self.others_are_open || self.open.iter().any(|name| name == property))
    }

    /// Whether this verdict of a property is as expected. It is the one that is named; without one, a property
    /// must not be violated.
    #[must_use]
    pub fn admits(&self, property: &str, outcome: Outcome) -> bool {
        match self.of(property) {
            Some(expected) => outcome == expected,
            None => outcome != Outcome::Violated || self.is_open(property),
        }
    }

    /// Whether nothing is expected of any run.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self { open: self.open.clone(), others_are_open: self.others_are_open, ..Self::default() }
    }
}
