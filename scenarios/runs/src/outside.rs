//! Where the components are that are nodes of ROS 2.

use std::time::Duration;

use remote::{Call, FromNode};

/// Carries requests to components outside the program, and back what they say.
pub trait Outside {
    /// What tells this run from all others.
    fn run(&self) -> u64;

    /// Waits for a moment until it is `now` there, in time since the start of the run. Returns what has come since it
    /// last did, and what else has happened, in words; none if it is not yet so late, and it is then asked again.
    fn hear(&mut self, now: Duration) -> Option<(Vec<FromNode>, Vec<String>)>;

    /// The run goes on: its time has stood still since the last call.
    fn resume(&mut self);

    /// Sends what is asked, at once.
    fn ask(&mut self, calls: Vec<Call>);

    /// Leaves, when all that was asked has been sent.
    fn leave(&mut self);
}
