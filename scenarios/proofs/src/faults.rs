//! Faults that a proof allows: the environment decides when they begin and end.

use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, ChannelId, ChannelSystem, Envelope, Message, NoNormalForm, NormalForm, Offer, Process, ProcessId,
    RequestNumber, Topology, TransitionId, Use,
};
use explorer::{AnyEnvironment, Environment, EnvironmentState, Instant, Move, Path, PathStep};
use runs::{Switched, SwitchedEffect as Effect, opposite, restart};
use scenarios::Complaints;
use scenarios::scenario::Scenario;
use skills::SkillProcess;

/// The faults that a scenario's `[prove.faults]` allows.
pub(super) fn of(scenario: &Scenario, system: &ChannelSystem, complaints: &mut Complaints) -> Vec<Switched> {
    let allowed = scenario.file.prove.faults.allowed.iter();
    allowed.filter_map(|(kind, name)| Switched::named(*kind, name, scenario, system, complaints)).collect()
}

/// The faults in words, to complete the assumption "At any time, … may begin".
pub(super) fn in_words(faults: &[Switched]) -> String {
    faults.iter().map(|fault| fault.begins.as_str()).collect::<Vec<_>>().join("; ")
}

/// Wraps the processes of a system so that they may fail.
pub(super) fn prepare(system: &mut ChannelSystem, faults: &[Switched]) {
    for fault in faults.iter().filter(|fault| !matches!(fault.effect, Effect::Machine { .. })) {
        let Some(inner) = system.clone_process(fault.process).filter(|process| impaired(process.as_ref()).is_none())
        else {
            continue;
        };
        let topology = Arc::clone(system.topology());
        let process = Impaired { inner, is_out: false, is_wrong: false, topology };
        system.replace(fault.process, Box::new(process)).expect("it keeps its channels");
    }
}

/// A process without the wrapper from [`prepare`].
pub(super) fn inside(process: &dyn Process) -> &dyn Process {
    impaired(process).map_or(process, |impaired| impaired.inner.as_ref())
}

/// The same, to change it.
pub(super) fn inside_mut(process: &mut dyn Process) -> &mut dyn Process {
    if !process.as_any_mut().is::<Impaired>() {
        return process;
    }
    process.as_any_mut().downcast_mut::<Impaired>().expect("it is one").inner.as_mut()
}

/// Whether neither a process nor its driver does anything.
pub(super) fn is_out(process: &dyn Process) -> bool {
    impaired(process).is_some_and(|impaired| impaired.is_out)
}

fn impaired(process: &dyn Process) -> Option<&Impaired> {
    process.as_any().downcast_ref()
}

/// A process that can fall silent, or send the opposite of what it means.
#[derive(Clone, Debug)]
struct Impaired {
    inner: Box<dyn Process>,
    is_out: bool,
    is_wrong: bool,
    topology: Arc<Topology>,
}

impl PartialEq for Impaired {
    fn eq(&self, other: &Self) -> bool {
        self.inner.same_state(other.inner.as_ref()) && (self.is_out, self.is_wrong) == (other.is_out, other.is_wrong)
    }
}

impl Eq for Impaired {}

impl Hash for Impaired {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.inner.hash(state);
        (self.is_out, self.is_wrong).hash(state);
    }
}

impl Process for Impaired {
    fn offers(&self, offers: &mut Vec<Offer>) {
        if self.is_out {
            return;
        }
        let begin = offers.len();
        self.inner.offers(offers);
        for offer in offers[begin..].iter_mut().filter(|_| self.is_wrong) {
            if let Action::Send(channel, envelope) = &mut offer.action {
                envelope.message = opposite(&self.topology, *channel)(&envelope.message);
            }
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        self.inner.take(transition, received, now);
    }

    fn next_timer(&self) -> Option<Duration> {
        self.inner.next_timer().filter(|_| !self.is_out)
    }

    fn fire_timers(&mut self, now: Duration) {
        self.inner.fire_timers(now);
    }

    fn uses(&self) -> Vec<Use> {
        self.inner.uses()
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        self.inner.awaits(requests);
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.inner.normalize(form)
    }

    fn in_words(&self, transition: TransitionId) -> Option<String> {
        self.inner.in_words(transition)
    }

    fn location(&self) -> String {
        self.inner.location()
    }
}

/// An environment in which faults may begin and end, one of them at each instant.
#[derive(Debug)]
pub(super) struct WithFaults {
    inner: Arc<AnyEnvironment>,
    faults: Vec<Switched>,
    /// The number of faults that may begin in a run.
    count: u8,
    driven: Vec<ProcessId>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct FaultyState {
    inner: EnvironmentState,
    /// How many faults may still begin.
    left: u8,
    /// By fault: whether it is active.
    active: Vec<bool>,
}

pub(super) fn without_faults(state: &EnvironmentState) -> &EnvironmentState {
    state.get().map_or(state, |FaultyState { inner, .. }| inner)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Switching {
    pub(super) index: usize,
    pub(super) begins: bool,
}

/// What is wrong with a process.
#[derive(Clone, Copy, Debug)]
struct Impairment {
    is_out: bool,
    is_wrong: bool,
    /// The fault of the process that begins or ends.
    change: Option<Switching>,
}

impl Impairment {
    /// What is reported to the process, as a number: its driver's number, and this.
    fn numbered(self, driver: u32, faults: usize) -> u32 {
        let change = self.change.map_or(0, |Switching { index, begins }| 1 + 2 * index as u32 + u32::from(begins));
        let numbers = [(2, u32::from(self.is_out)), (2, u32::from(self.is_wrong)), (1 + 2 * faults as u32, change)];
        numbers.into_iter().fold(driver, |all, (count, number)| all * count + number)
    }

    /// The driver's number, and what is wrong.
    fn decoded(report: u32, faults: usize) -> (u32, Self) {
        let (rest, change) = (report / (1 + 2 * faults as u32), report % (1 + 2 * faults as u32));
        let change = change.checked_sub(1).map(|one| Switching { index: one as usize / 2, begins: one % 2 == 1 });
        (rest / 4, Self { is_out: rest / 2 % 2 == 1, is_wrong: rest % 2 == 1, change })
    }
}

/// What happens to the faults in each step of a run.
pub(super) fn changes(run: &Path, faults: &[Switched]) -> Vec<Option<Switching>> {
    let mut active = vec![false; faults.len()];
    let change = |step: &PathStep| {
        let PathStep::Environment { state, .. } = step else { return None };
        let now = &state.get::<FaultyState>()?.active;
        let index = active.iter().zip(now).position(|(was, is)| was != is)?;
        active.clone_from(now);
        Some(Switching { index, begins: active[index] })
    };
    run.steps().iter().map(change).collect()
}

impl WithFaults {
    pub(super) fn new(inner: Arc<AnyEnvironment>, faults: Vec<Switched>, count: u8) -> Self {
        let mut driven = inner.driven().to_vec();
        for fault in &faults {
            if !driven.contains(&fault.process) {
                driven.push(fault.process);
            }
        }
        Self { inner, faults, count, driven }
    }

    /// What may happen to the faults in a state.
    fn changes(&self, FaultyState { left, active, .. }: &FaultyState) -> Vec<Option<Switching>> {
        let is_active = |index: &usize| active[*index];
        let machine = |index: usize| matches!(self.faults[index].effect, Effect::Machine { .. });
        // A skill runs one machine at a time.
        let is_free = |index: usize| {
            let same = |other: &usize| self.faults[*other].process == self.faults[index].process && machine(*other);
            !machine(index) || !(0..active.len()).filter(is_active).any(|other| same(&other))
        };
        let mut changes = vec![None];
        for index in 0..self.faults.len() {
            match is_active(&index) {
                true => changes.push(Some(Switching { index, begins: false })),
                false if *left > 0 && is_free(index) => changes.push(Some(Switching { index, begins: true })),
                false => {}
            }
        }
        changes
    }

    fn with(
        &self,
        inner: &Move<EnvironmentState>,
        change: Option<Switching>,
        before: &FaultyState,
    ) -> Move<FaultyState> {
        let mut state = FaultyState { inner: inner.state.clone(), ..before.clone() };
        if let Some(Switching { index, begins }) = change {
            state.active[index] = begins;
            state.left -= u8::from(begins);
        }
        let impairment = |process: ProcessId| {
            let active = || state.active.iter().zip(&self.faults).filter(|(active, _)| **active);
            let has = |effect: fn(&Effect) -> bool| {
                active().any(|(_, fault)| fault.process == process && effect(&fault.effect))
            };
            Impairment {
                is_out: has(|effect| matches!(effect, Effect::Outage { .. })),
                is_wrong: has(|effect| matches!(effect, Effect::WrongReply)),
                change: change.filter(|change| self.faults[change.index].process == process),
            }
        };
        let now: Vec<Impairment> = self.driven.iter().map(|process| impairment(*process)).collect();
        let inner = inner.reports.iter().copied().chain(std::iter::repeat(0));
        let reports = inner.zip(&now).map(|(inner, now)| now.numbered(inner, self.faults.len())).collect();
        Move { state, reports }
    }

    fn in_words(&self, inner: &str, change: Option<Switching>) -> String {
        let Some(Switching { index, begins }) = change else { return inner.to_owned() };
        let Switched { begins: beginning, ends, .. } = &self.faults[index];
        let happens = if begins { beginning } else { ends };
        if inner.is_empty() { happens.clone() } else { format!("{inner}, {happens}") }
    }
}

impl Environment for WithFaults {
    type State = FaultyState;

    fn driven(&self) -> &[ProcessId] {
        &self.driven
    }

    fn start(&self) -> FaultyState {
        FaultyState { inner: self.inner.start(), left: self.count, active: vec![false; self.faults.len()] }
    }

    fn moves(&self, state: &FaultyState, driven: &[&dyn Process], instant: Instant) -> Vec<Move<FaultyState>> {
        let changes = self.changes(state);
        let moves = self.inner.moves(&state.inner, &driven[..self.inner.driven().len()], instant);
        let with = |inner: &Move<_>| changes.iter().map(|change| self.with(inner, *change, state)).collect::<Vec<_>>();
        moves.iter().flat_map(with).collect()
    }

    fn report(&self, id: ProcessId, report: u32, process: &mut dyn Process, now: Duration) {
        let (driver, Impairment { is_out, is_wrong, change }) = Impairment::decoded(report, self.faults.len());
        let is_driven = self.inner.driven().contains(&id);
        let drive = |process: &mut dyn Process| {
            if is_driven {
                self.inner.report(id, driver, process, now);
            }
        };
        let changed = change.map(|change| (&self.faults[change.index], change.begins));
        // When the drivers act, a fault that ends has already ended, and one that begins has not begun yet.
        match process.as_any_mut().downcast_mut::<Impaired>() {
            Some(impaired) => {
                let was_out = impaired.is_out;
                (impaired.is_out, impaired.is_wrong) = (is_out, is_wrong);
                if let Some((Switched { effect: Effect::Outage { crashed: true }, .. }, false)) = changed {
                    restart(impaired.inner.as_mut(), now);
                }
                if !(was_out && is_out) {
                    drive(impaired.inner.as_mut());
                }
            }
            None => drive(process),
        }
        if let Some((Switched { effect: Effect::Machine { mutant, sound }, .. }, begins)) = changed
            && let Some(skill) = inside_mut(process).as_any_mut().downcast_mut::<SkillProcess>()
        {
            *skill = if begins { mutant } else { sound }.succeeding(skill, now);
        }
    }

    fn words(&self, state: &FaultyState, driven: &[&dyn Process], instant: Instant) -> Vec<String> {
        let changes = self.changes(state);
        let words = self.inner.words(&state.inner, &driven[..self.inner.driven().len()], instant);
        let with = |inner: &String| changes.iter().map(|change| self.in_words(inner, *change)).collect::<Vec<_>>();
        words.iter().flat_map(with).collect()
    }

    fn shown(&self, before: &FaultyState, after: &FaultyState) -> Option<(ChannelId, Message)> {
        self.inner.shown(&before.inner, &after.inner)
    }

    fn may_stir(&self, state: &FaultyState, driven: &[&dyn Process]) -> bool {
        state.left > 0
            || state.active.contains(&true)
            || self.inner.may_stir(&state.inner, &driven[..self.inner.driven().len()])
    }
}
