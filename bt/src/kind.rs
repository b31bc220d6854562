//! The kinds of nodes and what each of them means.

use std::fmt;

/// A kind of node.
///
/// The meaning is BehaviorTree.CPP's, version 4.10 (the version 3 differs where its reactive nodes leave a later child
/// running; we follow 4 for both formats). Words used below:
///
/// - A node is *reset* when its status goes back to idle. If it is running, it is *halted* first: its running children
///   are halted in their order, each before the next is looked at, and so on down to the actions, which are told.
/// - A node that is not running is never halted, and neither is anything below it.
/// - When a node has succeeded or failed, all its children have been reset, but for [`SequenceWithMemory`]'s.
/// - A child that is *skipped* is passed over. A node all of whose children are skipped is skipped, if nothing else is
///   said.
/// - A node that has *the tree ticked again* answers running, and when that tick is over and the root is running, the
///   tree is ticked once more as part of it (BehaviorTree.CPP's wake-up signal, with `tickOnce`). That lets reactive
///   nodes above look at their conditions again. After 10 000 times in one tick it is refused, and the tick ends.
/// - *Milliseconds* are those of the run's time. A tree moves only when it is ticked, so that a time that has come is
///   noticed at the next tick. (BehaviorTree.CPP has a thread with a clock, which halts the child of a [`Timeout`] at
///   once, and wakes a tree that sleeps between ticks. Ticked at a fixed rate, both answer the same at every tick.)
///
/// [`SequenceWithMemory`]: Kind::SequenceWithMemory
/// [`Timeout`]: Kind::Timeout
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Ticks its children in order until one fails or runs; succeeds when all have succeeded. While a child is running,
    /// the next tick goes on with that child. When a child fails, all are reset, and the next tick starts over.
    Sequence,
    /// Ticks its children in order *from the first at every tick* until one fails or runs; succeeds when all have
    /// succeeded. When a child runs, all the others are reset: one that ran before is halted, wherever it stands. A
    /// child that is skipped is reset at once.
    ///
    /// The paper's sequence is this one. BehaviorTree.CPP can be told to throw an error when a second child runs; 4.10
    /// does not by default, and neither do we. As there, only one child may be an
    /// [`AsyncSequence`](Kind::AsyncSequence): two would halt each other for ever.
    ReactiveSequence,
    /// Like [`Sequence`](Kind::Sequence), but children that have succeeded are not ticked again, even after a later
    /// child has failed or the node has been halted: only its own success starts it over. After a failure, that child
    /// and those behind it are reset.
    ///
    /// When a child that was idle succeeds and is not the last, the node has the tree ticked again.
    SequenceWithMemory,
    /// Like [`Sequence`](Kind::Sequence), but has the tree ticked again when a child that was idle succeeds and is not
    /// the last.
    AsyncSequence,
    /// Ticks its children in order until one succeeds or runs; fails when all have failed. While a child is running,
    /// the next tick goes on with that child.
    Fallback,
    /// Ticks its children in order *from the first at every tick* until one succeeds or runs; fails when all have
    /// failed. When a child runs, all the others are reset. The paper's fallback is this one.
    ReactiveFallback,
    /// Like [`Fallback`](Kind::Fallback), but has the tree ticked again when a child that was idle fails and is not the
    /// last.
    AsyncFallback,
    /// Ticks all children that have neither succeeded nor failed yet. Succeeds as soon as `success_count` children have
    /// succeeded (−1, the default, is all of them; −2 all but one; skipped ones then count as well), and fails as soon
    /// as `failure_count` (default 1) have failed or too few are left to succeed. Then the others are halted.
    Parallel,
    /// Ticks all children that have neither succeeded nor failed yet, until none is left. Fails if at least
    /// `max_failures` (default 1) have failed, and succeeds otherwise.
    ParallelAll,
    /// Ticks its first child; if that succeeds, the second; if it fails, the third, or fails if there is none. While
    /// the second or third is running, the first is not ticked again. A condition may not be skipped.
    IfThenElse,
    /// Ticks its first child *at every tick*; while that succeeds, the second; while it fails, the third, or fails if
    /// there is none. The one that is no longer wanted is halted. A condition may not be skipped.
    WhileDoElse,
    /// Compares `variable` to `case_1`, `case_2`, … (as texts, or as numbers) and ticks the child of the first that is
    /// equal, or the last child, which stands behind that many others. When the choice changes, the child that ran is
    /// halted.
    Switch(u8),
    /// Ticks all children but the last as a [`Sequence`](Kind::Sequence). If one fails, all are reset, the last is
    /// ticked until it is done, and the node fails. With `catch_on_halt`, the last is ticked once, too, when the node
    /// is halted before.
    TryCatch,
    /// Succeeds when its child fails and fails when it succeeds.
    Inverter,
    /// Succeeds when its child has succeeded or failed.
    ForceSuccess,
    /// Fails when its child has succeeded or failed.
    ForceFailure,
    /// Ticks its child until it has succeeded `num_cycles` times (−1: for ever). When a child that was idle succeeds
    /// and more is to do, the tree is ticked again. Fails, and starts over, when the child fails.
    Repeat,
    /// Ticks its child until it succeeds, at most `num_attempts` times (−1: for ever). When a child that was idle fails
    /// and may be tried again, the tree is ticked again.
    RetryUntilSuccessful,
    /// Answers running when its child succeeds, and fails when it fails.
    KeepRunningUntilFailure,
    /// Answers running for `delay_msec` milliseconds, then ticks its child.
    Delay,
    /// Ticks its child; if the child is running and `msec` milliseconds have gone by since the first tick, the child is
    /// halted, and the node fails. 0 is no limit.
    Timeout,
    /// Ticks its child until it has succeeded or failed once; ever after it is skipped, or answers the same again if
    /// `then_skip` is false. Halting it does not change that.
    RunOnce,
    /// Takes the first thing out of a `queue`, writes it to `value` and ticks its child; answers running while there is
    /// no failure, so that each tick takes one. Answers `if_empty` (default `SUCCESS`) when nothing is left. A queue is
    /// a text `1;2;3`, of which a copy is gone through, or a list on the blackboard, which gets shorter.
    Loop(Item),
    /// Ticks its child if the script `if` holds, and then until the child is done; answers `else` (default `FAILURE`)
    /// otherwise.
    Precondition,
    /// Is skipped unless the blackboard's `entry` was written since the last time that it was looked at; then, and
    /// while its child is running, ticks its child.
    SkipUnlessUpdated,
    /// Answers running unless the blackboard's `entry` was written since the last time that it was looked at; then, and
    /// while its child is running, ticks its child.
    WaitValueUpdate,
    /// Another tree in this place. Answers what that tree answers.
    SubTree,
    /// Succeeds at once.
    AlwaysSuccess,
    /// Fails at once.
    AlwaysFailure,
    /// Runs the script `code` and succeeds.
    Script,
    /// Succeeds if the script `code` holds.
    ScriptCondition,
    /// Writes `value`, a text or an entry to be copied, under the key `output_key`.
    SetBlackboard,
    /// Removes the entry `key`, if it is one of this tree's own.
    UnsetBlackboard,
    /// Answers running for `msec` milliseconds, then succeeds. Is halted without further ado.
    Sleep,
    /// Succeeds if the blackboard's `entry` was written since the last time that it was looked at.
    WasEntryUpdated,
    /// A leaf outside the tree that checks something. It is never told to stop: a condition that answers running (it
    /// should not) is forgotten when it is halted.
    Condition,
    /// A leaf outside the tree that does something. While it runs, it can be halted, and is told so.
    Action,
}

/// What is in the queue of a [`Kind::Loop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Item {
    /// Whole numbers: `LoopInt`.
    Int,
    /// Truth values: `LoopBool`.
    Bool,
    /// Real numbers: `LoopDouble`.
    Double,
    /// Texts: `LoopString`.
    Text,
}

/// Which part nodes of a kind play in a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Category {
    /// Directs one child or more.
    Control,
    /// Changes what its only child answers.
    Decorator,
    /// Does something; has no children.
    Action,
    /// Checks something; has no children.
    Condition,
    /// Stands for another tree.
    SubTree,
}

impl Category {
    /// The element that spells nodes of this category out: `<Control ID="Sequence">`.
    #[must_use]
    pub fn element(self) -> &'static str {
        match self {
            Self::Control => "Control",
            Self::Decorator => "Decorator",
            Self::Action => "Action",
            Self::Condition => "Condition",
            Self::SubTree => "SubTree",
        }
    }
}

impl fmt::Display for Category {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.element())
    }
}

impl Kind {
    /// All kinds that have a name of their own, which is all but the leaves outside the tree.
    pub const BUILTIN: [Self; 41] = [
        Self::Sequence,
        Self::ReactiveSequence,
        Self::SequenceWithMemory,
        Self::AsyncSequence,
        Self::Fallback,
        Self::ReactiveFallback,
        Self::AsyncFallback,
        Self::Parallel,
        Self::ParallelAll,
        Self::IfThenElse,
        Self::WhileDoElse,
        Self::Switch(2),
        Self::Switch(3),
        Self::Switch(4),
        Self::Switch(5),
        Self::Switch(6),
        Self::TryCatch,
        Self::Inverter,
        Self::ForceSuccess,
        Self::ForceFailure,
        Self::Repeat,
        Self::RetryUntilSuccessful,
        Self::KeepRunningUntilFailure,
        Self::Delay,
        Self::Timeout,
        Self::RunOnce,
        Self::Loop(Item::Int),
        Self::Loop(Item::Bool),
        Self::Loop(Item::Double),
        Self::Loop(Item::Text),
        Self::Precondition,
        Self::SkipUnlessUpdated,
        Self::WaitValueUpdate,
        Self::AlwaysSuccess,
        Self::AlwaysFailure,
        Self::Script,
        Self::ScriptCondition,
        Self::SetBlackboard,
        Self::UnsetBlackboard,
        Self::Sleep,
        Self::WasEntryUpdated,
    ];

    /// The name of the kind, as BehaviorTree.CPP registers it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sequence => "Sequence",
            Self::ReactiveSequence => "ReactiveSequence",
            Self::SequenceWithMemory => "SequenceWithMemory",
            Self::AsyncSequence => "AsyncSequence",
            Self::Fallback => "Fallback",
            Self::ReactiveFallback => "ReactiveFallback",
            Self::AsyncFallback => "AsyncFallback",
            Self::Parallel => "Parallel",
            Self::ParallelAll => "ParallelAll",
            Self::IfThenElse => "IfThenElse",
            Self::WhileDoElse => "WhileDoElse",
            Self::Switch(cases) => {
                ["Switch2", "Switch3", "Switch4", "Switch5", "Switch6"][usize::from(cases.clamp(2, 6)) - 2]
            }
            Self::TryCatch => "TryCatch",
            Self::Inverter => "Inverter",
            Self::ForceSuccess => "ForceSuccess",
            Self::ForceFailure => "ForceFailure",
            Self::Repeat => "Repeat",
            Self::RetryUntilSuccessful => "RetryUntilSuccessful",
            Self::KeepRunningUntilFailure => "KeepRunningUntilFailure",
            Self::Delay => "Delay",
            Self::Timeout => "Timeout",
            Self::RunOnce => "RunOnce",
            Self::Loop(Item::Int) => "LoopInt",
            Self::Loop(Item::Bool) => "LoopBool",
            Self::Loop(Item::Double) => "LoopDouble",
            Self::Loop(Item::Text) => "LoopString",
            Self::Precondition => "Precondition",
            Self::SkipUnlessUpdated => "SkipUnlessUpdated",
            Self::WaitValueUpdate => "WaitValueUpdate",
            Self::SubTree => "SubTree",
            Self::AlwaysSuccess => "AlwaysSuccess",
            Self::AlwaysFailure => "AlwaysFailure",
            Self::Script => "Script",
            Self::ScriptCondition => "ScriptCondition",
            Self::SetBlackboard => "SetBlackboard",
            Self::UnsetBlackboard => "UnsetBlackboard",
            Self::Sleep => "Sleep",
            Self::WasEntryUpdated => "WasEntryUpdated",
            Self::Condition => "Condition",
            Self::Action => "Action",
        }
    }

    /// What is drawn in the node's box: the literature's arrow and question mark for the nodes that look at all their
    /// children at every tick, with a star for those that resume and two for the one that never forgets. Kinds without
    /// a symbol are drawn by their label.
    #[must_use]
    pub fn symbol(self) -> Option<&'static str> {
        Some(match self {
            Self::ReactiveSequence => "→",
            Self::Sequence | Self::AsyncSequence => "→*",
            Self::SequenceWithMemory => "→**",
            Self::ReactiveFallback => "?",
            Self::Fallback | Self::AsyncFallback => "?*",
            Self::Parallel | Self::ParallelAll => "⇉",
            Self::Inverter => "¬",
            Self::ForceSuccess => "+",
            Self::ForceFailure => "−",
            Self::SubTree => "▸",
            _ => return None,
        })
    }

    /// Which part nodes of this kind play.
    #[must_use]
    pub fn category(self) -> Category {
        match self {
            Self::Sequence
            | Self::ReactiveSequence
            | Self::SequenceWithMemory
            | Self::AsyncSequence
            | Self::Fallback
            | Self::ReactiveFallback
            | Self::AsyncFallback
            | Self::Parallel
            | Self::ParallelAll
            | Self::IfThenElse
            | Self::WhileDoElse
            | Self::Switch(_)
            | Self::TryCatch => Category::Control,
            Self::Inverter
            | Self::ForceSuccess
            | Self::ForceFailure
            | Self::Repeat
            | Self::RetryUntilSuccessful
            | Self::KeepRunningUntilFailure
            | Self::Delay
            | Self::Timeout
            | Self::RunOnce
            | Self::Loop(_)
            | Self::Precondition
            | Self::SkipUnlessUpdated
            | Self::WaitValueUpdate => Category::Decorator,
            Self::SubTree => Category::SubTree,
            Self::AlwaysSuccess
            | Self::AlwaysFailure
            | Self::Script
            | Self::SetBlackboard
            | Self::UnsetBlackboard
            | Self::Sleep
            | Self::WasEntryUpdated
            | Self::Action => Category::Action,
            Self::ScriptCondition | Self::Condition => Category::Condition,
        }
    }

    /// Whether nodes of this kind are outside the tree: it calls them.
    #[must_use]
    pub fn is_leaf(self) -> bool {
        matches!(self, Self::Condition | Self::Action)
    }

    /// How many children such a node may have in the file, in words, or none if `count` is right.
    pub(crate) fn expected_children(self, count: usize) -> Option<&'static str> {
        match (self, self.category()) {
            (Self::IfThenElse | Self::WhileDoElse, _) if !(2..=3).contains(&count) => Some("two or three children"),
            (Self::TryCatch, _) if count < 2 => Some("at least two children"),
            (Self::Switch(cases), _) if count != usize::from(cases) + 1 => {
                Some("a child for every case, and one for all others")
            }
            (_, Category::Control) if count == 0 => Some("at least one child"),
            (_, Category::Decorator) if count != 1 => Some("exactly one child"),
            (_, Category::Action | Category::Condition | Category::SubTree) if count != 0 => Some("no children"),
            _ => None,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
