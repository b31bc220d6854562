//! Every process in its turn.

use crate::{Enabled, ProcessId, Scheduler};

/// Goes round the processes in the order they were declared; the first that can move after the one that moved last
/// takes its first enabled transition.
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
