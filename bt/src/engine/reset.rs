//! The nodes being reset, and the continuation.

use crate::program::Program;
use crate::semantics::Then;

/// The reset of a range of nodes in document order: a node, or some adjacent children of a node, with everything below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Halting {
    pub(super) cursor: u32,
    /// The beginning of the range.
    pub(super) start: u32,
    pub(super) end: u32,
    /// A node that is left alone with everything below it; zero means none.
    pub(super) spared: u32,
    /// Whether the first node is halted even if it is not running.
    pub(super) forced: bool,
    pub(super) after: After,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum After {
    /// This node continues, because of this child.
    Do(u32, u32, Then),
    /// This node has been halted and is skipped.
    Skip(u32),
    /// This node is being halted and ticks its catch block.
    Catch(u32),
    /// The catch block of this node is finished, and the node is halted.
    Caught(u32),
    /// The next node of the whole tree is halted.
    HaltFrom(u32),
    /// The whole tree has been halted.
    Halted,
}

impl After {
    /// The node that is in the middle of its tick.
    pub(super) fn node(self) -> Option<u32> {
        match self {
            Self::Do(node, ..) | Self::Skip(node) => Some(node),
            Self::Catch(_) | Self::Caught(_) | Self::HaltFrom(_) | Self::Halted => None,
        }
    }
}

impl Halting {
    /// Resets nothing.
    pub(super) const NONE: Self = Self { cursor: 0, start: 0, end: 0, spared: 0, forced: false, after: After::Halted };

    pub(super) fn of_node(program: &Program, node: u32, after: After) -> Self {
        let end = program.ops[node as usize].end;
        Self { cursor: node, start: node, end, spared: 0, forced: false, after }
    }

    /// Resets adjacent children of a node, except one.
    pub(super) fn of_children(start: u32, end: u32, spared: u32, after: After) -> Self {
        Self { cursor: start, start, end, spared, forced: false, after }
    }

    #[inline]
    pub(super) fn below(program: &Program, node: u32, after: After) -> Self {
        let end = program.ops[node as usize].end;
        Self { cursor: node + 1, start: node + 1, end, spared: 0, forced: false, after }
    }

    pub(super) fn forced(program: &Program, node: u32, after: After) -> Self {
        Self { forced: true, ..Self::of_node(program, node, after) }
    }
}
