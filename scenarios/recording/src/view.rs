//! A run as its readers see it: the state after the records read so far.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Topology, Verdict};
use chrono::{DateTime, TimeDelta, Utc};
use maps::{Point, Pose};
use monitors::Outcome;

use crate::heard::{Heard, HeardLevels};
use crate::tree_failure::{self, Failures, TreeFailure};
use crate::{
    Decision, Details, End, EntryValue, FaultCourse, FaultRecord, Happening, Header, Monitor, MonitorEnd, MonitorState,
    Navigation, RobotState, Scene, Step, Tally, UndoneFault,
};

/// The latest time of a step, which MCAP can still write: after 584 years.
const LATEST: Duration = Duration::from_nanos(u64::MAX);

/// A record that does not fit those before it: it goes back in time, or refers to a fault, a node or a channel that
/// does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a record refers to something that does not exist in the run")]
pub struct Inconsistent;

/// A run up to the records applied so far: its history, where readers need it, and its current state.
#[derive(Clone, Debug)]
pub struct RunView {
    header: Arc<Header>,
    /// The last step, as it was recorded.
    step: Step,
    robot: RobotState,
    /// What the last step changed in it, apart from the battery's charge.
    changes: RobotState,
    outcomes: Vec<Option<bt::Outcome>>,
    /// For each tick of the last step, the outcomes before it.
    before_ticks: Vec<Vec<Option<bt::Outcome>>>,
    /// By the index of the blackboard in the header, and the key.
    entries: BTreeMap<(usize, String), EntryValue>,
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
    faults: Vec<FaultRecord>,
    undone: Vec<UndoneFault>,
    /// Whether each fault of the scenario has been due.
    due: Vec<bool>,
    /// Whether a person has caused any of them.
    has_acts: bool,
    tree_errors: Vec<TreeError>,
    lost: Vec<String>,
    given_up: Vec<GivenUp>,
    said: Vec<Said>,
    moves: Vec<Moved>,
    /// By the index of the place in the header: when the robot first came to rest there.
    reached: Vec<Option<Duration>>,
    /// Likewise: when it was first there, at rest or on its way.
    entered: Vec<Option<Duration>>,
    tally: Tally,
    heard: Heard,
    failures: Failures,
    end: Option<End>,
}

/// What applying a record gives if this program has made the record itself. Unlike those of a file, which may be
/// damaged, such records refer only to what their header contains and never go back in time.
///
/// # Panics
/// If a record does not fit: this is a mistake in what makes the records.
pub fn fitting<T>(applied: Result<T, Inconsistent>) -> T {
    applied.expect("a run's records refer only to what its header contains")
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
            outcomes: vec![None; header.tree.len()],
            before_ticks: Vec::new(),
            entries: BTreeMap::new(),
            locations: vec![None; header.topology.processes().count()],
            monitors: vec![MonitorState::default(); header.monitors.len()],
            decisions: vec![None; header.monitors.len()],
            navigation: None,
            scene: Arc::default(),
            seen_from: None,
            has_new_scene: false,
            has_new_states: true,
            faults: Vec::new(),
            undone: Vec::new(),
            due: vec![false; header.faults.len()],
            has_acts: false,
            tree_errors: Vec::new(),
            lost: Vec::new(),
            given_up: Vec::new(),
            said: Vec::new(),
            moves: Vec::new(),
            reached: vec![None; header.places().len()],
            entered: vec![None; header.places().len()],
            tally: Tally::default(),
            heard: Heard::new(&header.topology),
            failures: Failures::new(&header),
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
        self.note_entries(&changes);
        self.changes = changes;
        self.changes.battery = changes.battery.filter(|battery| battery.charging != was_charging);
        self.has_new_scene = false;
        self.has_new_states = !step.happenings.is_empty();
        self.before_ticks.clear();
        for happening in &step.happenings {
            self.note(happening)?;
        }
        if let Some(details) = &step.details {
            self.take_details(details)?;
        }
        (self.step.happenings, self.step.details) = (step.happenings, step.details);
        Ok(())
    }

    /// Notes the places at which the robot is for the first time.
    fn note_entries(&mut self, changes: &RobotState) {
        let Some(truth) = &changes.truth else { return };
        let position = truth.pose.translation.vector.into();
        for (place, entered) in self.header.places().iter().zip(&mut self.entered) {
            if entered.is_none() && place.covers(&position) {
                *entered = Some(self.step.time);
            }
        }
    }

    fn note(&mut self, happening: &Happening) -> Result<(), Inconsistent> {
        // Every index comes from a file that may be damaged. It is checked here, so that readers of the view need not.
        let now = self.step.time;
        let known = |index: usize| self.header.faults.get(index).cloned().ok_or(Inconsistent);
        match happening {
            Happening::FaultAdded(fault) => {
                Arc::make_mut(&mut self.header).faults.push(Arc::clone(fault));
                self.due.push(false);
                self.has_acts = true;
            }
            Happening::FaultBegan { fault: index, time, tick, position } => {
                let (fault, position) = (known(*index)?, *position);
                self.due[*index] = true;
                self.faults.push(FaultRecord { time: *time, until: None, tick: *tick, fault, index: *index, position });
            }
            Happening::FaultEnded { fault, time } => {
                let latest = self.faults.iter_mut().rfind(|record| record.index == *fault);
                latest.ok_or(Inconsistent)?.until = Some(*time);
            }
            Happening::FaultLeftUndone { fault, time, reason } => {
                self.undone.push(UndoneFault { time: *time, fault: known(*fault)?, reason: reason.clone() });
                self.due[*fault] = true;
            }
            Happening::TreeError { node, message, tick } => {
                check(*node < self.header.tree.len())?;
                let (node, message) = (*node, message.clone());
                self.tree_errors.push(TreeError { node, message, tick: *tick, time: now });
            }
            Happening::GivenUp { reason } => self.given_up.push(GivenUp { time: now, reason: reason.clone() }),
            Happening::Said { by, text } => {
                let by = self.header.topology.processes().nth(*by).ok_or(Inconsistent)?;
                let by = self.header.topology.name(by).to_owned();
                self.said.push(Said { time: now, by, text: text.clone() });
            }
            Happening::Moved { words } => self.moves.push(Moved { time: now, words: words.clone() }),
            Happening::Lost(gap) => {
                gap.channel.map_or(Ok(()), |channel| self.check_channel(channel))?;
                let moved = Moved { time: now, words: gap.why.clone() };
                // One loss may leave gaps in several channels.
                if self.moves.last() != Some(&moved) {
                    self.lost.push(gap.why.clone());
                    self.moves.push(moved);
                }
            }
            Happening::Resumed(channel) => self.check_channel(*channel)?,
            Happening::Verdict { monitor, decision } => {
                self.check_event(&decision.event)?;
                self.monitors.get_mut(*monitor).ok_or(Inconsistent)?.verdict = decision.verdict;
                self.decisions[*monitor] = Some(decision.clone());
            }
            Happening::Arrival { place } => {
                *self.reached.get_mut(*place).ok_or(Inconsistent)? = Some(now);
            }
        }
        Ok(())
    }

    fn take_details(&mut self, details: &Details) -> Result<(), Inconsistent> {
        self.has_new_states |= details.has_new_states();
        let Details { events, outcomes, before_ticks, transitions, entries, locations, monitors, navigation, scene } =
            details;
        events.iter().try_for_each(|event| self.check_event(event))?;
        let mut before_ticks = before_ticks.iter();
        for event in events {
            if let (EventKind::Tick, Some(outcomes)) = (&event.kind, before_ticks.next()) {
                self.set_outcomes(outcomes, event.tick.saturating_sub(1))?;
                self.before_ticks.push(self.outcomes.clone());
            }
            self.heard.note(event, &self.header.topology);
            self.failures.note(event);
        }
        self.set_outcomes(outcomes, self.step.ticks.saturating_sub(1))?;
        check(transitions.iter().all(|(node, _)| *node < self.header.tree.len()))?;
        for (board, key, value) in entries {
            check(*board < self.header.blackboards.len())?;
            let entry = (*board, key.clone());
            match value {
                Some(value) => drop(self.entries.insert(entry, value.clone())),
                None => drop(self.entries.remove(&entry)),
            }
        }
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

    /// Sets these outcomes, which the nodes have after this tick.
    fn set_outcomes(&mut self, outcomes: &[(usize, Option<bt::Outcome>)], tick: u64) -> Result<(), Inconsistent> {
        for (node, outcome) in outcomes {
            *self.outcomes.get_mut(*node).ok_or(Inconsistent)? = *outcome;
        }
        if !outcomes.is_empty() {
            self.failures.judge(&self.header, &self.outcomes, tick, self.step.time);
        }
        Ok(())
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
        &self.outcomes
    }

    /// For each tick of the last step, the last outcome of each node before it; empty if that is not known.
    #[must_use]
    pub fn outcomes_before_ticks(&self) -> &[Vec<Option<bt::Outcome>>] {
        &self.before_ticks
    }

    /// The entries of blackboards that are known: the name of the blackboard, the key, and the value.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str, &EntryValue)> {
        let named = self.entries.iter().map(|((board, key), value)| (board, key.as_str(), value));
        named.map(|(board, key, value)| (self.header.blackboards[*board].as_str(), key, value))
    }

    /// Says when a recording of something else began.
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
        self.failures.latest()
    }

    /// The leaves of the tree that are running, by name: skills, and nodes such as `Sleep`.
    pub fn running(&self) -> impl Iterator<Item = &str> {
        let tree = &self.header.tree;
        // The first child of a node comes right after it.
        let is_leaf = |node: usize| tree.get(node + 1).is_none_or(|next| next.parent != Some(node));
        let is_running = |&node: &usize| self.outcomes[node] == Some(bt::Outcome::Answered(bt::Status::Running));
        (0..tree.len()).filter(is_running).filter(move |&node| is_leaf(node)).map(|node| tree[node].process.as_str())
    }

    /// What the tree is doing, in words: the leaf that is running, or the node that made it fail. Empty without a tree.
    #[must_use]
    pub fn doing(&self) -> String {
        let names: Vec<&str> = self.running().collect();
        match tree_failure::cause(&self.header.tree, &self.outcomes) {
            _ if !names.is_empty() => format!("{} is running", names.join(", ")),
            Some(node) => format!("the tree failed, because {} failed", self.header.tree[node].process),
            None if self.header.tree.is_empty() => String::new(),
            None => "no leaf is running".to_owned(),
        }
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
        &self.faults
    }

    /// Whether a person has intervened: the scenario alone does not give this run.
    #[must_use]
    pub fn has_acts(&self) -> bool {
        self.has_acts
    }

    /// The faults that have taken effect so far, each with all its occurrences, in the order of the first.
    #[must_use]
    pub fn fault_courses(&self) -> Vec<FaultCourse<'_>> {
        FaultCourse::of(&self.faults)
    }

    /// The faults of the scenario that have not come so far: they neither took effect nor could not be injected.
    pub fn absent_faults(&self) -> impl Iterator<Item = &crate::Fault> {
        self.header.faults.iter().zip(&self.due).filter(|(_, due)| !**due).map(|(fault, _)| &**fault)
    }

    /// The faults that were due so far but could not be injected.
    #[must_use]
    pub fn undone_faults(&self) -> &[UndoneFault] {
        &self.undone
    }

    /// What its recording lacks, in words, in the order in which it was noticed.
    #[must_use]
    pub fn lost(&self) -> &[String] {
        &self.lost
    }

    /// The errors in the tree so far.
    #[must_use]
    pub fn tree_errors(&self) -> &[TreeError] {
        &self.tree_errors
    }

    /// The trips that navigation has given up so far.
    #[must_use]
    pub fn given_up(&self) -> &[GivenUp] {
        &self.given_up
    }

    /// What has happened around the processes so far, because the schedule of the run says so.
    #[must_use]
    pub fn moves(&self) -> &[Moved] {
        &self.moves
    }

    /// What speakers have said so far.
    #[must_use]
    pub fn said(&self) -> &[Said] {
        &self.said
    }

    /// The places by name, with the time at which the robot first came to rest at each; at one where it stood from the
    /// start, the time at which it first came back, if it has.
    pub fn visits(&self) -> impl Iterator<Item = (&str, Option<Duration>)> {
        self.header.places().iter().zip(&self.reached).map(|(place, reached)| (place.name.as_str(), *reached))
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
        self.header.places().iter().zip(&self.entered).map(|(place, entered)| (place.name.as_str(), *entered))
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

/// Checks that parents come before their children, in the tree and in machines: those who draw them rely on it, and a
/// circle would make them loop.
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

fn check(fits: bool) -> Result<(), Inconsistent> {
    if fits { Ok(()) } else { Err(Inconsistent) }
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

/// An error in a node of the tree, and when it first occurred.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeError {
    /// The node's index in the header.
    pub node: usize,
    /// The error, in words.
    pub message: String,
    /// The tick.
    pub tick: u64,
    /// Since the start of the run.
    pub time: Duration,
}

/// A trip that navigation gave up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GivenUp {
    /// Since the start of the run.
    pub time: Duration,
    /// Why, in words.
    pub reason: String,
}

/// Something that happened around the processes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moved {
    /// When.
    pub time: Duration,
    /// What, in words.
    pub words: String,
}

/// What a speaker said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    /// When it began, since the start of the run.
    pub time: Duration,
    /// The speaker's process.
    pub by: String,
    /// The text.
    pub text: String,
}
