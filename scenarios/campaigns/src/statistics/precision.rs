//! Estimating until the interval is narrow enough.

use super::{Confidence, Count, Interval, StatisticsError};

/// Each look at the numbers comes after this many times the runs of the one before.
const GROWTH: f64 = 1.3;

/// A goal: to know a probability to within a half width, with a confidence.
///
/// Whoever stops as soon as the usual interval is narrow enough is wrong more often than the interval says, since
/// chance picks the moment. So the numbers are looked at only after certain numbers of runs, settled beforehand, and the
/// intervals of all looks together keep the promise: each is made with the confidence that remains when the probability
/// of an error is divided among them. The first look is the earliest that can be narrow enough, the last always is.
///
/// The price is small. To within 0.05 with a confidence of 0.95, one needs 402 runs at most if their number is settled
/// beforehand, and here 838; but where a probability is near 0 or 1, some 60 runs are enough.
#[derive(Clone, Debug, PartialEq)]
pub struct Precision {
    half_width: f64,
    each: Confidence,
    /// The numbers of runs after which to look.
    looks: Vec<u64>,
}

impl Precision {
    /// The goal of that half width and confidence.
    ///
    /// # Errors
    /// A half width outside 0.0005 to 0.25.
    pub fn new(half_width: f64, confidence: Confidence) -> Result<Self, StatisticsError> {
        if !(0.0005..=0.25).contains(&half_width) {
            return Err(StatisticsError::HalfWidth(half_width));
        }
        // More looks ask for more runs, and more runs for more looks; but their number grows so slowly with the runs that
        // this settles soon.
        let mut shares = 1;
        loop {
            let each = confidence.shared_by(shares);
            let looks = looks(half_width, each);
            if looks.len() <= shares {
                return Ok(Self { half_width, each, looks });
            }
            shares = looks.len();
        }
    }

    /// The numbers of runs after which to look, in ascending order.
    #[must_use]
    pub fn looks(&self) -> &[u64] {
        &self.looks
    }

    /// After so many runs the goal is reached, whatever came of them.
    #[must_use]
    pub fn max_runs(&self) -> u64 {
        self.looks.last().copied().unwrap_or(0)
    }

    /// The interval, if the campaign can stop after these runs. To be asked after each run, in the order of the runs.
    #[must_use]
    pub fn reached(&self, count: Count) -> Option<Interval> {
        self.looks.binary_search(&count.runs()).ok()?;
        let interval = count.interval(self.each);
        (interval.half_width() <= self.half_width).then_some(interval)
    }

    /// The interval that holds with the goal's confidence wherever a campaign stops, narrow enough or not. Wider than
    /// [`Count::interval`], because of the looks.
    #[must_use]
    pub fn interval(&self, count: Count) -> Interval {
        count.interval(self.each)
    }
}

/// From the fewest runs after which an interval can be narrow enough to the fewest after which all are.
fn looks(half_width: f64, each: Confidence) -> Vec<u64> {
    let first = fewest(|runs| Count::new(0, runs).interval(each).half_width() <= half_width);
    // An interval is widest where it happened in half of the runs.
    let last = fewest(|runs| Count::new(runs, 2 * runs).interval(each).half_width() <= half_width) * 2;
    let mut looks = Vec::new();
    let mut look = first;
    while look < last {
        looks.push(look);
        look = ((look as f64 * GROWTH).ceil() as u64).max(look + 1);
    }
    looks.push(last);
    looks
}

/// The least number from 1 on for which `enough` holds; from there on it holds for all.
fn fewest(enough: impl Fn(u64) -> bool) -> u64 {
    let mut high = 1;
    while !enough(high) {
        high *= 2;
    }
    let mut low = high / 2;
    while high - low > 1 {
        let middle = low.midpoint(high);
        if enough(middle) { high = middle } else { low = middle }
    }
    high
}
