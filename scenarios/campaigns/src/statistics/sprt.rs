//! Decides whether a probability lies above or below a bound, with as few runs as possible.

use serde::Serialize;

use super::{Count, StatisticsError};

/// Wald's sequential probability ratio test (Annals of Mathematical Statistics 16, 1945).
///
/// It decides whether a probability is below or above a bound. Within the indifference region around the bound, either
/// answer is acceptable; outside it, the wrong one has at most the given error probability. The thresholds are
/// `1/error` and `error`; Wald's approximations `(1−error)/error` would let the error probabilities slightly exceed the
/// requested ones.
///
/// ```
/// use campaigns::statistics::{Count, SprtDecision, Sprt};
///
/// let test = Sprt::new(0.05, 0.04, 0.01)?;
/// let mut violated = Count::default();
/// while test.decision(violated).is_none() {
///     violated.push(false);
/// }
/// assert_eq!((violated.runs(), test.decision(violated)), (55, Some(SprtDecision::Below)));
/// # Ok::<(), campaigns::statistics::StatisticsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sprt {
    /// The contribution of a run with the event to the log likelihood ratio.
    if_happened: f64,
    /// The contribution of any other run.
    if_not: f64,
    /// The decision threshold: above this, or below its negative.
    threshold: f64,
}

/// On which side of the bound the probability is decided to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SprtDecision {
    /// The probability is below the bound.
    Below,
    /// The probability is above the bound.
    Above,
}

impl SprtDecision {
    /// `below` or `above`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Below => "below",
            Self::Above => "above",
        }
    }
}

impl Sprt {
    /// The test of a probability against `bound`.
    ///
    /// # Errors
    /// If the indifference region is empty or extends beyond 0 to 1, or if the error is not between 0 and ½.
    pub fn new(bound: f64, indifference: f64, error: f64) -> Result<Self, StatisticsError> {
        let (low, high) = (bound - indifference, bound + indifference);
        if !(indifference > 0.0 && low > 0.0 && high < 1.0) {
            return Err(StatisticsError::Bound { bound, indifference });
        }
        if !(error > 0.0 && error < 0.5) {
            return Err(StatisticsError::ErrorRate(error));
        }
        Ok(Self {
            if_happened: libm::log(high / low),
            if_not: libm::log((1.0 - high) / (1.0 - low)),
            threshold: -libm::log(error),
        })
    }

    /// The decision after these runs, if there is one. Call it after each run, in the order of the runs; the first
    /// decision is final.
    #[must_use]
    pub fn decision(&self, count: Count) -> Option<SprtDecision> {
        let others = count.runs() - count.happened();
        let ratio = count.happened() as f64 * self.if_happened + others as f64 * self.if_not;
        if ratio >= self.threshold {
            Some(SprtDecision::Above)
        } else if ratio <= -self.threshold {
            Some(SprtDecision::Below)
        } else {
            None
        }
    }
}
