//! Runtime monitors over the channels of a system.
//!
//! A [`Property`] is a requirement with the monitor that watches it. The two properties of the paper are built here by
//! hand, as the program graphs of its monitor figure: [`phi1`], a safety property, and [`phi2`], a response property
//! with a deadline in ticks.

mod clause;
mod describe;
mod engine;
mod explain;
mod export;
mod formula;
mod load;
mod monitor;
mod oracle;
mod outcome;
mod paper;
mod problem;
mod resolve;
mod shipped;
mod suggest;
pub mod syntax;
mod synthesis;

pub use engine::Symbol;
pub use explain::explain;
pub use export::Format;
pub use formula::{Event, Formula, MessageCondition};
pub use load::{Property, PropertyFile, formulas, load, scope_monitor};
pub use monitor::{MAX_AUTOMATON_STATES, Moment, OpenObligation, ScopeMonitor, Sighting, Vacuity, Witness};
pub use oracle::{FormulaTooLarge, holds};
pub use outcome::Outcome;
pub use paper::{PhiTwo, phi1, phi2};
pub use problem::{Problem, ScopeError, Warnings};
pub use shipped::SHIPPED;
pub use synthesis::{Choice, Method};
