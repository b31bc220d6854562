//! An adversary that lets one process wait.

use crate::{Enabled, ProcessId, Scheduler};

/// Lets one process move only when no other can; the others are chosen by another policy.
#[derive(Debug)]
pub struct Starving {
    victim: ProcessId,
    others: Box<dyn Scheduler>,
    /// The transitions that the victim is not the one to move in, and their places among all.
    rest: (Vec<Enabled>, Vec<usize>),
}

impl Starving {
    /// The policy that starves `victim` and leaves the choice among the others to `others`.
    #[must_use]
    pub fn new(victim: ProcessId, others: Box<dyn Scheduler>) -> Self {
        Self { victim, others, rest: (Vec::new(), Vec::new()) }
    }
}

impl Scheduler for Starving {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        let (rest, places) = &mut self.rest;
        rest.clear();
        places.clear();
        for (place, transition) in enabled.iter().enumerate().filter(|(_, other)| other.process != self.victim) {
            rest.push(transition.clone());
            places.push(place);
        }
        if rest.is_empty() { self.others.choose(enabled) } else { places[self.others.choose(rest)] }
    }
}
