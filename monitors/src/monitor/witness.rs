//! Why a verdict was reached, and which obligations are pending: as data, and in words.

use std::fmt;
use std::time::Duration;

use channels::{Event, EventKind, Message, Shape, Topology};
use serde::{Deserialize, Serialize};

use crate::WORLD;

/// When something happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct EventTime {
    /// The number of communications so far.
    pub step: u64,
    /// The number of the last tick generated.
    pub tick: u64,
    /// Time since the start of the run.
    pub time: Duration,
}

impl EventTime {
    /// The time of an event.
    #[must_use]
    pub fn of(event: &Event) -> Self {
        Self { step: event.step, tick: event.tick, time: event.time }
    }
}

/// In the alternate form, `{:#}`, without the tick: of a run whose ticks are not known. So are all that contain it.
impl fmt::Display for EventTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let time_s = self.time.as_secs_f64();
        if f.alternate() {
            return write!(f, "step {}, {time_s:.2} s", self.step);
        }
        write!(f, "step {}, tick {}, {time_s:.2} s", self.step, self.tick)
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
    /// The names of its fields, if it shows what was true: which fields such a message has depends on the properties.
    pub fields: Vec<String>,
}

impl Sighting {
    /// The message of an event; `None` if it is a tick.
    #[must_use]
    pub fn of(event: &Event, topology: &Topology) -> Option<Self> {
        let EventKind::Received { channel, message } = &event.kind else { return None };
        let (from, to) = topology.ends(*channel);
        let shape = topology.get(*channel).domain.shapes().first().filter(|_| from == WORLD);
        let fields = shape.into_iter().flat_map(Shape::fields).map(|(name, _)| name.to_owned()).collect();
        let (from, to) = (from.to_owned(), to.to_owned());
        Some(Self { at: EventTime::of(event), from, to, message: message.clone(), fields })
    }

    /// The message for readers: `[<ok>, 9.975…]`, or `[speed_mps = 0.45…, touching = false]` if it shows what was true.
    #[must_use]
    pub fn message_in_words(&self) -> String {
        if self.fields.is_empty() {
            return format!("{:#}", self.message);
        }
        let fields = self.fields.iter().zip(self.message.fields());
        let fields: Vec<String> = fields.map(|(name, value)| format!("{name} = {value:#}")).collect();
        format!("[{}]", fields.join(", "))
    }
}

impl fmt::Display for Sighting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} → {} {} (", self.from, self.to, self.message_in_words())?;
        self.at.fmt(f)?;
        f.write_str(")")
    }
}

/// Why a property is violated.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Witness {
    /// The violated clause, in the SCOPE language; the whole formula if no single clause was violated.
    pub clause: String,
    /// The messages that caused it, oldest first: those that made the antecedent hold, and the forbidden one.
    pub messages: Vec<Sighting>,
    /// When the obligation began, if there was one.
    pub since: Option<EventTime>,
    /// The last tick at which the answer would have been in time, if one was pending; for a timed property, the tick
    /// that contains that time.
    pub deadline_tick: Option<u64>,
    /// The missing events, one of which should have held or passed.
    pub missing: Option<String>,
    /// The state in which the verdict was reached. If a timed property was violated by silence, its time is the
    /// deadline, its tick is the one that contains the deadline, and its step is that of the first event after it.
    pub settled: EventTime,
}

impl Witness {
    /// Whether the verdict came before the deadline: obligations and bans contradict each other.
    fn is_early(&self) -> bool {
        self.missing.is_none() && self.deadline_tick.is_some_and(|deadline| self.settled.tick <= deadline)
    }
}

impl fmt::Display for Witness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("violated at ")?;
        self.settled.fmt(f)?;
        writeln!(f, ": {}", self.clause)?;
        for message in &self.messages {
            f.write_str("  seen: ")?;
            message.fmt(f)?;
            writeln!(f)?;
        }
        if let Some(missing) = &self.missing {
            writeln!(f, "  missing: {missing}")?;
        }
        if self.is_early() {
            writeln!(f, "  no continuation can meet all of them")?;
        }
        match (self.deadline_tick, self.since) {
            (Some(_), Some(since)) if f.alternate() => {
                writeln!(f, "  pending since {:.2} s", since.time.as_secs_f64())
            }
            (Some(_), None) if f.alternate() => Ok(()),
            (Some(deadline), Some(since)) => {
                writeln!(f, "  pending since tick {}, due by tick {deadline}", since.tick)
            }
            (Some(deadline), None) => writeln!(f, "  due by tick {deadline}"),
            (None, _) => Ok(()),
        }
    }
}

/// An obligation that was pending when a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenObligation {
    /// The obligation: a clause, or what would answer it, in the SCOPE language.
    pub what: String,
    /// When it began.
    pub since: Option<EventTime>,
    /// The last tick at which it can be met, if there is one; for a timed property, `what` gives the time.
    pub until_tick: Option<u64>,
    /// Whether an answer with a deadline would meet it, alone or as one of several alternatives. Otherwise, the end of
    /// the run decides: nothing that is still due can meet it.
    pub has_deadline: bool,
}

impl fmt::Display for OpenObligation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "still pending: {}", self.what)?;
        if let Some(since) = &self.since {
            f.write_str(", since ")?;
            since.fmt(f)?;
        }
        if let Some(tick) = self.until_tick.filter(|_| !f.alternate()) {
            write!(f, ", due by tick {tick}")?;
        }
        Ok(())
    }
}
