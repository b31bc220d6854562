//! A shuffle with random access.

/// A permutation of the numbers below some length, chosen by a key.
///
/// A Feistel network shuffles the next larger power of 4; a number that is too large is shuffled again until it is
/// small enough (Black and Rogaway, Ciphers with Arbitrary Finite Domains, 2002).
#[derive(Clone, Debug)]
pub(crate) struct Permutation {
    len: u64,
    key: u64,
    /// The number of bits in one half of the network.
    half: u32,
}

/// Four rounds look random if only a few places are used; if a half has only one bit, more rounds help.
const ROUNDS: u64 = 6;

impl Permutation {
    /// The permutation of the numbers below `len` for `key`.
    pub(super) fn new(len: u64, key: u64) -> Self {
        let bits = u64::BITS - len.saturating_sub(1).leading_zeros();
        Self { len, key, half: bits.div_ceil(2).max(1) }
    }

    pub(super) fn len(&self) -> u64 {
        self.len
    }

    /// The image of `place`.
    ///
    /// # Panics
    /// If `place` is not below the length.
    pub(super) fn at(&self, place: u64) -> u64 {
        assert!(place < self.len, "{place} is not below {}", self.len);
        // This terminates: a permutation leads back to where it began, which is below the length. The network's domain
        // is at most four times as long, so four iterations are enough on average.
        let mut at = self.shuffled(place);
        while at >= self.len {
            at = self.shuffled(at);
        }
        at
    }

    fn shuffled(&self, number: u64) -> u64 {
        let mask = (1 << self.half) - 1;
        let (mut left, mut right) = (number >> self.half, number & mask);
        for round in 0..ROUNDS {
            // A half has at most 32 bits: the round's number, in the bits above, makes each round a different function.
            (left, right) = (right, left ^ (mixed(self.key ^ mixed(right ^ (round << 56))) & mask));
        }
        left << self.half | right
    }
}

/// Every bit of the result depends on every bit of the number (the finalizer of SplitMix64).
fn mixed(number: u64) -> u64 {
    let number = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let number = (number ^ (number >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ (number >> 31)
}
