//! An axis of numbers: the position of a value, the labeled values, and the bins of a histogram along it.
//!
//! Times have their own axis, [`TimeAxis`](super::TimeAxis): their round values are not decimal.

use std::ops::Range;

/// An axis of numbers, divided into bins.
///
/// Positions along it are fractions: 0 at its lower end, 1 at its upper end, less or more beyond them.
///
/// ```
/// use drawing::scale::{Scale, short};
///
/// let errors_m = Scale::new(0.01..1.0, true, 4);
/// let labels: Vec<String> = errors_m.ticks(10).into_iter().map(short).collect();
/// assert_eq!(labels, ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1"]);
/// assert_eq!(errors_m.share(0.1), 0.5);
/// assert_eq!(errors_m.bin(0.2), 2);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The number at its lower end.
    pub low: f64,
    /// The number at its upper end, greater than the one at the lower end.
    pub high: f64,
    /// Whether equal distances are equal ratios rather than equal differences.
    pub logarithmic: bool,
    /// The number of bins, at least one, all equally long on the axis.
    pub bins: usize,
}

impl Scale {
    /// An axis over this range, with this many bins (at least one). An empty range is extended, and a range that does
    /// not begin above zero is never logarithmic.
    #[must_use]
    pub fn new(range: Range<f64>, logarithmic: bool, bins: usize) -> Self {
        let Range { start: low, end: high } = range;
        let logarithmic = logarithmic && low > 0.0;
        let high = if high > low { high } else { low + low.abs().max(1.0) };
        Self { low, high, logarithmic, bins: bins.max(1) }
    }

    /// The position of a value along the axis.
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        if self.logarithmic {
            libm::log(value.max(f64::MIN_POSITIVE) / self.low) / libm::log(self.high / self.low)
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// The value at a position along the axis.
    #[must_use]
    pub fn at(&self, share: f64) -> f64 {
        if self.logarithmic {
            self.low * libm::pow(self.high / self.low, share)
        } else {
            self.low + (self.high - self.low) * share
        }
    }

    /// The bin of a value; values beyond an end belong to the last bin at that end.
    #[must_use]
    pub fn bin(&self, value: f64) -> usize {
        ((self.share(value) * self.bins as f64).max(0.0) as usize).min(self.bins - 1)
    }

    /// The values at the ends of a bin.
    #[must_use]
    pub fn ends(&self, bin: usize) -> [f64; 2] {
        [bin, bin + 1].map(|end| self.at(end as f64 / self.bins as f64))
    }

    /// The same axis with another number of bins.
    #[must_use]
    pub fn with_bins(self, bins: usize) -> Self {
        Self { bins, ..self }
    }

    /// Round values along the axis, in ascending order, at most about this many: 1, 2 and 5 times powers of ten. A
    /// logarithmic axis that is too short for two of them is divided like a linear one.
    #[must_use]
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        let ticks = if self.logarithmic { self.ratios(most) } else { Vec::new() };
        if ticks.len() >= 2 { ticks } else { self.steps(most) }
    }

    /// Multiples of the smallest round step that gives few enough of them.
    fn steps(&self, most: usize) -> Vec<f64> {
        let rough = (self.high - self.low) / most.max(1) as f64;
        let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
        let step = [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        // Multiples at an end belong to the axis, whatever the last bit of the quotient is.
        let first = libm::ceil(self.low / step - 1e-9);
        let last = libm::floor(self.high / step + 1e-9);
        (0..=(last - first).max(0.0) as usize).map(|number| (first + number as f64) * step).collect()
    }

    /// 1, 2 and 5 in every decade, or only its beginning.
    fn ratios(&self, most: usize) -> Vec<f64> {
        let [first, last] = [self.low, self.high].map(|end| libm::floor(libm::log10(end)) as i32);
        let decades = |parts: &[f64]| -> Vec<f64> {
            let all = (first..=last).flat_map(|decade| {
                parts.iter().map(move |part| {
                    // A quotient is the closest number to a negative power of ten as people write it.
                    if decade < 0 {
                        part / libm::pow(10.0, f64::from(-decade))
                    } else {
                        part * libm::pow(10.0, f64::from(decade))
                    }
                })
            });
            all.filter(|tick| (self.low * (1.0 - 1e-9)..=self.high * (1.0 + 1e-9)).contains(tick)).collect()
        };
        let choices = [&[1.0, 2.0, 5.0][..], &[1.0, 3.0], &[1.0]].map(decades);
        let fitting = choices.iter().find(|ticks| ticks.len() <= most);
        fitting.unwrap_or(&choices[2]).clone()
    }
}

/// A number with three significant digits, as people write it: `0.0123`, `12.3`, `123456`; with an exponent if it is
/// very small or very large.
#[must_use]
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - libm::floor(libm::log10(size)) as i32;
    if !(-4..=8).contains(&digits) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.*}", digits.max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_in_a_range_lies_in_its_bin() {
        for scale in [Scale::new(-2.0..3.0, false, 7), Scale::new(0.001..10.0, true, 16)] {
            for step in 0..=100 {
                let value = scale.at(f64::from(step) / 100.0);
                let [low, high] = scale.ends(scale.bin(value));
                assert!(low - 1e-9 <= value && value <= high + 1e-9, "{value} in {low}..{high}");
            }
            assert_eq!((scale.bin(-1e9), scale.bin(1e9)), (0, scale.bins - 1));
        }
    }

    #[test]
    fn ticks_are_round_and_in_range() {
        assert_eq!(Scale::new(0.1..9.9, false, 1).ticks(6), [2.0, 4.0, 6.0, 8.0]);
        assert_eq!(Scale::new(0.002..0.5, true, 1).ticks(10), [0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5]);
        assert_eq!(Scale::new(0.002..500.0, true, 1).ticks(6), [0.01, 0.1, 1.0, 10.0, 100.0]);
        assert_eq!(Scale::new(3.0..3.0, false, 4).high, 6.0);
    }

    #[test]
    fn numbers_are_short() {
        let written = [0.0, 12.0, 12.345, 0.012345, 123_456.0, 1e-7, 2.5, -0.5].map(short);
        assert_eq!(written, ["0", "12", "12.3", "0.0123", "123456", "1.00e-7", "2.5", "-0.5"]);
    }
}
