//! An adversary that starves one process.

use super::Rest;
use crate::{ChannelSystem, Enabled, ProcessId, Scheduler};

/// Starves one process with all its members: it moves only when no other process can, even as the receiver in a
/// handshake. Another policy chooses among the other processes.
#[derive(Debug)]
pub struct Starving {
    victim: ProcessId,
    others: Box<dyn Scheduler>,
    rest: Rest,
}

impl Starving {
    /// The policy that starves `victim` and leaves the choice among the others to `others`.
    #[must_use]
    pub fn new(victim: ProcessId, others: Box<dyn Scheduler>) -> Self {
        Self { victim, others, rest: Rest::default() }
    }
}

impl Scheduler for Starving {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        let Self { victim, others, rest } = self;
        let waits = |transition: &Enabled| transition.movers().any(|process| process == *victim);
        rest.choose(enabled, waits, |among| others.choose(among))
    }

    fn choose_in(&mut self, system: &ChannelSystem, enabled: &[Enabled]) -> usize {
        let Self { victim, others, rest } = self;
        let is_victim = |process| system.topology().is_part_of(process, *victim);
        let waits = |transition: &Enabled| transition.movers().any(is_victim);
        rest.choose(enabled, waits, |among| others.choose_in(system, among))
    }
}
