//! Tests whether something happens more often in one campaign than in another.

use serde::Serialize;

use super::{Confidence, Count, Interval, beta};

/// The greatest logarithm of an odds ratio that is considered. With the 10⁸ runs of the largest campaign, odds reach
/// about 10⁸ and their ratio 10¹⁶, which is e³⁷.
const LARGEST_LN_RATIO: f64 = 60.0;
/// Two outcomes whose probabilities differ by less than this fraction count as equally likely: rounding must not decide
/// whether one that is as likely as the observation counts. The value is that of R's `fisher.test`.
const EQUALLY_LIKELY: f64 = 1e-7;

/// The comparison of two counts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The count before.
    pub before: Count,
    /// The count after.
    pub after: Count,
    /// Fisher's exact test, two-sided: the probability of counts that differ at least this much if the true rates are
    /// the same.
    pub p_value: f64,
    /// The rate after minus the rate before; none if there are no runs.
    pub difference: Option<f64>,
    /// The confidence interval of the true difference: the two intervals of Clopper and Pearson, combined by Newcombe's
    /// method (Statistics in Medicine 17, 1998, method 10).
    pub interval: Interval,
    /// The odds after divided by the odds before; none if that is 0/0 or infinite.
    pub odds_ratio: Option<f64>,
    /// The confidence interval of the true odds ratio: the exact interval conditional on the total count, which matches
    /// Fisher's test (Cornfield, Proceedings of the Third Berkeley Symposium 4, 1956).
    pub odds_interval: OddsInterval,
    /// Cohen's h, the difference between the arcsine-transformed rates: 0.2 is small, 0.5 medium, 0.8 large.
    pub cohens_h: Option<f64>,
}

/// An interval of odds ratios.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OddsInterval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end; none if there is no bound.
    pub high: Option<f64>,
}

impl Comparison {
    /// Compares two campaigns.
    #[must_use]
    pub fn of(before: Count, after: Count, confidence: Confidence) -> Self {
        let rates = before.rate().zip(after.rate());
        let angle = |rate: f64| 2.0 * libm::asin(rate.sqrt());
        Self {
            before,
            after,
            p_value: fisher(before, after),
            difference: rates.map(|(before, after)| after - before),
            interval: difference(before, after, confidence),
            odds_ratio: odds_ratio(before, after),
            odds_interval: odds_interval(before, after, confidence),
            cohens_h: rates.map(|(before, after)| angle(after) - angle(before)),
        }
    }
}

fn odds_ratio(before: Count, after: Count) -> Option<f64> {
    let [x, y] = [before, after].map(|count| count.happened() as f64);
    let [not_x, not_y] = [before, after].map(|count| (count.runs() - count.happened()) as f64);
    let below = x * not_y;
    (below > 0.0).then(|| y * not_x / below)
}

/// The odds ratios under which the observation is not too unlikely on either side, by bisection of the logarithm.
fn odds_interval(before: Count, after: Count, confidence: Confidence) -> OddsInterval {
    let happened = before.happened() + after.happened();
    let (fewest, most) = (happened.saturating_sub(before.runs()), happened.min(after.runs()));
    let ways: Vec<f64> = (fewest..=most)
        .map(|after_runs| ln_choose(after.runs(), after_runs) + ln_choose(before.runs(), happened - after_runs))
        .collect();
    let seen = (after.happened() - fewest) as usize;
    // Fisher's noncentral hypergeometric distribution: each way has the weight ωˣ, relative to the greatest term, since
    // the terms themselves would overflow. The probability of at least (or at most) the observed count after, given the
    // logarithm of the odds ratio.
    let tail = |ln_ratio: f64, upper: bool| {
        let terms: Vec<f64> = ways.iter().enumerate().map(|(place, ways)| ways + place as f64 * ln_ratio).collect();
        let greatest = terms.iter().copied().fold(f64::MIN, f64::max);
        let part = |terms: &[f64]| terms.iter().map(|term| libm::exp(term - greatest)).sum::<f64>();
        part(if upper { &terms[seen..] } else { &terms[..=seen] }) / part(&terms)
    };
    let each = (1.0 - confidence.value()) / 2.0;
    let bound = |upper: bool| {
        let (mut low, mut high) = (-LARGEST_LN_RATIO, LARGEST_LN_RATIO);
        // 60 halvings of the interval leave less than the last bit of the result.
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if (tail(middle, upper) < each) == upper { low = middle } else { high = middle }
        }
        libm::exp(f64::midpoint(low, high))
    };
    OddsInterval { low: if seen == 0 { 0.0 } else { bound(true) }, high: (seen + 1 < ways.len()).then(|| bound(false)) }
}

/// The confidence interval of the difference of the probabilities.
fn difference(before: Count, after: Count, confidence: Confidence) -> Interval {
    let (Some(p), Some(q)) = (before.rate(), after.rate()) else { return Interval { low: -1.0, high: 1.0 } };
    let (around_p, around_q) = (before.interval(confidence), after.interval(confidence));
    let down = libm::hypot(q - around_q.low, around_p.high - p);
    let up = libm::hypot(around_q.high - q, p - around_p.low);
    Interval { low: (q - p - down).max(-1.0), high: (q - p + up).min(1.0) }
}

/// The two-sided p-value of Fisher's exact test: over all ways to distribute the events among the runs, the total
/// probability of those that are at most as likely as the observation.
fn fisher(before: Count, after: Count) -> f64 {
    let happened = before.happened() + after.happened();
    let fewest = happened.saturating_sub(after.runs());
    let most = happened.min(before.runs());
    let ways = |x: u64| ln_choose(before.runs(), x) + ln_choose(after.runs(), happened - x);
    let all = ln_choose(before.runs() + after.runs(), happened);
    let seen = ways(before.happened()) + EQUALLY_LIKELY;
    let p: f64 = (fewest..=most).map(ways).filter(|ln| *ln <= seen).map(|ln| libm::exp(ln - all)).sum();
    p.min(1.0)
}

/// The logarithm of the number of ways to choose k of n.
fn ln_choose(n: u64, k: u64) -> f64 {
    let ln_factorial = |n: u64| libm::lgamma(n as f64 + 1.0);
    ln_factorial(n) - ln_factorial(k) - ln_factorial(n - k)
}

/// The results of runs that were made both before and after, with everything else equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Paired {
    /// In how many pairs it happened only before.
    pub only_before: u64,
    /// In how many pairs it happened only after.
    pub only_after: u64,
}

impl Paired {
    /// McNemar's exact test, two-sided: the probability that the differing runs are split at least this unevenly if
    /// both ways are equally likely.
    #[must_use]
    pub fn p_value(self) -> f64 {
        let (differ, most) = (self.only_before + self.only_after, self.only_before.max(self.only_after));
        if 2 * most <= differ {
            return 1.0;
        }
        // At least `most` of `differ`: the distribution function of a Beta variable.
        (2.0 * beta::cdf(0.5, most as f64, (differ - most) as f64 + 1.0)).min(1.0)
    }
}
