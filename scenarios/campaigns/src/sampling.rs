//! The sample point of each run in the space of parameters, a pure function of the plan and the run's number.
//!
//! Each parameter is one dimension, named by its key, and a run gets a number from 0 to 1 in each. Each key has its own
//! random stream, so adding a parameter does not change the others. The designs:
//!
//! - [`Random`](Sampling::Random): each run is drawn independently.
//! - [`LatinHypercube`](Sampling::LatinHypercube): each dimension is divided into as many equal strata as there are
//!   runs, and each stratum has exactly one run (McKay, Beckman and Conover, Technometrics 21, 1979). Only all runs
//!   together form such a design.
//! - [`Sobol`](Sampling::Sobol): a sequence that fills the space evenly from its start, with a random shift.
//!
//! A grid enumerates all combinations of values instead; the plan does that, since it needs no numbers from 0 to 1.

mod permutation;
mod sobol;

use rand::RngExt;
use robot::Streams;

use permutation::Permutation;
pub use sobol::MAX_DIMENSIONS as MAX_SOBOL_DIMENSIONS;

/// How runs are distributed over the space of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Every combination of the parameters' values.
    Grid,
    /// Each run independently.
    Random,
    /// Divides each parameter's range evenly, with one run in each stratum.
    LatinHypercube,
    /// A low-discrepancy sequence.
    Sobol,
}

/// One dimension of a design.
#[derive(Clone, Debug)]
pub(super) enum Dimension {
    Random { streams: Streams, key: String },
    LatinHypercube { streams: Streams, key: String, strata: Permutation },
    Sobol { shift: u32, directions: [u32; 32] },
}

impl Dimension {
    /// The dimension of the parameter with this index; none for a grid. Only a Latin hypercube depends on `runs`.
    ///
    /// # Panics
    /// If a Sobol sequence has no such dimension.
    pub(super) fn new(sampling: Sampling, place: usize, key: &str, seed: u64, runs: u64) -> Option<Self> {
        let streams = Streams::new(seed);
        let key = key.to_owned();
        match sampling {
            Sampling::Grid => None,
            Sampling::Random => Some(Self::Random { streams, key }),
            Sampling::LatinHypercube => {
                let strata = Permutation::new(runs, streams.stream(&format!("campaign/strata/{key}")).random());
                Some(Self::LatinHypercube { streams, key, strata })
            }
            Sampling::Sobol => {
                let shift = streams.stream(&format!("campaign/shift/{key}")).random();
                Some(Self::Sobol { shift, directions: sobol::directions(place) })
            }
        }
    }

    /// The coordinate of run `k`, above 0 and below 1.
    pub(super) fn at(&self, k: u64) -> f64 {
        match self {
            Self::Random { streams, key } => random(streams, key, k),
            Self::LatinHypercube { streams, key, strata } => {
                let stratum = strata.at(k) as f64 + random(streams, key, k);
                inside(stratum / strata.len() as f64)
            }
            Self::Sobol { shift, directions } => {
                let point = sobol::point(directions, k as u32) ^ shift;
                (f64::from(point) + 0.5) / 4_294_967_296.0
            }
        }
    }
}

/// A random number for one run and one key.
fn random(streams: &Streams, key: &str, k: u64) -> f64 {
    inside(streams.stream(&format!("campaign/{k}/{key}")).random())
}

/// Keeps a number away from 0 and 1, where quantiles are infinite.
fn inside(number: f64) -> f64 {
    number.clamp(1e-12, 1.0 - 1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(sampling: Sampling, dimensions: usize, runs: u64) -> Vec<Vec<f64>> {
        let dimension = |place: usize| {
            Dimension::new(sampling, place, &format!("key{place}"), 7, runs).expect("this is not a grid")
        };
        let dimensions: Vec<_> = (0..dimensions).map(dimension).collect();
        (0..runs).map(|k| dimensions.iter().map(|dimension| dimension.at(k)).collect()).collect()
    }

    /// The centered L2 discrepancy (Hickernell, Mathematics of Computation 67, 1998): how unevenly points are
    /// distributed.
    fn discrepancy(points: &[Vec<f64>]) -> f64 {
        let n = points.len() as f64;
        let off = |x: f64| (x - 0.5).abs();
        let single =
            |point: &Vec<f64>| point.iter().map(|x| 1.0 + 0.5 * off(*x) - 0.5 * off(*x) * off(*x)).product::<f64>();
        let pair = |a: &Vec<f64>, b: &Vec<f64>| {
            let one = |(x, y): (&f64, &f64)| 1.0 + 0.5 * off(*x) + 0.5 * off(*y) - 0.5 * (x - y).abs();
            a.iter().zip(b).map(one).product::<f64>()
        };
        let singles: f64 = points.iter().map(single).sum();
        let pairs: f64 = points.iter().flat_map(|a| points.iter().map(move |b| pair(a, b))).sum();
        let dimensions = points[0].len() as i32;
        libm::sqrt(libm::pow(13.0 / 12.0, f64::from(dimensions)) - 2.0 / n * singles + pairs / (n * n))
    }

    #[test]
    fn each_stratum_of_a_latin_hypercube_has_one_run_in_every_dimension() {
        for runs in [1, 2, 7, 100, 1000] {
            let points = points(Sampling::LatinHypercube, 3, runs);
            for dimension in 0..3 {
                let mut strata: Vec<u64> = points.iter().map(|point| (point[dimension] * runs as f64) as u64).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..runs).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn the_dimensions_of_a_latin_hypercube_are_shuffled_differently() {
        let points = points(Sampling::LatinHypercube, 2, 1000);
        let product = |point: &Vec<f64>| (point[0] - 0.5) * (point[1] - 0.5);
        let correlation = points.iter().map(product).sum::<f64>() / 1000.0 * 12.0;
        assert!(correlation.abs() < 0.1, "correlation {correlation}");
    }

    #[test]
    fn every_dyadic_interval_has_its_share_of_a_sobol_sequence() {
        for place in 0..MAX_SOBOL_DIMENSIONS {
            let dimension = Dimension::new(Sampling::Sobol, place, "key", 3, 0).expect("this is not a grid");
            let mut cells: Vec<u64> = (0..256).map(|k| (dimension.at(k) * 256.0) as u64).collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..256).collect::<Vec<_>>(), "dimension {place}");
        }
    }

    /// The sequence's first two dimensions form a (0, m, 2)-net in base 2.
    #[test]
    fn every_dyadic_rectangle_has_its_share_of_a_sobol_sequence() {
        let points = points(Sampling::Sobol, 2, 256);
        for split in 0..=8 {
            let (wide, high) = (f64::from(1 << split), f64::from(1 << (8 - split)));
            let mut cells: Vec<_> = points.iter().map(|p| ((p[0] * wide) as u64, (p[1] * high) as u64)).collect();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), 256, "rectangles of 1/{wide} by 1/{high}");
        }
    }

    #[test]
    fn sobol_is_more_even_than_random_in_many_dimensions() {
        for dimensions in [2, 5, MAX_SOBOL_DIMENSIONS] {
            let of = |sampling| discrepancy(&points(sampling, dimensions, 512));
            let (sobol, random) = (of(Sampling::Sobol), of(Sampling::Random));
            assert!(sobol < 0.7 * random, "{sobol} against {random} in {dimensions} dimensions");
        }
    }

    #[test]
    fn random_points_are_uniform_and_depend_only_on_seed_key_and_number() {
        let points = points(Sampling::Random, 1, 4000);
        let mut sorted: Vec<f64> = points.iter().map(|point| point[0]).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let off = |(place, x): (usize, &f64)| (x - (place as f64 + 0.5) / 4000.0).abs();
        // Kolmogorov and Smirnov: above 1.63/√n with a probability of 0.01.
        let furthest = sorted.iter().enumerate().map(off).fold(0.0, f64::max);
        assert!(furthest < 1.63 / libm::sqrt(4000.0), "{furthest}");
        let elsewhere = Dimension::new(Sampling::Random, 5, "key0", 7, 12).expect("this is not a grid");
        assert_eq!(elsewhere.at(3999), points[3999][0]);
    }
}
