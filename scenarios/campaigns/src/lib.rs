//! Campaigns: from one run to a hundred thousand runs.
//!
//! One run shows that a fault can violate a requirement; a campaign estimates how likely that is. A [`Plan`] is read
//! from a TOML file and defines each run as a function of its number: the values of the [parameters](Parameter) that
//! the file varies, distributed by a [`Sampling`](sampling::Sampling), and a seed. [`statistics`] explains what the
//! results mean and when there are enough runs.
//!
//! [`run`] runs a campaign, or a [`Shard`] of it, on all cores and writes each run's [`RunRecord`] to a journal, in the
//! order of the runs. [`Ran::finish`] makes the [dataset] and the [`Summary`] from it, and [`merge`] puts shards
//! together. A run that is rejected, cannot continue or panics has a record like any other: it does not count for any
//! property, and it is not as expected. Runs are limited in simulated time and communications (`execution.max_time_s`,
//! `step_budget` and `run_budget` of the scenario), never by the wall clock: results must not depend on the machine.
//!
//! # Inside
//! A `plan` reads what varies from run to run, and defines run k as a function of plan and k; `statistics` estimates
//! probabilities from many runs: exact intervals, stopping rules and tests with guarantees, and the reordering that
//! makes campaigns stop at the same run on many cores as on one. The `runner` writes a record of each run to a
//! `journal`; `results`, `dataset` and the `page` of the report are made from it alone, so killed, resumed, sharded and
//! merged campaigns end with the same bytes. The page is computed in passes over the journal, in bins, so that its
//! memory does not grow with the runs. `suite` makes test cases of a summary, and `compare`
//! reads two journals side by side. `matrix` shows which property detects
//! which fault; `reproduce` runs the paper's experiments and checks them against `reproduce/experiments.rs`, the table
//! of the paper's claims with their sources, separate from this project's own; `reproduce/deviations.rs` lists where
//! the system differs from the published one. `findings` are the errors and warnings by file. The shipped
//! campaigns are beside the code.

pub mod compare;
pub mod dataset;
mod error;
pub mod file;
pub mod findings;
mod formula;
mod journal;
pub mod matrix;
mod measure;
mod model;
mod page;
pub mod parameter;
mod plan;
mod record;
pub mod reproduce;
mod results;
mod run_and_report;
mod runner;
pub mod sampling;
mod shard;
pub mod statistics;
mod suite;
mod summary;

pub use error::Error;
pub use file::CampaignFile;
pub use formula::{Formula, FormulaError};
pub use measure::Measure;
pub use model::Model;
pub use parameter::{Parameter, ParameterDomain, ParameterValue};
pub use plan::{Plan, PlannedRun};
pub use record::{MonitorFacts, RunFacts, RunOutcome, RunRecord};
pub use results::{merge, start_over};
pub use run_and_report::{refuse_campaign, report_of, run_and_report};
pub use runner::{Progress, Ran, run};
pub use shard::Shard;
pub use summary::{Estimate, Frequency, GoalReport, Named, Outcomes, Share, Summary, Unmet};
