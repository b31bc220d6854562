//! What a log says: a node got another status.

use std::path::Path;

use crate::error::LogError;
use crate::tree::Numbers;

/// The status of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NodeStatus {
    /// It has not been ticked since its parent was reset, or it was halted.
    Idle,
    /// This was its last answer.
    Answered(bt::Status),
}

impl NodeStatus {
    /// The status with this number in BehaviorTree.CPP.
    fn of(number: i64) -> Option<Self> {
        let answers = [bt::Status::Running, bt::Status::Success, bt::Status::Failure, bt::Status::Skipped];
        match usize::try_from(number).ok()?.checked_sub(1) {
            None => Some(Self::Idle),
            Some(answer) => answers.get(answer).copied().map(Self::Answered),
        }
    }
}

/// A node got another status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusChange {
    /// When, in microseconds since 1970 by the clock of whoever wrote the log. That clock may have been set back.
    pub at_us: i64,
    /// The node's index in [`Log::nodes`](crate::Log::nodes).
    pub node: usize,
    /// The status.
    pub status: NodeStatus,
}

/// A transition of the node with this number to the status with that one.
pub(crate) fn status_change(
    numbers: &Numbers,
    at_us: i64,
    uid: i64,
    status: i64,
    path: &Path,
) -> Result<StatusChange, LogError> {
    let damaged = |problem| LogError::Damaged { path: path.to_owned(), problem };
    let node = numbers.get(&uid).ok_or_else(|| damaged(format!("its tree has no node with the number {uid}")))?;
    let known =
        NodeStatus::of(status).ok_or_else(|| damaged(format!("there is no status with the number {status}")))?;
    Ok(StatusChange { at_us, node: *node, status: known })
}
