//! Nav2's control nodes and decorators.

use std::time::Duration;

use super::{Answer, Beginning, Memory, PortReading, Reaction, Reset, Resume, Then, Which};
use crate::{Kind, Status};

/// What a node of Nav2 does when it is ticked.
pub(super) fn begin_nav2(kind: Kind, memory: &mut Memory, beginning: Beginning) -> Reaction {
    let Beginning { was, reading, now, child_runs } = beginning;
    let starts = was.is_none();
    match (kind, reading) {
        (Kind::PersistentSequence, PortReading::Status(status)) => Reaction::finish(status),
        (_, PortReading::Status(status)) => Reaction::answer(status),
        (Kind::PipelineSequence, _) => {
            (memory.at, memory.skipped) = (0, 0);
            Reaction::tick(Which::First)
        }
        (Kind::NonblockingSequence, _) => {
            memory.count = 0;
            Reaction::tick(Which::First)
        }
        (Kind::PersistentSequence, PortReading::Numbers([index, _])) => begin_at(index),
        (Kind::RecoveryNode | Kind::RoundRobin, PortReading::Numbers(limits)) => begin_counting(kind, memory, limits),
        (Kind::PauseResumeController, PortReading::Numbers(requests)) => begin_pausable(memory, starts, requests),
        (Kind::RateController, _) => tick_if(memory.rate_is_due(starts, reading, now) || child_runs),
        (Kind::SpeedController, PortReading::Numbers(read)) => tick_if(memory.speed_is_due(read, now) || child_runs),
        (Kind::DistanceController | Kind::GoalUpdatedController, _) => {
            tick_if(reading == PortReading::Proceed || child_runs)
        }
        (Kind::SingleTrigger, _) => {
            // Nav2's decorators do not forget when they are halted: they start over when they are ticked while idle.
            memory.flag &= !starts;
            if memory.flag { Reaction::answer(Status::Failure) } else { Reaction::tick(Which::First) }
        }
        _ => Reaction::tick(Which::First),
    }
}

impl Memory {
    /// Whether a RateController ticks its child, whether or not that is running. The flag is its first tick.
    fn rate_is_due(&mut self, starts: bool, reading: PortReading, now: Duration) -> bool {
        if let (true, PortReading::Numbers(limits)) = (starts, reading) {
            (self.limits, self.flag) = (limits, true);
            self.until = Some(now.saturating_add(nanoseconds(limits[0])));
        }
        std::mem::take(&mut self.flag) || self.until.is_none_or(|until| until <= now)
    }

    /// Whether a SpeedController ticks its child, whether or not that is running: a goal is new, or the period is over.
    /// Then the next one begins.
    fn speed_is_due(&mut self, [is_new, period]: [i64; 2], now: Duration) -> bool {
        let is_due = is_new != 0 || self.until.is_none_or(|until| until <= now);
        if is_due {
            self.until = Some(now.saturating_add(nanoseconds(period)));
        }
        is_due
    }
}

/// A RecoveryNode or a RoundRobin continues, unless the number of retries has become less than those so far.
fn begin_counting(kind: Kind, memory: &mut Memory, limits: [i64; 2]) -> Reaction {
    (memory.limits, memory.skipped) = (limits, 0);
    let retries_were_lowered = kind == Kind::RecoveryNode && i64::from(memory.count) > limits[0];
    if retries_were_lowered { memory.end(Status::Failure) } else { Reaction::tick(Which::Resumed) }
}

fn nanoseconds(count: i64) -> Duration {
    Duration::from_nanos(count.try_into().unwrap_or_default())
}

fn tick_if(is_due: bool) -> Reaction {
    if is_due { Reaction::tick(Which::First) } else { Reaction::answer(Status::Running) }
}

/// A PersistentSequence begins with the child of its entry.
fn begin_at(index: i64) -> Reaction {
    match u32::try_from(index) {
        Ok(index) => Reaction::tick(Which::Nth(index)),
        Err(_) => Reaction::fault("current_child_idx is negative"),
    }
}

/// The children of a PauseResumeController.
const RESUMED: u32 = 0;
const PAUSED: u32 = 1;
const ON_PAUSE: u32 = 2;
const ON_RESUME: u32 = 3;

/// The child of a PauseResumeController that follows the one that is done.
fn after(child: u32) -> u32 {
    match child {
        ON_PAUSE => PAUSED,
        ON_RESUME => RESUMED,
        child => child,
    }
}

fn begin_pausable(memory: &mut Memory, starts: bool, requests: [i64; 2]) -> Reaction {
    let [pauses, resumes] = requests.map(|request| request != 0);
    if starts {
        memory.at = RESUMED;
    }
    let mut reset = Reset::None;
    if if memory.at == PAUSED { resumes } else { pauses } {
        memory.at = if memory.at == PAUSED { ON_RESUME } else { ON_PAUSE };
        reset = Reset::All;
    }
    let then = if memory.at < memory.children {
        Then::Tick(Which::Nth(memory.at))
    } else {
        memory.at = after(memory.at);
        Then::Answer(Status::Running)
    };
    Reaction::Do { reset, resume: Resume::Same, then }
}

/// Whether a node of this kind reads its values again when a child has given this answer.
pub(crate) fn needs_reading_after(kind: Kind, status: Status) -> bool {
    match kind {
        // The child may have changed the number of attempts.
        Kind::RetryUntilSuccessful => status == Status::Failure,
        Kind::PersistentSequence => status != Status::Running,
        Kind::DistanceController => status == Status::Success,
        Kind::PathLongerOnApproach => status.is_completed(),
        _ => false,
    }
}

/// What a node of Nav2 does when a child gives this answer.
pub(super) fn react_nav2(kind: Kind, memory: &mut Memory, status: Status, answer: Answer) -> Reaction {
    match kind {
        Kind::PipelineSequence => react_pipeline(memory, status, answer.is_last),
        Kind::NonblockingSequence => react_nonblocking(memory, status, answer.is_last),
        Kind::PersistentSequence => react_persistent(status, answer.reading),
        Kind::RecoveryNode => react_recovery(memory, status, answer.is_last),
        Kind::RoundRobin => react_round(memory, status, answer.is_last),
        Kind::PauseResumeController => react_pausable(memory, status),
        _ if !status.is_completed() => Reaction::answer(status),
        _ => {
            memory.flag |= kind == Kind::SingleTrigger;
            if kind == Kind::RateController && status == Status::Success {
                memory.until = Some(answer.now.saturating_add(nanoseconds(memory.limits[0])));
            }
            let status = if let PortReading::Status(status) = answer.reading { status } else { status };
            // The others leave it to the library to reset their child after the answer.
            if kind == Kind::PathLongerOnApproach { Reaction::finish(status) } else { Reaction::answer(status) }
        }
    }
}

impl Memory {
    /// The node is done and has forgotten what happened.
    fn end(&mut self, status: Status) -> Reaction {
        (self.count, self.at) = (0, 0);
        let then = if status == Status::Skipped { Then::Skip } else { Then::Answer(status) };
        Reaction::Do { reset: Reset::All, resume: Resume::First, then }
    }
}

/// The count is the last child reached.
fn react_pipeline(memory: &mut Memory, status: Status, is_last: bool) -> Reaction {
    match status {
        Status::Failure => return memory.end(status),
        Status::Running if memory.at >= memory.count => {
            memory.count = memory.at;
            return Reaction::answer(status);
        }
        Status::Skipped => memory.skipped += 1,
        Status::Running | Status::Success => {}
    }
    if !is_last {
        memory.at += 1;
        return Reaction::Next;
    }
    let all_skipped = memory.skipped == memory.children;
    memory.count = 0;
    Reaction::finish(if all_skipped { Status::Skipped } else { Status::Success })
}

/// It counts the running children.
fn react_nonblocking(memory: &mut Memory, status: Status, is_last: bool) -> Reaction {
    match status {
        Status::Failure => return Reaction::finish(status),
        Status::Skipped => return Reaction::fault("a child was skipped"),
        Status::Running => memory.count += 1,
        Status::Success => {}
    }
    match (is_last, memory.count) {
        (false, _) => Reaction::Next,
        (true, 0) => Reaction::finish(Status::Success),
        (true, _) => Reaction::answer(Status::Running),
    }
}

/// The entry has been changed already.
fn react_persistent(status: Status, reading: PortReading) -> Reaction {
    match (status, reading) {
        (Status::Running, _) => Reaction::answer(status),
        (Status::Success | Status::Skipped, PortReading::Numbers([0, _])) => Reaction::finish(Status::Success),
        (Status::Success | Status::Skipped, PortReading::Numbers([next, _])) => {
            Reaction::tick(Which::Nth(u32::try_from(next).unwrap_or(0)))
        }
        _ => Reaction::finish(Status::Failure),
    }
}

/// It counts the retries.
fn react_recovery(memory: &mut Memory, status: Status, is_recovery: bool) -> Reaction {
    let go_on = |reset, resume, then| Reaction::Do { reset, resume, then };
    match (is_recovery, status) {
        (_, Status::Running) => go_on(Reset::None, Resume::Here, Then::Answer(status)),
        (false, Status::Failure) if i64::from(memory.count) < memory.limits[0] => {
            go_on(Reset::Here, Resume::Next, Then::Tick(Which::Next))
        }
        (true, Status::Success) => {
            memory.count += 1;
            go_on(Reset::Here, Resume::First, Then::Tick(Which::First))
        }
        (true, Status::Skipped) => go_on(Reset::Here, Resume::First, Then::Answer(Status::Failure)),
        _ => memory.end(status),
    }
}

/// It counts the failures since the last success, and the children that were skipped in this tick.
fn react_round(memory: &mut Memory, status: Status, is_last: bool) -> Reaction {
    let go_on = |reset, resume, then| Reaction::Do { reset, resume, then };
    let (resume, next) = if is_last { (Resume::First, Which::First) } else { (Resume::Next, Which::Next) };
    let ends = is_last && memory.limits[0] == 0;
    match status {
        Status::Running => return go_on(Reset::None, Resume::Here, Then::Answer(status)),
        Status::Success if !ends => {
            memory.count = 0;
            return go_on(Reset::All, resume, Then::Answer(status));
        }
        Status::Success => {}
        Status::Failure => memory.count += 1,
        Status::Skipped => memory.skipped += 1,
    }
    if !ends && memory.count + memory.skipped < memory.children {
        return go_on(Reset::None, resume, Then::Tick(next));
    }
    memory.end(if memory.skipped == memory.children { Status::Skipped } else { Status::Failure })
}

fn react_pausable(memory: &mut Memory, status: Status) -> Reaction {
    match status {
        Status::Running | Status::Failure => Reaction::answer(status),
        Status::Success | Status::Skipped if memory.at == RESUMED => Reaction::answer(Status::Success),
        Status::Success | Status::Skipped => {
            memory.at = after(memory.at);
            Reaction::answer(Status::Running)
        }
    }
}
