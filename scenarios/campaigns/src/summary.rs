//! The summary of a campaign's results.

use std::cmp::Reverse;
use std::fmt;

use diagnostics::counted;
use recording::Provenance;
use serde::Serialize;

use super::statistics::{Count, Interval, SprtDecision};

/// Why runs were not as expected. If there are more reasons than this, only the most frequent ones are named.
const MOST_REASONS: usize = 5;

/// The summary of a campaign's results: `summary.json`.
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
    /// What the runs were made from, apart from their parameters.
    pub provenance: Provenance,
    /// The number of runs.
    pub runs: u64,
    /// How many runs were as the scenario expects, how many were not, and how many failed.
    pub outcomes: Outcomes,
    /// Whether the scenario expects anything of its runs, or a run was not as expected all the same.
    pub expects: bool,
    /// The expectations that some runs did not meet, the most frequent first.
    pub unmet: Vec<Unmet>,
    /// How often each property was violated. Runs that failed do not count for any property.
    pub properties: Vec<Estimate>,
    /// Whether its runs are those of a RoAML model, whose properties are true or false.
    pub of_roaml: bool,
    /// How often a run was not as the scenario expects, or failed.
    pub expectation: Estimate,
    /// The result of the campaign's goal; null without one.
    pub goal: Option<GoalReport>,
    /// The frontiers of the campaign's model and of the runs, in words; null without a model.
    pub frontier: Option<String>,
    /// The most instructive runs, the most important first.
    pub instructive: Vec<Named>,
    /// The first runs that failed, with the reasons and the commands that repeat them.
    pub failures: Vec<Named>,
    /// The first runs that were not as expected, with the commands that repeat them.
    pub unexpected: Vec<Named>,
}

impl Summary {
    /// The properties, those that were violated most often first; and apart from them, groups of those that were
    /// satisfied in every run and whose numbers are all equal, unless a group is small.
    #[must_use]
    pub fn by_rate(&self) -> (Vec<&Estimate>, Vec<Vec<&Estimate>>) {
        /// Fewer do not make a list long.
        const MANY: usize = 4;
        let mut sorted: Vec<&Estimate> = self.properties.iter().collect();
        // A model's properties may be true or false: neither is worse.
        if self.of_roaml {
            return (sorted, Vec::new());
        }
        let is_fine = |estimate: &&Estimate| estimate.is_fine();
        sorted.sort_by_key(|estimate| Reverse((estimate.count.happened(), estimate.inconclusive, !is_fine(estimate))));
        let first_fine = sorted.iter().position(is_fine).unwrap_or(sorted.len());
        let mut groups: Vec<Vec<&Estimate>> = Vec::new();
        for estimate in sorted.split_off(first_fine) {
            match groups.iter_mut().find(|group| group[0].numbers() == estimate.numbers()) {
                Some(group) => group.push(estimate),
                None => groups.push(vec![estimate]),
            }
        }
        let (groups, small): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| group.len() >= MANY);
        sorted.extend(small.into_iter().flatten());
        (sorted, groups)
    }

    /// The expectations that were not met most often, which are to be named.
    #[must_use]
    pub fn often_unmet(&self) -> &[Unmet] {
        &self.unmet[..self.unmet.len().min(MOST_REASONS)]
    }

    /// The command that repeats only this run, with pictures and report.
    #[must_use]
    pub fn command(&self, k: u64) -> String {
        command(&self.again, k)
    }
}

/// The command that repeats only one run, derived from the command `again` that runs its campaign.
pub(super) fn command(again: &str, k: u64) -> String {
    format!("{again} --only {k}")
}

/// The number of runs with each outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outcomes {
    /// As the scenario expects.
    pub as_expected: u64,
    /// Not as the scenario expects.
    pub not_as_expected: u64,
    /// Did not reach their end.
    pub failed: u64,
}

/// An expectation of the scenario that some runs did not meet.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unmet {
    /// The expectation, in words: `phi1 to be satisfied`.
    pub expected: String,
    /// How many runs did not meet it.
    pub runs: u64,
}

impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "in {}: expected {}", counted(self.runs, "run"), self.expected)
    }
}

/// How often something happened, and the estimate of its probability.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// The event: a violated property, or `expectation`.
    pub of: String,
    /// How many runs there were, and in how many of them it happened.
    pub count: Count,
    /// The fraction; null if there are no runs.
    pub rate: Option<f64>,
    /// The exact 95 % confidence interval, for a number of runs fixed in advance.
    pub interval: Interval,
    /// How often a property was violated in all runs together; null for `expectation`.
    pub violations: Option<Frequency>,
    /// In how many runs a property was inconclusive at the end; null for `expectation`.
    pub inconclusive: Option<u64>,
    /// The fraction of these runs; null for `expectation`, or if there are no runs.
    pub inconclusive_rate: Option<f64>,
    /// Its exact 95 % confidence interval; null for `expectation`.
    pub inconclusive_interval: Option<Interval>,
    /// In how many runs a property was satisfied vacuously, since a condition in it never occurred; null for
    /// `expectation`.
    pub vacuous: Option<u64>,
}

/// In how many runs something happened.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    /// How many runs there were, and in how many of them it happened.
    pub count: Count,
    /// The fraction; none if there are no runs.
    pub rate: Option<f64>,
    /// The exact 95 % confidence interval.
    pub interval: Interval,
}

/// `3 of 10: 0.3000 (95 %: 0.0667 to 0.6525)`.
impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (happened, runs, rate) = (self.count.happened(), self.count.runs(), self.rate.unwrap_or(0.0));
        write!(f, "{happened} of {runs}: {rate:.4} (95 %: {:.4})", self.interval)
    }
}

/// How often a property was violated, counting every violation of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Frequency {
    /// The number of violations in all runs.
    pub count: u64,
    /// The simulated time of all runs, in hours.
    pub hours: f64,
    /// Violations per run; null if there are no runs.
    pub per_run: Option<f64>,
    /// Violations per hour of simulated time; null if there is none.
    pub per_hour: Option<f64>,
}

impl Frequency {
    /// So many violations in so many runs, which lasted together this many hours.
    pub(super) fn of(count: u64, runs: u64, hours: f64) -> Self {
        let per = |of: f64| (of > 0.0).then(|| count as f64 / of);
        Self { count, hours, per_run: per(runs as f64), per_hour: per(hours) }
    }
}

impl fmt::Display for Frequency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (per_run, per_hour) = (self.per_run.unwrap_or(0.0), self.per_hour.unwrap_or(0.0));
        write!(f, "{} violations, {per_run:.2} per run, {per_hour:.2} per hour", self.count)
    }
}

impl Estimate {
    /// Whether the property was satisfied in every run, and not always because a condition in it never occurred.
    #[must_use]
    pub fn is_fine(&self) -> bool {
        let is_tested = self.vacuous < Some(self.count.runs());
        self.count.happened() == 0 && self.inconclusive == Some(0) && is_tested
    }

    /// How often a property was violated; of a RoAML model, how often it was true, as SMC Storm reports it.
    #[must_use]
    pub fn in_words(&self, of_roaml: bool) -> String {
        if of_roaml {
            let held = Count::new(self.count.runs() - self.count.happened(), self.count.runs());
            let share = Share { count: held, rate: held.rate(), interval: self.interval.complement() };
            return format!("true in {share}");
        }
        let repeated = self.repeated().map_or_else(String::new, |all| format!("; {all}"));
        let vacuous = self.vacuous.filter(|runs| *runs > 0);
        let vacuous = vacuous.map_or_else(String::new, |runs| format!("; vacuous in {runs}"));
        format!("violated in {}{repeated}{vacuous}", self.happened())
    }

    /// How often a property was inconclusive; none if it never was.
    #[must_use]
    pub fn open_in_words(&self) -> Option<String> {
        self.open().map(|share| format!("inconclusive in {share}"))
    }

    /// All that is counted, from which the rest follows.
    fn numbers(&self) -> (Count, Option<u64>, Option<u64>, Option<u64>) {
        (self.count, self.inconclusive, self.vacuous, self.violations.map(|all| all.count))
    }

    /// In how many runs it happened.
    #[must_use]
    pub fn happened(&self) -> Share {
        Share { count: self.count, rate: self.rate, interval: self.interval }
    }

    /// In how many runs the property was inconclusive, with the fraction and its exact 95 % interval, if it was in any.
    #[must_use]
    pub fn open(&self) -> Option<Share> {
        let count = Count::new(self.inconclusive.filter(|runs| *runs > 0)?, self.count.runs());
        Some(Share { count, rate: count.rate(), interval: self.inconclusive_interval? })
    }

    /// How often the property was violated, if it was violated more than once in some run.
    #[must_use]
    pub fn repeated(&self) -> Option<&Frequency> {
        self.violations.as_ref().filter(|violations| violations.count > self.count.happened())
    }
}

/// A run worth looking at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Named {
    /// Its number.
    pub k: u64,
    /// Why it is listed: why it failed, what it did not meet, or what makes it interesting.
    pub why: Option<String>,
    /// The command that repeats only this run, with pictures and report.
    pub command: String,
}

/// The result of a campaign's goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoalReport {
    /// The event whose probability is in question.
    pub of: String,
    /// How many runs there were, and in how many of them it happened. Runs that failed do not count for any property.
    pub count: Count,
    /// Whether the goal was reached with these runs.
    pub reached: bool,
    /// The interval of an estimate, which keeps the goal's confidence despite the intermediate looks.
    pub interval: Option<Interval>,
    /// The decision of a test.
    pub side: Option<SprtDecision>,
}

/// The answer to the campaign's question.
impl fmt::Display for GoalReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reached = if self.reached { "reached" } else { "not reached" };
        write!(f, "{reached} for {} after {}: ", self.of, counted(self.count.runs(), "run"))?;
        match (self.interval, self.side) {
            (Some(interval), _) => write!(f, "the probability lies in {interval:.4}"),
            (None, Some(side)) => write!(f, "the probability is {} the bound", side.name()),
            (None, None) => f.write_str("undecided"),
        }
    }
}
