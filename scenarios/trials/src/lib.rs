//! Measures navigation and localization alone, without a behavior tree: the benchmark of trips that `steward navigate`
//! runs ([`navigate`]), and localization of the recorded robots of `steward localize` ([`localize`]).
//!
//! # Inside
//! `navigate` is the navigation benchmark: robot, localization and navigator, without tree and channels, on trips drawn
//! from a map (`course`), among people placed across the path (`people`) and boxes beside it (`boxes`). `localize`
//! plays recorded robots back into localization and scores it.

pub mod localize;
mod median;
pub mod navigate;

pub use median::median;
