//! Scenarios: the contents of their files.
//!
//! A [`Scenario`](scenario::Scenario) is a file and everything that it names: a behavior tree, a skill for each of its
//! leaves, properties, faults, and the expected results. With a map, it has a robot; without one, tree, skills and
//! components run alone. `runs` runs it, and `proofs` explores all of its runs.
//!
//! # Inside
//! `faults` has the catalogue of what can go wrong. `scenario/monitoring` makes the monitors of a scenario: those of
//! its properties, and those that it attaches directly, an SCXML machine (`monitoring/machine.rs`) or a program graph
//! of the paper's figure. `scenario/declaration` declares the processes and channels, so that a scenario whose skills
//! and components do not fit together is refused when it is loaded; and a scenario is loaded only if the robot can
//! reach the places that it names: `scenario/places.rs` asks `nav::Reach`, which starts and ends paths as the planner
//! does. A scenario without a map has no `Premises`. A scenario of a RoAML model has its `Model`, from which tree,
//! skills and components come. Data shared by the runs of a scenario is built once and kept by its `Scenario`: the
//! software's `nav::Atlas`, the simulation's `sim::Building`, the properties' `Monitoring`; `Scenario::load_like`
//! passes it on to the same scenario with other values.
//!
//! Only `scenario/skill.rs` decides which machine implements which leaf, and `scenario/component.rs` makes components
//! from files.

mod coordinates;
mod error;
pub mod faults;
pub mod files;
pub mod names;
pub mod occurrences;
pub mod processes;
pub mod scenario;

pub use error::{Complaints, Error};
