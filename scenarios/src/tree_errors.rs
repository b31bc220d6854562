//! What goes wrong in a running tree: scripts that cannot be evaluated, ports without a value, conditions that were skipped.

use std::time::Duration;

use bt::{Fault, NodeId};

/// Something that went wrong in a node, and when it did for the first time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeError {
    /// The node.
    pub node: NodeId,
    /// What, in words.
    pub message: String,
    /// The tick.
    pub tick: u64,
    /// Since the start of the run.
    pub time: Duration,
}

/// All that has gone wrong in a tree, each thing once: a script that fails does so at every tick.
#[derive(Clone, Debug, Default)]
pub(crate) struct TreeErrors(Vec<TreeError>);

impl TreeErrors {
    /// Notes what is new in `faults`, which were found in that tick.
    pub(crate) fn note(&mut self, faults: Vec<Fault>, tick: u64, time: Duration) {
        for Fault { node, message } in faults {
            if !self.0.iter().any(|error| error.node == node && error.message == message) {
                self.0.push(TreeError { node, message, tick, time });
            }
        }
    }

    pub(crate) fn all(&self) -> &[TreeError] {
        &self.0
    }
}
