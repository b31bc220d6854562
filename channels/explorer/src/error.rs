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
        /// Why: `it draws random numbers`.
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
        /// How many were found.
        states: usize,
        /// Where it is in the last one.
        location: String,
    },
    /// A process sends what its channel cannot carry.
    #[error("{process} may send {message} on the channel {channel}, which carries {domain}")]
    OutsideDomain {
        /// The process.
        process: String,
        /// The message.
        message: Message,
        /// The channel in words.
        channel: String,
        /// Its domain in words.
        domain: String,
    },
}
