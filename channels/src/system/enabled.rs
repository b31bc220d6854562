//! What a system can do next.

use crate::{ChannelId, ProcessId, TransitionId};

/// What an enabled transition of the system does.
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
        /// Over this channel.
        channel: ChannelId,
        /// The process that receives.
        receiver: ProcessId,
        /// With this transition.
        receiving: TransitionId,
    },
    /// A disturbance acts on the message in the channel.
    Disturb(ChannelId),
}

/// A transition that the system can take now.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Enabled {
    /// The process that moves; the sender, in a handshake; the channel's source, where a disturbance acts.
    pub process: ProcessId,
    /// The process's own number for the transition; the disturbance's, where one acts.
    pub transition: TransitionId,
    /// What the transition does.
    pub kind: EnabledKind,
}
