//! A campaign's results in short.

use serde::Serialize;

use super::statistics::{Count, Interval, Side};

/// A campaign's results in short: `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The campaign's file.
    pub campaign: String,
    /// The command that runs it again.
    pub again: String,
    /// Its scenario.
    pub scenario: String,
    /// The program's version.
    pub version: String,
    /// How many runs there are.
    pub runs: u64,
    /// How many of them were not what the scenario expects, and how many failed.
    pub outcomes: Outcomes,
    /// How often each property was violated. Runs that failed count for no property.
    pub properties: Vec<Estimate>,
    /// How often a run was not what the scenario expects, or failed.
    pub expectation: Estimate,
    /// What came of the campaign's goal; null without one.
    pub goal: Option<GoalReport>,
    /// The first runs that failed, with why and how to repeat them.
    pub failures: Vec<Named>,
    /// The first runs that were not as expected, with how to repeat them.
    pub unexpected: Vec<Named>,
}

impl Summary {
    /// The command that repeats a run alone, with pictures and report.
    #[must_use]
    pub fn command(&self, k: u64) -> String {
        command(&self.again, k)
    }
}

/// The command that repeats a run alone, made of the one that runs its campaign `again`.
pub(super) fn command(again: &str, k: u64) -> String {
    format!("{again} --only {k}")
}

/// How many runs went how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outcomes {
    /// As the scenario expects.
    pub as_expected: u64,
    /// Not so.
    pub not_as_expected: u64,
    /// Not to their end.
    pub failed: u64,
}

/// How often something happened, and what that says.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// What: a property that was violated, or `expectation`.
    pub of: String,
    /// In how many of how many runs.
    pub count: Count,
    /// The fraction; null without runs.
    pub rate: Option<f64>,
    /// The exact interval with a confidence of 0.95, for a number of runs that was settled beforehand.
    pub interval: Interval,
}

/// A run worth looking at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Named {
    /// Its number.
    pub k: u64,
    /// Why it failed; null if it did not.
    pub why: Option<String>,
    /// The command that repeats it alone, with pictures and report.
    pub command: String,
}

/// What came of a campaign's goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoalReport {
    /// Of what the probability is asked.
    pub of: String,
    /// In how many of how many runs it happened. Runs that failed count for no property.
    pub count: Count,
    /// Whether the goal was reached with these runs.
    pub reached: bool,
    /// The interval of an estimate, which keeps the goal's confidence though it was looked at on the way.
    pub interval: Option<Interval>,
    /// The decision of a test.
    pub side: Option<Side>,
}
