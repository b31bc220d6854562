//! A run as its readers see it: the state after the records read so far.

mod incidents;
mod tree_view;
mod visits;

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Topology, Verdict};
use chrono::{DateTime, TimeDelta, Utc};
use maps::{Point, Pose};
use monitors::Outcome;

use crate::fault_course::FaultLog;
use crate::heard::{Heard, HeardLevels};
use crate::inconsistent::{Inconsistent, check};
use crate::tree_failure::TreeFailure;
use crate::{
    Decision, Details, End, EntryValue, FaultCourse, FaultRecord, Happening, Header, Monitor, MonitorEnd, MonitorState,
    Navigation, RobotState, Scene, Step, Tally, UndoneFault,
};
use incidents::Incidents;
pub use incidents::{GivenUp, Moved, Said};
pub use tree_view::TreeError;
use tree_view::TreeView;
use visits::Visits;

/// The latest time of a step, which MCAP can still write: after 584 years.
const LATEST: Duration = Duration::from_nanos(u64::MAX);

/// A run up to the records applied so far: its history, where readers need it, and its current state.
#[derive(Clone, Debug)]
pub struct RunView {
    header: Arc<Header>,
    /// The last step, as it was recorded.
    step: Step,
    robot: RobotState,
    /// What the last step changed in it, apart from the battery's charge.
    changes: RobotState,
    tree: TreeView,
    /// By the index of the process in the topology.
    locations: Vec<Option<String>>,
    monitors: Vec<MonitorState>,
    decisions: Vec<Option<Decision>>,
    navigation: Option<Navigation>,
    scene: Arc<Scene>,
    /// Where the robot was at that moment.
    seen_from: Option<Pose>,
    /// Whether the last step had it.
    has_new_scene: bool,
    /// Whether the last step may have changed outcomes, locations, monitors or navigation.
    has_new_states: bool,
    faults: FaultLog,
    incidents: Incidents,
    visits: Visits,
    tally: Tally,
    heard: Heard,
    end: Option<End>,
}

impl RunView {
    /// The run at its start; `start` is its first step, in which nothing has happened yet.
    ///
    /// # Errors
    /// [`Inconsistent`] if they do not fit.
    pub fn new(header: Header, start: Step) -> Result<Self, Inconsistent> {
        check_parents(&header)?;
        check_formulas(&header)?;
        let mut view = Self {
            step: Step::default(),
            tree: TreeView::new(&header),
            locations: vec![None; header.topology.processes().count()],
            monitors: vec![MonitorState::default(); header.monitors.len()],
            decisions: vec![None; header.monitors.len()],
            navigation: None,
            scene: Arc::default(),
            seen_from: None,
            has_new_scene: false,
            has_new_states: true,
            faults: FaultLog::of(&header),
            incidents: Incidents::default(),
            visits: Visits::of(header.places()),
            tally: Tally::default(),
            heard: Heard::new(&header.topology),
            end: None,
            robot: RobotState::default(),
            changes: RobotState::default(),
            header: Arc::new(header),
        };
        view.take(start)?;
        view.has_new_states = true;
        Ok(view)
    }

    /// Advances by one step.
    ///
    /// # Errors
    /// [`Inconsistent`] if it does not fit what came before it.
    pub fn apply(&mut self, step: Step) -> Result<(), Inconsistent> {
        self.take(step)?;
        self.tally.count_step();
        Ok(())
    }

    fn take(&mut self, step: Step) -> Result<(), Inconsistent> {
        check(step.time >= self.step.time && step.time <= LATEST)?;
        if step.details.is_none() && step.communications > self.step.communications {
            self.heard.miss();
        }
        self.step = Step { happenings: Vec::new(), details: None, ..step };
        let (changes, was_charging) = (self.step.robot, self.robot.is_charging());
        self.robot = self.robot.with(&changes);
        self.tally.note(self.step.time, &self.robot, &changes);
        if let Some(truth) = &changes.truth {
            self.visits.note_position(&truth.pose.translation.vector.into(), self.header.places(), self.step.time);
        }
        self.changes = changes;
        self.changes.battery = changes.battery.filter(|battery| battery.charging != was_charging);
        self.has_new_scene = false;
        self.has_new_states = !step.happenings.is_empty();
        self.tree.before_ticks.clear();
        for happening in &step.happenings {
            self.note(happening)?;
        }
        if let Some(details) = &step.details {
            self.take_details(details)?;
        }
        (self.step.happenings, self.step.details) = (step.happenings, step.details);
        Ok(())
    }

    fn note(&mut self, happening: &Happening) -> Result<(), Inconsistent> {
        // Every index comes from a file that may be damaged. It is checked here, so that readers of the view need not.
        let now = self.step.time;
        let known = |index: usize| self.header.faults.get(index).cloned().ok_or(Inconsistent);
        match happening {
            Happening::FaultAdded(fault) => {
                Arc::make_mut(&mut self.header).faults.push(Arc::clone(fault));
                self.faults.add();
            }
            Happening::FaultBegan { fault: index, time, tick, position } => {
                let (fault, position) = (known(*index)?, *position);
                self.faults.begin(FaultRecord {
                    time: *time,
                    until: None,
                    tick: *tick,
                    fault,
                    index: *index,
                    position,
                });
            }
            Happening::FaultEnded { fault, time } => self.faults.end(*fault, *time)?,
            Happening::FaultLeftUndone { fault: index, time, reason } => {
                let fault = known(*index)?;
                self.faults.leave_undone(*index, UndoneFault { time: *time, fault, reason: reason.clone() });
            }
            Happening::TreeError { node, message, tick } => {
                check(*node < self.header.tree.len())?;
                let (node, message) = (*node, message.clone());
                self.tree.errors.push(TreeError { node, message, tick: *tick, time: now });
            }
            Happening::GivenUp { reason } => {
                self.incidents.given_up.push(GivenUp { time: now, reason: reason.clone() });
            }
            Happening::Said { by, text } => {
                let by = self.header.topology.processes().nth(*by).ok_or(Inconsistent)?;
                let by = self.header.topology.name(by).to_owned();
                self.incidents.said.push(Said { time: now, by, text: text.clone() });
            }
            Happening::Moved { words } => self.incidents.moves.push(Moved { time: now, words: words.clone() }),
            Happening::Lost(gap) => {
                gap.channel.map_or(Ok(()), |channel| self.check_channel(channel))?;
                self.incidents.lose(gap, now);
            }
            Happening::Resumed(channel) => self.check_channel(*channel)?,
            Happening::Verdict { monitor, decision } => {
                self.check_event(&decision.event)?;
                self.monitors.get_mut(*monitor).ok_or(Inconsistent)?.verdict = decision.verdict;
                self.decisions[*monitor] = Some(decision.clone());
            }
            Happening::Arrival { place } => self.visits.reach(*place, now)?,
        }
        Ok(())
    }

    fn take_details(&mut self, details: &Details) -> Result<(), Inconsistent> {
        self.has_new_states |= details.has_new_states();
        let Details { events, locations, monitors, navigation, scene, .. } = details;
        events.iter().try_for_each(|event| self.check_event(event))?;
        events.iter().for_each(|event| self.heard.note(event, &self.header.topology));
        self.tree.take(details, &self.header, &self.step)?;
        for (process, location) in locations {
            *self.locations.get_mut(*process).ok_or(Inconsistent)? = Some(location.clone());
        }
        for (monitor, state) in monitors {
            self.set_monitor(*monitor, state)?;
        }
        if navigation.is_some() {
            self.navigation.clone_from(navigation);
        }
        scene.as_ref().map_or(Ok(()), |scene| self.set_scene(scene))
    }

    fn set_monitor(&mut self, monitor: usize, state: &MonitorState) -> Result<(), Inconsistent> {
        let graph = self.header.monitors.get(monitor).ok_or(Inconsistent)?.graph.as_ref();
        check(state.active.is_none_or(|active| graph.is_some_and(|graph| active < graph.locations.len())))?;
        self.monitors[monitor].clone_from(state);
        Ok(())
    }

    fn set_scene(&mut self, scene: &Arc<Scene>) -> Result<(), Inconsistent> {
        check(scene.scans.iter().all(|scan| scan.laser < self.header.lasers().len()))?;
        self.scene = Arc::clone(scene);
        self.seen_from = self.robot.pose();
        self.has_new_scene = true;
        Ok(())
    }

    fn check_event(&self, event: &Event) -> Result<(), Inconsistent> {
        let EventKind::Received { channel, .. } = &event.kind else { return Ok(()) };
        self.check_channel(*channel)
    }

    fn check_channel(&self, channel: ChannelId) -> Result<(), Inconsistent> {
        check(channel.index() < self.topology().channels().count())
    }

    /// Adds the verdicts that the end of the run decides to its last step.
    ///
    /// # Errors
    /// [`Inconsistent`] if they do not fit what came before.
    pub fn decide(&mut self, verdicts: Vec<Happening>) -> Result<(), Inconsistent> {
        verdicts.iter().try_for_each(|verdict| self.note(verdict))?;
        self.has_new_states |= !verdicts.is_empty();
        self.step.happenings.extend(verdicts);
        Ok(())
    }

    /// Finishes the run.
    ///
    /// # Errors
    /// [`Inconsistent`] if it does not fit what came before it.
    pub fn finish(&mut self, end: End) -> Result<(), Inconsistent> {
        check(end.monitors.len() == self.monitors.len() && end.messages_hit.len() == self.header.faults.len())?;
        for (monitor, ending) in end.monitors.iter().enumerate() {
            self.set_monitor(monitor, &ending.state)?;
        }
        self.has_new_states = true;
        if let Some(scene) = &end.scene {
            self.set_scene(scene)?;
        }
        self.end = Some(end);
        Ok(())
    }

    /// The header of the run.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The processes and channels.
    #[must_use]
    pub fn topology(&self) -> &Topology {
        &self.header.topology
    }

    /// The last step, as it was recorded.
    #[must_use]
    pub fn step(&self) -> &Step {
        &self.step
    }

    /// Time since the start of the run.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.step.time
    }

    /// How many ticks have been generated.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.step.ticks
    }

    /// How many of them could not be delivered.
    #[must_use]
    pub fn overruns(&self) -> u64 {
        self.step.overruns
    }

    /// How many communications there have been.
    #[must_use]
    pub fn communications(&self) -> u64 {
        self.step.communications
    }

    /// What is known of the robot: its true and estimated pose, its battery, the distance driven.
    #[must_use]
    pub fn robot(&self) -> &RobotState {
        &self.robot
    }

    /// The battery levels in the messages on a channel so far, if there were any; `None` if not all messages are known.
    #[must_use]
    pub fn heard(&self, channel: ChannelId) -> Option<Option<HeardLevels>> {
        self.heard.on(channel)
    }

    /// What the last step changed in the state of the robot, apart from the battery's charge.
    pub(crate) fn robot_changes(&self) -> &RobotState {
        &self.changes
    }

    /// Where the robot [is](RobotState::pose), in the `map` frame.
    #[must_use]
    pub fn position(&self) -> Option<Point> {
        self.robot.pose().map(|pose| pose.translation.vector.into())
    }

    /// The events of the last step, in order.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        self.step.details.as_deref().map_or(&[], |details| &details.events)
    }

    /// What happened in the last step, in order.
    #[must_use]
    pub fn happenings(&self) -> &[Happening] {
        &self.step.happenings
    }

    /// The last outcome of each node of the tree.
    #[must_use]
    pub fn outcomes(&self) -> &[Option<bt::Outcome>] {
        &self.tree.outcomes
    }

    /// For each tick of the last step, the last outcome of each node before it; empty if that is not known.
    #[must_use]
    pub fn outcomes_before_ticks(&self) -> &[Vec<Option<bt::Outcome>>] {
        &self.tree.before_ticks
    }

    /// The entries of blackboards that are known: the name of the blackboard, the key, and the value.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str, &EntryValue)> {
        let named = self.tree.entries.iter().map(|((board, key), value)| (board, key.as_str(), value));
        named.map(|(board, key, value)| (self.header.blackboards[*board].as_str(), key, value))
    }

    /// Sets when a recording of something else began.
    pub fn set_began(&mut self, began: Option<DateTime<Utc>>) {
        Arc::make_mut(&mut self.header).origin.began = began;
    }

    /// A time of the run as date and time of day, if it is such a recording and its clock is known.
    #[must_use]
    pub fn date(&self, time: Duration) -> Option<DateTime<Utc>> {
        self.header.origin.began?.checked_add_signed(TimeDelta::from_std(time).ok()?)
    }

    /// The latest failure of the whole tree; none if it never failed, or if nodes' answers were not recorded.
    #[must_use]
    pub fn tree_failure(&self) -> Option<TreeFailure> {
        self.tree.failures.latest()
    }

    /// The leaves of the tree that are running, by name: skills, and nodes such as `Sleep`.
    pub fn running(&self) -> impl Iterator<Item = &str> {
        self.tree.running(&self.header.tree)
    }

    /// What the tree is doing, in words: the leaf that is running, or the node that made it fail. Empty without a tree.
    #[must_use]
    pub fn doing(&self) -> String {
        self.tree.doing(&self.header.tree)
    }

    /// The location of a skill or a component, by its name.
    #[must_use]
    pub fn location(&self, process: &str) -> Option<&str> {
        self.locations[self.topology().find_process(process)?.index()].as_deref()
    }

    /// The locations of all skills and components, by their index in the topology.
    #[must_use]
    pub fn locations(&self) -> &[Option<String>] {
        &self.locations
    }

    /// The watched properties, with the states of their monitors.
    pub fn monitors(&self) -> impl ExactSizeIterator<Item = MonitorView<'_>> {
        (0..self.monitors.len()).map(|monitor| self.monitor(monitor))
    }

    /// The property with that index in the header, with the state of its monitor.
    ///
    /// # Panics
    /// If there is no such property.
    #[must_use]
    pub fn monitor(&self, monitor: usize) -> MonitorView<'_> {
        let state = &self.monitors[monitor];
        MonitorView {
            about: &self.header.monitors[monitor],
            state,
            // Messages that turn out to be missing take a verdict back.
            decision: self.decisions[monitor].as_ref().filter(|decision| decision.verdict == state.verdict),
            end: self.end.as_ref().map(|end| &end.monitors[monitor]),
        }
    }

    /// What navigation is doing, if that is known.
    #[must_use]
    pub fn navigation(&self) -> Option<&Navigation> {
        self.navigation.as_ref()
    }

    /// What is visible in the last step, if it has a scene.
    #[must_use]
    pub fn new_scene(&self) -> Option<&Scene> {
        self.has_new_scene.then_some(&self.scene)
    }

    /// Whether outcomes, locations, monitors or navigation may have changed in the last step.
    pub fn has_new_states(&self) -> bool {
        self.has_new_states
    }

    /// Whether nothing happened in the last step, and nothing has changed but the time and the battery's charge.
    pub(crate) fn is_quiet(&self) -> bool {
        let is_still = self.changes.pose().is_none() && self.changes.battery.is_none();
        is_still && self.events().is_empty() && !self.has_new_states && !self.has_new_scene
    }

    /// What was visible in the last scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Where the robot was in the last scene, in the `map` frame: the scans of that scene were taken there.
    #[must_use]
    pub fn seen_from(&self) -> Option<Pose> {
        self.seen_from
    }

    /// The faults that have taken effect so far.
    #[must_use]
    pub fn faults(&self) -> &[FaultRecord] {
        &self.faults.records
    }

    /// Whether a person has intervened: the scenario alone does not give this run.
    #[must_use]
    pub fn has_acts(&self) -> bool {
        self.faults.has_acts
    }

    /// The faults that have taken effect so far, each with all its occurrences, in the order of the first.
    #[must_use]
    pub fn fault_courses(&self) -> Vec<FaultCourse<'_>> {
        FaultCourse::of(&self.faults.records)
    }

    /// The faults of the scenario that have not come so far: they neither took effect nor could not be injected.
    pub fn absent_faults(&self) -> impl Iterator<Item = &crate::Fault> {
        self.faults.absent(&self.header.faults)
    }

    /// The faults that were due so far but could not be injected.
    #[must_use]
    pub fn undone_faults(&self) -> &[UndoneFault] {
        &self.faults.undone
    }

    /// What its recording lacks, in words, in the order in which it was noticed.
    #[must_use]
    pub fn lost(&self) -> &[String] {
        &self.incidents.lost
    }

    /// The errors in the tree so far.
    #[must_use]
    pub fn tree_errors(&self) -> &[TreeError] {
        &self.tree.errors
    }

    /// The trips that navigation has given up so far.
    #[must_use]
    pub fn given_up(&self) -> &[GivenUp] {
        &self.incidents.given_up
    }

    /// What has happened around the processes so far, because it is in the schedule of the run.
    #[must_use]
    pub fn moves(&self) -> &[Moved] {
        &self.incidents.moves
    }

    /// The texts of speakers so far.
    #[must_use]
    pub fn said(&self) -> &[Said] {
        &self.incidents.said
    }

    /// The places by name, with the time at which the robot first came to rest at each; at one where it stood from the
    /// start, the time at which it first came back, if it has.
    pub fn visits(&self) -> impl Iterator<Item = (&str, Option<Duration>)> {
        self.header.places().iter().zip(&self.visits.reached).map(|(place, reached)| (place.name.as_str(), *reached))
    }

    /// The places to which the robot has come, with the time at which it first came to rest at each.
    pub fn arrivals(&self) -> impl Iterator<Item = (&str, Duration)> {
        self.visits().filter_map(|(place, at)| Some((place, at.filter(|at| self.is_arrival(*at))?)))
    }

    /// Whether a robot that first came to rest at a place at this time has arrived there: one that stands there from
    /// the start is at rest there in the first step.
    #[must_use]
    pub fn is_arrival(&self, reached: Duration) -> bool {
        reached > self.header.dt
    }

    /// The places by name, with the time at which the robot was first at each, at rest or on its way: its true position
    /// was within the area, or within the tolerance of the point. Headings do not matter.
    pub fn entered(&self) -> impl Iterator<Item = (&str, Option<Duration>)> {
        self.header.places().iter().zip(&self.visits.entered).map(|(place, entered)| (place.name.as_str(), *entered))
    }

    /// Aggregates over the steps so far.
    #[must_use]
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// What is known about the run once it has ended.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }
}

/// Checks that parents come before their children, in the tree and in machines: drawing relies on it, and
/// would loop in a circle.
fn check_parents(header: &Header) -> Result<(), Inconsistent> {
    let later = |parent: Option<usize>, place: usize| parent.is_some_and(|parent| parent >= place);
    let mut parents = vec![header.tree.iter().map(|node| node.parent).collect::<Vec<_>>()];
    parents.extend(header.machines.iter().map(|machine| machine.states.iter().map(|state| state.parent).collect()));
    check(!parents.iter().any(|all| all.iter().enumerate().any(|(place, parent)| later(*parent, place))))
}

/// Checks that the channels of all formulas exist.
fn check_formulas(header: &Header) -> Result<(), Inconsistent> {
    let mut named = Vec::new();
    header.monitors.iter().filter_map(|monitor| monitor.formula.as_ref()).for_each(|formula| {
        formula.events(&mut |event| named.push(event.channel));
    });
    let channels = header.topology.channels().count();
    check(named.iter().all(|channel| channel.index() < channels))
}

/// A watched property, with the results of its monitor.
#[derive(Clone, Copy, Debug)]
pub struct MonitorView<'a> {
    /// The property.
    pub about: &'a Monitor,
    /// The state of the monitor.
    pub state: &'a MonitorState,
    /// Its verdict, once it is decided.
    pub decision: Option<&'a Decision>,
    /// Its final state.
    pub end: Option<&'a MonitorEnd>,
}

impl<'a> MonitorView<'a> {
    /// The property's name.
    #[must_use]
    pub fn name(&self) -> &'a str {
        &self.about.name
    }

    /// The outcome of the property if the run ends now.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        self.state.outcome()
    }

    /// The decision that violated the property, if it is violated.
    #[must_use]
    pub fn violation(&self) -> Option<&'a Decision> {
        self.decision.filter(|decision| decision.verdict == Verdict::False)
    }

    /// The monitor's final state; empty while the run goes on.
    #[must_use]
    pub fn ending(&self) -> MonitorEnd {
        self.end.cloned().unwrap_or_default()
    }
}
