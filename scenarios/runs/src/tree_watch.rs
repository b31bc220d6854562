//! What a running tree leaves behind: its errors, such as scripts that cannot be evaluated or ports without a value,
//! and the outcomes at the end of each tick.

use std::sync::Arc;

use bt::{Fault, Outcome, Tree};
use channels::{ChannelSystem, ProcessId};
use recording::Happening;

/// Looks at the tree of a run. A new tick begins without the errors and outcomes of the last one, so it is looked at
/// before each tick and at the end of each step: a tick may end in the very step in which the next one begins, when a
/// leaf's time is up.
#[derive(Clone, Debug, Default)]
pub(crate) struct TreeWatch {
    tree: Option<(Arc<Tree>, ProcessId)>,
    /// All errors, each once, since a failing script fails at every tick.
    known: Vec<Fault>,
    /// Those that are new in this step.
    new: Vec<Happening>,
    /// For each tick of this step, the outcomes before it.
    before_ticks: Vec<Vec<Option<Outcome>>>,
}

impl TreeWatch {
    /// Looks at this tree; at none if there is none.
    pub(crate) fn new(tree: Option<(Arc<Tree>, ProcessId)>) -> Self {
        Self { tree, ..Self::default() }
    }

    pub(crate) fn begin_step(&mut self) {
        self.new.clear();
        self.before_ticks.clear();
    }

    pub(crate) fn tick_begins(&mut self, system: &ChannelSystem) {
        self.look(system);
        let outcomes = self.tree.as_ref().map(|(tree, process)| {
            bt::states_in(tree, system, *process).into_iter().map(|state| state.outcome).collect()
        });
        self.before_ticks.extend(outcomes);
    }

    /// Notes new errors.
    pub(crate) fn look(&mut self, system: &ChannelSystem) {
        let Some((_, process)) = &self.tree else { return };
        let tick = system.ticks().saturating_sub(1);
        for fault in bt::faults_in(system, *process) {
            if !self.known.iter().any(|known| known.node == fault.node && known.message == fault.message) {
                self.known.push(fault.clone());
                self.new.push(Happening::TreeError { node: fault.node.index(), message: fault.message, tick });
            }
        }
    }

    pub(crate) fn take_new(&mut self) -> impl Iterator<Item = Happening> {
        self.new.drain(..)
    }

    pub(crate) fn take_before_ticks(&mut self) -> Vec<Vec<Option<Outcome>>> {
        std::mem::take(&mut self.before_ticks)
    }
}
