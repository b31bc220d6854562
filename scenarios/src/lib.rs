//! Scenarios: the simulated service robot with all its software, run under formal monitors.
//!
//! A [`Scenario`](scenario::Scenario) is a file and everything that it names: a behavior tree, a skill for each of its
//! leaves, properties, faults, and the expected results. With a map, it has a robot; without one, tree, skills and
//! components run alone. [`Live`](live::Live) is a running scenario, which advances step by step and describes itself
//! in records; [`conduct`](conduct::conduct) runs one from start to end.

pub mod conduct;
mod driven;
mod ending;
mod error;
pub mod faults;
pub mod files;
mod given_up;
pub mod live;
pub mod machines;
mod monitoring;
pub mod names;
mod occurrences;
pub mod processes;
pub mod prove;
pub mod scenario;
pub mod schedule;
pub mod schema;
pub mod session;
mod skill_errors;
mod tick_clock;
mod tree_errors;
pub mod wiring;
mod world;

pub use error::{Complaints, Error, StepError};
