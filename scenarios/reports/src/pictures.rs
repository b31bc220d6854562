//! Turns a moment of a run into a picture.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Relation, Shape, Topology, Value, Verdict};
use drawing::{self, Frame, MapPicture, Scene};
use maps::Point;
use monitors::{EventAtom, Formula, MessageCondition, MessageField, Term};
use recording::{
    FaultCourse, Follower, Graph, Happening, Header, LEVEL, MachineState, Monitor, MonitorState, MonitorView, Node,
    Premises, RunView,
};

/// The trail has a point this often, in meters.
const TRAIL_STEP_M: f64 = 0.10;
/// The component that reports the battery's level.
const BATTERY: &str = "BatteryReader";
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
            seed: view.header().seed,
            caption: caption.to_owned(),
            time: view.time(),
            tick: view.ticks().saturating_sub(1),
            scene: self.scene(view),
            battery: self.battery(view),
            tree: tree_nodes(&view.header().tree, view.outcomes()),
            monitors: view.monitors().map(|watched| monitor(watched, view.end().is_some())).collect(),
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
            thresholds: thresholds(view.header()),
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

/// The battery levels in the properties, each with the names of the properties that compare the level read by a skill
/// with it. A level that a property requires is critical; one that is only a condition is not.
pub fn thresholds(header: &Header) -> Vec<drawing::Threshold> {
    let mut thresholds: Vec<drawing::Threshold> = Vec::new();
    for monitor in header.monitors.iter() {
        for ComparedLevel { level_pct, critical, .. } in compared_levels(monitor, &header.topology) {
            match thresholds.iter_mut().find(|known| known.level_pct == level_pct) {
                Some(known) => {
                    known.critical |= critical;
                    if !known.label.split(", ").any(|name| name == monitor.name) {
                        known.label += &format!(", {}", monitor.name);
                    }
                }
                None => thresholds.push(drawing::Threshold { level_pct, label: monitor.name.clone(), critical }),
            }
        }
    }
    thresholds
}

/// A battery level with which a property compares those in messages.
pub(crate) struct ComparedLevel {
    /// The channel of the messages.
    pub(crate) channel: ChannelId,
    /// The level, in percent.
    pub(crate) level_pct: f64,
    /// Whether a lower level violates the property by itself.
    pub(crate) critical: bool,
}

/// The battery levels in a property.
pub(crate) fn compared_levels(monitor: &Monitor, topology: &Topology) -> Vec<ComparedLevel> {
    let mut levels = Levels { topology, found: Vec::new() };
    monitor.formula.iter().for_each(|formula| levels.of_formula(formula, Role { holds: true, alone: true }));
    levels.found
}

/// The battery levels in formulas.
struct Levels<'a> {
    topology: &'a Topology,
    found: Vec<ComparedLevel>,
}

/// What a part of a formula means for the whole.
#[derive(Clone, Copy)]
struct Role {
    /// Whether the part has to hold, rather than its negation.
    holds: bool,
    /// Whether it counts by itself, rather than as a condition or an alternative.
    alone: bool,
}

impl Role {
    fn negated(self) -> Self {
        Self { holds: !self.holds, ..self }
    }

    fn among_others(self) -> Self {
        Self { alone: false, ..self }
    }
}

impl Levels<'_> {
    fn of_formula(&mut self, formula: &Formula, role: Role) {
        match formula {
            Formula::Event(event) | Formula::Fresh(event) => self.of_event(event, role),
            // What happens at most zero times never happens.
            Formula::Count { event, is_at_most: true, count: 0, .. } if role.holds => {
                self.of_event(event, role.negated());
            }
            Formula::TimeUntil { event, .. } | Formula::Count { event, .. } => {
                self.of_event(event, role.among_others());
            }
            Formula::Not(part) => self.of_formula(part, role.negated()),
            Formula::Timed(part) | Formula::Next(part) => self.of_formula(part, role),
            Formula::Always(part) | Formula::Historically(_, part) if role.holds => self.of_formula(part, role),
            // What never holds is a requirement, too.
            Formula::Eventually(part) | Formula::Once(_, part) if !role.holds => self.of_formula(part, role),
            // `not (a and b)` is `a implies not b`.
            Formula::And(parts) => parts.iter().for_each(|part| self.of_formula(part, role)),
            Formula::Or(parts) if !role.holds => parts.iter().for_each(|part| self.of_formula(part, role)),
            Formula::Implies(a, b) if matches!(**b, Formula::False) => self.of_formula(a, role.negated()),
            Formula::Implies(a, b) => {
                self.of_formula(a, role.among_others());
                self.of_formula(b, role);
            }
            others => {
                others.operands().into_iter().for_each(|part| self.of_formula(part, role.among_others()));
            }
        }
    }

    fn of_event(&mut self, event: &EventAtom, role: Role) {
        let (from, _) = self.topology.ends(event.channel);
        if from == BATTERY {
            self.of_condition(&event.condition, event.channel, role);
        }
    }

    fn of_condition(&mut self, condition: &MessageCondition, channel: ChannelId, role: Role) {
        match condition {
            MessageCondition::Compare { field, relation, value } => {
                let most = matches!(relation, Relation::LessOrEqual | Relation::Less);
                let least = matches!(relation, Relation::GreaterOrEqual | Relation::Greater);
                self.of_comparison((field, value), (least, most), channel, role);
            }
            // `15 <= m.level`.
            MessageCondition::Relate { left: Term::Value(value), relation, right: Term::Field(field) } => {
                let most = matches!(relation, Relation::GreaterOrEqual | Relation::Greater);
                let least = matches!(relation, Relation::LessOrEqual | Relation::Less);
                self.of_comparison((field, value), (least, most), channel, role);
            }
            MessageCondition::True
            | MessageCondition::False
            | MessageCondition::Relate { .. }
            | MessageCondition::Remember { .. } => {}
            MessageCondition::Not(part) => self.of_condition(part, channel, role.negated()),
            MessageCondition::And(parts) => parts.iter().for_each(|part| self.of_condition(part, channel, role)),
            MessageCondition::Or(parts) if !role.holds => {
                parts.iter().for_each(|part| self.of_condition(part, channel, role));
            }
            MessageCondition::Or(parts) => {
                // `m[1] = <error> or level >= 15`: messages of other kinds have no level.
                let is_other_kind = |part: &&MessageCondition| {
                    matches!(part, MessageCondition::Compare { relation: Relation::Equal, value: Value::Symbol(_), .. })
                };
                let selects = parts.iter().filter(is_other_kind).count() + 1 == parts.len();
                let role = if selects { role } else { role.among_others() };
                parts.iter().for_each(|part| self.of_condition(part, channel, role));
            }
            MessageCondition::Implies(a, b) => {
                self.of_condition(a, channel, role.among_others());
                self.of_condition(b, channel, role);
            }
        }
    }

    /// A comparison of a field with a value, as a lower or an upper bound. Only what is required by itself is critical:
    /// a lower bound where the condition must hold, an upper bound where it must not.
    fn of_comparison(
        &mut self,
        (field, value): (&MessageField, &Value),
        (least, most): (bool, bool),
        channel: ChannelId,
        role: Role,
    ) {
        if let Some(level_pct) = value.as_number().filter(|_| (least || most) && self.is_level(channel, field)) {
            self.found.push(ComparedLevel { channel, level_pct, critical: role.alone && least == role.holds });
        }
    }

    /// Whether a field of a channel's messages is the battery's level.
    fn is_level(&self, channel: ChannelId, field: &MessageField) -> bool {
        let named = |shape: &Shape| {
            field.number.checked_sub(1).and_then(|at| shape.fields().get(at)).is_some_and(|(name, _)| name == LEVEL)
        };
        match &field.name {
            Some(name) => &**name == LEVEL,
            None => self.topology.get(channel).domain.shapes().iter().any(named),
        }
    }
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

/// A mark for each time a fault took effect; the first says what it did.
fn fault_marks(course: &FaultCourse<'_>) -> Vec<drawing::Mark> {
    let label = |index| if index == 0 { course.fault.words.clone() } else { String::new() };
    let records = course.records.iter().enumerate();
    let mark = |(index, record): (usize, &&recording::FaultRecord)| {
        Some(drawing::Mark { position: record.position?, label: label(index) })
    };
    records.filter_map(mark).collect()
}

/// A mark where the robot was when a property was violated.
pub(crate) fn violation_mark(monitor: MonitorView<'_>, position: Point) -> Option<drawing::Mark> {
    monitor.violation().map(|_| drawing::Mark { position, label: format!("{} violated", monitor.name()) })
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
            label: node.symbol.as_deref().unwrap_or_else(|| drawing::short_name(&node.process)).to_owned(),
            status: node_status(outcome),
        })
        .collect()
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

/// A property as pictures show it; `over` says whether the run has ended.
pub fn monitor(monitor: MonitorView<'_>, over: bool) -> drawing::Monitor {
    drawing::Monitor {
        name: monitor.name().to_owned(),
        description: monitor.about.summary.clone(),
        verdict: verdict(monitor.state, over),
        note: monitor.decision.map_or_else(String::new, |decision| format!("tick {}", decision.event.tick)),
        diagram: match (&monitor.about.graph, monitor.state.active) {
            (Some(graph), Some(active)) => diagram(graph, active),
            _ => drawing::Diagram::default(),
        },
    }
}

/// The verdict on a property now; `over` says whether the run has ended.
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
    use runs::Run;
    use scenarios::scenario::{Scenario, find};

    use super::*;

    /// The header of a scenario with this property file and other changes.
    fn header(overrides: &[&str]) -> Header {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let scenario = Scenario::load(&find::find("battery_fault").unwrap(), &overrides).unwrap();
        Run::new(Arc::new(scenario), 1, true).unwrap().header()
    }

    #[test]
    fn levels_are_those_of_the_properties() {
        let levels = |header: &Header| -> Vec<(f64, String, bool)> {
            thresholds(header).into_iter().map(|known| (known.level_pct, known.label, known.critical)).collect()
        };
        let shipped = [(20.0, "phi1".to_owned(), true), (30.0, "phi2, phi3".to_owned(), false)];
        assert_eq!(levels(&header(&[])), shipped);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.scope");
        let text = "property own := always not (BatteryReader, BatteryLevel, m[1] = <ok> and m[2] < 60)\n\
                    property other := always ((Navigation, GoToDestination, m[2] = <running>) implies true)\n";
        std::fs::write(&file, text).unwrap();
        let own = format!("properties=[\"{}\"]", file.display());
        assert_eq!(levels(&header(&[&own])), [(60.0, "own".to_owned(), true)]);
        assert_eq!(levels(&header(&["properties=[]"])), []);
    }

    #[test]
    fn a_required_level_is_critical_however_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.scope");
        let own = format!("properties=[\"{}\"]", file.display());
        let critical = |requirement: &str| {
            let text = requirement.replace("[", "(BatteryReader, BatteryLevel, ").replace(']', ")");
            std::fs::write(&file, format!("property own := {text}\n")).unwrap();
            thresholds(&header(&[&own])).iter().map(|known| (known.level_pct, known.critical)).collect::<Vec<_>>()
        };
        for requirement in [
            "always [level >= 15]",
            "always [15 <= level]",
            "always not [15 > level]",
            "always ([level < 15] implies false)",
            "always at most 0 [level < 15] in 10 s",
            "always [status = <error> or level >= 15]",
        ] {
            assert_eq!(critical(requirement), [(15.0, true)], "{requirement}");
        }
        for requirement in [
            "always [15 > level]",
            "always ([level < 15] implies next [level >= 0])",
            "always at most 1 [level < 15] in 10 s",
        ] {
            let found = critical(requirement);
            assert!(found.contains(&(15.0, false)), "{requirement}: {found:?}");
        }
    }

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
