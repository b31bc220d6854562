//! A run of a model.

use std::time::Duration;

use bt::{Status, TreeProcess};
use channels::{Event, EventKind, Process, RunError, Scheduler, Topology, WiringError};
use robot::Streams;

use crate::model::Model;
use crate::property::{State, Watch};
use crate::system::{Automaton, Clock, System};

/// More transitions than this at one time count as endless.
const STEP_BUDGET: u64 = 1_000_000;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The model's time is over.
    TimeLimit,
    /// Nothing can happen any more.
    Quiet,
    /// Every property has its verdict.
    Settled,
}

/// The result of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Whether each property holds, in the order of the model.
    pub verdicts: Vec<bool>,
    /// When the run ended.
    pub time: Duration,
    /// Why.
    pub ended: Ended,
    /// The tree's last answer.
    pub tree: Option<Status>,
    /// How many messages were received.
    pub communications: u64,
    /// Errors of machines, with the names of their processes.
    pub errors: Vec<(String, String)>,
}

/// A run of a model in progress.
///
/// Time jumps from one timer to the next. At each time, the timers of machines fire one after the other, in the order
/// of their declarations, and then the tree is ticked; each time, everything that follows happens before the next.
#[derive(Debug)]
pub struct Run<'m> {
    model: &'m Model,
    system: System,
    scheduler: Box<dyn Scheduler>,
    watches: Vec<Watch<'m>>,
    state: State,
    now: Duration,
    /// When the next tick is due; none after the last.
    next_tick: Option<Duration>,
}

impl<'m> Run<'m> {
    /// The model at its start. `seed` determines what machines leave to chance, `scheduler` the order of messages.
    ///
    /// # Errors
    /// [`WiringError`] if the model's parts do not fit together.
    pub fn new(model: &'m Model, seed: u64, scheduler: Box<dyn Scheduler>) -> Result<Self, WiringError> {
        let system = System::new(model, &Streams::new(seed))?;
        let watches = model.properties.iter().map(Watch::new).collect();
        let next_tick = model.tree.is_some().then_some(model.parameters.tick);
        Ok(Self { model, system, scheduler, watches, state: State::default(), now: Duration::ZERO, next_tick })
    }

    /// The processes and channels.
    #[must_use]
    pub fn topology(&self) -> &Topology {
        self.system.system.topology()
    }

    /// Runs to the end. `follow` sees every event. If `settles`, the run ends when all properties have their verdicts.
    ///
    /// # Errors
    /// [`RunError`] if the processes never come to rest.
    pub fn finish(mut self, settles: bool, mut follow: impl FnMut(&Event, &Topology)) -> Result<Outcome, RunError> {
        self.observe(0);
        self.communicate(&mut follow)?;
        let ended = loop {
            if settles && !self.watches.is_empty() && self.watches.iter().all(|watch| watch.verdict().is_some()) {
                break Ended::Settled;
            }
            let timer = self.next_timer();
            let Some(next) = [timer, self.next_tick].into_iter().flatten().min() else { break Ended::Quiet };
            if next > self.model.parameters.max_time {
                self.now = self.model.parameters.max_time;
                break Ended::TimeLimit;
            }
            self.now = next;
            if timer == Some(next) {
                self.system.system.advance(next);
                self.communicate(&mut follow)?;
            } else {
                self.system.system.advance(next);
                self.tick(next, &mut follow)?;
            }
        };
        Ok(self.outcome(ended))
    }

    /// When the next timer is due.
    fn next_timer(&self) -> Option<Duration> {
        let System { system, clock, machines, .. } = &self.system;
        let clock = system.process::<Clock>(*clock).and_then(Process::next_timer);
        let machine = |id: &channels::ProcessId| system.process::<Automaton>(*id).and_then(Process::next_timer);
        machines.iter().filter_map(machine).chain(clock).min()
    }

    fn tick(&mut self, now: Duration, follow: &mut impl FnMut(&Event, &Topology)) -> Result<(), RunError> {
        let (Some(generator), Some(tree)) = (self.system.tick_generator, self.system.tree) else { return Ok(()) };
        let (event, _) = self.system.system.generate_tick(generator);
        follow(&event, self.system.system.topology());
        self.communicate(follow)?;
        let process = self.system.system.process::<TreeProcess>(tree);
        let answered = process.filter(|tree| tree.is_idle());
        let status = answered.and_then(|tree| tree.execution().last_status());
        if let Some(tree) = answered {
            let states = tree.states();
            self.state.nodes.resize(states.len(), 0);
            for (known, state) in self.state.nodes.iter_mut().zip(states) {
                match state.outcome {
                    Some(bt::Outcome::Answered(Status::Success)) => *known = 1,
                    Some(bt::Outcome::Answered(Status::Failure)) => *known = 2,
                    Some(bt::Outcome::Answered(Status::Running)) => *known = 3,
                    _ => {}
                }
            }
            self.observe(self.system.system.steps());
        }
        let continues =
            self.model.parameters.tick_if_not_running || status.is_none_or(|status| status == Status::Running);
        self.next_tick = continues.then(|| now + self.model.parameters.tick);
        Ok(())
    }

    /// Lets everything happen that can happen now.
    fn communicate(&mut self, follow: &mut impl FnMut(&Event, &Topology)) -> Result<(), RunError> {
        let Self { system: System { system, recorder, events, .. }, scheduler, watches, state, .. } = self;
        let topology = std::sync::Arc::clone(system.topology());
        for event in system.run(scheduler.as_mut(), STEP_BUDGET) {
            let event = event?;
            follow(&event, &topology);
            let EventKind::Received { channel, message } = &event.kind else { continue };
            if topology.get(*channel).target == *recorder
                && let Some(head) = message.head()
                && let Some(fields) = events.get(head)
            {
                let values = fields.iter().zip(message.fields().iter().skip(1));
                let values = values.map(|((name, kind), value)| (name.clone(), kind.datum(value)));
                state.latest.insert(head.to_owned(), crate::system::nested(values.collect()));
            }
            watches.iter_mut().for_each(|watch| watch.observe(state, event.step));
        }
        Ok(())
    }

    fn observe(&mut self, step: u64) {
        let state = &self.state;
        self.watches.iter_mut().for_each(|watch| watch.observe(state, step));
    }

    fn outcome(self, ended: Ended) -> Outcome {
        let System { system, machines, tree, .. } = &self.system;
        let mut errors = Vec::new();
        for id in machines {
            let name = system.topology().name(*id);
            let of = system.process::<Automaton>(*id).map_or(&[][..], Automaton::errors);
            errors.extend(of.iter().map(|error| (name.to_owned(), error.clone())));
        }
        let tree = tree.and_then(|tree| system.process::<TreeProcess>(tree)?.execution().last_status());
        Outcome {
            verdicts: self.watches.iter().map(Watch::conclude).collect(),
            time: self.now,
            ended,
            tree,
            communications: system.steps(),
            errors,
        }
    }
}
