//! A schedule while a run follows it.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Enabled, EnabledKind, Event, ProcessId, Topology};
use diagnostics::{Problem, Span, Spanned};
use explorer::{Damage, EnvironmentState, PathStep, Performer, Update};
use scenarios::names::unknown;
use scenarios::scenario::Scenario;
use scenarios::scenario::schedule::driven;
use scenarios::scenario::schedule::{EnvironmentMove, FaultChange, Schedule, ScheduleStep, Taken};
use scenarios::{Complaints, Error};

use crate::switched::{Switchboard, Switched};
use crate::tree_watch::TreeWatch;

/// A schedule that a run follows.
#[derive(Debug)]
pub(crate) struct ScheduleReplay {
    schedule: Arc<Schedule>,
    next: usize,
    performer: Performer,
    /// The places of Localization.
    known: Arc<[String]>,
    switchboard: Switchboard,
}

/// The steps between two moments at which the environment moves or time passes.
#[derive(Debug, Default)]
pub(crate) struct ReplayedSteps {
    /// The events, including those before an error.
    pub(crate) events: Vec<Event>,
    /// What happened around the system, in words.
    pub(crate) words: Vec<String>,
    /// How many ticks were lost.
    pub(crate) overruns: u64,
}

impl ScheduleReplay {
    /// A schedule at its start. Processes, places and faults that the system does not have are reported.
    pub(crate) fn new(
        schedule: &Arc<Schedule>,
        scenario: &Scenario,
        system: &ChannelSystem,
        generator: Option<ProcessId>,
        complaints: &mut Complaints,
    ) -> Self {
        let places = scenario.premises.iter().flat_map(|premises| premises.places.iter());
        let known: Arc<[String]> = places.map(|(name, _)| name.to_owned()).collect();
        check_names(schedule, system.topology(), &known, complaints);
        let switchboard = switchboard(schedule, scenario, system, complaints);
        let performer = Performer { generator, driven: driven(system), hold: Duration::ZERO, now: Duration::ZERO };
        Self { schedule: Arc::clone(schedule), next: 0, performer, known, switchboard }
    }

    pub(crate) fn is_over(&self) -> bool {
        self.next >= self.schedule.steps.len()
    }

    pub(crate) fn now(&self) -> Duration {
        self.performer.now
    }

    /// Performs the next steps until the environment moves or time passes again, and adds them to `replayed`. `watch`
    /// looks at the tree before each tick.
    pub(crate) fn advance(
        &mut self,
        system: &mut ChannelSystem,
        watch: &mut TreeWatch,
        replayed: &mut ReplayedSteps,
    ) -> Result<(), Error> {
        let schedule = Arc::clone(&self.schedule);
        let mut may_begin = true;
        while let Some(Spanned { value: step, span }) = schedule.steps.get(self.next) {
            let begins = matches!(step, ScheduleStep::Environment(..) | ScheduleStep::Wait(_));
            if begins && !may_begin {
                break;
            }
            // The environment may move several times before time passes: all of that is one step of the run.
            may_begin &= matches!(step, ScheduleStep::Environment(..));
            if matches!(step, ScheduleStep::Tick(_)) {
                watch.tick_begins(system);
            }
            self.perform(step, span, system, replayed)?;
            self.next += 1;
        }
        Ok(())
    }

    fn perform(
        &mut self,
        step: &ScheduleStep,
        span: &Span,
        system: &mut ChannelSystem,
        replayed: &mut ReplayedSteps,
    ) -> Result<(), Error> {
        let mut begun = None;
        let step = match step {
            ScheduleStep::Environment(moved) => {
                replayed.words.extend((!moved.words.is_empty()).then(|| moved.words.clone()));
                // When the drivers act, a fault that ends has already ended, and one that begins has not begun yet.
                if let Some(FaultChange { begins, kind, name }) = &moved.change {
                    let fault = self.switchboard.find(*kind, name);
                    begun = fault.filter(|_| *begins);
                    let ended = fault.filter(|_| !begins);
                    ended.into_iter().for_each(|it| self.switchboard.switch(it, false, system, self.performer.now));
                }
                let (data, known) = (moved.data.clone(), Arc::clone(&self.known));
                let update: Update = Arc::new(move |_, process, _| data.update(process, &known));
                PathStep::Environment { words: String::new(), update, state: EnvironmentState::new(()), shown: None }
            }
            ScheduleStep::Wait(span) => PathStep::Wait(*span),
            ScheduleStep::Tick(delivered) => {
                replayed.overruns += u64::from(!delivered);
                PathStep::Tick { delivered: *delivered }
            }
            ScheduleStep::Take(taken) => self.take(taken, system, span)?,
        };
        let performed = self.performer.perform(&step, system)?;
        let performed = performed.ok_or_else(|| match step {
            PathStep::Tick { delivered: true } => misfit(span, "the tree cannot take a tick here"),
            _ => misfit(span, "the tree takes the tick here"),
        })?;
        replayed.events.extend(performed.event);
        self.damage(&step, system)?;
        begun.into_iter().for_each(|fault| self.switchboard.switch(fault, true, system, self.performer.now));
        Ok(())
    }

    /// A fault acts on a message as soon as it is sent.
    fn damage(&self, step: &PathStep, system: &mut ChannelSystem) -> Result<(), Error> {
        let PathStep::Take { enabled: Enabled { kind: EnabledKind::Send(_), .. }, .. } = step else { return Ok(()) };
        let acts = |enabled: &Enabled| matches!(enabled.kind, EnabledKind::Disturb(_));
        while let Some(enabled) = system.enabled().into_iter().find(acts) {
            system.take(&enabled)?;
        }
        Ok(())
    }

    /// The transition of the system to which a step refers.
    fn take(&mut self, taken: &Taken, system: &mut ChannelSystem, span: &Span) -> Result<PathStep, Error> {
        let enabled = system.enabled();
        let topology = system.topology();
        let means = |one: &&channels::Enabled| {
            let offered = Taken::of(one, taken.damage, taken.held, topology);
            offered == *taken
        };
        if let Some(found) = enabled.iter().find(means) {
            self.performer.hold = taken.held;
            return Ok(PathStep::Take { enabled: found.clone(), damage: taken.damage });
        }
        let possible: Vec<String> =
            enabled.iter().map(|one| Taken::of(one, Damage::None, Duration::ZERO, topology).words()).collect();
        let help = match possible.as_slice() {
            [] => "nothing is possible here before time passes".to_owned(),
            possible => format!("possible here: {}", possible.join(", ")),
        };
        let problem = problem(span, &format!("{} is not possible here", taken.words()));
        Err(Error::bad_input(problem.with_help(help)))
    }
}

/// Reports processes and places that do not exist, each name once.
fn check_names(schedule: &Schedule, topology: &Topology, places: &[String], complaints: &mut Complaints) {
    let processes: Vec<&str> = topology.processes().map(|id| topology.name(id)).collect();
    let places: Vec<&str> = places.iter().map(String::as_str).collect();
    let mut reported = BTreeSet::new();
    let mut check = |what, name: &str, span: &Span, known: &[&str]| {
        if !known.contains(&name) && reported.insert(name.to_owned()) {
            let name = Spanned { value: name.to_owned(), span: span.clone() };
            complaints.push(unknown(what, &name, known.iter().copied()));
        }
    };
    for Spanned { value, span } in &schedule.steps {
        match value {
            ScheduleStep::Take(Taken { process, to, from, .. }) => {
                let named = [Some(process), to.as_ref(), from.as_ref()];
                named.into_iter().flatten().for_each(|name| check("process", name, span, &processes));
            }
            ScheduleStep::Environment(EnvironmentMove { data, .. }) => {
                data.place.iter().for_each(|place| check("place", place, span, &places));
            }
            ScheduleStep::Wait(_) | ScheduleStep::Tick(_) => {}
        }
    }
}

/// The faults that begin or end in a schedule. Those that do not fit the scenario are reported, each once.
fn switchboard(
    schedule: &Schedule,
    scenario: &Scenario,
    system: &ChannelSystem,
    complaints: &mut Complaints,
) -> Switchboard {
    let mut switchboard = Switchboard::default();
    let mut seen = BTreeSet::new();
    for Spanned { value, span } in &schedule.steps {
        let ScheduleStep::Environment(EnvironmentMove { change: Some(change), .. }) = value else { continue };
        if seen.insert((change.kind.name(), &change.name)) {
            let name = Spanned { value: change.name.clone(), span: span.clone() };
            let fault = Switched::named(change.kind, &name, scenario, system, complaints);
            fault.into_iter().for_each(|fault| switchboard.add(fault));
        }
    }
    switchboard
}

fn problem(span: &Span, what: &str) -> Problem {
    span.problem("the schedule does not fit the system").with_label(what)
}

fn misfit(span: &Span, what: &str) -> Error {
    let help = "a schedule fits the tree, the skills and the settings for which it was written";
    Error::bad_input(problem(span, what).with_help(help))
}
