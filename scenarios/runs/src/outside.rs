//! Where the components are that are nodes of ROS 2.

use std::time::Duration;

use remote::{Call, FromNode, Loss, Lost};

/// Carries requests to components outside the program, and back what they say.
pub trait Outside {
    /// What tells this run from all others.
    fn run(&self) -> u64;

    /// Waits for a moment until it is `now` there, in time since the start of the run. Returns what has come since it
    /// last did; none if it is not yet so late, and it is then asked again.
    fn hear(&mut self, now: Duration) -> Option<Delivery>;

    /// The run goes on: its time has stood still since the last call.
    fn resume(&mut self);

    /// Sends what is asked, at once.
    fn ask(&mut self, calls: Vec<Call>);

    /// Leaves, when all that was asked has been sent.
    fn leave(&mut self);
}

/// What has come from components outside the program, and what has happened on the way.
#[derive(Clone, Debug, Default)]
pub struct Delivery {
    /// The responses and messages, in order.
    pub answers: Vec<FromNode>,
    /// What has been lost on the way.
    pub losses: Vec<Loss>,
    /// Of what was lost, now or earlier, nothing more is missing after these answers.
    pub resumed: Vec<Lost>,
    /// What else has happened, in words.
    pub happened: Vec<String>,
}
