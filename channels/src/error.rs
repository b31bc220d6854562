//! Errors of wiring a system and of running it.

use crate::Message;

/// Why a system cannot be put together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WiringError {
    /// Two processes have the same name.
    #[error("two processes are named {name}")]
    DuplicateProcess {
        /// The name.
        name: String,
    },
    /// Two channels join the same processes in the same direction.
    #[error("two channels lead from {source_process} to {target_process}")]
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
    /// A channel leads into the system, or out of it.
    #[error("no channel can lead from {source_process} to {target_process}: only one of them is part of the system")]
    Outside {
        /// The sender.
        source_process: String,
        /// The receiver.
        target_process: String,
    },
    /// A required channel does not exist.
    #[error("{process} needs the channel {channel}, which does not exist")]
    MissingChannel {
        /// The process that needs it.
        process: String,
        /// The channel in words, sender first.
        channel: String,
    },
    /// A process uses a channel that does not start or end at it.
    #[error("{process} would {verb} the channel {channel}, which belongs to other processes")]
    ForeignChannel {
        /// The process.
        process: String,
        /// `send on` or `receive from`.
        verb: &'static str,
        /// The channel in words.
        channel: String,
    },
    /// A process may send or wait for a message that the channel cannot carry.
    #[error("{process} uses the message {message}, which the channel {channel} cannot carry; it carries {domain}")]
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
    /// A declared process has no behavior.
    #[error("the process {process} is declared but has no behavior")]
    MissingProcess {
        /// The process.
        process: String,
    },
    /// A composed process has no behavior of its own that could be replaced.
    #[error("{process} is composed of members, which must be replaced one at a time")]
    Composed {
        /// The process.
        process: String,
    },
    /// A disturbance is on a channel that never holds a message.
    #[error("the channel {channel} passes messages on without holding them, so it cannot be disturbed")]
    HoldsNothing {
        /// The channel in words.
        channel: String,
    },
    /// A program graph uses a location, a variable or a field that it does not have, or it cannot start.
    #[error("the program graph {graph} {problem}")]
    Graph {
        /// The graph's name.
        graph: String,
        /// Its problem.
        problem: String,
    },
}

/// Why a run cannot continue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The system never becomes quiet: some processes keep moving forever.
    #[error("the system was still busy after {steps} transitions, at {time_s} s; {} kept moving", processes.join(", "))]
    Livelock {
        /// The number of transitions it was allowed.
        steps: u64,
        /// The time at which this happened, in seconds.
        time_s: String,
        /// The processes that were still moving, in alphabetical order.
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
    /// A disturbance replaced a message with one that the channel cannot carry.
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
