//! The contents of a log: a node got another status.

use channels::Flaw;

/// The status of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NodeStatus {
    /// It has not been ticked since its parent was reset, or it was halted.
    Idle,
    /// This was its last answer.
    Answered(bt::Status),
}

impl NodeStatus {
    /// Its number in BehaviorTree.CPP.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::Idle => 0,
            Self::Answered(bt::Status::Running) => 1,
            Self::Answered(bt::Status::Success) => 2,
            Self::Answered(bt::Status::Failure) => 3,
            Self::Answered(bt::Status::Skipped) => 4,
        }
    }

    /// Its name: `idle`, or that of its last answer.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Answered(answer) => bt::Outcome::Answered(answer).name(),
        }
    }

    /// The status with this number in BehaviorTree.CPP; none if there is none.
    #[must_use]
    pub fn of(number: i64) -> Option<Self> {
        let answers = [bt::Status::Running, bt::Status::Success, bt::Status::Failure, bt::Status::Skipped];
        match usize::try_from(number).ok()?.checked_sub(1) {
            None => Some(Self::Idle),
            Some(answer) => answers.get(answer).copied().map(Self::Answered),
        }
    }
}

/// The next item of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LogEntry {
    /// A node got another status.
    Changed(StatusChange),
    /// From here on, the log is not what happened.
    Lost(LogGap),
}

/// What may be wrong with a log, from some entry on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogGap {
    /// Since when, in microseconds as in [`StatusChange::at_us`]; none if since the beginning.
    pub since_us: Option<i64>,
    /// What.
    pub flaw: Flaw,
    /// Why, in words.
    pub why: String,
}

/// A node got another status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusChange {
    /// When, in microseconds since 1970 by the clock of the log's writer. That clock may have been set back.
    pub at_us: i64,
    /// The node's index in [`LoggedTree::nodes`](crate::LoggedTree::nodes).
    pub node: usize,
    /// The status before, if the log has it.
    pub before: Option<NodeStatus>,
    /// The status.
    pub status: NodeStatus,
}

impl StatusChange {
    /// Whether the tree is ticked anew, after its root had been reset.
    pub(crate) fn begins_run(&self) -> bool {
        self.node == 0 && self.before == Some(NodeStatus::Idle) && self.status != NodeStatus::Idle
    }
}

/// A transition as it is written, which may not fit its tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoggedTransition {
    /// By the clock of the program that wrote it, in microseconds since 1970.
    pub at_us: i64,
    /// The number of the node.
    pub uid: i64,
    /// The number of its new status: 0 for idle, then running, success, failure and skipped.
    pub status: i64,
}

impl LoggedTransition {
    /// How many bytes one has in a file `.btlog` and in the reply of a running program.
    pub const BYTES: usize = 9;

    /// Reads one: the time in microseconds since `began_us` has six bytes, the node's number two, and its status one,
    /// each little-endian.
    #[must_use]
    pub fn from_bytes(bytes: [u8; Self::BYTES], began_us: i64) -> Self {
        let [time @ .., uid_low, uid_high, status] = bytes;
        let time = time.iter().rev().fold(0, |time, byte| time << 8 | i64::from(*byte));
        // If the clock is set back to before the beginning, the time is negative, and there are only its lower bits.
        let unused = i64::BITS - 8 * 6;
        let at_us = began_us.saturating_add(time << unused >> unused);
        Self { at_us, uid: u16::from_le_bytes([uid_low, uid_high]).into(), status: status.into() }
    }

    /// The bytes of it; none if it does not fit in them.
    #[must_use]
    pub fn to_bytes(self, began_us: i64) -> Option<[u8; Self::BYTES]> {
        let since_us = self.at_us.checked_sub(began_us)?;
        let [a, b, c, d, e, f, ..] = since_us.to_le_bytes();
        let [low, high] = u16::try_from(self.uid).ok()?.to_le_bytes();
        let bytes = [a, b, c, d, e, f, low, high, u8::try_from(self.status).ok()?];
        (Self::from_bytes(bytes, began_us) == self).then_some(bytes)
    }
}
