//! Odometry made worse on purpose.

use maps::{Pose, heading, pose, wrap_angle};
use rand_chacha::ChaCha8Rng;

use crate::random::normal;

/// What odometry gets wrong: each motion between two readings is made longer by `drift` (0.05: by 5 %) and by a random
/// share of standard deviation `noise`, and each turn likewise by another random share.
///
/// Published logs often carry odometry that has been corrected already, which is no test of localization.
#[derive(Clone, Debug)]
pub struct OdometryErrors {
    drift: f64,
    noise: f64,
    rng: ChaCha8Rng,
    /// The last reading, and what was made of it.
    last: Option<(Pose, Pose)>,
}

impl OdometryErrors {
    /// Errors of that size, with their stream of random numbers.
    #[must_use]
    pub fn new(drift: f64, noise: f64, rng: ChaCha8Rng) -> Self {
        Self { drift, noise, rng, last: None }
    }

    /// What becomes of the next reading. The first stays as it is.
    pub fn apply(&mut self, reading: &Pose) -> Pose {
        let wrong = match self.last {
            Some((before, wrong_before)) => wrong_before * self.wrong(&before.inv_mul(reading)),
            None => *reading,
        };
        self.last = Some((*reading, wrong));
        wrong
    }

    fn wrong(&mut self, motion: &Pose) -> Pose {
        let mut factor = || 1.0 + self.drift + self.noise * normal(&mut self.rng);
        let (way, turn) = (motion.translation.vector * factor(), wrap_angle(heading(motion)) * factor());
        pose(way.x, way.y, turn)
    }
}
