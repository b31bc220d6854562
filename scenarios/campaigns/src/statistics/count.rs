//! How often something happened, and what follows for its probability.

use std::fmt;

use serde::Serialize;

use super::{StatisticsError, beta};

/// A confidence level: the minimum probability that a procedure gives a true statement.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
#[serde(transparent)]
pub struct Confidence(f64);

impl Confidence {
    /// 95 %: the confidence of the intervals in all results.
    pub const OF_RESULTS: Self = Self(0.95);

    /// A confidence, such as 0.95.
    ///
    /// # Errors
    /// [`StatisticsError::Confidence`] unless it lies strictly between ½ and 1.
    pub fn new(confidence: f64) -> Result<Self, StatisticsError> {
        let sensible = confidence > 0.5 && confidence < 1.0;
        if sensible { Ok(Self(confidence)) } else { Err(StatisticsError::Confidence(confidence)) }
    }

    /// The confidence as a number.
    #[must_use]
    pub fn value(self) -> f64 {
        self.0
    }

    /// The confidence with which each of `statements` must be made so that all of them hold with this one (Bonferroni).
    #[must_use]
    pub(super) fn shared_by(self, statements: usize) -> Self {
        Self(1.0 - (1.0 - self.0) / statements.max(1) as f64)
    }
}

/// How many runs there were, and in how many of them something happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Count {
    /// In how many runs it happened.
    happened: u64,
    /// How many runs there were.
    runs: u64,
}

impl Count {
    /// A count.
    ///
    /// # Panics
    /// If `happened` is greater than `runs`.
    #[must_use]
    pub fn new(happened: u64, runs: u64) -> Self {
        assert!(happened <= runs, "it happened in {happened} of only {runs} runs");
        Self { happened, runs }
    }

    /// Counts one more run.
    pub fn push(&mut self, happened: bool) {
        self.runs += 1;
        self.happened += u64::from(happened);
    }

    /// The count over the runs of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { happened: self.happened + other.happened, runs: self.runs + other.runs }
    }

    /// In how many runs it happened.
    #[must_use]
    pub fn happened(self) -> u64 {
        self.happened
    }

    /// How many runs there were.
    #[must_use]
    pub fn runs(self) -> u64 {
        self.runs
    }

    /// The fraction of runs in which it happened; none if there are no runs.
    #[must_use]
    pub fn rate(self) -> Option<f64> {
        (self.runs > 0).then(|| self.happened as f64 / self.runs as f64)
    }

    /// The interval of Clopper and Pearson (Biometrika 26, 1934): it contains the probability with at least this
    /// confidence, for every probability, if the number of runs was fixed in advance. Without runs, it is 0 to 1.
    #[must_use]
    pub fn interval(self, confidence: Confidence) -> Interval {
        let each = (1.0 - confidence.0) / 2.0;
        let (x, n) = (self.happened as f64, self.runs as f64);
        let low = if self.happened == 0 { 0.0 } else { beta::quantile(each, x, n - x + 1.0) };
        let high = if self.happened == self.runs { 1.0 } else { beta::quantile(1.0 - each, x + 1.0, n - x) };
        Interval { low, high }
    }
}

/// An interval of probabilities, or of differences between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl Interval {
    /// Half the distance between its ends.
    #[must_use]
    pub fn half_width(self) -> f64 {
        (self.high - self.low) / 2.0
    }

    /// The interval for the probability that it does not happen.
    #[must_use]
    pub fn complement(self) -> Self {
        Self { low: 1.0 - self.high, high: 1.0 - self.low }
    }

    /// Whether `value` lies in it, ends included.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.low.fmt(f)?;
        f.write_str(" to ")?;
        self.high.fmt(f)
    }
}
