//! The semantics of all kinds of nodes: what a node does when it is ticked, when a child has answered, and when it is
//! halted.
//!
//! Both the engine and the node processes use these functions. [`Kind`] describes the same in words. The values that a
//! node reads from the blackboard are passed as a [`PortReading`].

mod begin;
mod nav2;
mod react;

use std::time::Duration;

pub(crate) use begin::{begin, begin_plain, needs_reading};
pub(crate) use nav2::needs_reading_after;
pub(crate) use react::{react, react_plain};

use channels::NormalForm;

use crate::{Category, Kind, Status};

/// State that a node keeps between ticks, besides the child with which it continues. The meaning of the fields depends
/// on the kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Memory {
    /// The number of children. It never changes.
    pub(crate) children: u32,
    /// Children that were skipped in this round.
    skipped: u32,
    /// Children that have succeeded or are done, or the number of successes or failures of the only child.
    count: u32,
    /// Children that have failed.
    failures: u32,
    /// The child that is being ticked or, for Switch and similar nodes, one more than the child that ran; 0 is the
    /// condition, or none.
    at: u32,
    /// Whether it has begun to wait, is in its catch block, has run once, or continues with a running child.
    pub(crate) flag: bool,
    /// Whether it ticks its last child because it is being halted.
    pub(crate) catches: bool,
    /// The final answer of its child.
    kept: Option<Status>,
    /// Its parameters, as last read.
    pub(crate) limits: [i64; 2],
    /// The time at which its wait ends.
    until: Option<Duration>,
}

/// The tick of a node, as the node sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beginning {
    /// Its status before; `None` is idle.
    pub(crate) was: Option<Status>,
    pub(crate) reading: PortReading,
    pub(crate) now: Duration,
    /// Whether its first child is running.
    pub(crate) child_runs: bool,
}

/// A child's answer, as its parent sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    /// `None` if the child was done before and has not been ticked.
    pub(crate) status: Option<Status>,
    /// Whether the child was idle when it was ticked.
    pub(crate) was_idle: bool,
    /// Whether it is the last child.
    pub(crate) is_last: bool,
    /// The values that the parent has read since then, if it [needs to](needs_reading_after).
    pub(crate) reading: PortReading,
    /// The time of the answer.
    pub(crate) now: Duration,
}

/// The values that a node has read from its ports and the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum PortReading {
    /// There is nothing to read.
    Nothing,
    /// Its parameters, or whether the entries that it watches have been written, 1 or 0.
    Numbers([i64; 2]),
    /// The child may be ticked.
    Proceed,
    /// The answer of the node.
    Status(Status),
}

/// The next action of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reaction {
    /// It ticks the next child.
    Next,
    /// It resets some children, and then acts.
    Do {
        reset: Reset,
        /// The child with which its next tick begins.
        resume: Resume,
        then: Then,
    },
}

/// The action of a node after resetting children.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Then {
    Tick(Which),
    Answer(Status),
    /// It is done: all children are reset, and it starts over and answers.
    Finish(Status),
    /// It is idle again, and is skipped.
    Skip,
    /// It returns running and requests another tick of the whole tree.
    Again,
    /// BehaviorTree.CPP would throw an exception: the node fails for this reason.
    Fault(&'static str),
}

/// The child to tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Which {
    First,
    /// The one with which the node's tick begins.
    Resumed,
    /// The one after the child that answered.
    Next,
    Nth(u32),
    Last,
}

/// The children to reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reset {
    None,
    All,
    /// All except the one that answered.
    Others,
    /// The one that answered and those after it.
    FromHere,
    /// The one that answered.
    Here,
    Nth(u32),
}

/// The beginning of a node's next tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Resume {
    /// Unchanged.
    Same,
    /// At the first child.
    First,
    /// At the child that answered.
    Here,
    /// After the child that answered.
    Next,
}

impl Reaction {
    fn tick(which: Which) -> Self {
        Self::Do { reset: Reset::None, resume: Resume::Same, then: Then::Tick(which) }
    }

    fn answer(status: Status) -> Self {
        Self::Do { reset: Reset::None, resume: Resume::Same, then: Then::Answer(status) }
    }

    /// It is done: all children are reset, and it starts over.
    pub(crate) fn finish(status: Status) -> Self {
        Self::Do { reset: Reset::All, resume: Resume::First, then: Then::Answer(status) }
    }

    pub(crate) fn fault(why: &'static str) -> Self {
        Self::Do { reset: Reset::All, resume: Resume::First, then: Then::Fault(why) }
    }
}

impl Memory {
    pub(crate) fn new(children: u32) -> Self {
        Self { children, ..Self::default() }
    }

    /// State that a node forgets when it is halted.
    pub(crate) fn forget(&mut self, kind: Kind) {
        match kind {
            // A RunOnce has run; a satisfied Precondition stays satisfied until its child is done; a loop checks
            // whether it was idle when it is ticked again.
            Kind::SequenceWithMemory | Kind::RunOnce | Kind::Precondition | Kind::WasEntryUpdated | Kind::Loop(_) => {}
            Kind::SkipUnlessUpdated | Kind::WaitValueUpdate => self.flag = false,
            // Nav2's decorators start over when they are ticked while they are idle.
            kind if kind.is_of_nav2() && kind.category() == Category::Decorator => {}
            _ => {
                let Self { children, limits, .. } = *self;
                *self = Self { children, limits, ..Self::default() };
            }
        }
    }

    /// Brings it into [normal form](NormalForm). `reading` is what a node of this kind always reads, if that is known.
    pub(crate) fn normalize(&mut self, form: &NormalForm<'_>, kind: Kind, reading: Option<PortReading>) {
        if let Some(until) = &mut self.until {
            form.time(until);
            // An expired wait has no age: how long ago it expired does not matter.
            *until = NormalForm::NOW.max(*until);
        }
        let is_endless = matches!(reading, Some(PortReading::Numbers([-1, _])));
        if matches!(kind, Kind::Repeat | Kind::RetryUntilSuccessful) && is_endless {
            self.count = 0;
        }
    }

    /// Whether a running node of this kind ticks its last child when it is halted, if its port is set so.
    pub(crate) fn catches_halts(&self, kind: Kind) -> bool {
        kind == Kind::TryCatch && !self.flag && !self.catches
    }
}

impl Kind {
    /// Whether, as in BehaviorTree.CPP, a node that begins its tick like this is running, even if it is then skipped or
    /// answers without a child.
    pub(crate) fn runs_when_begun(self, reaction: Reaction) -> bool {
        match (self, reaction) {
            (Self::Repeat | Self::RetryUntilSuccessful, _) => true,
            (_, Reaction::Do { then: Then::Tick(_), .. }) => !matches!(
                self,
                Self::Switch(_)
                    | Self::Precondition
                    | Self::SkipUnlessUpdated
                    | Self::WaitValueUpdate
                    | Self::PipelineSequence
                    | Self::NonblockingSequence
                    | Self::GoalUpdater
                    | Self::Condition
                    | Self::Action
            ),
            _ => false,
        }
    }

    /// The answer of a child, other than the last, after which a node of this kind simply ticks the next one.
    #[inline]
    pub(crate) fn goes_on_after(self) -> Option<Status> {
        match self {
            Self::ReactiveSequence | Self::Sequence => Some(Status::Success),
            Self::ReactiveFallback | Self::Fallback => Some(Status::Failure),
            _ => None,
        }
    }

    /// Whether finished children are not ticked again until the node is finished.
    pub(crate) fn passes_over_completed(self) -> bool {
        matches!(self, Self::Parallel | Self::ParallelAll)
    }

    /// Whether nodes of this kind have ports or code, or do not always tick a child.
    pub(crate) fn has_settings(self) -> bool {
        !matches!(
            self,
            Self::Sequence
                | Self::ReactiveSequence
                | Self::SequenceWithMemory
                | Self::AsyncSequence
                | Self::Fallback
                | Self::ReactiveFallback
                | Self::AsyncFallback
                | Self::Inverter
                | Self::ForceSuccess
                | Self::ForceFailure
                | Self::SubTree
        )
    }

    /// Whether a node of this kind that is ticked again has its earlier answer until it gives another.
    pub(crate) fn keeps_answer(self) -> bool {
        matches!(self, Self::SubTree | Self::Loop(_))
    }

    /// Whether a node of this kind starts over after it has been halted.
    pub(crate) fn forgets(self) -> bool {
        self != Self::SequenceWithMemory
    }
}
