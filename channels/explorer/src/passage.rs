//! The reduction: states with a single successor are passed through.

use crate::semantics::{Fate, Label, Semantics, Successors};
use crate::store::Change;
use crate::tables::Gap;

/// A walk from a state to the next one in which there is a choice, or in which time passes.
#[derive(Debug, Default)]
pub(crate) struct Passage {
    /// How the end differs from the beginning.
    pub(crate) changes: Vec<Change>,
    slots: Vec<u32>,
    /// A state on the way, to find that the walk has come back to it (Brent: *An improved Monte Carlo factorization
    /// algorithm*, 1980).
    landmark: Vec<u32>,
    successors: Successors,
}

impl Passage {
    /// Walks on from the state that differs from `from` in these slots. `visit` sees every state on the way, with the
    /// label that leads on. The result is what becomes of the end.
    ///
    /// No transition is left out: in each state on the way there is only one.
    pub(crate) fn follow(
        &mut self,
        semantics: &Semantics,
        from: &[u32],
        changes: &[Change],
        mut visit: impl FnMut(&[u32], &Label),
    ) -> Result<Fate, Gap> {
        let Self { slots, landmark, successors, .. } = self;
        slots.clear();
        slots.extend_from_slice(from);
        apply(slots, changes);
        landmark.clear();
        let mut fate = Fate::GoOn;
        let (mut steps, mut next_landmark) = (0_u64, 1);
        while fate == Fate::GoOn {
            semantics.expand(slots, successors)?;
            if successors.is_quiet || successors.len() != 1 {
                break;
            }
            visit(slots, successors.label(0));
            fate = successors.fate(0);
            apply(slots, successors.changes(0));
            if slots == landmark {
                fate = Fate::Circular;
            }
            steps += 1;
            if steps == next_landmark {
                next_landmark *= 2;
                landmark.clone_from(slots);
            }
        }
        self.changes.clear();
        let changed = (0..).zip(from.iter().zip(&self.slots)).filter(|(_, (before, after))| before != after);
        self.changes.extend(changed.map(|(slot, (_, after))| (slot, *after)));
        Ok(fate)
    }
}

fn apply(slots: &mut [u32], changes: &[Change]) {
    changes.iter().for_each(|(slot, value)| slots[*slot as usize] = *value);
}
