//! The steps that a system can take next.

use crate::{ChannelId, ProcessId, TransitionId};

/// The action of an enabled transition of the system.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum EnabledKind {
    /// An internal action of the process.
    Internal,
    /// The process fills an empty channel.
    Send(ChannelId),
    /// The process empties a full channel.
    Receive(ChannelId),
    /// The process sends while another receives.
    Handshake {
        /// The channel.
        channel: ChannelId,
        /// The process that receives.
        receiver: ProcessId,
        /// The receiver's transition.
        receiving: TransitionId,
    },
    /// A disturbance acts on the message in the channel.
    Disturb(ChannelId),
}

/// A transition that the system can take now.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Enabled {
    /// The process that moves: the sender in a handshake, the channel's source if a disturbance acts.
    pub process: ProcessId,
    /// The process's own number for the transition; the disturbance's number if one acts.
    pub transition: TransitionId,
    /// What the transition does.
    pub kind: EnabledKind,
}

impl Enabled {
    /// The processes that move: one, both sides of a handshake, or none if a disturbance acts.
    pub fn movers(&self) -> impl Iterator<Item = ProcessId> + use<> {
        let (first, second) = match self.kind {
            EnabledKind::Handshake { receiver, .. } => (Some(self.process), Some(receiver)),
            EnabledKind::Disturb(_) => (None, None),
            EnabledKind::Internal | EnabledKind::Send(_) | EnabledKind::Receive(_) => (Some(self.process), None),
        };
        first.into_iter().chain(second)
    }
}
