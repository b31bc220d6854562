//! Campaigns: from one run to a hundred thousand.
//!
//! One run shows that a fault can break a requirement; a campaign says how likely it is. A [`Plan`] is read from a TOML
//! file, and says what each run is as a function of its number: the values of the [parameters](Parameter) that the file
//! varies, spread by a [`Sampling`](sampling::Sampling), and a seed. What the numbers that come of it mean, and when there
//! are enough of them, is in [`statistics`].

pub mod file;
pub mod parameter;
mod plan;
pub mod sampling;
pub mod statistics;

pub use file::CampaignFile;
pub use parameter::{Domain, Parameter, Value};
pub use plan::{Plan, PlannedRun};
