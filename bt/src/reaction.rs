//! What a node does when one of its children has answered: the semantics of all kinds, node by node.
//!
//! Both the engine and the node processes follow this one function. [`Kind`] says the same in words.

use crate::{Kind, Status};

/// A child's answer, as its parent sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    pub(crate) status: Status,
    /// The child was idle when it was ticked.
    pub(crate) was_idle: bool,
    /// It is the last child.
    pub(crate) is_last: bool,
}

/// What the parent does now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reaction {
    /// It ticks the next child.
    Next,
    /// It answers.
    Answer {
        status: Status,
        /// After these children have been reset.
        reset: Reset,
        /// The next tick starts there.
        resume: Resume,
    },
    /// It answers running and wants the whole tree ticked again at once. The next tick starts behind this child.
    Again,
}

/// Which children are reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reset {
    None,
    All,
    /// All but the one that answered.
    Others,
    /// The one that answered and those behind it.
    FromHere,
}

/// Where a node's next tick starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Resume {
    /// At the first child.
    First,
    /// At the child that answered.
    Here,
}

/// What a node of that kind does when a child answers so.
#[inline]
pub(crate) fn react(kind: Kind, answer: Answer) -> Reaction {
    use Status::{Failure, Running, Success};
    let finish = |status| Reaction::Answer { status, reset: Reset::All, resume: Resume::First };
    let keep = Reaction::Answer { status: Running, reset: Reset::None, resume: Resume::Here };
    let keep_alone = Reaction::Answer { status: Running, reset: Reset::Others, resume: Resume::First };
    match (kind, answer.status) {
        (Kind::ReactiveSequence | Kind::ReactiveFallback, Running) => keep_alone,
        (_, Running) => keep,

        (Kind::SequenceWithMemory, Success) if !answer.is_last && answer.was_idle => Reaction::Again,
        (Kind::SequenceWithMemory, Failure) => {
            Reaction::Answer { status: Failure, reset: Reset::FromHere, resume: Resume::Here }
        }
        (Kind::Sequence | Kind::ReactiveSequence | Kind::SequenceWithMemory, Success) if !answer.is_last => {
            Reaction::Next
        }
        (Kind::Fallback | Kind::ReactiveFallback, Failure) if !answer.is_last => Reaction::Next,

        (Kind::Inverter, status) => finish(status.inverted()),
        (Kind::ForceSuccess, _) => finish(Success),
        (Kind::ForceFailure, _) => finish(Failure),
        (_, status) => finish(status),
    }
}
