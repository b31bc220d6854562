//! Measures navigation and localization alone, without a behavior tree: the benchmark of trips that `steward navigate`
//! runs ([`navigate`]), and the recorded robots of `steward localize` and `steward map` ([`replay`]).
//!
//! # Inside
//! `navigate` is the navigation benchmark: robot, localization and navigator, without tree and channels, on trips drawn
//! from a map (`course`), among people placed across the path (`people`) and boxes beside it (`boxes`). `replay` plays
//! logs of recorded robots back into localization, scores it, and makes maps from logs; `replay/bag` makes such a log
//! from a bag. `replay/trajectory` and `replay/live_pose` contain the poses of a robot in a bag, and of a running
//! robot.

mod median;
pub mod navigate;
pub mod replay;

pub use median::median;
