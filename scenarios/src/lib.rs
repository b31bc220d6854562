//! Scenarios: the simulated service robot with all its software, run under formal monitors.
//!
//! A [`Scenario`](scenario::Scenario) is a file and everything that it names: a behavior tree, a skill for each of its
//! leaves, properties, faults, and the expected results. With a map, it has a robot; without one, tree, skills and
//! components run alone. [`Live`](live::Live) is a running scenario, which advances step by step and describes itself
//! in records; [`conduct`](conduct::conduct) runs one from start to end.
//!
//! # Inside
//! `faults` has the catalogue of what can go wrong, the timetable that says when each fault is active, and the injector
//! that applies it: in the simulated world (`sim::Faults`), on a channel (`channels::Disturbance`), in a component
//! (`components::Outages`), in a skill (`skills::Mutation`), in the ticks (`tick_clock`). `monitoring` makes the
//! monitors of a run: those of its properties, and those that a scenario attaches directly, an SCXML machine
//! (`monitoring/machine.rs`) or a program graph of the paper's figure. A scenario is loaded only if the robot can reach
//! the places that it names: `scenario/places.rs` asks `nav::Reach`, which starts and ends paths as the planner does. A
//! scenario without a map has no `Premises`, and its `World` is only the time. A scenario of a RoAML model has its
//! `Model`, from which tree, skills and components come; its steps go from event to event, not every 20 ms. Data shared
//! by the runs of a scenario is built once and kept by its `Scenario`: the software's `nav::Atlas`, the simulation's
//! `sim::Building`, the properties' `Monitoring`; `Scenario::load_like` passes it on to the same scenario with other
//! values. `conduct` runs a scenario from start to end, and `ending` decides when it ends.
//!
//! Only `scenario/skill.rs` decides which machine implements which leaf, and `scenario/component.rs` makes components
//! from files. `world.rs` is what devices sense and move in the simulation.
//!
//! `prove` prepares a scenario for `explorer`: `subject` decides what can be proved, `thresholds` which levels are
//! distinguished, `levels` divides them into classes, `environment` defines what may happen around the system, `faults`
//! lets faults from the catalogue occur in it, and `assumptions` states all of this in words. `coverage` follows every
//! step to find what is never reached; `mutants` repeats the proof on a scenario with a mistake, unless the mistake
//! changes nothing that was explored. `concrete` gives each run that was found battery levels that can occur, and
//! `written` turns it into a `schedule`, which a `Live` run follows instead of drivers and physics.

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
