//! A run in which something goes wrong, replayed in the channel system with the ordinary monitor.

use channels::{ChannelId, ChannelSystem, EnabledKind, EventKind, Message, NoNormalForm, Topology, Verdict};
use explorer::{Damage, Outcome, Path, PathStep, Replay};
use monitors::scope_monitor;
use scenarios::Error;

use super::{Answer, Assumption, Proof, Question, assumptions};

/// A run in which something goes wrong, replayed in the channel system with the ordinary monitor.
#[derive(Clone, Debug)]
pub struct ReplayedRun {
    /// What happens in it, each with the tick after which it happens; `None` before the first.
    pub events: Vec<(Option<u64>, ReplayedEvent)>,
    /// Its number of ticks.
    pub ticks: usize,
    /// Whether the replay confirms the search.
    pub is_as_found: bool,
    /// Which messages pile up, in words, if that is so: `more than 32 messages from Client to Server are waiting`.
    pub piled_up: Option<String>,
    /// The assumptions of which it makes use.
    pub rests_on: Vec<Assumption>,
}

impl ReplayedRun {
    /// The tick in which it is decided; `None` before the first.
    #[must_use]
    pub fn decided_at(&self) -> Option<u64> {
        self.events.last().and_then(|(tick, _)| *tick)
    }
}

/// What may happen in a run.
#[derive(Clone, Debug)]
pub enum ReplayedEvent {
    /// The following events repeat forever.
    Repeats,
    /// The environment moves, or a process does something by itself, in words.
    Environment(String),
    /// A tick is due.
    Tick {
        /// Whether the tree takes it; otherwise it is lost.
        is_delivered: bool,
    },
    /// A message is received.
    Message {
        /// The sender and the receiver.
        ends: [String; 2],
        /// The message.
        message: Message,
        /// Whether the property is about such messages.
        is_watched: bool,
    },
    /// A message is damaged.
    Damage {
        /// The sender and the receiver.
        ends: [String; 2],
        /// How, in words: `is lost`.
        how: &'static str,
    },
}

impl Proof {
    /// Replays the run that a search has found; `None` if it has found none.
    ///
    /// # Errors
    /// If the channel system does not allow this run, which is a mistake in the search.
    pub fn replay(&self, question: &Question, answer: &Answer) -> Result<Option<ReplayedRun>, Error> {
        let monitor = self.monitor(question);
        let outcome = &answer.exploration.outcome;
        let (Outcome::Violated(path) | Outcome::Endless(path) | Outcome::Deadlock(path) | Outcome::Livelock(path)) =
            outcome
        else {
            return Ok(None);
        };
        let mut replay = path.replay(&answer.model, monitor).map_err(|error| {
            let help = "this is a bug in steward: please report it, with the scenario";
            Error::refused(format!("a run that violates {} cannot be replayed: {error}", question.property), help)
        })?;
        let mut watched: Vec<ChannelId> = Vec::new();
        if let Some(scope) = monitor.and_then(scope_monitor) {
            scope.formula().events(&mut |event| watched.push(event.channel));
        }
        // Without a property, only the end of the run matters.
        let is_tick = |step: &PathStep| matches!(step, PathStep::Tick { delivered: true });
        let end = match (monitor, path.cycle()) {
            (Some(_), _) => path.steps().len(),
            (None, 0) => path.steps().iter().rposition(is_tick).unwrap_or(0),
            (None, cycle) => path.steps().len() - cycle,
        };
        let is_watched = |step, channel| step >= end || watched.contains(&channel);
        let piled_up = if let Outcome::Endless(_) = outcome { piled_up(&replay.system) } else { None };
        let is_as_found = match outcome {
            Outcome::Violated(_) => replay.verdict() == Verdict::False,
            Outcome::Endless(_) => piled_up.is_some(),
            Outcome::Deadlock(_) => replay.system.enabled().is_empty(),
            _ => replay.comes_back,
        };
        let rests_on = assumptions::used(&self.assumptions(), path, &replay, &self.faults);
        let events = events(path, &replay, is_watched);
        Ok(Some(ReplayedRun { events, ticks: path.ticks(), is_as_found, piled_up, rests_on }))
    }
}

/// Which messages pile up in this state, in words.
fn piled_up(system: &ChannelSystem) -> Option<String> {
    match system.fork().normalize() {
        Err((_, NoNormalForm::Endless { what })) => Some(what),
        _ => None,
    }
}

fn events(
    path: &Path,
    replay: &Replay,
    is_watched: impl Fn(usize, ChannelId) -> bool,
) -> Vec<(Option<u64>, ReplayedEvent)> {
    let topology = replay.system.topology();
    let mut all = Vec::new();
    let mut tick = None;
    for (number, step) in path.steps().iter().enumerate() {
        let event = replay.events.iter().find(|(after, _)| *after == number).map(|(_, event)| event);
        // Nothing marks the beginning of a cycle in the path: it is as long as the cycle before its end.
        if path.cycle() > 0 && number + path.cycle() == path.steps().len() {
            all.push((tick, ReplayedEvent::Repeats));
        }
        if let PathStep::Tick { .. } = step {
            tick = event.map(|event| event.tick);
        }
        let received = event.and_then(|event| received(event, topology, |channel| is_watched(number, channel)));
        let done = replay.internal.iter().filter(|(at, _)| *at == number);
        let done = done.map(|(_, words)| ReplayedEvent::Environment(words.clone()));
        all.extend(happening(step, topology).into_iter().chain(done).chain(received).map(|event| (tick, event)));
    }
    all
}

/// What happens in a step, apart from the message that is received in it.
fn happening(step: &PathStep, topology: &Topology) -> Option<ReplayedEvent> {
    match step {
        PathStep::Environment { words, .. } => (!words.is_empty()).then(|| ReplayedEvent::Environment(words.clone())),
        PathStep::Wait(_) => None,
        PathStep::Tick { delivered } => Some(ReplayedEvent::Tick { is_delivered: *delivered }),
        PathStep::Take { enabled, damage } => {
            let how = match damage {
                Damage::None => return None,
                Damage::Lost => "is lost",
                Damage::Held => "is delayed",
                Damage::Repeated => "is delivered twice",
            };
            let (EnabledKind::Send(channel) | EnabledKind::Receive(channel)) = &enabled.kind else { return None };
            Some(ReplayedEvent::Damage { ends: ends(topology, *channel), how })
        }
    }
}

fn received(
    event: &channels::Event,
    topology: &Topology,
    is_watched: impl Fn(ChannelId) -> bool,
) -> Option<ReplayedEvent> {
    let EventKind::Received { channel, message } = &event.kind else { return None };
    let (ends, message) = (ends(topology, *channel), message.clone());
    Some(ReplayedEvent::Message { ends, message, is_watched: is_watched(*channel) })
}

fn ends(topology: &Topology, channel: ChannelId) -> [String; 2] {
    <[&str; 2]>::from(topology.ends(channel)).map(str::to_owned)
}
