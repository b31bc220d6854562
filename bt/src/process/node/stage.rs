//! What the process of a node is about to do, or waits for.

use crate::Request;
use crate::process::board::Question;
use crate::process::protocol::Said;
use crate::semantics::Then;

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
    Answering(Said),
}

/// What comes after a child has answered.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum After {
    /// The child was ticked: its answer is what comes.
    Tick,
    /// These children are to be reset as well, and then that is done.
    Reset(Vec<usize>, Goal),
}

/// What comes after children have been reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Goal {
    /// Because of that child.
    Do(usize, Then),
    /// This node is halted; it is skipped then, or says that it has halted.
    Halt { skips: bool },
    /// The last child is ticked, and then this node is halted.
    Catch,
}

/// Why the blackboard is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Purpose {
    Tick,
    /// A child has failed that was idle or not, and the number of attempts is read again.
    Retry {
        child: usize,
        was_idle: bool,
    },
    /// To see whether the last child is ticked before this node is halted.
    Halt,
    /// This node has been halted.
    Halted {
        skips: bool,
    },
}
