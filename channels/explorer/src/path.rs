//! A run that the search found, and its replay in the channel system with the ordinary monitors.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    ChannelId, ChannelSystem, Disturbance, Effect, Enabled, EnabledKind, Event, EventKind, Message, Monitor, Process,
    ProcessId, RunError, TransitionId, Verdict,
};

use crate::environment::EnvironmentState;
use crate::model::{Damage, Model};

/// Changes a driven process at this time.
pub type Update = Arc<dyn Fn(ProcessId, &mut dyn Process, Duration) + Send + Sync>;

/// A run, step by step.
#[derive(Clone, Debug, Default)]
pub struct Path {
    pub(crate) steps: Vec<PathStep>,
    /// The number of steps at the end that can be repeated forever.
    pub(crate) cycle: usize,
}

/// A step of a run.
#[derive(Clone)]
pub enum PathStep {
    /// The environment moves. Its words are empty if the move is not worth mentioning.
    Environment {
        /// What happens.
        words: String,
        /// The effect on the processes that it drives.
        update: Update,
        /// Its state afterwards.
        state: EnvironmentState,
        /// The message that monitors are shown, on a channel outside the system.
        shown: Option<(ChannelId, Message)>,
    },
    /// Time passes; timers that are due at its end fire.
    Wait(Duration),
    /// A tick is due.
    Tick {
        /// Whether the tree takes it; otherwise it is lost.
        delivered: bool,
    },
    /// A transition of the channel system.
    Take {
        /// The transition.
        enabled: Enabled,
        /// The disturbance of the message, if there is one.
        damage: Damage,
    },
}

impl fmt::Debug for PathStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Environment { words, .. } => f.debug_tuple("Environment").field(words).finish(),
            Self::Wait(span) => f.debug_tuple("Wait").field(span).finish(),
            Self::Tick { delivered } => f.debug_struct("Tick").field("delivered", delivered).finish(),
            Self::Take { enabled, damage } => {
                f.debug_struct("Take").field("enabled", enabled).field("damage", damage).finish()
            }
        }
    }
}

/// A run that was replayed.
#[derive(Debug)]
pub struct Replay {
    /// The events of the timed state sequence, each with the number of the step after which it happened.
    pub events: Vec<(usize, Event)>,
    /// The messages that were lost, held back or repeated, each with the number of its step.
    pub damaged: Vec<(usize, ChannelId, Message, Damage)>,
    /// What processes did by themselves and is worth mentioning, in words, each with the number of its step.
    pub internal: Vec<(usize, String)>,
    /// The monitor at the end.
    pub monitor: Option<Box<dyn Monitor>>,
    /// The system at the end.
    pub system: ChannelSystem,
    /// Whether the [cycle](Path::cycle) of the run, if it has one, leads back to where it began.
    pub comes_back: bool,
}

impl Replay {
    /// The verdict at the end.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        self.monitor.as_ref().map_or(Verdict::Inconclusive, |monitor| monitor.verdict())
    }
}

/// Why a run cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// A transition is not enabled, so the search and the channel system disagree.
    #[error("step {step} of the run is not possible in the channel system: {what}")]
    Impossible {
        /// The number of the step.
        step: usize,
        /// The step.
        what: String,
    },
    /// The channel system reports an error.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl Path {
    /// The steps.
    #[must_use]
    pub fn steps(&self) -> &[PathStep] {
        &self.steps
    }

    /// The number of steps at the end that can be repeated forever: those of a livelock.
    #[must_use]
    pub fn cycle(&self) -> usize {
        self.cycle
    }

    /// The number of ticks.
    #[must_use]
    pub fn ticks(&self) -> usize {
        self.steps.iter().filter(|step| matches!(step, PathStep::Tick { .. })).count()
    }

    /// Replays the run in the model's channel system, with an ordinary monitor.
    ///
    /// # Errors
    /// [`ReplayError`] if the channel system does not have this run.
    pub fn replay(&self, model: &Model, monitor: Option<&dyn Monitor>) -> Result<Replay, ReplayError> {
        self.replay_and_look(model, monitor, |_, _| ())
    }

    /// The same; `look` sees the system after each step, with the step's number.
    ///
    /// # Errors
    /// As [`replay`](Self::replay).
    pub fn replay_and_look(
        &self,
        model: &Model,
        monitor: Option<&dyn Monitor>,
        mut look: impl FnMut(usize, &ChannelSystem),
    ) -> Result<Replay, ReplayError> {
        let mut system = model.start.fork();
        let mut monitor = monitor.map(Monitor::boxed_clone);
        let (mut events, mut damaged, mut internal) = (Vec::new(), Vec::new(), Vec::new());
        let mut performer = Performer::of(model);
        let mut beginning = None;
        for (number, step) in self.steps.iter().enumerate() {
            // The cycle begins. It leads back to the same normal form: time, and the numbers of requests, grow forever.
            if number + self.cycle == self.steps.len() {
                beginning = Some(in_normal_form(&system));
            }
            let impossible = || ReplayError::Impossible { step: number, what: format!("{step:?}") };
            let performed = performer.perform(step, &mut system)?.ok_or_else(impossible)?;
            if let (Some((channel, message)), PathStep::Take { damage, .. }) = (performed.damaged, step) {
                damaged.push((number, channel, message, *damage));
            }
            internal.extend(performed.internal.map(|words| (number, words)));
            if let Some(event) = performed.event {
                if let Some(monitor) = &mut monitor {
                    monitor.observe(&event);
                }
                events.push((number, event));
            }
            look(number, &system);
        }
        let comes_back = beginning.is_none_or(|beginning| beginning.same_state(&in_normal_form(&system)));
        Ok(Replay { events, damaged, internal, monitor, system, comes_back })
    }
}

impl From<Vec<PathStep>> for Path {
    /// The run with these steps. The search notices that a message is delivered twice when it is received; in a run, it
    /// is repeated when it is sent.
    fn from(mut steps: Vec<PathStep>) -> Self {
        let mut repeated: Vec<ChannelId> = Vec::new();
        for step in steps.iter_mut().rev() {
            let PathStep::Take { enabled, damage } = step else { continue };
            match enabled.kind {
                EnabledKind::Receive(channel) if *damage == Damage::Repeated => {
                    repeated.push(channel);
                    *damage = Damage::None;
                }
                EnabledKind::Send(channel) if repeated.contains(&channel) => {
                    repeated.retain(|other| *other != channel);
                    if *damage == Damage::None {
                        *damage = Damage::Repeated;
                    }
                }
                _ => {}
            }
        }
        Self { steps, cycle: 0 }
    }
}

/// Performs the steps of a run in a channel system.
#[derive(Clone, Debug)]
pub struct Performer {
    /// What generates ticks.
    pub generator: Option<ProcessId>,
    /// The processes that the environment drives.
    pub driven: Vec<ProcessId>,
    /// How long a delayed message is held back.
    pub hold: Duration,
    /// The simulated time in the run.
    pub now: Duration,
}

/// The result of a step.
#[derive(Clone, Debug, Default)]
pub struct Performed {
    /// Its event, if it belongs to the timed state sequence.
    pub event: Option<Event>,
    /// The message that was lost, held back or repeated.
    pub damaged: Option<(ChannelId, Message)>,
    /// What a process did by itself, in words, if it is worth mentioning.
    pub internal: Option<String>,
}

impl Performer {
    /// Performs the runs of a model.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        Self {
            generator: model.ticks.map(|ticks| ticks.generator),
            driven: model.environment.driven().to_vec(),
            hold: model.faults.delayed.1,
            now: Duration::ZERO,
        }
    }

    /// Performs a step; `None` if the system cannot take it.
    ///
    /// # Errors
    /// [`RunError`] if a process sends what its channel cannot carry.
    pub fn perform(&mut self, step: &PathStep, system: &mut ChannelSystem) -> Result<Option<Performed>, RunError> {
        let mut performed = Performed::default();
        match step {
            PathStep::Environment { update, shown, .. } => {
                drive(system, &self.driven, update, self.now);
                performed.event = shown.clone().map(|(channel, message)| system.show(channel, message));
            }
            PathStep::Wait(span) => {
                self.now += *span;
                system.advance(self.now);
            }
            PathStep::Tick { delivered } => {
                let Some(generator) = self.generator else { return Ok(None) };
                let (event, taken) = system.generate_tick(generator);
                performed.event = Some(event);
                return Ok((taken == *delivered).then_some(performed));
            }
            PathStep::Take { enabled, .. } if !system.enabled().contains(enabled) => return Ok(None),
            PathStep::Take {
                enabled: enabled @ Enabled { kind: EnabledKind::Internal, process, transition }, ..
            } => {
                let words = system.any_process(*process).and_then(|process| process.in_words(*transition));
                performed.internal = words.map(|words| format!("{} {words}", system.topology().name(*process)));
                performed.event = system.take(enabled)?;
            }
            PathStep::Take { enabled, damage } => match (self.effect(*damage), &enabled.kind) {
                (None, _) => performed.event = system.take(enabled)?,
                (Some(effect), EnabledKind::Send(channel)) => {
                    performed.damaged = send_damaged(system, enabled, *channel, effect)?;
                }
                // A path repeats a message when it is sent.
                (Some(_), _) => return Ok(None),
            },
        }
        Ok(Some(performed))
    }

    fn effect(&self, damage: Damage) -> Option<Effect> {
        match damage {
            Damage::None => None,
            Damage::Lost => Some(Effect::Lose),
            Damage::Held => Some(Effect::Hold(self.hold)),
            Damage::Repeated => Some(Effect::Repeat),
        }
    }
}

/// Sends a message and lets a disturbance act on it at once. Returns the channel and the message.
fn send_damaged(
    system: &mut ChannelSystem,
    enabled: &Enabled,
    channel: ChannelId,
    effect: Effect,
) -> Result<Option<(ChannelId, Message)>, RunError> {
    let disturbance = system.disturb(Disturbance::all(channel, effect));
    system.take(enabled)?;
    let message = system.content(channel).map(|envelope| envelope.message.clone());
    let acts = Enabled {
        process: system.topology().get(channel).source,
        transition: TransitionId(u32::try_from(disturbance.index()).unwrap_or(u32::MAX)),
        kind: EnabledKind::Disturb(channel),
    };
    system.take(&acts)?;
    system.calm(disturbance);
    Ok(message.map(|message| (channel, message)))
}

fn in_normal_form(system: &ChannelSystem) -> ChannelSystem {
    let mut system = system.fork();
    system.normalize().expect("what was explored has a normal form");
    system
}

fn drive(system: &mut ChannelSystem, driven: &[ProcessId], update: &Update, now: Duration) {
    for id in driven {
        if let Some(mut process) = system.clone_process(*id) {
            update(*id, process.as_mut(), now);
            let replaced = system.replace(*id, process);
            assert!(replaced.is_ok(), "a process that is driven keeps its channels");
        }
    }
}

impl Replay {
    /// What happened, in words: `tick 3`, `Server → Client: [<ok>]`, `Server → Client: [<ok>] is lost`.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let topology = self.system.topology();
        let events = self.events.iter().map(|(step, event)| match &event.kind {
            EventKind::Tick => (step, format!("tick {}", event.tick)),
            EventKind::Received { channel, message } => (step, format!("{}: {message}", topology.describe(*channel))),
        });
        let damaged = self.damaged.iter().map(|(step, channel, message, damage)| {
            let what = match damage {
                Damage::Lost => "is lost",
                Damage::Repeated => "is repeated",
                _ => "is held back",
            };
            (step, format!("{}: {message} {what}", topology.describe(*channel)))
        });
        let internal = self.internal.iter().map(|(step, words)| (step, words.clone()));
        let mut lines: Vec<(&usize, String)> = events.chain(damaged).chain(internal).collect();
        lines.sort_by_key(|(step, _)| **step);
        lines.into_iter().map(|(_, line)| line).collect()
    }
}
