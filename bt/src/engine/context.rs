//! The context of a run of the engine: the tree, the time, the leaves.

use std::time::Duration;

use super::Next;
use super::reset::Halting;
use crate::program::{Op, Program};
use crate::{Leaf, Leaves, Status, Tree};

/// The leaves as the engine sees them: an answer may take time.
pub(crate) trait Answers {
    fn tick(&mut self, leaf: Leaf<'_>) -> Option<Status>;
    fn halt(&mut self, leaf: Leaf<'_>) -> Option<()>;
}

/// Leaves that answer at once.
pub(crate) struct Now<'a, L>(pub(crate) &'a mut L);

impl<L: Leaves> Answers for Now<'_, L> {
    #[inline]
    fn tick(&mut self, leaf: Leaf<'_>) -> Option<Status> {
        Some(self.0.tick(leaf))
    }

    #[inline]
    fn halt(&mut self, leaf: Leaf<'_>) -> Option<()> {
        self.0.halt(leaf);
        Some(())
    }
}

/// Leaves whose every call suspends the execution.
pub(crate) struct Later;

impl Answers for Later {
    fn tick(&mut self, _: Leaf<'_>) -> Option<Status> {
        None
    }

    fn halt(&mut self, _: Leaf<'_>) -> Option<()> {
        None
    }
}

pub(crate) struct Context<'a, A> {
    pub(super) tree: &'a Tree,
    pub(super) now: Duration,
    pub(super) leaves: A,
    /// The halt in progress, if there is one.
    pub(super) halting: Halting,
}

impl<'a, A> Context<'a, A> {
    pub(crate) fn new(tree: &'a Tree, now: Duration, leaves: A) -> Self {
        Self { tree, now, leaves, halting: Halting::NONE }
    }

    #[inline]
    pub(super) fn program(&self) -> &'a Program {
        &self.tree.program
    }

    #[inline]
    pub(super) fn reset(&mut self, halting: Halting) -> Next {
        self.halting = halting;
        Next::Reset
    }

    pub(super) fn op(&self, node: u32) -> Op {
        self.tree.program.ops[node as usize]
    }
}
