//! The next action of a node's process, or what it waits for.

use crate::process::board::Question;
use crate::process::protocol::NodeReply;
use crate::semantics::Then;
use crate::{Request, Status};

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Stage {
    Idle,
    /// About to ask this child.
    Asking(usize, Request, After),
    /// Waiting for it.
    Waiting(usize, Request, After),
    /// About to ask the blackboard.
    Consulting(Question, Purpose),
    /// Waiting for it.
    Consulted(Question, Purpose),
    /// About to answer.
    Answering(NodeReply),
}

/// The continuation after a child has answered.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum After {
    /// The child was ticked; handle its answer.
    Tick,
    /// Reset these children as well, then continue with the goal.
    Reset(Vec<usize>, Goal),
}

/// The continuation after children have been reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Goal {
    /// Continue because of this child.
    Do(usize, Then),
    /// This node is halted; then it is skipped, or confirms the halt.
    Halt { skips: bool },
    /// The last child is ticked, and then this node is halted.
    Catch,
}

/// Why the blackboard is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Purpose {
    Tick,
    /// A child has given this answer.
    Answer {
        child: usize,
        status: Status,
        was_idle: bool,
    },
    /// Decides whether the last child is ticked before this node is halted.
    Halt,
    /// This node has been halted.
    Halted {
        skips: bool,
    },
}
