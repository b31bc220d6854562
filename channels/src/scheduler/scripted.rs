//! A schedule written in advance, for tests.

use std::collections::VecDeque;

use crate::{Enabled, ProcessId, Scheduler};

/// Follows a list of processes: the one at the head takes its first enabled transition and is removed from the list. If
/// it cannot move, or the list is empty, the system's first enabled transition is taken.
#[derive(Clone, Debug, Default)]
pub struct Scripted {
    script: VecDeque<ProcessId>,
}

impl Scripted {
    /// The policy that follows this list.
    pub fn new(script: impl IntoIterator<Item = ProcessId>) -> Self {
        Self { script: script.into_iter().collect() }
    }
}

impl Scheduler for Scripted {
    fn choose(&mut self, enabled: &[Enabled]) -> usize {
        let head = self.script.front();
        let choice = head.and_then(|head| enabled.iter().position(|transition| transition.process == *head));
        if choice.is_some() {
            self.script.pop_front();
        }
        choice.unwrap_or(0)
    }
}
