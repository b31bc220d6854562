//! Schedulers: they choose which enabled transition is taken.
//!
//! The paper leaves the choice open ("a level of abstraction with respect to actual scheduling policies"), so a verdict
//! must not depend on it. Each policy here is one way to search for a verdict that does depend on it.

mod ordered;
mod random;
mod round_robin;
mod starving;

use std::fmt::Debug;

pub use ordered::{Delivery, Ordered, Precedence};
pub use random::Random;
pub use round_robin::RoundRobin;
pub use starving::Starving;

use crate::{ChannelSystem, Enabled};

/// Some of the enabled transitions, and their indices among all; the memory is used again for each choice.
#[derive(Debug, Default)]
struct Rest {
    transitions: Vec<Enabled>,
    places: Vec<usize>,
}

impl Rest {
    /// Lets `choose` pick among the transitions that do not wait, or among all if there are no others.
    fn choose(
        &mut self,
        enabled: &[Enabled],
        waits: impl Fn(&Enabled) -> bool,
        choose: impl FnOnce(&[Enabled]) -> usize,
    ) -> usize {
        self.transitions.clear();
        self.places.clear();
        for (place, transition) in enabled.iter().enumerate().filter(|(_, transition)| !waits(transition)) {
            self.transitions.push(transition.clone());
            self.places.push(place);
        }
        if self.transitions.is_empty() { choose(enabled) } else { self.places[choose(&self.transitions)] }
    }
}

/// A scheduling policy.
pub trait Scheduler: Debug + Send {
    /// The index of the transition to take. `enabled` is never empty.
    fn choose(&mut self, enabled: &[Enabled]) -> usize;

    /// Like [`choose`](Self::choose), for a policy that also considers the messages in transit. A running system calls
    /// this method.
    fn choose_in(&mut self, system: &ChannelSystem, enabled: &[Enabled]) -> usize {
        let _ = system;
        self.choose(enabled)
    }
}
