//! When each fault of a run begins and ends.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Event, EventKind, ProcessId};
use maps::{Place, Places, Pose};
use monitors::OwnWorld;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::Streams;
use scenarios::Complaints;
use scenarios::faults::{Fault, Trigger};
use scenarios::names::unknown;
use scenarios::occurrences::occurrences;
use skills::SkillProcess;

/// The inputs of triggers: the run at the start of a step.
pub(crate) struct Observation<'a> {
    pub(crate) now: Duration,
    /// The robot's true pose, if there is a robot.
    pub(crate) pose: Option<Pose>,
    /// Tree, skills and components.
    pub(crate) system: &'a ChannelSystem,
    /// The events of the previous step.
    pub(crate) events: &'a [Event],
}

/// The beginning or end of a fault, given by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DueChange {
    /// It becomes active.
    Begins(usize),
    /// It ends.
    Ends(usize),
}

/// The faults of a scenario, each with its state.
#[derive(Debug)]
pub(crate) struct Timetable {
    faults: Vec<TimedFault>,
    /// The indices of the active faults: of thousands, few are active at once.
    holding: BTreeSet<usize>,
}

#[derive(Debug)]
struct TimedFault {
    fault: Arc<Fault>,
    watch: Watch,
    /// How often it may still become active.
    left: u64,
    state: Phase,
    rng: ChaCha8Rng,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Waiting,
    /// It has been active since this time.
    Holding(Duration),
}

/// A trigger with resolved names, and its memory.
#[derive(Debug)]
enum Watch {
    Time { next: Option<Duration>, every: Option<Duration> },
    Tick { number: u64, passed: bool },
    Near { place: Place, within_m: f64, was_near: bool },
    Message(Vec<monitors::EventAtom>, OwnWorld),
    State { process: ProcessId, state: String, was_in: bool },
}

impl Timetable {
    /// The timetable of these faults in a run of this system.
    pub(crate) fn new(
        faults: &[Arc<Fault>],
        system: &ChannelSystem,
        places: &Places,
        streams: &Streams,
        complaints: &mut Complaints,
    ) -> Self {
        let mut timed = Vec::with_capacity(faults.len());
        for (fault, stream) in faults.iter().zip(stream_names(faults)) {
            let watch = Watch::new(&fault.timing.trigger, system, places, complaints);
            timed.extend(watch.map(|watch| TimedFault {
                fault: Arc::clone(fault),
                watch,
                left: fault.timing.times,
                state: Phase::Waiting,
                rng: streams.stream(&format!("fault/trigger/{stream}")),
            }));
        }
        Self { faults: timed, holding: BTreeSet::new() }
    }

    /// The changes at this moment: first the ends, then the beginnings, each in the order of the scenario.
    pub(crate) fn changes(&mut self, observed: &Observation<'_>) -> Vec<DueChange> {
        let mut changes = Vec::new();
        for index in self.holding.iter().copied() {
            let fault = &mut self.faults[index];
            if fault.ends(observed.now) {
                fault.state = Phase::Waiting;
                changes.push(DueChange::Ends(index));
            }
        }
        for (index, fault) in self.faults.iter_mut().enumerate() {
            if fault.begins(observed) {
                changes.push(DueChange::Begins(index));
            }
        }
        // A fault that ends and begins in the same step holds, and a momentary one never does: the state decides.
        for change in &changes {
            let (DueChange::Begins(index) | DueChange::Ends(index)) = *change;
            if self.faults[index].state == Phase::Waiting {
                self.holding.remove(&index);
            } else {
                self.holding.insert(index);
            }
        }
        changes
    }

    /// Adopts the state of an earlier timetable whose faults are the first of these. Their durations may differ.
    pub(crate) fn resume(&mut self, earlier: Self) {
        let Self { faults, holding } = earlier;
        for (fault, earlier) in self.faults.iter_mut().zip(faults) {
            *fault = TimedFault { fault: Arc::clone(&fault.fault), ..earlier };
        }
        self.holding = holding;
    }

    /// The indices of the active faults, in the order of the scenario.
    pub(crate) fn holding(&self) -> impl Iterator<Item = usize> {
        self.holding.iter().copied()
    }
}

impl TimedFault {
    /// Whether the fault is active and ends now.
    fn ends(&self, now: Duration) -> bool {
        let Phase::Holding(since) = self.state else { return false };
        self.fault.timing.lasts.is_some_and(|lasts| since + lasts <= now)
    }

    /// Whether the fault becomes active now. Triggers while it is active are ignored.
    fn begins(&mut self, observed: &Observation<'_>) -> bool {
        let comes = self.watch.comes(observed);
        if !comes || self.left == 0 || self.state != Phase::Waiting {
            return false;
        }
        let probability = self.fault.timing.probability;
        if probability < 1.0 && self.rng.random::<f64>() >= probability {
            return false;
        }
        self.left -= 1;
        self.state = if self.fault.kind().is_momentary() { Phase::Waiting } else { Phase::Holding(observed.now) };
        true
    }
}

impl Watch {
    fn new(trigger: &Trigger, system: &ChannelSystem, places: &Places, complaints: &mut Complaints) -> Option<Self> {
        let topology = system.topology();
        match trigger {
            Trigger::Time { at, every } => Some(Self::Time { next: Some(*at), every: *every }),
            Trigger::Tick(number) => Some(Self::Tick { number: *number, passed: false }),
            Trigger::Near { place, within_m } => {
                let found = places.get(&place.value);
                if found.is_none() {
                    complaints.push(unknown("place", place, places.iter().map(|(name, _)| name)));
                }
                Some(Self::Near { place: found?.clone(), within_m: *within_m, was_near: false })
            }
            Trigger::Message(text) => {
                let events = occurrences(text, topology, complaints)?;
                let world = OwnWorld::of_events(&events, topology);
                Some(Self::Message(events, world))
            }
            Trigger::State { process, state } => {
                let skills = || topology.processes().filter(|id| system.process::<SkillProcess>(*id).is_some());
                let Some(id) = topology.find_process(&process.value).filter(|id| skills().any(|other| other == *id))
                else {
                    complaints.push(unknown("skill", process, skills().map(|id| topology.name(id))));
                    return None;
                };
                let chart = system.process::<SkillProcess>(id)?.machine().chart();
                if chart.find_state(state).is_none() {
                    let named = diagnostics::Spanned { value: state.clone(), span: process.span.clone() };
                    complaints.push(unknown("state", &named, chart.states().map(|state| chart.state(state).id())));
                    return None;
                }
                Some(Self::State { process: id, state: state.clone(), was_in: false })
            }
        }
    }

    /// Whether the trigger fires at this observation.
    fn comes(&mut self, observed: &Observation<'_>) -> bool {
        // A trigger fires when its condition becomes true: its memory advances at every step, even while the fault is
        // active and the trigger is ignored. A message is an event, and has no memory, except of what the world showed.
        let becomes = |was: &mut bool, is: bool| !std::mem::replace(was, is) && is;
        match self {
            Self::Time { next, every } => {
                let comes = next.is_some_and(|next| next <= observed.now);
                if comes {
                    *next = next.zip(*every).map(|(next, every)| next + every);
                }
                comes
            }
            Self::Tick { number, passed } => becomes(passed, observed.system.ticks() > *number),
            Self::Near { place, within_m, was_near } => becomes(
                was_near,
                observed.pose.is_some_and(|pose| place.distance_m(&pose.translation.vector.into()) <= *within_m),
            ),
            Self::Message(waited_for, world) => {
                let mut comes = false;
                for event in observed.events.iter().filter(|event| world.sees(&event.kind)) {
                    comes |= match &event.kind {
                        EventKind::Received { channel, message } => {
                            waited_for.iter().any(|one| one.channel == *channel && one.condition.holds(message))
                        }
                        EventKind::Tick => false,
                    };
                }
                comes
            }
            Self::State { process, state, was_in } => {
                let skill = observed.system.process::<SkillProcess>(*process);
                becomes(was_in, skill.is_some_and(|skill| skill.machine().is_in(state)))
            }
        }
    }
}

/// The names of the faults' streams of random numbers: each fault's kind, and its number among the faults of this kind.
/// So adding or removing faults of other kinds changes nothing.
pub(crate) fn stream_names(faults: &[Arc<Fault>]) -> impl Iterator<Item = String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    faults.iter().map(move |fault| {
        let count = counts.entry(fault.kind().name).or_default();
        *count += 1;
        format!("{}/{}", fault.kind().name, *count - 1)
    })
}
