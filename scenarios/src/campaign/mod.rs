//! Campaigns: from one run to a hundred thousand.
//!
//! One run shows that a fault can break a requirement; a campaign says how likely it is. What its numbers mean, and when
//! there are enough of them, is in [`statistics`].

pub mod statistics;
