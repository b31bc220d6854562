//! From a run to a picture of one of its moments.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, GraphTransition, Label, LocationId, Monitor, ProgramGraph, Topology, Verdict};
use maps::{Place, Point, Pose};
use robot::RobotModel;

use crate::draw::{self, Frame, MapPicture, Scene};
use crate::live::Live;

/// The trail has a point this often, in metres.
const TRAIL_STEP_M: f64 = 0.10;
/// The battery's course has a point this often.
const BATTERY_PERIOD: Duration = Duration::from_secs(1);
/// More particles than this tell no more in a picture.
const MAX_PARTICLES: usize = 600;

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
    pub fn new(live: &Live) -> Self {
        let map = Arc::new(MapPicture::new(&live.scenario().map));
        let level_before = (live.time(), live.truth().battery().charge_pct);
        let mut camera = Self { map, trail: Vec::new(), battery: Vec::new(), level_before };
        camera.follow(live);
        camera
    }

    /// Keeps in mind where the run is now. Call it after every step.
    pub fn follow(&mut self, live: &Live) {
        let truth = live.truth();
        let position: Point = truth.pose().translation.vector.into();
        if self.trail.last().is_none_or(|last| (last - position).norm() >= TRAIL_STEP_M) {
            self.trail.push(position);
        }
        let now = (live.time(), truth.battery().charge_pct);
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
    pub fn frame(&self, live: &Live, seed: u64, caption: &str, over: bool) -> Frame {
        Frame {
            scenario: live.scenario().name.clone(),
            seed,
            caption: caption.to_owned(),
            time: live.time(),
            tick: live.system().ticks().saturating_sub(1),
            scene: self.scene(live),
            battery: self.battery(live),
            tree: tree(live),
            monitors: monitors(live, over),
        }
    }

    fn scene(&self, live: &Live) -> Scene {
        let (truth, scenario, software) = (live.truth(), live.scenario(), live.software());
        let mut trail = self.trail.clone();
        trail.push(truth.pose().translation.vector.into());
        let stride = software.particle_count().div_ceil(MAX_PARTICLES).max(1);
        Scene {
            map: Arc::clone(&self.map),
            robot: truth.pose(),
            robot_radius_m: software.model().radius_m,
            estimate: Some(software.estimate().pose),
            path: software.path().to_vec(),
            laser_hits: truth.scans().flat_map(|scan| hits(scan, &truth.pose(), software.model())).collect(),
            particles: software.particles().step_by(stride).map(|pose| pose.translation.vector.into()).collect(),
            trail,
            start: Some(scenario.start),
            station: Some(scenario.station),
            destination: scenario.places.get(&scenario.file.sites.destination.value).map(destination),
            faults: live.fault_courses().iter().flat_map(fault_marks).collect(),
            bodies: truth.obstacles().map(|obstacle| body(&obstacle)).collect(),
        }
    }

    fn battery(&self, live: &Live) -> draw::Battery {
        let state = live.truth().battery();
        let mut history = self.battery.clone();
        history.push((live.time(), state.charge_pct));
        draw::Battery {
            history,
            level_pct: state.charge_pct,
            charging: state.charging,
            thresholds: thresholds(),
            faults: live.fault_courses().iter().map(|course| (course.first().time, "fault".to_owned())).collect(),
        }
    }
}

/// The battery levels that mean something.
pub(crate) fn thresholds() -> Vec<draw::Threshold> {
    let threshold = |level_pct, label: &str, critical| draw::Threshold { level_pct, label: label.to_owned(), critical };
    vec![threshold(30.0, "recharge", false), threshold(20.0, "unsafe", true)]
}

/// Where the beams of a scan ended on something, in the `map` frame.
pub(crate) fn hits<'a>(
    scan: &'a robot::LaserScan,
    pose: &Pose,
    model: &'a RobotModel,
) -> impl Iterator<Item = Point> + use<'a> {
    let laser = &model.lasers[scan.laser];
    let at = pose * laser.mount;
    let ranges = scan.ranges_m.iter().enumerate().filter(|(_, range)| range.is_finite());
    ranges.map(move |(beam, &range)| {
        let (sin, cos) = libm::sincos(laser.beam_angle_rad(beam));
        at * Point::new(f64::from(range) * cos, f64::from(range) * sin)
    })
}

fn destination(place: &Place) -> draw::Destination {
    let corners = match place {
        Place::Area { corners } => corners.clone(),
        Place::Point { .. } => vec![place.goal_position()],
    };
    draw::Destination { label: "destination".to_owned(), corners }
}

/// A mark for each time that a fault took hold; the first says what it did.
fn fault_marks(course: &crate::live::FaultCourse<'_>) -> Vec<draw::FaultMark> {
    let label = |index| if index == 0 { course.words() } else { String::new() };
    let records = course.records.iter().enumerate();
    records.map(|(index, record)| draw::FaultMark { position: record.position, label: label(index) }).collect()
}

pub(crate) fn body(obstacle: &sim::ObstacleTruth<'_>) -> draw::Body {
    let pose = obstacle.pose;
    let shape = match obstacle.shape {
        sim::Shape::Disc { radius_m } => draw::BodyShape::Disc { center: pose.translation.vector.into(), radius_m },
        sim::Shape::Box { length_m, width_m } => draw::BodyShape::Rectangle { pose, length_m, width_m },
    };
    draw::Body { shape, label: obstacle.name.to_owned() }
}

fn tree(live: &Live) -> Vec<draw::TreeNode> {
    tree_nodes(&live.scenario().tree, &live.tree_states())
}

/// A tree as it is drawn, its nodes standing so; those of which nothing is known have not been ticked.
pub(crate) fn tree_nodes(tree: &bt::Tree, states: &[bt::NodeState]) -> Vec<draw::TreeNode> {
    let states = states.iter().copied().chain(std::iter::repeat(bt::NodeState::default()));
    let nodes = tree.nodes().iter().zip(states);
    nodes
        .map(|(node, state)| draw::TreeNode {
            parent: node.parent().map(bt::NodeId::index),
            label: node.kind().symbol().map_or_else(|| node.label().to_owned(), str::to_owned),
            status: node_status(&state),
        })
        .collect()
}

/// What a node did in the last tick, as pictures show it.
pub(crate) fn node_status(state: &bt::NodeState) -> draw::NodeStatus {
    match state.outcome {
        Some(bt::Outcome::Answered(bt::Status::Success)) => draw::NodeStatus::Success,
        Some(bt::Outcome::Answered(bt::Status::Failure)) => draw::NodeStatus::Failure,
        Some(bt::Outcome::Answered(bt::Status::Running)) => draw::NodeStatus::Running,
        Some(bt::Outcome::Halted | bt::Outcome::Answered(bt::Status::Skipped)) | None => draw::NodeStatus::NotTicked,
    }
}

fn monitors(live: &Live, over: bool) -> Vec<draw::Monitor> {
    let attached = live.watched().iter().zip(live.system().monitors());
    attached
        .map(|(watched, attached)| {
            let monitor = attached.monitor.as_ref();
            let decided = watched.decided.as_ref();
            draw::Monitor {
                name: watched.name.clone(),
                description: watched.summary.clone(),
                verdict: verdict(monitor, over),
                note: decided.map_or_else(String::new, |event| format!("at tick {}", event.tick)),
                diagram: diagram(monitor, live),
            }
        })
        .collect()
}

/// What can be said of a property now; `over` says whether the run has ended.
pub(crate) fn verdict(monitor: &dyn Monitor, over: bool) -> draw::Verdict {
    match (monitor.verdict(), over) {
        (Verdict::False, _) => draw::Verdict::Violated,
        (Verdict::Inconclusive, false) => draw::Verdict::HoldsSoFar,
        (Verdict::Inconclusive, true) if monitor.is_open() => draw::Verdict::Inconclusive,
        (Verdict::True | Verdict::Inconclusive, _) => draw::Verdict::Satisfied,
    }
}

fn diagram(monitor: &dyn Monitor, live: &Live) -> draw::Diagram {
    let Some((graph, active)) = monitor.graph() else { return draw::Diagram::default() };
    let is_failure = |index: usize| monitor.failures().iter().any(|failure| failure.index() == index);
    let locations = graph.locations().iter().enumerate();
    draw::Diagram {
        locations: locations
            .map(|(index, name)| draw::Location { name: name.clone(), error: is_failure(index) })
            .collect(),
        initial: graph.initial_locations().first().map_or(0, |initial| initial.index()),
        active: LocationId::index(active),
        transitions: transitions(graph, live.system().topology()),
    }
}

/// The transitions as a picture shows them. Loops are left out: a monitor without a matching transition stays where it
/// is. A receive action is named by what the message tells, and the negation of another transition's label is "else".
fn transitions(graph: &ProgramGraph, topology: &Topology) -> Vec<draw::Transition> {
    let shown = || graph.transitions().iter().filter(|transition| transition.from != transition.to);
    let label = |transition: &GraphTransition| {
        let caption = graph.caption(transition, topology);
        match &transition.label {
            Label::Receive(channel, _) if caption == topology.describe(*channel) => what_passes(topology, *channel),
            _ => caption,
        }
    };
    shown()
        .map(|transition| {
            let own = label(transition);
            let is_else = shown()
                .filter(|other| other.from == transition.from && other.to != transition.to)
                .any(|other| own == format!("not ({})", label(other)));
            let label = if is_else { "else".to_owned() } else { own };
            draw::Transition { from: transition.from.index(), to: transition.to.index(), label }
        })
        .collect()
}

/// What a channel's messages tell, in a word: `request`, or the last field of a reply, such as `level`.
fn what_passes(topology: &Topology, channel: ChannelId) -> String {
    let fields = topology.get(channel).domain.shapes().first().map_or(&[][..], |shape| shape.fields());
    let request = fields.first().filter(|(name, _)| name == "request");
    let told = request.or(fields.last()).map(|(name, _)| name.clone());
    told.unwrap_or_else(|| topology.ends(channel).0.to_owned())
}
