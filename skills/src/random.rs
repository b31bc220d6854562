//! The sequence of random numbers of a machine.

/// A sequence, which begins with a seed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RandomSequence {
    pub(crate) position: u64,
    seed: u64,
    /// Whether the caller has set the seed.
    is_seeded: bool,
}

impl RandomSequence {
    /// The sequence of a machine whose caller has set no seed.
    pub(crate) fn of(seed: u64) -> Self {
        Self { position: seed, seed, is_seeded: false }
    }

    /// Begins anew, with another seed of the same origin.
    pub(crate) fn restart(&mut self, seed: u64) {
        (self.position, self.seed) = (seed, seed);
    }

    /// The same, unless the caller has set a seed.
    pub(crate) fn restart_unless_set(&mut self, seed: u64) {
        if !self.is_seeded {
            self.restart(seed);
        }
    }

    /// Begins with the seed of the caller.
    pub(crate) fn set_seed(&mut self, seed: u64) {
        self.restart(seed);
        self.is_seeded = true;
    }

    /// Continues the sequence of another machine if its caller has set the seed.
    pub(crate) fn draw_after(&mut self, other: &Self) {
        if other.is_seeded {
            self.set_seed(other.position);
        }
    }

    pub(crate) fn has_drawn(&self) -> bool {
        self.position != self.seed
    }
}

/// The next number of the sequence, in [0, 1) with 53 bits: SplitMix64 (Steele, Lea and Flood, 2014).
pub(crate) fn next(position: &mut u64) -> f64 {
    *position = position.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut mixed = (*position ^ (*position >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^= mixed >> 31;
    (mixed >> 11) as f64 / (1_u64 << 53) as f64
}
