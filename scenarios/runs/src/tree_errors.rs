//! Errors in a running tree: scripts that cannot be evaluated, ports without a value, skipped conditions.

use bt::Fault;

/// All errors in a tree, each once, since a failing script fails at every tick.
#[derive(Clone, Debug, Default)]
pub(crate) struct TreeErrors(Vec<Fault>);

impl TreeErrors {
    /// Records faults, and returns the new ones.
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
