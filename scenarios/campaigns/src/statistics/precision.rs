//! Estimates a probability until the interval is narrow enough.

use super::{Confidence, Count, Interval, StatisticsError};

/// The ratio between the numbers of runs at one look at the results and at the previous look.
const GROWTH: f64 = 1.3;

/// A goal: to know a probability to within a half width, with a confidence.
///
/// A campaign that stops as soon as the usual interval is narrow enough is wrong more often than the interval allows,
/// since chance picks the moment. So the results are looked at only after certain numbers of runs, fixed in advance,
/// and the intervals of all looks together keep the guarantee: the probability of an error is divided among them. The
/// first look is the earliest at which the interval can be narrow enough; at the last one it always is.
///
/// The cost is small. For a half width of 0.05 and a confidence of 0.95, at most 402 runs are needed if their number is
/// fixed in advance, and 838 here; but if the probability is near 0 or 1, some 60 runs are enough.
#[derive(Clone, Debug, PartialEq)]
pub struct Precision {
    half_width: f64,
    each: Confidence,
    /// The numbers of runs after which to look.
    looks: Vec<u64>,
}

impl Precision {
    /// The goal with this half width and confidence.
    ///
    /// # Errors
    /// If the half width is not between 0.0005 and 0.25.
    pub fn new(half_width: f64, confidence: Confidence) -> Result<Self, StatisticsError> {
        if !(0.0005..=0.25).contains(&half_width) {
            return Err(StatisticsError::HalfWidth(half_width));
        }
        // More looks require more runs, and more runs require more looks. The number of looks grows so slowly that this
        // converges soon.
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

    /// After this many runs, the goal is always reached.
    #[must_use]
    pub fn max_runs(&self) -> u64 {
        self.looks.last().copied().unwrap_or(0)
    }

    /// The interval, if the campaign can stop after these runs. Call it after each run, in the order of the runs.
    #[must_use]
    pub fn reached(&self, count: Count) -> Option<Interval> {
        self.looks.binary_search(&count.runs()).ok()?;
        let interval = count.interval(self.each);
        (interval.half_width() <= self.half_width).then_some(interval)
    }

    /// The interval that holds with the goal's confidence wherever a campaign stops, narrow enough or not. It is wider
    /// than [`Count::interval`], because of the looks.
    #[must_use]
    pub fn interval(&self, count: Count) -> Interval {
        count.interval(self.each)
    }
}

/// The looks: from the smallest number of runs after which an interval can be narrow enough to the smallest number
/// after which all intervals are.
fn looks(half_width: f64, each: Confidence) -> Vec<u64> {
    let first = fewest(|runs| Count::new(0, runs).interval(each).half_width() <= half_width);
    // An interval is widest if the event happened in half of the runs.
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

/// The smallest number, at least 1, for which `enough` holds; it also holds for all greater numbers.
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
