//! The timed state sequence: what happened, in order.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::{ChannelId, Message, Topology};

/// One state of the timed state sequence.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Event {
    /// The number of communications so far, including this one.
    pub step: u64,
    /// τ: the number of the last tick generated. For a tick's own event, the number of that tick.
    pub tick: u64,
    /// Time since the start of the run.
    pub time: Duration,
    /// What happened.
    pub kind: EventKind,
}

impl Event {
    /// Whether it is a message that only monitors [are shown](crate::ChannelSystem::show); `topology` is the system's.
    #[must_use]
    pub fn is_shown(&self, topology: &Topology) -> bool {
        let EventKind::Received { channel, .. } = self.kind else { return false };
        topology.is_outside(topology.get(channel).source)
    }
}

/// What happened at a state of the timed state sequence.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EventKind {
    /// A tick was generated, whether or not a process took it.
    Tick,
    /// A message was received.
    Received {
        /// The channel from which it came.
        channel: ChannelId,
        /// The message.
        message: Message,
    },
}

/// Why a sequence of events may not be what happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Flaw {
    /// Messages may be missing.
    #[default]
    Missing,
    /// Messages come later than they were sent. None is missing. If they are those of a channel, it is its last one.
    Late,
    /// A message comes after others that were sent after it.
    Displaced,
    /// Messages may be missing, and those that come may be others than they seem.
    Mixed,
    /// Another number of ticks may have passed, and no message is missing.
    Ticks,
}

/// Messages that may be missing from a sequence of events, or be others, or come late.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Gap {
    /// What may be wrong with them.
    pub flaw: Flaw,
    /// Which, and why they are missing, in words.
    pub why: String,
    /// Their channel; `None` if they may be missing on any.
    pub channel: Option<ChannelId>,
    /// Since when they may be missing, if events after that have come: verdicts reached since then may be wrong.
    pub since: Option<Duration>,
    /// Whether the gap ends: then it lies between two messages of the channel, or before the first.
    pub ends: bool,
}

impl Gap {
    /// From now on, any messages may be missing on any channel.
    pub fn of_anything(why: impl Into<String>) -> Self {
        Self { flaw: Flaw::Missing, why: why.into(), channel: None, since: None, ends: false }
    }
}
