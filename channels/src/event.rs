//! The timed state sequence: what happened, in order.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::{ChannelId, Message};

/// One state of the timed state sequence.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Event {
    /// How many communications there have been, this one included.
    pub step: u64,
    /// τ: the number of the last tick generated; a tick's own event already has it.
    pub tick: u64,
    /// When it happened, since the start of the run.
    pub time: Duration,
    /// What happened.
    pub kind: EventKind,
}

/// What happened at a state of the timed state sequence.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EventKind {
    /// A tick was generated, taken or not.
    Tick,
    /// A message was received.
    Received {
        /// From this channel.
        channel: ChannelId,
        /// This message.
        message: Message,
    },
}
