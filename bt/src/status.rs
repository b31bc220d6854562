//! The answers and states of nodes.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The answer of a node to a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Status {
    /// It needs more ticks.
    Running,
    /// It achieved its purpose.
    Success,
    /// It could not achieve its purpose.
    Failure,
    /// It should not have been asked: its parent continues as if it did not exist.
    Skipped,
}

impl Status {
    /// The status in lower case, as in the messages between tree and skills.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Success => "success",
            Self::Failure => "failure",
            Self::Skipped => "skipped",
        }
    }

    /// Whether it is final: success or failure.
    #[must_use]
    pub fn is_completed(self) -> bool {
        matches!(self, Self::Success | Self::Failure)
    }

    /// Success for failure and failure for success.
    pub(crate) fn inverted(self) -> Self {
        match self {
            Self::Success => Self::Failure,
            Self::Failure => Self::Success,
            status => status,
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The last status of a node in a tick of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Outcome {
    /// It was ticked and gave this answer.
    Answered(Status),
    /// It was running and was asked to stop.
    Halted,
}

impl Outcome {
    /// The outcome in lower case: `running`, `success`, `failure`, `skipped` or `halted`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Answered(status) => status.name(),
            Self::Halted => "halted",
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What happened to a node in a tick of the tree, a bit for each [`Outcome`]. All zeros are nothing, so that a new tick
/// can clear the outcomes of all nodes as one block of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Outcomes {
    last: u8,
    /// The tree may tick a node more than once.
    all: u8,
}

impl Outcomes {
    #[inline]
    pub(crate) fn note(&mut self, outcome: Outcome) {
        self.last = Self::bit(outcome);
        self.all |= self.last;
    }

    pub(crate) fn last(self) -> Option<Outcome> {
        Self::of(self.last).next()
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = Outcome> {
        Self::of(self.all)
    }

    fn of(bits: u8) -> impl Iterator<Item = Outcome> {
        let answers = [Status::Running, Status::Success, Status::Failure, Status::Skipped].map(Outcome::Answered);
        let all = answers.into_iter().chain([Outcome::Halted]);
        all.filter(move |outcome| bits & Self::bit(*outcome) != 0)
    }

    fn bit(outcome: Outcome) -> u8 {
        match outcome {
            Outcome::Answered(status) => 1 << status as u8,
            Outcome::Halted => 16,
        }
    }
}

/// The state of a node, as pictures and logs show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct NodeState {
    /// Its status in BehaviorTree.CPP's sense; `None` is `IDLE`. A node becomes idle again as soon as its parent is
    /// done with it, often within the tick in which it succeeded or failed.
    pub status: Option<Status>,
    /// What happened to it in the last tick of the tree: its answer, or a halt. `None` if the tick did not reach it. A
    /// node that is being ticked counts as running.
    pub outcome: Option<Outcome>,
}

/// A node's status as the engine keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) enum Mark {
    /// `IDLE`.
    #[default]
    Idle,
    /// `SUCCESS`.
    Success,
    /// `FAILURE`.
    Failure,
    /// Being ticked, idle before; idle again if it is skipped.
    Started,
    /// Being ticked, idle before; counts as running from now on, even if it is skipped.
    Begun,
    /// Being ticked, after a success; keeps that status if it is skipped.
    AfterSuccess,
    /// Being ticked, after a failure; keeps that status if it is skipped.
    AfterFailure,
    /// `RUNNING`.
    Running,
    /// `RUNNING`, although it has only been skipped: BehaviorTree.CPP counts it as running once it has begun.
    Lingering,
}

impl Mark {
    /// The mark of a node with this mark that is ticked now. A leaf that is asked a second time, because its answer to
    /// this tick is still missing, keeps its mark.
    pub(crate) fn entered(self) -> Self {
        match self {
            Self::Idle | Self::Started | Self::Begun => Self::Started,
            Self::Success | Self::AfterSuccess => Self::AfterSuccess,
            Self::Failure | Self::AfterFailure => Self::AfterFailure,
            Self::Running => Self::Running,
            Self::Lingering => Self::Lingering,
        }
    }

    /// The status of a node when its tick began, or now if it is not being ticked; `None` is idle.
    pub(crate) fn before(self) -> Option<Status> {
        if self == Self::Begun { None } else { self.reported() }
    }

    /// The status that BehaviorTree.CPP has reported to its loggers; `None` is idle. A node reports running when it
    /// begins to tick its children, or with its answer.
    pub(crate) fn reported(self) -> Option<Status> {
        match self {
            Self::Started => None,
            Self::AfterSuccess => Some(Status::Success),
            Self::AfterFailure => Some(Status::Failure),
            mark => mark.status(),
        }
    }

    /// The mark of a node that is being ticked and has begun to tick its children. One that `keeps` its answer until it
    /// has another begins to run only if it was idle.
    pub(crate) fn begun(self, keeps: bool) -> Self {
        match self {
            Self::Started => Self::Begun,
            Self::AfterSuccess | Self::AfterFailure if !keeps => Self::Lingering,
            mark => mark,
        }
    }

    pub(crate) fn answered(self, status: Status) -> Self {
        match (status, self) {
            (Status::Running, _) => Self::Running,
            (Status::Success, _) => Self::Success,
            (Status::Failure, _) => Self::Failure,
            (Status::Skipped, Self::Started) => Self::Idle,
            (Status::Skipped, Self::Begun) => Self::Lingering,
            (Status::Skipped, Self::AfterSuccess) => Self::Success,
            (Status::Skipped, Self::AfterFailure) => Self::Failure,
            (Status::Skipped, mark) => mark,
        }
    }

    /// Whether the node was idle when its tick began.
    pub(crate) fn was_idle(self) -> bool {
        matches!(self, Self::Idle | Self::Started | Self::Begun)
    }

    pub(crate) fn is_running(self) -> bool {
        !matches!(self, Self::Idle | Self::Success | Self::Failure)
    }

    pub(crate) fn is_completed(self) -> bool {
        matches!(self, Self::Success | Self::Failure)
    }

    pub(crate) fn status(self) -> Option<Status> {
        match self {
            Self::Idle => None,
            Self::Success => Some(Status::Success),
            Self::Failure => Some(Status::Failure),
            _ => Some(Status::Running),
        }
    }
}
