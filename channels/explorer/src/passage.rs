//! The reduction: states with a single successor are passed through.

use crate::semantics::{Fate, Label, Semantics, Successors};
use crate::store::Assignment;
use crate::tables::Gap;

/// How many states are passed through before one is stored again. This bounds how much is repeated when a walk meets
/// something not computed yet, and ensures that every cycle contains a stored state. Any number is correct; this one is
/// chosen, not measured.
const LONGEST: usize = 64;

/// A walk from a state to the next one that has a choice or in which time passes.
#[derive(Debug, Default)]
pub(crate) struct Passage {
    /// How the end differs from the beginning.
    pub(crate) changes: Vec<Assignment>,
    slots: Vec<u32>,
    successors: Successors,
    /// How many states it has passed through since this was last set to 0.
    pub(crate) passed: u32,
}

impl Passage {
    /// Walks on from the state that differs from `from` in these slots. `visit` sees every state on the way, with the
    /// label of the transition that leaves it. Returns the fate of the last state.
    ///
    /// No transition is left out, since each state on the way has only one.
    pub(crate) fn follow(
        &mut self,
        semantics: &Semantics,
        from: &[u32],
        changes: &[Assignment],
        mut visit: impl FnMut(&[u32], &Label),
    ) -> Result<Fate, Gap> {
        let Self { slots, successors, passed, .. } = self;
        slots.clear();
        slots.extend_from_slice(from);
        apply(slots, changes);
        let mut fate = Fate::GoOn;
        for _ in 0..LONGEST {
            if fate != Fate::GoOn {
                break;
            }
            semantics.expand(slots, successors)?;
            if successors.is_quiet || successors.len() != 1 {
                break;
            }
            visit(slots, successors.label(0));
            *passed += 1;
            fate = successors.fate(0);
            apply(slots, successors.changes(0));
        }
        // Compared at the end: on the way, a slot may change several times, and back.
        self.changes.clear();
        let changed = (0..).zip(from.iter().zip(&self.slots)).filter(|(_, (before, after))| before != after);
        self.changes.extend(changed.map(|(slot, (_, after))| (slot, *after)));
        Ok(fate)
    }
}

fn apply(slots: &mut [u32], changes: &[Assignment]) {
    changes.iter().for_each(|(slot, value)| slots[*slot as usize] = *value);
}
