//! Scenarios: the simulated service robot with its whole software stack, run under formal monitors.
//!
//! A [`Scenario`](scenario::Scenario) is a file and everything that it names: a map with places, a behavior tree, a
//! skill for each of its leaves, properties, faults, and what the run must come to. [`Live`](live::Live) is a scenario at
//! work, step by step, and tells of itself in records; [`conduct`](conduct::conduct) runs one from start to end.

pub mod conduct;
mod ending;
mod error;
pub mod faults;
pub mod files;
mod given_up;
pub mod live;
mod monitoring;
pub mod names;
mod occurrences;
pub mod processes;
pub mod scenario;
mod skill_errors;
mod tick_clock;
mod tree_errors;
pub mod wiring;

pub use error::{Complaints, Error, StepError};
