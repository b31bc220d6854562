//! A violation as a sequence chart: the messages between the processes, tick by tick.
//!
//! Only the processes that the property concerns are drawn, and the tree that ticks them. The ticks at which something
//! happened that led to the violation are drawn in full; everything in between is summarized.

mod chart;
mod select;

pub(super) use chart::{draw, picture};
pub(super) use select::{Row, Sequence, Weight};
