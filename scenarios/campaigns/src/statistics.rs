//! Statistical model checking: how likely a requirement is violated, from runs that are independent of each other.
//!
//! Everything here counts. A [`Count`] says in how many of how many runs something happened, and its
//! [`interval`](Count::interval) is the exact one of Clopper and Pearson. [`Precision`] says when an estimate is as
//! precise as was asked for, [`Sprt`] decides on which side of a bound a probability lies, and [`Comparison`] whether two
//! campaigns differ. The promises (coverage, error rates) hold for every true probability and are no approximations.
//!
//! **Stopping and order.** A campaign that stops when its numbers suffice must not look at the runs in the order in which
//! they end: on many cores, short runs end first, and a violation often ends a run early. Results go through
//! [`batch::InOrder`], so that the rule sees run 0, run 1, run 2, … whatever ended when, and stops at the same run on every
//! machine.
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
pub use sprt::{Side, Sprt};

/// Why a statistical goal makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StatisticsError {
    /// A confidence that is not between ½ and 1.
    #[error("a confidence must lie between 0.5 and 1, and {0} does not")]
    Confidence(f64),
    /// A half width that no number of runs that anybody has time for can reach, or that asks for nothing.
    #[error("the half width of an interval must lie between 0.0005 and 0.25, and {0} does not")]
    HalfWidth(f64),
    /// A bound whose indifference region leaves the probabilities.
    #[error("{bound} ± {indifference} must lie between 0 and 1, and 0 < {indifference}")]
    Bound {
        /// The bound.
        bound: f64,
        /// How far from it either decision is right.
        indifference: f64,
    },
    /// A probability of a wrong decision that is not between 0 and ½.
    #[error("the probability of a wrong decision must lie between 0 and 0.5, and {0} does not")]
    ErrorRate(f64),
}

#[cfg(test)]
mod tests;
