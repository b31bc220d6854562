//! Random errors in a motion.

use rand_chacha::ChaCha8Rng;
use robot::normal;

use crate::config::DriftNoise;

/// Adds drift noise to the motions of a run, from its own stream.
#[derive(Clone, Debug)]
pub(crate) struct Drift {
    noise: DriftNoise,
    rng: ChaCha8Rng,
}

impl Drift {
    pub(crate) fn new(noise: DriftNoise, rng: ChaCha8Rng) -> Self {
        Self { noise, rng }
    }

    /// The motion with its errors. Without noise, or without motion, it is exactly the same.
    pub(crate) fn disturb(&mut self, forward_m: f64, turn_rad: f64) -> (f64, f64) {
        let (distance, angle) = (forward_m.abs(), turn_rad.abs());
        if self.noise == DriftNoise::default() || distance + angle == 0.0 {
            return (forward_m, turn_rad);
        }
        let DriftNoise { angle_per_sqrt_rad, angle_per_sqrt_m, distance_per_sqrt_m, distance_per_sqrt_rad } =
            self.noise;
        let sigma = |per_sqrt_m: f64, per_sqrt_rad: f64| {
            (per_sqrt_m * per_sqrt_m * distance + per_sqrt_rad * per_sqrt_rad * angle).sqrt()
        };
        let forward = forward_m + sigma(distance_per_sqrt_m, distance_per_sqrt_rad) * normal(&mut self.rng);
        let turn = turn_rad + sigma(angle_per_sqrt_m, angle_per_sqrt_rad) * normal(&mut self.rng);
        (forward, turn)
    }
}

#[cfg(test)]
mod tests {
    use robot::Streams;

    use super::*;

    /// The standard deviation of the distance after driving 1 m in this many steps.
    fn spread_after_a_meter(steps: u32) -> f64 {
        let noise = DriftNoise { distance_per_sqrt_m: 0.02, ..DriftNoise::default() };
        let mut drift = Drift::new(noise, Streams::new(3).stream("drift"));
        let mut ends = (0..2000).map(|_| (0..steps).map(|_| drift.disturb(1.0 / f64::from(steps), 0.0).0).sum::<f64>());
        (ends.by_ref().map(|end| (end - 1.0) * (end - 1.0)).sum::<f64>() / 2000.0).sqrt()
    }

    #[test]
    fn drift_depends_on_the_distance_and_not_on_the_number_of_steps() {
        for steps in [1, 100] {
            let spread = spread_after_a_meter(steps);
            assert!((spread - 0.02).abs() < 0.001, "{spread} after {steps} steps");
        }
    }

    #[test]
    fn standing_still_draws_nothing() {
        let noise = DriftNoise { angle_per_sqrt_m: 0.1, ..DriftNoise::default() };
        let mut drift = Drift::new(noise, Streams::new(3).stream("drift"));
        let mut other = drift.clone();
        assert_eq!(drift.disturb(0.0, 0.0), (0.0, 0.0));
        assert_eq!(drift.disturb(1.0, 0.0), other.disturb(1.0, 0.0));
    }
}
