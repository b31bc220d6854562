//! The kinds of nodes and their semantics.

use std::fmt;

use crate::Status;

/// A kind of node.
///
/// The semantics are those of BehaviorTree.CPP 4.10. (In version 3, reactive nodes leave a later child running; both
/// formats follow version 4 here.) Nav2's control nodes and decorators have the semantics of Nav2's main branch of
/// August 2026. Terms used below:
///
/// - A node is *reset* when its status goes back to idle. If it is running, it is *halted* first: its running children
///   are halted in order, one after another, down to the actions, which are asked to stop.
/// - A node that is not running is not halted, and neither is anything below it. Only when the whole tree is halted,
///   every node is, so the `_onHalted` of all nodes runs.
/// - When a node has succeeded or failed, all its children have been reset, except those of [`SequenceWithMemory`] and
///   [`PauseResumeController`], and of an [`IfThenElse`] that has failed because it has no third child.
/// - A child that is *skipped* has no effect on its parent. If all children of a node are skipped, the node is skipped
///   unless stated otherwise.
/// - A node that *requests another tick* returns running. When the tick is finished and the root is running, the
///   tree is ticked once more as part of the same tick (BehaviorTree.CPP's wake-up signal, with `tickOnce`). So
///   reactive nodes above can check their conditions again. After 10,000 repetitions within one tick, another is
///   refused, and the tick ends.
/// - *Milliseconds* count the run's time. A tree acts only when it is ticked, so an elapsed time takes effect at the
///   next tick. (BehaviorTree.CPP has a timer thread, which halts the child of a [`Timeout`] at once and wakes a tree
///   that sleeps between ticks. Ticked at a fixed rate with `Tree::sleep`, both give the same answer at every tick. A
///   robot that waits with `std::this_thread::sleep_for` instead, as some of its examples do, leaves the timer's
///   wake-up pending, and its next tick ticks the tree twice if it answers running.)
///
/// [`SequenceWithMemory`]: Kind::SequenceWithMemory
/// [`PauseResumeController`]: Kind::PauseResumeController
/// [`IfThenElse`]: Kind::IfThenElse
/// [`Timeout`]: Kind::Timeout
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Ticks its children in order until one fails or runs; succeeds when all have succeeded. While a child is running,
    /// the next tick continues with that child. When a child fails, all are reset, and the next tick starts over.
    Sequence,
    /// Ticks its children in order, *from the first at every tick*, until one fails or runs; succeeds when all have
    /// succeeded. When a child runs, all others are reset: a child that ran before is halted, wherever it is. A child
    /// that is skipped is reset at once.
    ///
    /// This is the paper's sequence. BehaviorTree.CPP has an option to throw an exception when a second child runs; it
    /// is off by default in 4.10, and not implemented here. As in BehaviorTree.CPP, only one child may be an
    /// [`AsyncSequence`](Kind::AsyncSequence): two would halt each other forever.
    ReactiveSequence,
    /// Like [`Sequence`](Kind::Sequence), but children that have succeeded are not ticked again, even after a later
    /// child has failed or the node has been halted: only its own success starts it over. After a failure, the failed
    /// child and those after it are reset.
    ///
    /// When a child that was idle succeeds and is not the last, the node requests another tick.
    SequenceWithMemory,
    /// Like [`Sequence`](Kind::Sequence), but requests another tick when a child that was idle succeeds and is not
    /// the last.
    AsyncSequence,
    /// Ticks its children in order until one succeeds or runs; fails when all have failed. While a child is running,
    /// the next tick continues with that child.
    Fallback,
    /// Ticks its children in order, *from the first at every tick*, until one succeeds or runs; fails when all have
    /// failed. When a child runs, all others are reset. This is the paper's fallback.
    ReactiveFallback,
    /// Like [`Fallback`](Kind::Fallback), but requests another tick when a child that was idle fails and is not the
    /// last.
    AsyncFallback,
    /// Ticks all children that have neither succeeded nor failed yet. Succeeds as soon as `success_count` children have
    /// succeeded (−1, the default, means all of them; −2 all but one; skipped ones then count as well). Fails as soon
    /// as `failure_count` (default 1) have failed or too few are left to succeed. Then the others are halted.
    Parallel,
    /// Ticks all children that have neither succeeded nor failed yet, until none is left. Fails if at least
    /// `max_failures` (default 1) have failed, and succeeds otherwise.
    ParallelAll,
    /// Ticks its first child. If that succeeds, ticks the second; if it fails, ticks the third, or fails if there is
    /// none. While the second or third is running, the first is not ticked again. The condition must not be skipped.
    IfThenElse,
    /// Ticks its first child *at every tick*. While that succeeds, ticks the second; while it fails, ticks the third,
    /// or fails if there is none. A branch that is no longer selected is halted. The condition must not be skipped.
    WhileDoElse,
    /// Compares `variable` with `case_1`, `case_2`, … (as strings, or as numbers) and ticks the child of the first
    /// equal case, or otherwise the last child, the default. When the choice changes, the child that ran is halted. The
    /// number in its name is the number of cases. Up to 4.9.1, BehaviorTree.CPP reads a string such as `3 apples` as
    /// the number 3 here, and since 4.10 as no number.
    Switch(u8),
    /// Ticks all children but the last as a [`Sequence`](Kind::Sequence). If one fails, all are reset, the last is
    /// ticked until it is done, and the node fails. With `catch_on_halt`, the last is also ticked once when the node is
    /// halted before that.
    TryCatch,
    /// Nav2's sequence for work in stages, such as planning and following: ticks its children in order *from the first
    /// at every tick*, and moves past a running child that comes before the last one reached. Returns running at the
    /// first running child that is not before that one. Fails when a child fails, and succeeds when the last has
    /// succeeded or was skipped; then all are reset.
    PipelineSequence,
    /// Nav2's nonblocking sequence: ticks all its children at every tick. Fails as soon as one fails, succeeds when all
    /// succeed in the same tick, and otherwise returns running. No child may be skipped.
    NonblockingSequence,
    /// Nav2's sequence that keeps its position in the entry `current_child_idx`, counted from 0, so that the position
    /// survives a halt. The entry must have a value before the first tick. The position advances when a child succeeds
    /// or is skipped, and returns to 0 when a child fails or the last one is done.
    PersistentSequence,
    /// Nav2's retries with a recovery: ticks its first child. If that fails, ticks the second, and if that succeeds,
    /// the first again, at most `number_of_retries` times. Fails when the second fails or is skipped, or when no
    /// retries are left; is skipped if the first is. As in Nav2, a skipped recovery does not reset the number of
    /// retries so far.
    RecoveryNode,
    /// Nav2's round robin: ticks one child after another until one succeeds, and begins with the next one at its next
    /// tick. Fails when the number of children that have failed or been skipped since the last success reaches the
    /// number of children.
    ///
    /// With `wrap_around`, the first child follows the last one. Without it, the node ends after the last child, and
    /// the next tick begins with the first: as in Nav2, it then fails *whatever the last child has answered*, even
    /// success. Nav2 has this port since Lyrical; older releases always wrap around. So it is true by default in files
    /// of version 3 (Humble), and a file of version 4 that does not set it gets a warning.
    RoundRobin,
    /// Nav2's switch between work and pause. Its first child is its normal work. Up to three optional ones follow: one
    /// ticked while it is paused, one ticked once when it is paused, and one ticked once when it resumes. It gives the
    /// answer of its first child (success if that is skipped), and fails if any child fails; otherwise it answers
    /// running.
    ///
    /// `pause_service_name` and `resume_service_name` are services in Nav2. Here each is an entry of the main tree with
    /// that name, without a leading `/`: every write to it is a request. While the node is paused, it accepts only
    /// requests to resume; otherwise only requests to pause. It takes others from the entry and ignores them.
    PauseResumeController,
    /// Succeeds when its child fails, and fails when it succeeds.
    Inverter,
    /// Succeeds when its child has succeeded or failed.
    ForceSuccess,
    /// Fails when its child has succeeded or failed.
    ForceFailure,
    /// Ticks its child until it has succeeded `num_cycles` times (−1: forever). When a child that was idle succeeds and
    /// repetitions remain, the tree is ticked again. Fails, and starts over, when the child fails.
    Repeat,
    /// Ticks its child until it succeeds, at most `num_attempts` times (−1: forever). When a child that was idle fails
    /// and attempts remain, the tree is ticked again.
    RetryUntilSuccessful,
    /// Returns running when its child succeeds, and fails when it fails.
    KeepRunningUntilFailure,
    /// Returns running for `delay_msec` milliseconds, then ticks its child.
    Delay,
    /// Ticks its child. If the child is running and `msec` milliseconds have passed since the first tick, the child is
    /// halted, and the node fails. 0 means no limit.
    Timeout,
    /// Ticks its child until it has succeeded or failed once. After that it is always skipped, or repeats the answer if
    /// `then_skip` is false. Halting it does not change that.
    RunOnce,
    /// Takes the first item from a `queue`, writes it to `value` and ticks its child; returns running unless the child
    /// fails, so each tick takes one item. Returns `if_empty` (default `SUCCESS`) when nothing is left. A queue is a
    /// string such as `1;2;3`, which stays unchanged, or a list on the blackboard, which gets shorter.
    Loop(Item),
    /// Ticks its child if the script `if` holds, and then until the child is done; otherwise returns `else` (default
    /// `FAILURE`).
    Precondition,
    /// Is skipped unless the blackboard's `entry` has been written since it was last checked; then ticks its child, and
    /// continues to do so while the child is running.
    SkipUnlessUpdated,
    /// Returns running unless the blackboard's `entry` has been written since it was last checked; then ticks its
    /// child, and continues to do so while the child is running.
    WaitValueUpdate,
    /// Nav2's rate limit: ticks its child at the first tick, and again when 1/`hz` seconds have passed since the
    /// child's last success (or else since the first tick); otherwise returns running. Ticks a running child at every
    /// tick.
    ///
    /// It starts over after it has been reset. Below a [`PipelineSequence`](Kind::PipelineSequence), which resets no
    /// child until it is done itself, the period counts from success to success.
    RateController,
    /// Nav2's distance limit: ticks its child at the first tick, and again when the robot is at least `distance` meters
    /// from where it was when the child last succeeded (or else at the first tick); otherwise returns running. Ticks a
    /// running child at every tick. Fails while the pose is unknown; as in Nav2, a running child is not halted then.
    ///
    /// The pose is the entry `robot_pose` of the main tree: `x;y` in meters, or Nav2's nine fields
    /// `stamp;frame;x;y;z;qx;qy;qz;qw`.
    DistanceController,
    /// Nav2's limit that depends on speed: like [`RateController`](Kind::RateController), but the period depends on the
    /// speed. It is 1/`max_rate` seconds at first, and again when a goal has changed. At the end of each period, the
    /// rate for the next one follows from the current speed: `min_rate` at `min_speed`, `max_rate` at `max_speed`, and
    /// linear in between. The new period starts at once, whatever the child answers.
    ///
    /// The speed is the entry `robot_speed` of the main tree, in m/s; without a value it is 0.
    SpeedController,
    /// Nav2's update of the goal while the robot drives: before each tick of its child, writes the update to
    /// `output_goal`, or `input_goal` if there is none, and does the same with `input_goals` and `output_goals`.
    ///
    /// Updates are topics in Nav2. Here they are the entries `goal_update` and `goals_update` of the main tree. In
    /// Nav2's format (nine fields for a goal; `stamp;frame;` and nine fields for each pose for goals), an update is
    /// ignored if it has no stamp or an older one than the input. In any other format, the update counts.
    GoalUpdater,
    /// Nav2's trigger for new goals: ticks its child at the first tick, and again when `goal` or `goals` has changed;
    /// otherwise returns running. Ticks a running child at every tick.
    GoalUpdatedController,
    /// Nav2's guard against detours near the goal: ticks its child if the `path` has become more than `length_factor`
    /// times longer while the goal is the same and the previous path was shorter than `prox_len` meters; otherwise
    /// succeeds. As in Nav2, two paths with the same number of poses count as equal, and a running child that is no
    /// longer ticked is not halted.
    ///
    /// A path is `x;y;x;y;…` in meters, or `stamp;frame;` and Nav2's nine fields for each pose.
    PathLongerOnApproach,
    /// Nav2's one-time trigger: ticks its child until it has succeeded or failed once; after that, fails until it is
    /// reset.
    SingleTrigger,
    /// Stands for another tree, and gives that tree's answer.
    SubTree,
    /// Succeeds at once.
    AlwaysSuccess,
    /// Fails at once.
    AlwaysFailure,
    /// Runs the script `code` and succeeds.
    Script,
    /// Succeeds if the script `code` holds.
    ScriptCondition,
    /// Writes `value`, a string or an entry to be copied, under the key `output_key`.
    SetBlackboard,
    /// Removes the entry `key` if it belongs to this tree.
    UnsetBlackboard,
    /// Returns running for `msec` milliseconds, then succeeds. Halting it has no further effect.
    Sleep,
    /// Succeeds if the blackboard's `entry` has been written since it was last checked.
    WasEntryUpdated,
    /// A leaf that checks something, in a process of its own. It is never asked to stop: a condition that returns
    /// running (it should not) is simply reset when it is halted.
    Condition,
    /// A leaf that does something, in a process of its own. When it is halted while it runs, it is asked to stop.
    Action,
}

/// The items in the queue of a [`Kind::Loop`].
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

/// The role of nodes in a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Category {
    /// Directs one or more children.
    Control,
    /// Changes the answer of its only child.
    Decorator,
    /// Does something; has no children.
    Action,
    /// Checks something; has no children.
    Condition,
    /// Represents another tree.
    SubTree,
}

impl Category {
    /// The element of this category's explicit form: `<Control ID="Sequence">`.
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
    /// All kinds with a name of their own: all except leaves outside the tree.
    pub const BUILTIN: [Self; 54] = [
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
        Self::PipelineSequence,
        Self::NonblockingSequence,
        Self::PersistentSequence,
        Self::RecoveryNode,
        Self::RoundRobin,
        Self::PauseResumeController,
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
        Self::RateController,
        Self::DistanceController,
        Self::SpeedController,
        Self::GoalUpdater,
        Self::GoalUpdatedController,
        Self::PathLongerOnApproach,
        Self::SingleTrigger,
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
            Self::PipelineSequence => "PipelineSequence",
            Self::NonblockingSequence => "NonblockingSequence",
            Self::PersistentSequence => "PersistentSequence",
            Self::RecoveryNode => "RecoveryNode",
            Self::RoundRobin => "RoundRobin",
            Self::PauseResumeController => "PauseResumeController",
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
            Self::RateController => "RateController",
            Self::DistanceController => "DistanceController",
            Self::SpeedController => "SpeedController",
            Self::GoalUpdater => "GoalUpdater",
            Self::GoalUpdatedController => "GoalUpdatedController",
            Self::PathLongerOnApproach => "PathLongerOnApproach",
            Self::SingleTrigger => "SingleTrigger",
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

    /// The symbol in the node's box: the literature's arrow and question mark, without a star for nodes that check all
    /// their children at every tick, with one star for those that resume, and with two for the one that never forgets.
    /// Kinds without a symbol are drawn with their label.
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

    /// The role of nodes of this kind.
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
            | Self::TryCatch
            | Self::PipelineSequence
            | Self::NonblockingSequence
            | Self::PersistentSequence
            | Self::RecoveryNode
            | Self::RoundRobin
            | Self::PauseResumeController => Category::Control,
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
            | Self::WaitValueUpdate
            | Self::RateController
            | Self::DistanceController
            | Self::SpeedController
            | Self::GoalUpdater
            | Self::GoalUpdatedController
            | Self::PathLongerOnApproach
            | Self::SingleTrigger => Category::Decorator,
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

    /// Whether nodes of this kind can ever give this answer.
    #[must_use]
    pub fn may_answer(self, status: Status) -> bool {
        match status {
            Status::Success => {
                !matches!(self, Self::AlwaysFailure | Self::ForceFailure | Self::KeepRunningUntilFailure)
            }
            Status::Failure => !matches!(
                self,
                Self::AlwaysSuccess
                    | Self::ForceSuccess
                    | Self::Script
                    | Self::SetBlackboard
                    | Self::UnsetBlackboard
                    | Self::Sleep
            ),
            Status::Running | Status::Skipped => true,
        }
    }

    /// Whether it is a control node or decorator of Nav2, which BehaviorTree.CPP itself does not have.
    #[must_use]
    pub fn is_of_nav2(self) -> bool {
        matches!(
            self,
            Self::PipelineSequence
                | Self::NonblockingSequence
                | Self::PersistentSequence
                | Self::RecoveryNode
                | Self::RoundRobin
                | Self::PauseResumeController
                | Self::RateController
                | Self::DistanceController
                | Self::SpeedController
                | Self::GoalUpdater
                | Self::GoalUpdatedController
                | Self::PathLongerOnApproach
                | Self::SingleTrigger
        )
    }

    /// Whether nodes of this kind are outside the tree and are called by it.
    #[must_use]
    pub fn is_leaf(self) -> bool {
        matches!(self, Self::Condition | Self::Action)
    }

    /// The allowed number of children in the file, in words; `None` if `count` is allowed.
    pub(crate) fn expected_children(self, count: usize) -> Option<&'static str> {
        match (self, self.category()) {
            (Self::IfThenElse | Self::WhileDoElse, _) if !(2..=3).contains(&count) => Some("two or three children"),
            (Self::TryCatch, _) if count < 2 => Some("at least two children"),
            (Self::RecoveryNode, _) if count != 2 => Some("two children"),
            (Self::PauseResumeController, _) if !(1..=4).contains(&count) => Some("one to four children"),
            (Self::Switch(cases), _) if count != usize::from(cases) + 1 => {
                Some("one child per case, and one more for all other values")
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
