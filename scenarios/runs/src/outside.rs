//! Where the components are that are nodes of ROS 2.

use std::time::Duration;

use remote::{Call, FromNode};

/// Carries requests to components outside the program, and back what they say.
pub trait Outside {
    /// What tells this run from all others.
    fn run(&self) -> u64;

    /// Waits until it is `now` there, in time since the start of the run. Returns what has come since the last call,
    /// and what else has happened, in words.
    fn hear(&mut self, now: Duration) -> (Vec<FromNode>, Vec<String>);

    /// Sends what is asked, at once.
    fn ask(&mut self, calls: Vec<Call>);

    /// Leaves, when all that was asked has been sent.
    fn leave(&mut self);
}
