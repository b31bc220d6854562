//! Parts of a campaign, for many machines.

use serde::{Deserialize, Serialize};

/// A part of a campaign: the runs whose number leaves the remainder `index` when divided by `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which part, from 0.
    pub index: u64,
    /// How many parts there are.
    pub of: u64,
}

impl Shard {
    /// All of a campaign.
    pub const ALL: Self = Self { index: 0, of: 1 };

    /// A campaign has no more parts than this.
    pub const MOST: u64 = 1_000_000;

    /// One of so many parts, if there is such a part.
    #[must_use]
    pub fn new(index: u64, of: u64) -> Option<Self> {
        (index < of && of <= Self::MOST).then_some(Self { index, of })
    }

    /// How many of that many runs are in the part.
    #[must_use]
    pub fn len(self, runs: u64) -> u64 {
        (runs + self.of - 1 - self.index) / self.of
    }

    /// The number of the part's run of that place.
    #[must_use]
    pub fn run(self, place: u64) -> u64 {
        self.index + place * self.of
    }
}
