//! Why a system cannot be explored.

use channels::Message;

/// Why a system cannot be explored.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// A process has no normal form.
    #[error("{process} cannot be explored: {reason}")]
    Process {
        /// The process.
        process: String,
        /// The reason: `it draws random numbers`.
        reason: String,
        /// How to fix it.
        help: Option<String>,
    },
    /// The monitor has no normal form.
    #[error("the property {property} cannot be explored: {reason}")]
    Property {
        /// Its name.
        property: String,
        /// Why.
        reason: String,
        /// How to fix it.
        help: Option<String>,
    },
    /// A process has too many states.
    #[error("{process} has more than {states} states: something in it may grow forever; the last one is at {location}")]
    TooManyStates {
        /// The process.
        process: String,
        /// The number of states found so far.
        states: usize,
        /// Its location in the last of them.
        location: String,
    },
    /// A process sends a message that its channel cannot carry.
    #[error("{process} may send {message} on the channel {channel}, which carries {domain}")]
    OutsideDomain {
        /// The process.
        process: String,
        /// The message.
        message: Message,
        /// The channel, in words.
        channel: String,
        /// Its domain, in words.
        domain: String,
    },
}
