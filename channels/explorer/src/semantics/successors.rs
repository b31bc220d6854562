//! What leads out of a state.

use crate::model::Damage;
use crate::store::Assignment;

/// A step from one state to another. Indices are those of the steps that a process offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    Own {
        process: u32,
        own: u32,
        damage: Damage,
    },
    Receive {
        process: u32,
        receive: u32,
        damage: Damage,
    },
    Handshake {
        process: u32,
        own: u32,
        receiver: u32,
        receive: u32,
    },
    /// The environment moves while time stands still.
    Drive {
        index: u32,
    },
    /// The environment moves, time passes, timers that are due fire, and the tick arrives if it is due.
    Wait {
        index: u32,
        delivered: bool,
    },
}

/// How the search continues with a successor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    GoOn,
    /// The verdict is true, whatever follows.
    Settled,
    /// The verdict is false.
    Violated,
    /// Messages pile up in a process. It has no next state, so what follows is not known.
    Endless,
}

impl Fate {
    /// The fate of a step that has both. The first verdict counts, even if messages pile up in the same step: the
    /// system can take this step, and what the monitor sees of it does not depend on what follows.
    pub(super) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::GoOn, other) | (Self::Endless, other @ (Self::Settled | Self::Violated)) => other,
            (first, _) => first,
        }
    }
}

#[derive(Debug, Default)]
pub(crate) struct Successors {
    pub(super) changes: Vec<Assignment>,
    transitions: Vec<Transition>,
    /// Nothing can happen before time passes.
    pub(crate) is_quiet: bool,
    /// Working memory: the state after a move of the environment, and the key of its moves.
    pub(super) moved: Vec<u32>,
    pub(super) key: Vec<u32>,
}

impl Successors {
    pub(super) fn clear(&mut self) {
        self.changes.clear();
        self.transitions.clear();
        self.is_quiet = false;
    }

    pub(crate) fn len(&self) -> usize {
        self.transitions.len()
    }

    pub(crate) fn changes(&self, index: usize) -> &[Assignment] {
        let begin = index.checked_sub(1).map_or(0, |before| self.transitions[before].end);
        &self.changes[begin..self.transitions[index].end]
    }

    pub(super) fn labels(&self) -> impl Iterator<Item = &Label> {
        self.transitions.iter().map(|transition| &transition.label)
    }

    pub(crate) fn label(&self, index: usize) -> &Label {
        &self.transitions[index].label
    }

    pub(crate) fn fate(&self, index: usize) -> Fate {
        self.transitions[index].fate
    }

    /// Forgets all successors but the first ones, and all changes but the first ones.
    pub(super) fn truncate(&mut self, len: usize, changes: usize) {
        self.transitions.truncate(len);
        self.changes.truncate(changes);
    }

    pub(super) fn finish(&mut self, label: Label, fate: Fate) {
        self.transitions.push(Transition { label, fate, end: self.changes.len() });
    }
}

#[derive(Debug)]
struct Transition {
    label: Label,
    fate: Fate,
    /// Where the changes end that it makes.
    end: usize,
}

/// A vector with changes that are being made.
pub(super) struct Draft<'a> {
    pub(super) from: &'a [u32],
    pub(super) changes: &'a mut Vec<Assignment>,
    pub(super) begin: usize,
}

impl Draft<'_> {
    /// The slots that have changed so far.
    pub(super) fn changed(&self) -> impl Iterator<Item = u32> {
        self.changes[self.begin..].iter().map(|(slot, _)| *slot)
    }

    pub(super) fn get(&self, slot: u32) -> u32 {
        let changed = self.changes[self.begin..].iter().find(|(changed, _)| *changed == slot);
        changed.map_or(self.from[slot as usize], |(_, value)| *value)
    }

    pub(super) fn set(&mut self, slot: u32, value: u32) {
        match self.changes[self.begin..].iter_mut().find(|(changed, _)| *changed == slot) {
            Some((_, old)) => *old = value,
            None => self.changes.push((slot, value)),
        }
    }
}
