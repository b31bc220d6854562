//! Randomness: one root seed, and a named stream for each consumer.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The source of all random numbers of a run.
///
/// Each consumer takes its own stream once, by name (`"sim/laser_front"`). So an additional consumer, or more draws
/// in one place, does not affect other streams.
///
/// ```
/// use robot::{Streams, normal};
///
/// let streams = Streams::new(7);
/// let noise = normal(&mut streams.stream("laser/front"));
/// assert_eq!(noise, normal(&mut streams.stream("laser/front")));
/// assert_ne!(noise, normal(&mut streams.stream("laser/back")));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Streams {
    seed: u64,
}

impl Streams {
    /// The streams of a run with this root seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The root seed.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The stream with this name, from its beginning. The same seed and name give the same numbers on every machine.
    #[must_use]
    pub fn stream(&self, name: &str) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(fnv1a(name.as_bytes()));
        rng
    }
}

/// The 64-bit FNV-1a hash, which spreads names over ChaCha's 2⁶⁴ streams.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// A number from the standard normal distribution (Box–Muller), computed with libm and therefore the same on every
/// machine.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - rng.random::<f64>())).sqrt();
    radius * libm::cos(std::f64::consts::TAU * rng.random::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_depend_on_name_and_seed_only() {
        let first = |seed, name| Streams::new(seed).stream(name).random::<u64>();
        assert_eq!(first(1, "a"), first(1, "a"));
        assert_ne!(first(1, "a"), first(1, "b"));
        assert_ne!(first(1, "a"), first(2, "a"));
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let mut rng = Streams::new(7).stream("normal");
        let numbers: Vec<f64> = (0..20_000).map(|_| normal(&mut rng)).collect();
        let mean = numbers.iter().sum::<f64>() / 20_000.0;
        let variance = numbers.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03, "mean {mean}");
        assert!((variance - 1.0).abs() < 0.05, "variance {variance}");
    }
}
