//! The calls of a tree to its leaves, and their answers.

use crate::{NodeId, Status};

/// A request to a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Request {
    /// Continue, and report the status.
    Tick,
    /// Stop. Only actions that last answered running get this request.
    Halt,
}

impl Request {
    /// The reply to assume if none arrives: the leaf has failed, or it has halted.
    pub(crate) fn unanswered(self) -> Reply {
        match self {
            Self::Tick => Reply::Status(Status::Failure),
            Self::Halt => Reply::Halted,
        }
    }
}

/// A call of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Call {
    /// The leaf.
    pub leaf: NodeId,
    /// The request.
    pub request: Request,
}

/// The answer of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reply {
    /// To a tick: its status.
    Status(Status),
    /// To a halt: it has stopped.
    Halted,
}

/// The progress of an execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Progress {
    /// It waits for the answer to this call.
    Call(Call),
    /// The tick is finished, with this status of the tree.
    Done(Status),
    /// The tree has been halted.
    Halted,
}

/// An error in a node while it was ticked: a script that could not be evaluated, a port without a value. Where
/// BehaviorTree.CPP throws an exception, the node fails here, its children are reset, and the fault is recorded.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Fault {
    /// The node.
    pub node: NodeId,
    /// A description of the error.
    pub message: String,
}
