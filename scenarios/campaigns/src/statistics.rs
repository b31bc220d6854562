//! Statistical model checking: estimates from independent runs how likely it is that a requirement is violated.
//!
//! Everything here is based on counts. A [`Count`] is in how many of how many runs something happened, and its
//! [`interval`](Count::interval) is the exact one of Clopper and Pearson. [`Precision`] decides when an estimate is
//! precise enough, [`Sprt`] on which side of a bound a probability lies, and [`Comparison`] whether two campaigns
//! differ. The guarantees (coverage, error rates) hold for every true probability and are not approximations.
//!
//! **Stopping and order.** A campaign that stops as soon as its results are sufficient must not look at the runs in the
//! order in which they end: on many cores, short runs end first, and a violation often ends a run early. Results go
//! through [`batch::InOrder`], so that the rule sees run 0, run 1, run 2, … regardless of when each ended, and stops at
//! the same run on every machine.
//!
//! ```
//! use campaigns::statistics::{Confidence, Count};
//!
//! let violated = Count::new(682, 925);
//! let interval = violated.interval(Confidence::new(0.95)?);
//! assert_eq!(format!("{interval:.4}"), "0.7077 to 0.7654");
//! # Ok::<(), campaigns::statistics::StatisticsError>(())
//! ```

mod beta;
mod comparison;
mod count;
mod precision;
mod sprt;

pub use comparison::{Comparison, OddsInterval, Paired};
pub use count::{Confidence, Count, Interval};
pub use precision::Precision;
pub use sprt::{Sprt, SprtDecision};

/// Why a statistical goal is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StatisticsError {
    /// A confidence that is not between ½ and 1.
    #[error("a confidence must lie between 0.5 and 1, but is {0}")]
    Confidence(f64),
    /// A half width so small that it needs too many runs, or so large that it is pointless.
    #[error("the half width of an interval must lie between 0.0005 and 0.25, but is {0}")]
    HalfWidth(f64),
    /// A bound whose indifference region is not within the probabilities.
    #[error("{bound} ± {indifference} must lie between 0 and 1, with {indifference} > 0")]
    Bound {
        /// The bound.
        bound: f64,
        /// The distance from the bound within which either decision is acceptable.
        indifference: f64,
    },
    /// A probability of a wrong decision that is not between 0 and ½.
    #[error("the probability of a wrong decision must lie between 0 and 0.5, but is {0}")]
    ErrorRate(f64),
}

#[cfg(test)]
mod tests;
