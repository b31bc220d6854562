//! What goes wrong in a running tree: scripts that cannot be evaluated, ports without a value, conditions that were skipped.

use bt::Fault;

/// All that has gone wrong in a tree, each thing once: a script that fails does so at every tick.
#[derive(Clone, Debug, Default)]
pub(crate) struct TreeErrors(Vec<Fault>);

impl TreeErrors {
    /// Notes faults that were found: those that are new.
    pub(crate) fn note(&mut self, faults: Vec<Fault>) -> Vec<Fault> {
        let mut new = Vec::new();
        for fault in faults {
            if !self.0.iter().any(|known| known.node == fault.node && known.message == fault.message) {
                self.0.push(fault.clone());
                new.push(fault);
            }
        }
        new
    }
}
