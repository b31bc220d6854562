//! From a run to a picture of one of its moments.

use std::sync::Arc;
use std::time::Duration;

use channels::Verdict;
use drawing::{self, Frame, MapPicture, Scene};
use maps::Point;
use recording::{BodyShape, FaultCourse, Graph, Header, MonitorState, MonitorView, Node, RunView};

/// The trail has a point this often, in metres.
const TRAIL_STEP_M: f64 = 0.10;
/// The battery's course has a point this often.
const BATTERY_PERIOD: Duration = Duration::from_secs(1);

/// Keeps what a picture needs of the past, and makes frames of the present.
#[derive(Clone, Debug)]
pub struct Camera {
    map: Arc<MapPicture>,
    trail: Vec<Point>,
    battery: Vec<(Duration, f64)>,
    /// Time and level in the step before.
    level_before: (Duration, f64),
}

impl Camera {
    /// The camera for a run.
    #[must_use]
    pub fn new(view: &RunView) -> Self {
        let map = Arc::new(MapPicture::new(&view.header().map));
        let level_before = (view.time(), view.robot().charge_pct);
        let mut camera = Self { map, trail: Vec::new(), battery: Vec::new(), level_before };
        camera.follow(view);
        camera
    }

    /// Keeps in mind where the run is now. Call it after every step.
    pub fn follow(&mut self, view: &RunView) {
        let position = view.position();
        if self.trail.last().is_none_or(|last| (last - position).norm() >= TRAIL_STEP_M) {
            self.trail.push(position);
        }
        let now = (view.time(), view.robot().charge_pct);
        let jumped = (now.1 - self.level_before.1).abs() > 1.0;
        if jumped {
            // A step, not a slope.
            self.battery.push(self.level_before);
        }
        if jumped || self.battery.last().is_none_or(|last| now.0 >= last.0 + BATTERY_PERIOD) {
            self.battery.push(now);
        }
        self.level_before = now;
    }

    /// The present moment of the run, with a sentence that says what is happening.
    #[must_use]
    pub fn frame(&self, view: &RunView, caption: &str) -> Frame {
        Frame {
            scenario: view.header().scenario.clone(),
            seed: view.header().seed,
            caption: caption.to_owned(),
            time: view.time(),
            tick: view.ticks().saturating_sub(1),
            scene: self.scene(view),
            battery: self.battery(view),
            tree: tree_nodes(&view.header().tree, view.outcomes()),
            monitors: view.monitors().map(|said| monitor(said, view.end().is_some())).collect(),
        }
    }

    fn scene(&self, view: &RunView) -> Scene {
        let (header, seen, pose) = (view.header(), view.scene(), view.pose());
        let mut trail = self.trail.clone();
        trail.push(view.position());
        Scene {
            map: Arc::clone(&self.map),
            robot: pose,
            robot_radius_m: header.robot_radius_m,
            estimate: Some(view.robot().estimate),
            path: seen.path.clone(),
            laser_hits: seen.scans.iter().flat_map(|scan| scan.hits(&header.lasers[scan.laser], &pose)).collect(),
            particles: seen.particles.clone(),
            trail,
            start: Some(header.start),
            station: header.station,
            destination: destination_of(header),
            faults: view.fault_courses().iter().flat_map(fault_marks).collect(),
            bodies: seen.bodies.iter().map(body).collect(),
        }
    }

    fn battery(&self, view: &RunView) -> drawing::Battery {
        let robot = view.robot();
        let mut history = self.battery.clone();
        history.push((view.time(), robot.charge_pct));
        drawing::Battery {
            history,
            level_pct: robot.charge_pct,
            charging: robot.charging,
            thresholds: thresholds(),
            faults: view.fault_courses().iter().map(|course| (course.first().time, "fault".to_owned())).collect(),
        }
    }
}

/// The battery levels that mean something.
pub fn thresholds() -> Vec<drawing::Threshold> {
    let threshold =
        |level_pct, label: &str, critical| drawing::Threshold { level_pct, label: label.to_owned(), critical };
    vec![threshold(30.0, "recharge", false), threshold(20.0, "unsafe", true)]
}

fn destination_of(header: &Header) -> Option<drawing::Destination> {
    let name = header.destination.as_ref()?;
    let place = header.places.iter().find(|place| place.name == *name)?;
    Some(drawing::Destination { label: "destination".to_owned(), corners: place.corners.clone() })
}

/// A mark for each time that a fault took hold; the first says what it did.
fn fault_marks(course: &FaultCourse<'_>) -> Vec<drawing::FaultMark> {
    let label = |index| if index == 0 { course.words() } else { String::new() };
    let records = course.records.iter().enumerate();
    records.map(|(index, record)| drawing::FaultMark { position: record.position, label: label(index) }).collect()
}

fn body(body: &recording::Body) -> drawing::Body {
    let pose = body.pose;
    let shape = match body.shape {
        BodyShape::Disc { radius_m } => drawing::BodyShape::Disc { center: pose.translation.vector.into(), radius_m },
        BodyShape::Box { length_m, width_m } => drawing::BodyShape::Rectangle { pose, length_m, width_m },
    };
    drawing::Body { shape, label: body.name.clone() }
}

/// A tree as it is drawn, its nodes standing so; those of which nothing is known have not been ticked.
pub fn tree_nodes(tree: &[Node], outcomes: &[Option<bt::Outcome>]) -> Vec<drawing::TreeNode> {
    let outcomes = outcomes.iter().copied().chain(std::iter::repeat(None));
    let nodes = tree.iter().zip(outcomes);
    nodes
        .map(|(node, outcome)| drawing::TreeNode {
            parent: node.parent,
            label: node.symbol.as_ref().unwrap_or(&node.process).clone(),
            status: node_status(outcome),
        })
        .collect()
}

/// What a node did in the last tick, as pictures show it.
pub fn node_status(outcome: Option<bt::Outcome>) -> drawing::NodeStatus {
    match outcome {
        Some(bt::Outcome::Answered(bt::Status::Success)) => drawing::NodeStatus::Success,
        Some(bt::Outcome::Answered(bt::Status::Failure)) => drawing::NodeStatus::Failure,
        Some(bt::Outcome::Answered(bt::Status::Running)) => drawing::NodeStatus::Running,
        Some(bt::Outcome::Halted | bt::Outcome::Answered(bt::Status::Skipped)) | None => drawing::NodeStatus::NotTicked,
    }
}

fn monitor(monitor: MonitorView<'_>, over: bool) -> drawing::Monitor {
    drawing::Monitor {
        name: monitor.name().to_owned(),
        description: monitor.about.summary.clone(),
        verdict: verdict(monitor.state, over),
        note: monitor.decision.map_or_else(String::new, |decision| format!("at tick {}", decision.event.tick)),
        diagram: match (&monitor.about.graph, monitor.state.active) {
            (Some(graph), Some(active)) => diagram(graph, active),
            _ => drawing::Diagram::default(),
        },
    }
}

/// What can be said of a property now; `over` says whether the run has ended.
pub fn verdict(state: &MonitorState, over: bool) -> drawing::Verdict {
    match (state.verdict, over) {
        (Verdict::False, _) => drawing::Verdict::Violated,
        (Verdict::Inconclusive, false) => drawing::Verdict::HoldsSoFar,
        (Verdict::Inconclusive, true) if state.is_open => drawing::Verdict::Inconclusive,
        (Verdict::True | Verdict::Inconclusive, _) => drawing::Verdict::Satisfied,
    }
}

fn diagram(graph: &Graph, active: usize) -> drawing::Diagram {
    let locations = graph.locations.iter();
    let transitions = graph.transitions.iter();
    drawing::Diagram {
        locations: locations
            .map(|location| drawing::Location { name: location.name.clone(), error: location.is_failure })
            .collect(),
        initial: graph.initial,
        active,
        transitions: transitions
            .map(|transition| drawing::Transition {
                from: transition.from,
                to: transition.to,
                label: transition.label.clone(),
            })
            .collect(),
    }
}
