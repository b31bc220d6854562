//! What can go wrong in wiring a system and in running it.

use crate::Message;

/// Why a system cannot be put together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WiringError {
    /// Two processes have the same name.
    #[error("there are two processes named {name}")]
    DuplicateProcess {
        /// The name.
        name: String,
    },
    /// Two channels join the same processes in the same direction.
    #[error("there are two channels {source_process} → {target_process}")]
    DuplicateChannel {
        /// The sender.
        source_process: String,
        /// The receiver.
        target_process: String,
    },
    /// A channel has the same process at both ends.
    #[error("a channel joins {process} to itself")]
    SelfChannel {
        /// The process.
        process: String,
    },
    /// A channel that somebody needs is not there.
    #[error("{process} needs a channel {channel}, and there is none")]
    MissingChannel {
        /// The process that needs it.
        process: String,
        /// The channel in words, sender first.
        channel: String,
    },
    /// A process uses a channel that it is not at that end of.
    #[error("{process} would {verb} the channel {channel}, which is not its own")]
    ForeignChannel {
        /// The process.
        process: String,
        /// `send on` or `receive from`.
        verb: &'static str,
        /// The channel in words.
        channel: String,
    },
    /// A process may send or wait for a message that the channel cannot carry.
    #[error("{process} knows the message {message}, which the channel {channel} cannot carry; it carries {domain}")]
    OutsideDomain {
        /// The process.
        process: String,
        /// The message.
        message: Message,
        /// The channel in words.
        channel: String,
        /// The channel's domain in words.
        domain: String,
    },
    /// A declared process has no behaviour.
    #[error("the process {process} is declared, but nothing says what it does")]
    MissingProcess {
        /// The process.
        process: String,
    },
    /// A process that is the sum of its members has no behaviour of its own that could be replaced.
    #[error("{process} is the sum of its members, which have to be replaced one by one")]
    Composed {
        /// The process.
        process: String,
    },
    /// A disturbance of a channel that never holds a message.
    #[error("the channel {channel} hands messages over without holding them, so nothing can happen to them there")]
    HoldsNothing {
        /// The channel in words.
        channel: String,
    },
    /// A program graph's transition names a location that it does not have, or it has no initial location.
    #[error("the program graph {graph} {problem}")]
    Graph {
        /// The graph's name.
        graph: String,
        /// What is wrong with it.
        problem: String,
    },
}

/// Why a system cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The system does not become quiet: some processes keep going without end.
    #[error("the system was not quiet after {steps} transitions at {time_s} s; {} kept going", processes.join(", "))]
    Livelock {
        /// How many transitions it was given.
        steps: u64,
        /// When it happened, in seconds.
        time_s: String,
        /// The processes that were still taking transitions, in order of name.
        processes: Vec<String>,
    },
    /// A process sent a message that its channel cannot carry.
    #[error("{process} sent {message} on the channel {channel}, which carries {domain}")]
    OutsideDomain {
        /// The process.
        process: String,
        /// The message.
        message: Message,
        /// The channel in words.
        channel: String,
        /// The channel's domain in words.
        domain: String,
    },
    /// A disturbance replaced a message by one that the channel cannot carry.
    #[error("a disturbance put {message} into the channel {channel}, which carries {domain}")]
    Corrupted {
        /// The message.
        message: Message,
        /// The channel in words.
        channel: String,
        /// The channel's domain in words.
        domain: String,
    },
}
