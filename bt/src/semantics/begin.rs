//! What a node does when it is ticked.

use std::time::Duration;

use super::nav2::begin_nav2;
use super::{Beginning, Memory, PortReading, Reaction, Reset, Resume, Then, Which};
use crate::{Kind, Status};

/// Whether a node of this kind has anything to read in its current state.
pub(crate) fn needs_reading(kind: Kind, memory: &Memory, was_idle: bool) -> bool {
    match kind {
        Kind::Precondition | Kind::SkipUnlessUpdated | Kind::WaitValueUpdate => !memory.flag,
        Kind::Loop(_) => was_idle || !memory.flag,
        Kind::Sleep => was_idle,
        Kind::RateController => was_idle,
        Kind::TryCatch => false,
        _ => true,
    }
}

pub(crate) fn begin(kind: Kind, memory: &mut Memory, beginning: Beginning) -> Reaction {
    match kind {
        Kind::AlwaysSuccess => Reaction::answer(Status::Success),
        Kind::AlwaysFailure => Reaction::answer(Status::Failure),
        kind if kind.has_settings() => begin_other(kind, memory, beginning),
        kind => Reaction::tick(begin_plain(kind, memory, beginning.was.is_none())),
    }
}

/// The child that a node [without settings](Kind::has_settings) ticks when it is ticked. The engine calls this
/// directly, since most inner nodes of trees are of these kinds.
#[inline]
pub(crate) fn begin_plain(kind: Kind, memory: &mut Memory, was_idle: bool) -> Which {
    match kind {
        Kind::ReactiveSequence | Kind::ReactiveFallback => {
            memory.skipped = 0;
            Which::First
        }
        Kind::Sequence | Kind::SequenceWithMemory | Kind::AsyncSequence | Kind::Fallback | Kind::AsyncFallback => {
            if was_idle {
                memory.skipped = 0;
            }
            Which::Resumed
        }
        _ => Which::First,
    }
}

fn begin_other(kind: Kind, memory: &mut Memory, beginning: Beginning) -> Reaction {
    match kind {
        Kind::IfThenElse => Reaction::tick(Which::Nth(memory.at)),
        Kind::WhileDoElse => {
            memory.at = 0;
            Reaction::tick(Which::First)
        }
        Kind::TryCatch => {
            if beginning.was.is_none() {
                (memory.skipped, memory.flag) = (0, false);
            }
            Reaction::tick(if memory.flag { Which::Last } else { Which::Resumed })
        }
        Kind::Switch(_) => begin_switch(memory, beginning.reading),
        Kind::Parallel | Kind::ParallelAll => begin_parallel(kind, memory, beginning.reading),
        Kind::Repeat | Kind::RetryUntilSuccessful => begin_repetition(kind, memory, beginning.reading),
        Kind::Delay | Kind::Timeout | Kind::Sleep => begin_timed(kind, memory, beginning),
        Kind::RunOnce if memory.flag => {
            // The first number is `then_skip`.
            let skips = beginning.reading != PortReading::Numbers([0, 0]);
            Reaction::answer(if skips { Status::Skipped } else { memory.kept.unwrap_or(Status::Skipped) })
        }
        Kind::Loop(_) => {
            // A halt does not clear the flag (`Memory::forget`), so this does.
            memory.flag &= beginning.was.is_some();
            proceed(beginning.reading)
        }
        Kind::Precondition => {
            memory.flag |= beginning.reading == PortReading::Proceed;
            proceed(beginning.reading)
        }
        Kind::SkipUnlessUpdated | Kind::WaitValueUpdate | Kind::WasEntryUpdated => begin_update(kind, beginning),
        Kind::Script | Kind::ScriptCondition | Kind::SetBlackboard | Kind::UnsetBlackboard => {
            proceed(beginning.reading)
        }
        kind if kind.is_of_nav2() => begin_nav2(kind, memory, beginning),
        _ => Reaction::tick(Which::First),
    }
}

/// Gives the answer that was read, or else ticks the child.
fn proceed(reading: PortReading) -> Reaction {
    match reading {
        PortReading::Status(status) => Reaction::answer(status),
        _ => Reaction::tick(Which::First),
    }
}

fn begin_switch(memory: &mut Memory, reading: PortReading) -> Reaction {
    let chosen = match reading {
        PortReading::Numbers([chosen, _]) => u32::try_from(chosen).unwrap_or(0),
        _ => 0,
    };
    memory.count = chosen;
    let reset = match memory.at.checked_sub(1) {
        Some(running) if running != chosen => Reset::Nth(running),
        _ => Reset::None,
    };
    Reaction::Do { reset, resume: Resume::Same, then: Then::Tick(Which::Nth(chosen)) }
}

fn begin_parallel(kind: Kind, memory: &mut Memory, reading: PortReading) -> Reaction {
    let PortReading::Numbers(limits) = reading else { return Reaction::fault("its thresholds are missing") };
    memory.limits = limits;
    memory.skipped = 0;
    let children = i64::from(memory.children);
    let too_high = |limit| threshold(limit, memory.children) > children;
    match kind {
        Kind::Parallel if too_high(limits[0]) => {
            Reaction::fault("success_count is greater than the number of children")
        }
        Kind::Parallel if too_high(limits[1]) => {
            Reaction::fault("failure_count is greater than the number of children")
        }
        Kind::ParallelAll if too_high(limits[0]) => {
            Reaction::fault("max_failures is greater than the number of children")
        }
        _ => Reaction::tick(Which::First),
    }
}

/// A number of children: −1 means all of them, −2 all but one, and so on.
pub(super) fn threshold(limit: i64, children: u32) -> i64 {
    if limit < 0 { (i64::from(children) + limit + 1).max(0) } else { limit }
}

fn begin_repetition(kind: Kind, memory: &mut Memory, reading: PortReading) -> Reaction {
    if let PortReading::Numbers(limits) = reading {
        memory.limits = limits;
    }
    if memory.may_go_on() {
        return Reaction::tick(Which::First);
    }
    memory.count = 0;
    Reaction::answer(if kind == Kind::Repeat { Status::Success } else { Status::Failure })
}

impl Memory {
    /// Whether a repetition continues.
    pub(super) fn may_go_on(&self) -> bool {
        self.limits[0] == -1 || i64::from(self.count) < self.limits[0]
    }
}

fn begin_timed(kind: Kind, memory: &mut Memory, beginning: Beginning) -> Reaction {
    let Beginning { was, reading, now, child_runs } = beginning;
    let span = match reading {
        PortReading::Numbers([milliseconds, _]) => Duration::from_millis(milliseconds.try_into().unwrap_or(0)),
        _ => Duration::ZERO,
    };
    let starts = if kind == Kind::Sleep { was.is_none() } else { !memory.flag };
    if starts {
        memory.flag = true;
        // A Timeout of 0 ms has no limit.
        memory.until = (kind != Kind::Timeout || !span.is_zero()).then(|| now.saturating_add(span));
    }
    let is_due = memory.until.is_some_and(|until| until <= now);
    match kind {
        Kind::Timeout if is_due => {
            memory.until = None;
            if !child_runs {
                return Reaction::tick(Which::First);
            }
            memory.flag = false;
            Reaction::finish(Status::Failure)
        }
        Kind::Timeout => Reaction::tick(Which::First),
        Kind::Delay if is_due => Reaction::tick(Which::First),
        Kind::Delay => Reaction::answer(Status::Running),
        _ => Reaction::answer(match was {
            Some(status @ (Status::Success | Status::Failure)) => status,
            _ if is_due => Status::Success,
            _ => Status::Running,
        }),
    }
}

fn begin_update(kind: Kind, beginning: Beginning) -> Reaction {
    let is_new = match beginning.reading {
        PortReading::Numbers([is_new, _]) => is_new != 0,
        // The child is running: nothing was read.
        _ => true,
    };
    match kind {
        Kind::WasEntryUpdated if is_new => Reaction::answer(Status::Success),
        Kind::WasEntryUpdated => Reaction::answer(Status::Failure),
        _ if is_new => Reaction::tick(Which::First),
        Kind::WaitValueUpdate => Reaction::answer(Status::Running),
        _ => Reaction::answer(Status::Skipped),
    }
}
