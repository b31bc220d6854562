//! Turns a moment of a run into a picture.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use channels::Verdict;
use drawing::{self, Frame, MapPicture, Scene};
use maps::Point;
use recording::{
    Argument, Decision, FaultCourse, Follower, Graph, Happening, MachineState, MonitorState, MonitorView, Node,
    Premises, RunView,
};

use crate::bounds;

/// The trail has a point this often, in meters.
const TRAIL_STEP_M: f64 = 0.10;
/// The battery's curve has a point this often.
const BATTERY_PERIOD: Duration = Duration::from_secs(1);

/// Keeps what a picture needs from the past, and makes frames of the present.
#[derive(Clone, Debug)]
pub struct Camera {
    /// None without a map.
    map: Option<Arc<MapPicture>>,
    trail: Vec<Point>,
    battery: Vec<(Duration, f64)>,
    /// Time and level in the previous step, if there is a battery.
    level_before: Option<(Duration, f64)>,
    violations: Vec<drawing::Mark>,
}

impl Camera {
    /// The camera for a run.
    #[must_use]
    pub fn new(view: &RunView) -> Self {
        let map = view.header().premises.as_ref().map(|premises| Arc::new(MapPicture::new(&premises.map)));
        let mut camera =
            Self { map, trail: Vec::new(), battery: Vec::new(), level_before: None, violations: Vec::new() };
        camera.note(view);
        camera
    }

    /// Remembers the present state of the run.
    fn note(&mut self, view: &RunView) {
        let is_new = |position: &Point| self.trail.last().is_none_or(|last| (last - position).norm() >= TRAIL_STEP_M);
        let position = view.position().filter(is_new);
        self.trail.extend(position);
        for happening in view.happenings() {
            if let (Happening::Verdict { monitor, .. }, Some(position)) = (happening, view.position()) {
                self.violations.extend(violation_mark(view.monitor(*monitor), position));
            }
        }
        let Some(now) = level(view) else { return };
        let before = self.level_before.filter(|before| (now.1 - before.1).abs() > 1.0);
        // A step, not a slope.
        self.battery.extend(before);
        if before.is_some() || self.battery.last().is_none_or(|last| now.0 >= last.0 + BATTERY_PERIOD) {
            self.battery.push(now);
        }
        self.level_before = Some(now);
    }

    /// The present moment of the run, with a sentence about what is happening.
    #[must_use]
    pub fn frame(&self, view: &RunView, caption: &str) -> Frame {
        Frame {
            scenario: view.header().scenario.clone(),
            seed: Some(view.header().seed).filter(|_| view.header().knows_ticks()),
            caption: caption.to_owned(),
            time: view.time(),
            tick: Some(view.ticks().saturating_sub(1)).filter(|_| view.header().knows_ticks()),
            scene: self.scene(view),
            battery: self.battery(view),
            tree: tree_nodes(&view.header().tree, view.outcomes()),
            monitors: view.monitors().map(|watched| monitor(watched, view)).collect(),
        }
    }

    /// What the map shows; none without a map or a robot.
    fn scene(&self, view: &RunView) -> Option<Scene> {
        let (header, seen, pose) = (view.header(), view.scene(), view.robot().pose()?);
        let (map, premises, robot) = (self.map.as_ref()?, header.premises.as_ref()?, header.robot.as_ref()?);
        let trail = self.trail.iter().copied().chain(view.position());
        Some(Scene {
            map: Arc::clone(map),
            robot: pose,
            robot_radius_m: robot.radius_m,
            estimate: view.robot().estimate,
            path: seen.path.clone(),
            laser_hits: seen.scans.iter().flat_map(|scan| scan.hits(&robot.lasers[scan.laser], &pose)).collect(),
            particles: seen.particles.clone(),
            trail: trail.collect(),
            start: Some(premises.start),
            station: station(premises),
            destination: premises.places.iter().find(|place| is_destination(place, premises)).map(place),
            places: other_places(premises),
            faults: view.fault_courses().iter().flat_map(fault_marks).collect(),
            violations: self.violations.clone(),
            bodies: seen.bodies.iter().map(body).collect(),
            speeches: seen.speeches.clone(),
        })
    }

    fn battery(&self, view: &RunView) -> Option<drawing::BatteryHistory> {
        let recording::Battery { charge_pct, charging } = view.robot().battery?;
        let mut history = self.battery.clone();
        history.push((view.time(), charge_pct));
        Some(drawing::BatteryHistory {
            history,
            level_pct: charge_pct,
            charging,
            thresholds: bounds::thresholds(view.header()),
            faults: view.faults().iter().map(|record| (record.time, "fault".to_owned())).collect(),
        })
    }
}

impl Follower for Camera {
    type Error = Infallible;

    fn follow(&mut self, view: &RunView) -> Result<(), Infallible> {
        self.note(view);
        Ok(())
    }
}

/// Time and level of the battery, if there is one.
fn level(view: &RunView) -> Option<(Duration, f64)> {
    view.robot().battery.map(|battery| (view.time(), battery.charge_pct))
}

fn place(place: &recording::Place) -> drawing::Place {
    let rule = match (place.keep_out, place.speed_mps) {
        (true, _) => " (keep out)".to_owned(),
        (false, Some(speed_mps)) => format!(" ({speed_mps} m/s)"),
        (false, None) => String::new(),
    };
    let label = format!("{}{rule}", place.name);
    drawing::Place { label, corners: place.corners.clone(), keep_out: place.keep_out }
}

fn is_destination(place: &recording::Place, premises: &Premises) -> bool {
    premises.destination.as_ref() == Some(&place.name)
}

/// Whether a place is at that point.
fn is_at(place: &recording::Place, pose: &maps::Pose) -> bool {
    let point = Point::from(pose.translation.vector);
    matches!(place.corners[..], [corner] if (corner - point).norm() < 0.05)
}

/// The charging station, with the name of the place where it stands.
fn station(premises: &Premises) -> Option<drawing::Station> {
    let pose = premises.station?;
    let named = premises.places.iter().find(|place| is_at(place, &pose));
    let label = named.map_or_else(|| "charging station".to_owned(), |place| place.name.clone());
    Some(drawing::Station { pose, label })
}

/// The places that are neither start nor station nor destination.
fn other_places(premises: &Premises) -> Vec<drawing::Place> {
    let is_marked = |known: &recording::Place| {
        is_destination(known, premises)
            || is_at(known, &premises.start)
            || premises.station.is_some_and(|station| is_at(known, &station))
    };
    premises.places.iter().filter(|known| !is_marked(known)).map(place).collect()
}

/// A mark for each time a fault took effect, where it put something or where the robot was; the first has words.
fn fault_marks(course: &FaultCourse<'_>) -> Vec<drawing::Mark> {
    let label = |index| if index == 0 { course.fault.words.replace('`', "") } else { String::new() };
    let put = course.fault.arguments.iter().find_map(|(name, argument)| match (name.as_str(), argument) {
        ("at", Argument::Place(at)) => Some(Point::new(*at.first()?, *at.get(1)?)),
        _ => None,
    });
    let records = course.records.iter().enumerate();
    let mark = |(index, record): (usize, &&recording::FaultRecord)| {
        let short = course.fault.kind.replace('_', " ");
        Some(drawing::Mark { position: put.or(record.position)?, label: label(index), short })
    };
    records.filter_map(mark).collect()
}

/// A mark where the robot was when a property was violated.
pub(crate) fn violation_mark(monitor: MonitorView<'_>, position: Point) -> Option<drawing::Mark> {
    let short = monitor.name().to_owned();
    monitor.violation().map(|_| drawing::Mark { position, label: format!("{short} violated"), short })
}

fn body(body: &recording::Body) -> drawing::Body {
    drawing::Body { shape: body.shape, pose: body.pose, label: body.name.clone() }
}

/// A tree to draw, with the outcomes of its nodes. Nodes without a known outcome have not been ticked.
pub fn tree_nodes(tree: &[Node], outcomes: &[Option<bt::Outcome>]) -> Vec<drawing::TreeNode> {
    let outcomes = outcomes.iter().copied().chain(std::iter::repeat(None));
    let nodes = tree.iter().zip(outcomes);
    nodes
        .map(|(node, outcome)| drawing::TreeNode {
            parent: node.parent,
            label: node_label(node),
            status: node_status(outcome),
        })
        .collect()
}

/// The text in a node: the sign of its kind, and its name if it has one of its own.
fn node_label(node: &Node) -> String {
    let is_named = !bt::Kind::BUILTIN.iter().any(|kind| kind.name() == node.process);
    match &node.symbol {
        Some(symbol) if is_named => format!("{symbol} {}", node.process),
        Some(symbol) => symbol.clone(),
        None => drawing::short_name(&node.process).to_owned(),
    }
}

/// The last outcome of a node, as pictures show it.
pub fn node_status(outcome: Option<bt::Outcome>) -> drawing::NodeStatus {
    match outcome {
        Some(bt::Outcome::Answered(bt::Status::Success)) => drawing::NodeStatus::Success,
        Some(bt::Outcome::Answered(bt::Status::Failure)) => drawing::NodeStatus::Failure,
        Some(bt::Outcome::Answered(bt::Status::Running)) => drawing::NodeStatus::Running,
        Some(bt::Outcome::Halted | bt::Outcome::Answered(bt::Status::Skipped)) | None => drawing::NodeStatus::NotTicked,
    }
}

/// A machine as a standalone SVG picture.
#[must_use]
pub fn machine_svg(machine: &recording::Machine) -> String {
    drawing::state_chart_svg(&state(&machine.states, 0))
}

/// The state with this index, with everything inside it.
fn state(states: &[MachineState], index: usize) -> drawing::State {
    let Some(known) = states.get(index) else { return drawing::State::default() };
    let inner = states.iter().enumerate().filter(|(_, inner)| inner.parent == Some(index));
    drawing::State {
        title: known.name.clone(),
        lines: known.transitions.clone(),
        is_default: known.is_default,
        is_parallel: known.is_parallel,
        is_final: known.is_final,
        inner: inner.map(|(place, _)| state(states, place)).collect(),
    }
}

/// A property of a run as pictures show it.
pub fn monitor(monitor: MonitorView<'_>, view: &RunView) -> drawing::Monitor {
    drawing::Monitor {
        name: monitor.name().to_owned(),
        description: monitor.about.summary.clone(),
        verdict: verdict(monitor.state, view.end().is_some()),
        note: monitor.decision.map_or_else(String::new, |decision| when(decision, view)),
        diagram: match (&monitor.about.graph, monitor.state.active) {
            (Some(graph), Some(active)) => diagram(graph, active),
            _ => drawing::Diagram::default(),
        },
    }
}

/// When a verdict was reached: the tick, or else the time.
pub(crate) fn when(decision: &Decision, view: &RunView) -> String {
    match view.header().knows_ticks() {
        true => format!("tick {}", decision.at().tick),
        false => format!("{} s", recording::decimals(decision.at().time.as_secs_f64(), 2)),
    }
}

/// The verdict on a property now; `over` is whether the run has ended.
pub fn verdict(state: &MonitorState, over: bool) -> drawing::Verdict {
    match (state.verdict, over) {
        (Verdict::False, _) => drawing::Verdict::Violated,
        (Verdict::Inconclusive, false) => drawing::Verdict::HoldsSoFar,
        (Verdict::Inconclusive, true) if state.is_open => drawing::Verdict::Inconclusive,
        (Verdict::True | Verdict::Inconclusive, _) => drawing::Verdict::Satisfied,
    }
}

/// A graph in this location.
#[must_use]
pub fn diagram(graph: &Graph, active: usize) -> drawing::Diagram {
    let locations = graph.locations.iter();
    let transitions = graph.transitions.iter();
    drawing::Diagram {
        locations: locations
            .map(|location| drawing::Location {
                name: location.name.clone(),
                about: monitors::location_meaning(&location.name).unwrap_or_default().to_owned(),
                error: location.is_failure,
            })
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

#[cfg(test)]
mod tests {
    use recording::Header;

    use super::*;
    use crate::bounds::tests::header;

    #[test]
    fn places_have_their_own_names() {
        let camera = |header: &Header| {
            let premises = header.premises.as_ref().unwrap();
            let names = other_places(premises).into_iter().map(|place| place.label).collect::<Vec<_>>();
            (station(premises).map(|station| station.label), names)
        };
        let station = Some("RechargingStation".to_owned());
        assert_eq!(camera(&header(&[])), (station.clone(), vec![]));
        assert_eq!(camera(&header(&["sites.destination=\"start\""])), (station, vec!["Destination".to_owned()]));
    }

    #[test]
    fn every_sign_in_a_tree_is_explained() {
        for symbol in bt::Kind::BUILTIN.into_iter().filter_map(bt::Kind::symbol) {
            assert!(drawing::SYMBOLS.iter().any(|(known, _)| *known == symbol), "{symbol}");
        }
    }
}
