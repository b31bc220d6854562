//! The distribution of numbers, in bins.

use drawing::scale::Scale;

/// The number of values in each bin of an axis.
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    pub(super) scale: Scale,
    pub(super) counts: Vec<u64>,
}

impl Histogram {
    pub(super) fn new(scale: Scale) -> Self {
        Self { scale, counts: vec![0; scale.bins] }
    }

    pub(super) fn add(&mut self, value: f64) {
        self.counts[self.scale.bin(value)] += 1;
    }

    pub(super) fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The value below which this fraction of the numbers lies, to within a bin; none without numbers.
    pub(super) fn quantile(&self, share: f64) -> Option<f64> {
        let wanted = share * self.total() as f64;
        let mut below = 0.0;
        for (bin, count) in self.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let count = *count as f64;
            if below + count >= wanted {
                let inside = (wanted - below) / count;
                return Some(self.scale.at((bin as f64 + inside) / self.counts.len() as f64));
            }
            below += count;
        }
        None
    }

    /// The same numbers in fewer bins; the number of bins must be a divisor of the present one.
    pub(super) fn coarser(&self, bins: usize) -> Self {
        let each = self.counts.len() / bins;
        let counts = self.counts.chunks(each).map(|counts| counts.iter().sum()).collect();
        Self { scale: self.scale.with_bins(bins), counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_within_a_bin_of_the_truth() {
        let mut histogram = Histogram::new(Scale::new(0.0..100.0, false, 200));
        (0..1000).for_each(|number| histogram.add(f64::from(number * 37 % 1000) / 10.0));
        for share in [0.1, 0.5, 0.9] {
            let got = histogram.quantile(share).unwrap();
            assert!((got - 100.0 * share).abs() <= 0.5, "{got} at {share}");
        }
        let coarse = histogram.coarser(10);
        assert_eq!((coarse.total(), coarse.counts[3]), (1000, 100));
        assert_eq!(Histogram::new(coarse.scale).quantile(0.5), None);
    }
}
