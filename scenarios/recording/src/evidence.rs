//! What a verdict rests on.

use std::fmt;

use monitors::Outcome;
use serde::{Deserialize, Serialize};

/// How sure a verdict is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Certainty {
    /// Nothing that is not known could change it.
    Sure,
    /// Only the loss of a message that would not have been noticed yet could change it: which, in words.
    Unless(String),
    /// Messages are missing that could change it: which, and why, in words.
    Unsure(String),
    /// There is no verdict, since nothing vouches that the messages which it is about could have come: why, in words.
    Groundless(String),
}

impl Certainty {
    /// Its name in results.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sure => "sure",
            Self::Unless(_) => "unless",
            Self::Unsure(_) => "unsure",
            Self::Groundless(_) => "none",
        }
    }

    /// Why it is not sure, in words.
    #[must_use]
    pub fn why(&self) -> Option<&str> {
        match self {
            Self::Sure => None,
            Self::Unless(why) | Self::Unsure(why) | Self::Groundless(why) => Some(why),
        }
    }

    /// The verdict that may be shown for this outcome of a monitor.
    #[must_use]
    pub fn verdict(&self, outcome: Outcome) -> ShownVerdict {
        match self {
            Self::Sure | Self::Unless(_) => ShownVerdict::Of(outcome),
            Self::Unsure(_) => ShownVerdict::Unsure,
            Self::Groundless(_) => ShownVerdict::Groundless,
        }
    }
}

/// A verdict that may be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownVerdict {
    /// The outcome of the monitor.
    Of(Outcome),
    /// Messages are missing that could change it.
    Unsure,
    /// There is none, since nothing could be judged.
    Groundless,
}

impl ShownVerdict {
    /// Its name in results: `satisfied`, `violated`, `inconclusive`, `unsure`, or `no verdict`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Of(outcome) => outcome.name(),
            Self::Unsure => "unsure",
            Self::Groundless => "no verdict",
        }
    }
}

impl fmt::Display for ShownVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What a verdict rests on. It comes only from [`Grounds`](crate::Grounds), for what the source of the messages vouches
/// for, and [`Doubts`](crate::Doubts), for what is missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Evidence {
    certainty: Certainty,
    assumptions: Vec<String>,
    silent: Vec<String>,
}

impl Default for Evidence {
    /// There is none.
    fn default() -> Self {
        Self::new(Certainty::Groundless(channels::Ground::default().to_string()), Vec::new(), Vec::new())
    }
}

impl Evidence {
    pub(crate) fn new(certainty: Certainty, assumptions: Vec<String>, silent: Vec<String>) -> Self {
        Self { certainty, assumptions, silent }
    }

    /// How sure the verdict is.
    #[must_use]
    pub fn certainty(&self) -> &Certainty {
        &self.certainty
    }

    /// What is assumed of the messages, in words, each without "that".
    #[must_use]
    pub fn assumptions(&self) -> &[String] {
        &self.assumptions
    }

    /// The channels of the property on which there was no message at all, as "from A to B".
    #[must_use]
    pub fn silent(&self) -> &[String] {
        &self.silent
    }

    /// Whether an outcome may be shown at all.
    #[must_use]
    pub fn has_verdict(&self) -> bool {
        matches!(self.certainty, Certainty::Sure | Certainty::Unless(_))
    }
}
