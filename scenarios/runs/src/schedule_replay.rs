//! A schedule while a run follows it.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, Enabled, EnabledKind, Event, ProcessId};
use diagnostics::{Problem, Span, Spanned};
use explorer::{Damage, EnvironmentState, PathStep, Performer, Update};
use scenarios::Complaints;
use scenarios::names::unknown;
use scenarios::scenario::Scenario;
use scenarios::scenario::schedule::driven;
use scenarios::scenario::schedule::{FaultChange, Happening, Schedule, Step, Taken};

use crate::error::StepError;
use crate::switched::{Switchboard, Switched};

/// A schedule that a run follows.
#[derive(Debug)]
pub(crate) struct Player {
    schedule: Arc<Schedule>,
    /// The number of the next step.
    next: usize,
    performer: Performer,
    /// The places that Localization knows.
    known: Arc<[String]>,
    /// The faults that begin and end.
    switchboard: Switchboard,
}

/// What happens between two moments at which the environment moves or time passes.
#[derive(Debug, Default)]
pub(crate) struct Part {
    /// The events, including those before an error.
    pub(crate) events: Vec<Event>,
    /// What happened around the system, in words.
    pub(crate) words: Vec<String>,
    /// How many ticks were lost.
    pub(crate) overruns: u64,
}

impl Player {
    /// A schedule at its start. Processes and places that the system does not have are reported.
    pub(crate) fn new(
        schedule: &Arc<Schedule>,
        scenario: &Scenario,
        system: &ChannelSystem,
        generator: Option<ProcessId>,
        complaints: &mut Complaints,
    ) -> Self {
        let topology = system.topology();
        let known: Vec<String> = scenario
            .premises
            .iter()
            .flat_map(|premises| premises.places.iter().map(|(name, _)| name.to_owned()))
            .collect();
        let mut switchboard = Switchboard::default();
        let (mut misnamed, mut misfits) = (BTreeSet::new(), Complaints::default());
        let mut complained = BTreeSet::new();
        let mut check = |what, name: &str, span: &Span, is_known: bool, all: Vec<&str>| {
            if !is_known && complained.insert(name.to_owned()) {
                complaints.push(unknown(what, &Spanned { value: name.to_owned(), span: span.clone() }, all));
            }
        };
        for Spanned { value, span } in &schedule.steps {
            match value {
                Step::Take(Taken { process, to, from, .. }) => {
                    for name in [Some(process), to.as_ref(), from.as_ref()].into_iter().flatten() {
                        let all = topology.processes().map(|id| topology.name(id)).collect();
                        check("process", name, span, topology.find_process(name).is_some(), all);
                    }
                }
                Step::Environment(Happening { told, change, .. }) => {
                    if let Some(place) = &told.place {
                        check("place", place, span, known.contains(place), known.iter().map(String::as_str).collect());
                    }
                    if let Some(FaultChange { kind, name, .. }) = change
                        && switchboard.find(*kind, name).is_none()
                        && misnamed.insert((kind.name(), name))
                    {
                        let name = Spanned { value: name.clone(), span: span.clone() };
                        let fault = Switched::named(*kind, &name, scenario, system, &mut misfits);
                        fault.into_iter().for_each(|fault| _ = switchboard.add(fault));
                    }
                }
                Step::Wait(_) | Step::Tick(_) => {}
            }
        }
        complaints.take(misfits.check());
        let performer = Performer { generator, driven: driven(system), hold: Duration::ZERO, now: Duration::ZERO };
        Self { schedule: Arc::clone(schedule), next: 0, performer, known: known.into(), switchboard }
    }

    /// Whether the schedule has ended.
    pub(crate) fn is_over(&self) -> bool {
        self.next >= self.schedule.steps.len()
    }

    /// The simulated time in the run.
    pub(crate) fn now(&self) -> Duration {
        self.performer.now
    }

    /// Performs the next steps until the environment moves or time passes again, and adds them to `part`.
    pub(crate) fn perform_part(&mut self, system: &mut ChannelSystem, part: &mut Part) -> Result<(), StepError> {
        let schedule = Arc::clone(&self.schedule);
        let mut may_begin = true;
        while let Some(Spanned { value: step, span }) = schedule.steps.get(self.next) {
            let begins = matches!(step, Step::Environment(..) | Step::Wait(_));
            if begins && !may_begin {
                break;
            }
            may_begin &= matches!(step, Step::Environment(..));
            let mut begun = None;
            let step = match step {
                Step::Environment(Happening { words, told, change }) => {
                    part.words.extend((!words.is_empty()).then(|| words.clone()));
                    // When the drivers act, a fault that ends has already ended, and one that begins has not begun yet.
                    if let Some(FaultChange { begins, kind, name }) = change {
                        let fault = self.switchboard.find(*kind, name);
                        begun = fault.filter(|_| *begins);
                        let ended = fault.filter(|_| !begins);
                        ended.into_iter().for_each(|it| self.switchboard.switch(it, false, system, self.performer.now));
                    }
                    let (told, known) = (told.clone(), Arc::clone(&self.known));
                    let update: Update = Arc::new(move |_, process, _| told.update(process, &known));
                    PathStep::Environment { words: String::new(), update, state: EnvironmentState::new() }
                }
                Step::Wait(span) => PathStep::Wait(*span),
                Step::Tick(delivered) => {
                    part.overruns += u64::from(!delivered);
                    PathStep::Tick { delivered: *delivered }
                }
                Step::Take(taken) => self.take(taken, system, span)?,
            };
            let performed = self.performer.perform(&step, system)?;
            let performed = performed.ok_or_else(|| match step {
                PathStep::Tick { delivered: true } => misfit(span, "the tree cannot take a tick here"),
                _ => misfit(span, "the tree takes the tick here"),
            })?;
            part.events.extend(performed.event);
            self.damage(&step, system)?;
            begun.into_iter().for_each(|fault| self.switchboard.switch(fault, true, system, self.performer.now));
            self.next += 1;
        }
        Ok(())
    }

    /// A fault acts on a message as soon as it is sent.
    fn damage(&self, step: &PathStep, system: &mut ChannelSystem) -> Result<(), StepError> {
        let PathStep::Take { enabled: Enabled { kind: EnabledKind::Send(_), .. }, .. } = step else { return Ok(()) };
        let acts = |enabled: &Enabled| matches!(enabled.kind, EnabledKind::Disturb(_));
        while let Some(enabled) = system.enabled().into_iter().find(acts) {
            system.take(&enabled)?;
        }
        Ok(())
    }

    /// The transition of the system to which a step refers.
    fn take(&mut self, taken: &Taken, system: &mut ChannelSystem, span: &Span) -> Result<PathStep, StepError> {
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
        Err(StepError::Schedule(problem.with_help(help)))
    }
}

fn problem(span: &Span, what: &str) -> Problem {
    span.problem("the schedule does not fit the system").with_label(what)
}

fn misfit(span: &Span, what: &str) -> StepError {
    let help = "a schedule fits the tree, the skills and the settings for which it was written";
    StepError::Schedule(problem(span, what).with_help(help))
}
