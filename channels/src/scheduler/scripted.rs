//! A schedule written down in advance, for tests.

use std::collections::VecDeque;

use crate::{Enabled, ProcessId, Scheduler};

/// Follows a list of processes: the one at the head moves, with its first enabled transition, and is struck off. While
/// it cannot move, and when the list has come to its end, the first enabled transition is taken.
#[derive(Clone, Debug, Default)]
pub struct Scripted {
    script: VecDeque<ProcessId>,
}

impl Scripted {
    /// The policy that follows that list.
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
