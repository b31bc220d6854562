//! A violation as a sequence chart: which messages passed between whom, tick by tick.
//!
//! Only the processes that the property concerns are drawn, and the tree that ticks them. The ticks at which something
//! happened that led to the violation are drawn in full; what lies between is summed up.

mod chart;
mod select;

pub(super) use chart::{draw, picture};
pub(super) use select::{Row, Sequence, Weight};
