//! Gives each process its turn.

use crate::{Enabled, ProcessId, Scheduler};

/// Cycles through the processes in the order of their declaration. After the process that moved last, the next one that
/// can move takes its first enabled transition.
#[derive(Clone, Debug, Default)]
pub struct RoundRobin {
    last: Option<ProcessId>,
}

impl Scheduler for RoundRobin {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        let turn = |enabled: &Enabled| (Some(enabled.process) <= self.last, enabled.process);
        let choice = (0..enabled.len()).min_by_key(|&index| turn(&enabled[index])).unwrap_or(0);
        self.last = Some(enabled[choice].process);
        choice
    }
}
