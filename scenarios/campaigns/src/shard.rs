//! Shards: parts of a campaign, for several machines.

use serde::{Deserialize, Serialize};

/// A part of a campaign: the runs whose numbers leave the remainder `index` when divided by `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which part, from 0.
    pub index: u64,
    /// How many parts there are.
    pub of: u64,
}

impl Shard {
    /// The whole campaign.
    pub const ALL: Self = Self { index: 0, of: 1 };

    /// The greatest number of parts of a campaign.
    pub const MOST: u64 = 1_000_000;

    /// Part `index` of `of`, if it exists.
    #[must_use]
    pub fn new(index: u64, of: u64) -> Option<Self> {
        (index < of && of <= Self::MOST).then_some(Self { index, of })
    }

    /// The number of runs in this part, out of `runs`.
    #[must_use]
    pub fn len(self, runs: u64) -> u64 {
        (runs + self.of - 1 - self.index) / self.of
    }

    /// The number of the part's run with this index.
    #[must_use]
    pub fn run(self, place: u64) -> u64 {
        self.index + place * self.of
    }
}
