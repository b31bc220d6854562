//! The default policy: every enabled transition is equally likely.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{Enabled, Scheduler};

/// Chooses uniformly at random, with numbers from its stream.
#[derive(Clone, Debug)]
pub struct Random {
    stream: ChaCha8Rng,
}

impl Random {
    /// The policy that draws its choices from this stream, from which nothing else should draw.
    #[must_use]
    pub fn new(stream: ChaCha8Rng) -> Self {
        Self { stream }
    }
}

impl Scheduler for Random {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        self.stream.random_range(0..enabled.len())
    }
}
