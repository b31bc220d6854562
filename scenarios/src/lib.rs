//! Scenarios: the simulated service robot with its whole software stack, run under formal monitors.
//!
//! A [`Scenario`](scenario::Scenario) is a file and everything that it names: a map with places, a behavior tree, a
//! skill for each of its leaves, properties, faults, and the expected results. [`Live`](live::Live) is a running
//! scenario, which advances step by step and describes itself in records; [`conduct`](conduct::conduct) runs one from
//! start to end.

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
pub mod schema;
mod skill_errors;
mod tick_clock;
mod tree_errors;
pub mod wiring;

pub use error::{Complaints, Error, StepError};
