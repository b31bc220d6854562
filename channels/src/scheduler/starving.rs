//! An adversary that starves one process.

use crate::{ChannelSystem, Enabled, ProcessId, Scheduler};

/// Starves one process with all its members: it moves only when no other process can, even as the receiver in a
/// handshake. Another policy chooses among the other processes.
#[derive(Debug)]
pub struct Starving {
    victim: ProcessId,
    others: Box<dyn Scheduler>,
    /// The transitions in which the victim does not move, and their indices among all.
    rest: (Vec<Enabled>, Vec<usize>),
}

impl Starving {
    /// The policy that starves `victim` and leaves the choice among the others to `others`.
    #[must_use]
    pub fn new(victim: ProcessId, others: Box<dyn Scheduler>) -> Self {
        Self { victim, others, rest: (Vec::new(), Vec::new()) }
    }

    /// Lets `choose` pick among the transitions in which the victim does not move, or among all if there are no others.
    fn choose_by(
        &mut self,
        enabled: &[Enabled],
        is_victim: impl Fn(ProcessId) -> bool,
        choose: impl FnOnce(&mut dyn Scheduler, &[Enabled]) -> usize,
    ) -> usize {
        let (rest, places) = &mut self.rest;
        rest.clear();
        places.clear();
        for (place, transition) in enabled.iter().enumerate().filter(|(_, other)| !other.movers().any(&is_victim)) {
            rest.push(transition.clone());
            places.push(place);
        }
        let others = self.others.as_mut();
        if rest.is_empty() { choose(others, enabled) } else { places[choose(others, rest)] }
    }
}

impl Scheduler for Starving {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        let victim = self.victim;
        self.choose_by(enabled, |process| process == victim, |others, among| others.choose(among))
    }

    fn choose_in(&mut self, system: &ChannelSystem, enabled: &[Enabled]) -> usize {
        let (victim, topology) = (self.victim, system.topology());
        let is_victim = |process| topology.is_part_of(process, victim);
        self.choose_by(enabled, is_victim, |others, among| others.choose_in(system, among))
    }
}
