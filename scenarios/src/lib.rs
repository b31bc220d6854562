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
//! reach the places that it names: `scenario/places.rs` uses `nav::Reach`, which starts and ends paths as the planner
//! does. A scenario without a map has no `Premises`. A scenario of a RoAML model has its `Model`, from which tree,
//! skills and components come.
//!
//! What is made of files is kept by the [`Memo`](diagnostics::Memo) of their disk, until the files change: parsed files
//! (`files::Files::load`), and what is computed from a map, `nav::Reach`, `nav::Atlas` and `sim::Building`. So the runs
//! of a scenario share it, also those with other values, and an editor parses only what was edited.
//!
//! `tree_script` is another file that users write: the answers of the leaves of a tree that is ticked without skills.
//! An `application` is a scenario with all its files, to be copied.
//!
//! Only `scenario/skill.rs` decides which machine implements which leaf, and `scenario/component.rs` makes components
//! from files.

pub mod application;
mod coordinates;
mod error;
pub mod faults;
pub mod files;
pub mod names;
pub mod occurrences;
pub mod processes;
pub mod scenario;
pub mod tree_script;

pub use error::{Complaints, Error};
