//! What vouches for the messages of a channel.

use std::fmt;

use serde::{Deserialize, Serialize};

/// On what ground every message of a channel is known to be among the events: once, as it was sent, and in order.
///
/// Without evidence against it, which is a [`Gap`](crate::Gap). That time goes on, or that a participant announces
/// itself, is no ground: only what took the same way as the messages shows that the way is open.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ground {
    /// None, with the reason in words: whether any message could have come is not known.
    Missing(String),
    /// The events were computed together with the messages, or read from a file, whole and in order. It reaches as far
    /// as the events.
    Complete,
    /// An assumption, in words, such as "the recorder wrote every message that it received". It reaches as far as the
    /// events.
    Assumed(String),
    /// Consecutive numbers. They reach as far as the newest message of the channel: one that was lost after it leaves
    /// no trace before the next one arrives.
    Numbered,
    /// Consecutive numbers of several senders. Which of them sent the newest message is not known, so that one may have
    /// been lost at any time since the first.
    NumberedApart,
}

impl Ground {
    /// The ground of a channel whose messages come in two ways: the weaker one.
    #[must_use]
    pub fn weaker(self, other: Self) -> Self {
        match (self, other) {
            (missing @ Self::Missing(_), _) | (_, missing @ Self::Missing(_)) => missing,
            // The newest message may be one of the others.
            (Self::Numbered | Self::NumberedApart, _) | (_, Self::Numbered | Self::NumberedApart) => {
                Self::NumberedApart
            }
            (Self::Assumed(one), Self::Assumed(other)) if one != other => {
                Self::Assumed(format!("{one}, and that {other}"))
            }
            (assumed @ Self::Assumed(_), _) | (_, assumed @ Self::Assumed(_)) => assumed,
            (Self::Complete, Self::Complete) => Self::Complete,
        }
    }
}

impl Default for Ground {
    fn default() -> Self {
        Self::Missing("no source vouches for its messages".to_owned())
    }
}

impl fmt::Display for Ground {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(why) => f.write_str(why),
            Self::Complete => f.write_str("all messages are known"),
            Self::Assumed(what) => write!(f, "it is assumed that {what}"),
            Self::Numbered | Self::NumberedApart => f.write_str("the messages are numbered"),
        }
    }
}
