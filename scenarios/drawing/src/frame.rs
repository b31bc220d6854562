//! The contents of a picture: one moment of a run, as plain data.
//!
//! Positions and poses are in the `map` frame, in meters and radians. Values that are not finite are left out of the
//! picture, and so are parents, locations and transitions that do not exist.

use std::sync::Arc;
use std::time::Duration;

use maps::{Point, Pose, Shape};

use super::map_picture::MapPicture;

/// One moment of a run.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Name of the scenario: the title.
    pub scenario: String,
    /// The run's root seed, if it is known.
    pub seed: Option<u64>,
    /// One sentence: what is happening, or why the picture was taken; may be empty.
    pub caption: String,
    /// Simulated time since the start of the run.
    pub time: Duration,
    /// Number of the last tick generated, if it is known.
    pub tick: Option<u64>,
    /// The map and everything on it, if there is a map.
    pub scene: Option<Scene>,
    /// The battery's level over time, if there is a battery.
    pub battery: Option<BatteryHistory>,
    /// The nodes of the behavior tree in document order, parents before their children.
    pub tree: Vec<TreeNode>,
    /// The monitors, most important first: where room is short, the last ones are drawn small or only counted.
    pub monitors: Vec<Monitor>,
}

/// The map and everything on it.
///
/// ```
/// use std::sync::Arc;
///
/// use drawing::canvas::Canvas;
/// use drawing::{Area, MapPicture, Mark, Scene, map_panel};
/// use maps::{Point, pose};
///
/// let map = Arc::new(MapPicture::new(&maps::house::map()));
/// let mut scene = Scene::new(map, pose(1.0, 0.5, 0.0), 0.3);
/// scene.trail = vec![Point::new(0.0, 0.0), Point::new(1.0, 0.5)];
/// let (label, short) = ("wheel slips".to_owned(), "slip".to_owned());
/// scene.faults.push(Mark { position: Point::new(0.5, 0.2), label, short });
///
/// let mut canvas = Canvas::new();
/// map_panel::draw(&mut canvas, Area::new(0.0, 0.0, 800.0, 600.0), &scene);
/// assert!(canvas.finish(800.0, 600.0).contains("wheel slips"));
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    /// The map, prepared once per run.
    pub map: Arc<MapPicture>,
    /// Where the robot truly is.
    pub robot: Pose,
    /// Radius of the robot's body, in meters.
    pub robot_radius_m: f64,
    /// The estimated pose of the robot; drawn if it visibly differs from the truth.
    pub estimate: Option<Pose>,
    /// The planned path from the robot to its goal; empty without one.
    pub path: Vec<Point>,
    /// Where laser beams hit something.
    pub laser_hits: Vec<Point>,
    /// The positions of localization's particles.
    pub particles: Vec<Point>,
    /// The robot's true positions so far, in order; a point every 5 to 20 cm is enough.
    pub trail: Vec<Point>,
    /// Where the run began.
    pub start: Option<Pose>,
    /// The charging station.
    pub station: Option<Station>,
    /// The robot's final goal.
    pub destination: Option<Place>,
    /// The other places of the run.
    pub places: Vec<Place>,
    /// Where faults took effect, oldest first.
    pub faults: Vec<Mark>,
    /// Where properties were violated, oldest first.
    pub violations: Vec<Mark>,
    /// People, closed doors, obstacles: everything that is solid but not on the map.
    pub bodies: Vec<Body>,
    /// The text that the robot is saying.
    pub speeches: Vec<String>,
}

impl Scene {
    /// A map with a robot of this radius (in meters) on it, and nothing else.
    #[must_use]
    pub fn new(map: Arc<MapPicture>, robot: Pose, robot_radius_m: f64) -> Self {
        Self {
            map,
            robot,
            robot_radius_m,
            estimate: None,
            path: Vec::new(),
            laser_hits: Vec::new(),
            particles: Vec::new(),
            trail: Vec::new(),
            start: None,
            station: None,
            destination: None,
            places: Vec::new(),
            faults: Vec::new(),
            violations: Vec::new(),
            bodies: Vec::new(),
            speeches: Vec::new(),
        }
    }
}

/// A charging station.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// Where it is; the heading is that of a docked robot.
    pub pose: Pose,
    /// Its name, for example `charging station`.
    pub label: String,
}

/// A place on the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its name, for example `kitchen`.
    pub label: String,
    /// Its corners in order if it is an area; only its position if it is a point.
    pub corners: Vec<Point>,
    /// Whether the robot must keep out of it.
    pub keep_out: bool,
}

/// Where the robot was when something went wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Its position.
    pub position: Point,
    /// What happened, in a few words: `level set to 10 %`, `phi1 violated`.
    pub label: String,
    /// The same in fewer words, for a map without room for these: `battery level`, `phi1`.
    pub short: String,
}

/// A solid thing that is not on the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its outline.
    pub shape: Shape,
    /// The pose of its center.
    pub pose: Pose,
    /// Its name (`person`, `door`); may be empty.
    pub label: String,
}

/// The battery's level since the start of the run.
#[derive(Clone, Debug, Default)]
pub struct BatteryHistory {
    /// Level in percent by time since the start of the run, oldest first. There may be any number: close ones are
    /// thinned out.
    pub history: Vec<(Duration, f64)>,
    /// The level now, in percent.
    pub level_pct: f64,
    /// Whether it is being charged now.
    pub charging: bool,
    /// Levels that mean something, as dashed lines.
    pub thresholds: Vec<Threshold>,
    /// When faults took effect, with a short label (`fault`), oldest first.
    pub faults: Vec<(Duration, String)>,
}

/// A battery level that means something.
#[derive(Clone, Debug, PartialEq)]
pub struct Threshold {
    /// The level, in percent.
    pub level_pct: f64,
    /// Its meaning, in a word or two: the properties that mention it.
    pub label: String,
    /// Whether a level below it is a violation (red) or only a turning point (amber).
    pub critical: bool,
}

/// A node of the behavior tree.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeNode {
    /// Index of the parent in [`Frame::tree`], smaller than the node's own; `None` for the root.
    pub parent: Option<usize>,
    /// The text in the node: the name of a leaf; the symbol of an inner node (`→` sequence, `?` fallback, `⇉` parallel)
    /// or the name of a decorator.
    pub label: String,
    /// The last answer of the node.
    pub status: NodeStatus,
}

/// The last answer of a node of the behavior tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum NodeStatus {
    /// Success at the last tick.
    Success,
    /// Failure at the last tick.
    Failure,
    /// Running at the last tick.
    Running,
    /// Not reached by the last tick, or halted.
    #[default]
    NotTicked,
}

/// A property under observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// The property's name.
    pub name: String,
    /// The property in one line, in words.
    pub description: String,
    /// The verdict so far.
    pub verdict: Verdict,
    /// More about the verdict in a few words (`tick 67`); may be empty.
    pub note: String,
    /// The monitor as a state machine.
    pub diagram: Diagram,
}

/// The verdict on a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// It has not been violated yet, and the run goes on.
    HoldsSoFar,
    /// It holds, whatever follows.
    Satisfied,
    /// It is violated, whatever follows.
    Violated,
    /// The run has ended without a decision.
    Inconclusive,
}

/// A state machine: locations and transitions, with the one location that is active.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagram {
    /// Its locations.
    pub locations: Vec<Location>,
    /// Index of the initial location.
    pub initial: usize,
    /// Index of the active location.
    pub active: usize,
    /// Its transitions.
    pub transitions: Vec<Transition>,
}

/// A location of a [`Diagram`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Location {
    /// Its name.
    pub name: String,
    /// Its meaning, in a few words; empty if the name is self-explanatory.
    pub about: String,
    /// Whether being there means that the property is violated.
    pub error: bool,
}

/// A transition of a [`Diagram`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transition {
    /// Index of the location it leaves.
    pub from: usize,
    /// Index of the location it enters.
    pub to: usize,
    /// What it waits for or does, in a few words: `< 20`.
    pub label: String,
}
