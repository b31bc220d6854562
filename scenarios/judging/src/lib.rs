//! Logs, bags and running robots, judged by properties.
//!
//! [`verify`] judges what was recorded, [`Mapped`] the messages of any source, with a mapping to channels,
//! and [`TreeProgram`] a program with BehaviorTree.CPP. All give a [`VerificationResult`], and make what else is
//! [`Wanted`]: a report, a page, verdicts as they are reached.
//!
//! # Inside
//! `event_log` judges event logs, recordings and logs of BehaviorTree.CPP: each is a `logged_run`, line by line or of
//! records (`recorded_events`); `description` is what a log states about its run, `ticks` whether its ticks fit the
//! properties, `tree_log` what a log of BehaviorTree.CPP leaves open, and `growing` reads one that is being written.
//! `bag` and `mapped` judge messages of ROS 2. These end in `judge`, which runs the monitors: on the events alone,
//! or on the records of a `judged_run`, if something shows these. `log_context` has what is known besides events, of
//! which `scene_sampler` makes scenes. `tree_program` judges a tree while a program runs it.
//! `black_box` keeps the last moments of a source.

mod bag;
mod black_box;
mod boards;
mod description;
#[cfg(test)]
mod disorder;
mod event_log;
#[cfg(test)]
mod formats;
mod growing;
mod host;
mod judge;
mod judged_run;
#[cfg(test)]
mod lines;
mod log_context;
mod log_request;
mod logged_run;
#[cfg(test)]
mod loss;
mod mapped;
mod node_places;
#[cfg(test)]
mod random;
mod recorded_events;
mod scene_sampler;
mod ticks;
mod tree_log;
mod tree_program;
mod verify;
mod wanted;

pub use bag::open as open_bag;
pub use black_box::BlackBox;
pub use host::Host;
pub use judge::{NO_FORMULA, VerificationResult, load};
pub use log_context::LogContext;
pub use log_request::{LogRequest, Robots};
pub use mapped::{Mapped, await_topics, check_no_bag, check_no_metadata, check_violations, load_mapping};
pub use node_places::node_places;
pub use tree_program::TreeProgram;
pub use verify::verify;
pub use wanted::{ShowRun, ShownRun, VerdictObserver, Wanted};
