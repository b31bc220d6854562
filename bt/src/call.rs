//! What a tree asks of its leaves, and what they answer.

use crate::{NodeId, Status};

/// What a tree asks of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Request {
    /// To go on, and to say how it stands.
    Tick,
    /// To stop. Only actions that last answered running are asked to.
    Halt,
}

impl Request {
    /// What is taken for the answer if none comes: the leaf has failed, or it has halted.
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
    /// What it is asked.
    pub request: Request,
}

/// What a leaf answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reply {
    /// To a tick: how it stands.
    Status(Status),
    /// To a halt: it has stopped.
    Halted,
}

/// How far an execution has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// It waits for the answer to this call.
    Call(Call),
    /// The tick is over; this is the tree's status.
    Done(Status),
    /// The tree has been halted.
    Halted,
}

/// Something that went wrong in a node while it was ticked: a script that could not be evaluated, a port without a value.
/// Where BehaviorTree.CPP throws an exception, the node fails here, its children are reset, and the fault is kept.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Fault {
    /// The node.
    pub node: NodeId,
    /// What went wrong, in words.
    pub message: String,
}
