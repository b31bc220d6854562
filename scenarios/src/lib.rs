//! Scenarios: the simulated service robot with its whole software stack, run under formal monitors.
//!
//! A [`Scenario`](scenario::Scenario) is a file and everything that it names: a map with places, a behavior tree, a
//! skill for each of its leaves, properties, faults, and what the run must come to. [`Live`](live::Live) is a scenario at
//! work, step by step; [`conduct`](conduct::conduct) runs one from start to end, takes pictures ([`drawing`]), records
//! it and gives the [`Report`](report::Report). The command line is in [`cli`].

pub mod campaign;
pub mod cli;
pub mod conduct;
mod ending;
mod error;
pub mod faults;
mod files;
mod given_up;
pub mod html;
pub mod junit;
pub mod live;
pub mod matrix;
mod monitoring;
mod occurrences;
pub mod pictures;
pub mod presentation;
pub mod report;
mod reporting;
pub mod reproduce;
pub mod scenario;
mod skill_errors;
mod tick_clock;
pub mod timeline;
mod tree_errors;
mod wiring;

pub use error::Error;
