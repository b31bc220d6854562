//! The outcome of a property at the end of a run.

use std::fmt;

use channels::{Monitor, Verdict};
use serde::{Deserialize, Serialize};

/// The outcome of a property at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The property holds on the run.
    Satisfied,
    /// The property was violated.
    Violated,
    /// An obligation was still pending when the run ended.
    Inconclusive,
}

impl Outcome {
    /// All outcomes, in the order in which they are listed.
    pub const ALL: [Self; 3] = [Self::Satisfied, Self::Violated, Self::Inconclusive];

    /// The outcome of a run that ends with the monitor in its current state.
    #[must_use]
    pub fn of(monitor: &dyn Monitor) -> Self {
        match monitor.verdict() {
            Verdict::False => Self::Violated,
            Verdict::Inconclusive if monitor.is_open() => Self::Inconclusive,
            Verdict::True | Verdict::Inconclusive => Self::Satisfied,
        }
    }

    /// The outcome as reports write it: `satisfied`, `violated` or `inconclusive`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Satisfied => "satisfied",
            Self::Violated => "violated",
            Self::Inconclusive => "inconclusive",
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outcome_fills_the_width_of_its_column() {
        assert_eq!(format!("{:<12}|", Outcome::Violated), "violated    |");
    }
}
