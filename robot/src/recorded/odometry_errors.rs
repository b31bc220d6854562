//! Odometry with artificial errors.

use maps::{Pose, heading, pose, wrap_angle};
use rand_chacha::ChaCha8Rng;

use crate::random::normal;

/// The errors of odometry: each motion between two readings is lengthened by `drift` (0.05: by 5 %) and by a random
/// share with standard deviation `noise`, and each turn by another random share.
///
/// Published logs often contain corrected odometry, which is too easy for localization.
#[derive(Clone, Debug)]
pub struct OdometryErrors {
    drift: f64,
    noise: f64,
    rng: ChaCha8Rng,
    /// The last reading, and the result for it.
    last: Option<(Pose, Pose)>,
}

impl OdometryErrors {
    /// Errors of this size, with their stream of random numbers.
    #[must_use]
    pub fn new(drift: f64, noise: f64, rng: ChaCha8Rng) -> Self {
        Self { drift, noise, rng, last: None }
    }

    /// The erroneous version of the next reading. The first reading is unchanged.
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
