//! Why a verdict fell, and what is still owed: as data, and in words.

use std::fmt;
use std::time::Duration;

use channels::{Event, EventKind, Message, Topology};
use serde::{Deserialize, Serialize};

/// When something happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct EventTime {
    /// How many communications there had been.
    pub step: u64,
    /// The number of the last tick generated.
    pub tick: u64,
    /// Since the start of the run.
    pub time: Duration,
}

impl EventTime {
    /// When an event happened.
    #[must_use]
    pub fn of(event: &Event) -> Self {
        Self { step: event.step, tick: event.tick, time: event.time }
    }
}

impl fmt::Display for EventTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "step {}, tick {}, {:.2} s", self.step, self.tick, self.time.as_secs_f64())
    }
}

/// A message that was received.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sighting {
    /// When.
    pub at: EventTime,
    /// The process that sent it.
    pub from: String,
    /// The process that received it.
    pub to: String,
    /// The message.
    pub message: Message,
}

impl Sighting {
    /// The message that an event is; `None` if it is a tick.
    pub(crate) fn of(event: &Event, topology: &Topology) -> Option<Self> {
        let EventKind::Received { channel, message } = &event.kind else { return None };
        let (from, to) = crate::describe::ends(*channel, topology);
        Some(Self { at: EventTime::of(event), from, to, message: message.clone() })
    }
}

impl fmt::Display for Sighting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} → {} {} ({})", self.from, self.to, self.message, self.at)
    }
}

/// Why a property is violated.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Witness {
    /// The clause that was violated, in the SCOPE language; the whole formula where no single clause is to blame.
    pub clause: String,
    /// The messages that caused it, oldest first: what made the antecedent hold, and the one that must not have come.
    pub messages: Vec<Sighting>,
    /// Since when something was owed, if something was.
    pub since: Option<EventTime>,
    /// The last tick at which the answer would have been in time, if one was owed.
    pub deadline_tick: Option<u64>,
    /// What was missing: the events one of which should have held or passed.
    pub missing: Option<String>,
    /// The state at which the verdict fell.
    pub settled: EventTime,
}

impl Witness {
    /// Whether the verdict fell before the deadline: what is owed and what is forbidden contradict each other.
    fn is_early(&self) -> bool {
        self.missing.is_none() && self.deadline_tick.is_some_and(|deadline| self.settled.tick <= deadline)
    }
}

impl fmt::Display for Witness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "violated at {}: {}", self.settled, self.clause)?;
        for message in &self.messages {
            writeln!(f, "  seen: {message}")?;
        }
        if let Some(missing) = &self.missing {
            writeln!(f, "  missing: {missing}")?;
        }
        if self.is_early() {
            writeln!(f, "  whatever comes, they cannot all be kept any more")?;
        }
        match (self.deadline_tick, self.since) {
            (Some(deadline), Some(since)) => {
                writeln!(f, "  owed since tick {}, in time until tick {deadline}", since.tick)
            }
            (Some(deadline), None) => writeln!(f, "  in time until tick {deadline}"),
            (None, _) => Ok(()),
        }
    }
}

/// Something that was owed when a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenObligation {
    /// What: a clause, or what would answer it, in the SCOPE language.
    pub what: String,
    /// Since when.
    pub since: Option<EventTime>,
    /// The last tick at which it can be met, if there is one.
    pub until_tick: Option<u64>,
}

impl fmt::Display for OpenObligation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "still owed: {}", self.what)?;
        if let Some(since) = &self.since {
            write!(f, ", since {since}")?;
        }
        if let Some(tick) = self.until_tick {
            write!(f, ", until tick {tick}")?;
        }
        Ok(())
    }
}
