//! Model checking of channel systems.

mod error;
mod interner;
mod local;
mod model;
mod passage;
mod path;
mod search;
mod semantics;
mod store;
mod tables;

pub use error::Refused;
pub use model::{Closed, Environment, Instant, MessageFaults, Model, Move, Onlooker, Ticks, Update};
pub use path::{Path, PathStep, Replay, ReplayError};
pub use search::{Exploration, Limits, Outcome, Progress, explore};
pub use semantics::Damage;
