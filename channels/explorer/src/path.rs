//! A run that the search has found, and its replay in the channel system with the ordinary monitors.

use std::fmt;
use std::time::Duration;

use channels::{
    ChannelId, ChannelSystem, Disturbance, Effect, Enabled, EnabledKind, Event, EventKind, Message, Monitor, RunError,
    TransitionId, Verdict,
};

use crate::model::{Damage, Model, Update};

/// A run, step by step.
#[derive(Clone, Debug, Default)]
pub struct Path {
    pub(crate) steps: Vec<PathStep>,
}

/// A step of a run.
#[derive(Clone)]
pub enum PathStep {
    /// The environment moves; its words are empty if that is worth none.
    Environment {
        /// What happens.
        words: String,
        /// What it does to the processes that it drives.
        update: Update,
    },
    /// Time passes; timers that are due at its end fire.
    Wait(Duration),
    /// A tick is due.
    Tick {
        /// Whether the tree takes it; it is lost otherwise.
        delivered: bool,
    },
    /// A transition of the channel system.
    Take {
        /// The transition.
        enabled: Enabled,
        /// What happens to the message besides what should.
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
    /// What happened, and after which step of the run: the events of the timed state sequence.
    pub events: Vec<(usize, Event)>,
    /// The messages that were lost or held back, and at which step of the run.
    pub damaged: Vec<(usize, ChannelId, Message, Damage)>,
    /// The monitor at the end.
    pub monitor: Option<Box<dyn Monitor>>,
    /// The system at the end.
    pub system: ChannelSystem,
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

    /// The number of ticks.
    #[must_use]
    pub fn ticks(&self) -> usize {
        self.steps.iter().filter(|step| matches!(step, PathStep::Tick { .. })).count()
    }

    /// Replays the run in the model's channel system, with an ordinary monitor.
    ///
    /// # Errors
    /// [`ReplayError`] if the run is not one of the channel system.
    pub fn replay(&self, model: &Model, monitor: Option<&dyn Monitor>) -> Result<Replay, ReplayError> {
        let mut system = model.start.fork();
        let mut monitor = monitor.map(Monitor::boxed_clone);
        let (mut events, mut damaged) = (Vec::new(), Vec::new());
        let mut now = Duration::ZERO;
        for (number, step) in self.steps.iter().enumerate() {
            let impossible = || ReplayError::Impossible { step: number, what: format!("{step:?}") };
            let event = match step {
                PathStep::Environment { update, .. } => {
                    drive(&mut system, model, update);
                    None
                }
                PathStep::Wait(span) => {
                    now += *span;
                    system.advance(now);
                    None
                }
                PathStep::Tick { delivered } => {
                    let ticks = model.ticks.ok_or_else(impossible)?;
                    let (event, taken) = system.generate_tick(ticks.generator);
                    if taken != *delivered {
                        return Err(impossible());
                    }
                    Some(event)
                }
                PathStep::Take { enabled, damage: damage @ (Damage::Lost | Damage::Held) } => {
                    let hold = model.faults.delayed.1;
                    let effect = if *damage == Damage::Lost { Effect::Lose } else { Effect::Hold(hold) };
                    let (channel, message) = send_damaged(&mut system, enabled, effect)?.ok_or_else(impossible)?;
                    damaged.push((number, channel, message, *damage));
                    None
                }
                PathStep::Take { enabled, .. } if self.is_repeated_later(number) => {
                    send_damaged(&mut system, enabled, Effect::Repeat)?.ok_or_else(impossible)?;
                    None
                }
                PathStep::Take { enabled, .. } if system.enabled().contains(enabled) => system.take(enabled)?,
                PathStep::Take { .. } => return Err(impossible()),
            };
            if let Some(event) = event {
                if let Some(monitor) = &mut monitor {
                    monitor.observe(&event);
                }
                events.push((number, event));
            }
        }
        Ok(Replay { events, damaged, monitor, system })
    }

    /// Whether the message that this step sends is received twice.
    fn is_repeated_later(&self, number: usize) -> bool {
        let PathStep::Take { enabled: Enabled { kind: EnabledKind::Send(sent), .. }, .. } = &self.steps[number] else {
            return false;
        };
        let later = self.steps[number + 1..].iter().find_map(|step| match step {
            PathStep::Take { enabled, damage } if enabled.kind == EnabledKind::Receive(*sent) => Some(*damage),
            _ => None,
        });
        later == Some(Damage::Repeated)
    }
}

/// Sends a message, and lets a disturbance act on it at once. The channel and the message; `None` if it cannot be sent.
fn send_damaged(
    system: &mut ChannelSystem,
    enabled: &Enabled,
    effect: Effect,
) -> Result<Option<(ChannelId, Message)>, RunError> {
    let EnabledKind::Send(channel) = enabled.kind else { return Ok(None) };
    if !system.enabled().contains(enabled) {
        return Ok(None);
    }
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

fn drive(system: &mut ChannelSystem, model: &Model, update: &Update) {
    for id in model.environment.driven() {
        if let Some(mut process) = system.clone_process(*id) {
            update(*id, process.as_mut());
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
            let what = if *damage == Damage::Lost { "is lost" } else { "is held back" };
            (step, format!("{}: {message} {what}", topology.describe(*channel)))
        });
        let mut lines: Vec<(&usize, String)> = events.chain(damaged).collect();
        lines.sort_by_key(|(step, _)| **step);
        lines.into_iter().map(|(_, line)| line).collect()
    }
}
