//! Systematic resampling: one random number, evenly spaced draws.
//!
//! Each particle of normalized weight w is drawn ⌊n·w⌋ or ⌈n·w⌉ times, and n·w times on average.

/// Draws `count` particles with these normalized weights, with a comb that starts at `offset` (in [0, 1) of a tooth),
/// and passes the index of each to `draw`, in ascending order.
pub(crate) fn systematic(weights: impl Iterator<Item = f64>, count: usize, offset: f64, mut draw: impl FnMut(usize)) {
    let mut drawn = 0;
    let mut sum = 0.0;
    let mut last = 0;
    for (index, weight) in weights.enumerate() {
        sum += weight;
        last = index;
        while drawn < count && drawn as f64 + offset < sum * count as f64 {
            draw(index);
            drawn += 1;
        }
    }
    // The sum of the weights may be below one because of rounding.
    for _ in drawn..count {
        draw(last);
    }
}

/// The number of equally weighted particles that would be as informative as these normalized weights: 1 / Σ w².
pub(crate) fn effective_number(weights: impl Iterator<Item = f64>) -> f64 {
    1.0 / weights.map(|weight| weight * weight).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::RngExt;

    use super::*;

    fn counts(weights: &[f64], count: usize, offset: f64) -> Vec<usize> {
        let mut counts = vec![0; weights.len()];
        systematic(weights.iter().copied(), count, offset, |index| counts[index] += 1);
        counts
    }

    proptest! {
        #[test]
        fn each_particle_is_drawn_in_proportion_to_its_weight(
            raw in prop::collection::vec(0.0..1.0_f64, 1..40), count in 1_usize..200, offset in 0.0..1.0_f64,
        ) {
            let total = raw.iter().sum::<f64>();
            prop_assume!(total > 1e-3);
            let weights: Vec<f64> = raw.iter().map(|weight| weight / total).collect();
            let counts = counts(&weights, count, offset);
            prop_assert_eq!(counts.iter().sum::<usize>(), count);
            for (drawn, weight) in counts.iter().zip(&weights) {
                let expected = count as f64 * weight;
                prop_assert!((*drawn as f64 - expected).abs() < 1.0 + 1e-9, "{drawn} draws for {expected}");
            }
        }
    }

    #[test]
    fn draws_are_unbiased() {
        let weights = [0.013, 0.507, 0.111, 0.369];
        let mut rng = robot::Streams::new(3).stream("resampling");
        let mut sums = [0.0; 4];
        for _ in 0..20_000 {
            for (sum, drawn) in sums.iter_mut().zip(counts(&weights, 10, rng.random())) {
                *sum += drawn as f64 / 200_000.0;
            }
        }
        for (mean, weight) in sums.iter().zip(weights) {
            assert!((mean - weight).abs() < 0.002, "drawn with frequency {mean} instead of {weight}");
        }
    }

    #[test]
    fn equal_weights_count_fully_and_one_weight_counts_once() {
        assert!((effective_number([0.25; 4].into_iter()) - 4.0).abs() < 1e-12);
        assert!((effective_number([1.0, 0.0, 0.0].into_iter()) - 1.0).abs() < 1e-12);
    }
}
