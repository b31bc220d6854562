//! The connection to the components of a run that are nodes of ROS 2.

use std::time::Duration;

use remote::{Loss, Lost, NodeMessage, ServiceRequest};

/// Carries requests to components outside the program, and brings back their responses and messages.
pub trait RemoteComponents {
    /// A number that distinguishes this run from all others.
    fn run(&self) -> u64;

    /// Waits for a moment until the components' time is `now`, as time since the start of the run. Returns what has
    /// come since the last delivery; `None` if their time is earlier: the caller then calls again.
    fn receive(&mut self, now: Duration) -> Option<Delivery>;

    /// Continues after a pause of the run, in which its time stood still.
    fn resume(&mut self);

    /// Sends requests at once.
    fn send(&mut self, requests: Vec<ServiceRequest>);

    /// Disconnects, once all requests have been sent.
    fn leave(&mut self);
}

/// What has come from components outside the program, and what was lost on the way.
#[derive(Clone, Debug, Default)]
pub struct Delivery {
    /// The responses and messages, in order.
    pub messages: Vec<NodeMessage>,
    /// The losses that have begun.
    pub losses: Vec<Loss>,
    /// The losses, of now or earlier, that are over after these messages.
    pub resumed: Vec<Lost>,
    /// What else has happened, in words.
    pub notes: Vec<String>,
}
