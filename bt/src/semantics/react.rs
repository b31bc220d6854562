//! What a node does when a child has answered.

use super::begin::threshold;
use super::nav2::react_nav2;
use super::{Answer, Memory, PortReading, Reaction, Reset, Resume, Then, Which};
use crate::{Kind, Status};

/// What a node of this kind does when a child gives this answer.
pub(crate) fn react(kind: Kind, memory: &mut Memory, answer: Answer) -> Reaction {
    let Some(status) = answer.status else { return react_parallel(kind, memory, answer) };
    match kind {
        Kind::Parallel | Kind::ParallelAll => react_parallel(kind, memory, answer),
        kind if kind.has_settings() => react_other(kind, memory, status, answer),
        kind => react_plain(kind, memory, status, answer.was_idle, answer.is_last),
    }
}

/// What a node [without settings](Kind::has_settings) does when a child gives this answer. The engine calls this
/// directly, since most inner nodes of trees are of these kinds; an [`Answer`] would not fit into registers.
#[inline]
pub(crate) fn react_plain(kind: Kind, memory: &mut Memory, status: Status, was_idle: bool, is_last: bool) -> Reaction {
    match (kind, status) {
        (Kind::ReactiveSequence, _) => react_reactive(memory, Status::Success, status, is_last),
        (Kind::ReactiveFallback, _) => react_reactive(memory, Status::Failure, status, is_last),
        (Kind::Sequence | Kind::SequenceWithMemory | Kind::AsyncSequence, _) => {
            react_in_order(kind, memory, Status::Success, status, was_idle, is_last)
        }
        (Kind::Fallback | Kind::AsyncFallback, _) => {
            react_in_order(kind, memory, Status::Failure, status, was_idle, is_last)
        }
        (_, Status::Running | Status::Skipped) => Reaction::answer(status),
        (Kind::Inverter, _) => Reaction::finish(status.inverted()),
        (Kind::ForceSuccess, _) => Reaction::finish(Status::Success),
        (Kind::ForceFailure, _) => Reaction::finish(Status::Failure),
        (_, status) => Reaction::finish(status),
    }
}

/// Nodes that start over at every tick. `neutral` is the answer after which they continue with the next child.
#[inline]
fn react_reactive(memory: &mut Memory, neutral: Status, status: Status, is_last: bool) -> Reaction {
    match status {
        Status::Running => {
            Reaction::Do { reset: Reset::Others, resume: Resume::First, then: Then::Answer(Status::Running) }
        }
        Status::Skipped => {
            memory.skipped += 1;
            // It is reset first, so that it can be skipped again, even if all are reset then.
            let then = match is_last {
                true if memory.skipped == memory.children => Then::Finish(Status::Skipped),
                true => Then::Finish(neutral),
                false => Then::Tick(Which::Next),
            };
            Reaction::Do { reset: Reset::Here, resume: Resume::Same, then }
        }
        status if status == neutral && !is_last => Reaction::Next,
        status => Reaction::finish(status),
    }
}

/// Nodes that continue with the running child.
#[inline]
fn react_in_order(
    kind: Kind,
    memory: &mut Memory,
    neutral: Status,
    status: Status,
    was_idle: bool,
    is_last: bool,
) -> Reaction {
    let yields = matches!(kind, Kind::SequenceWithMemory | Kind::AsyncSequence | Kind::AsyncFallback);
    let stop = |reset| Reaction::Do { reset, resume: Resume::Here, then: Then::Answer(status) };
    match status {
        Status::Running => return stop(Reset::None),
        Status::Skipped => memory.skipped += 1,
        status if status == neutral => {}
        _ if kind == Kind::SequenceWithMemory => return stop(Reset::FromHere),
        _ => return Reaction::finish(status),
    }
    if !is_last {
        if yields && was_idle && status == neutral {
            return Reaction::Do { reset: Reset::None, resume: Resume::Next, then: Then::Again };
        }
        return Reaction::Next;
    }
    // BehaviorTree.CPP forgets skips when the node is reset, not when it fails: those before a failure still count.
    let all_skipped = memory.skipped == memory.children;
    memory.skipped = 0;
    Reaction::finish(if all_skipped { Status::Skipped } else { neutral })
}

fn react_parallel(kind: Kind, memory: &mut Memory, answer: Answer) -> Reaction {
    match answer.status {
        Some(Status::Skipped) => memory.skipped += 1,
        Some(Status::Failure) => memory.failures += 1,
        Some(Status::Success) => memory.count += 1,
        Some(Status::Running) | None => {}
    }
    if let Some(status) = memory.verdict(kind, answer.is_last) {
        (memory.count, memory.failures) = (0, 0);
        return Reaction::finish(status);
    }
    match answer.is_last {
        false => Reaction::Next,
        true if memory.skipped == memory.children => Reaction::answer(Status::Skipped),
        true => Reaction::answer(Status::Running),
    }
}

impl Memory {
    /// The result of a parallel node's children so far, if it is decided.
    fn verdict(&self, kind: Kind, is_last: bool) -> Option<Status> {
        let [children, skipped, successes, failures] =
            [self.children, self.skipped, self.count, self.failures].map(i64::from);
        let [first, second] = self.limits.map(|limit| threshold(limit, self.children));
        let verdict = |succeeds| if succeeds { Status::Success } else { Status::Failure };
        if kind == Kind::ParallelAll {
            let is_done = is_last && skipped < children && skipped + successes + failures >= children;
            return is_done.then(|| verdict(failures < first));
        }
        let counted = if self.limits[0] < 0 { successes + skipped } else { successes };
        if counted >= first {
            return Some(Status::Success);
        }
        (children - failures < first || failures == second).then_some(Status::Failure)
    }
}

fn react_other(kind: Kind, memory: &mut Memory, status: Status, answer: Answer) -> Reaction {
    use Status::{Running, Skipped};
    match (kind, status) {
        (Kind::IfThenElse | Kind::WhileDoElse, _) => react_conditional(kind, memory, status),
        (Kind::TryCatch, _) => react_try_catch(memory, status),
        (Kind::Switch(_), _) => {
            memory.at = if status == Running { memory.count + 1 } else { 0 };
            pass_on(status)
        }
        (Kind::Repeat | Kind::RetryUntilSuccessful, _) => react_repetition(kind, memory, status, answer),
        (Kind::Loop(_), _) => {
            memory.flag = status == Running;
            until_failure(status)
        }
        (Kind::KeepRunningUntilFailure, _) => until_failure(status),
        (Kind::SkipUnlessUpdated | Kind::WaitValueUpdate, _) => {
            memory.flag = status == Running;
            // If the child is done, it is reset after the answer, as that of any decorator.
            Reaction::answer(status)
        }
        (kind, _) if kind.is_of_nav2() => react_nav2(kind, memory, status, answer),

        (_, Running | Skipped) => Reaction::answer(status),
        (Kind::RunOnce, _) => {
            (memory.flag, memory.kept) = (true, Some(status));
            Reaction::finish(status)
        }
        (_, status) => {
            // A Delay or a Timeout starts again, and a Precondition is checked again.
            (memory.flag, memory.until) = (false, None);
            Reaction::finish(status)
        }
    }
}

/// The node passes on its child's answer.
fn pass_on(status: Status) -> Reaction {
    if status.is_completed() { Reaction::finish(status) } else { Reaction::answer(status) }
}

/// The node returns running unless its child fails.
fn until_failure(status: Status) -> Reaction {
    match status {
        Status::Failure => Reaction::finish(Status::Failure),
        Status::Success => Reaction::finish(Status::Running),
        Status::Running | Status::Skipped => Reaction::answer(Status::Running),
    }
}

fn react_conditional(kind: Kind, memory: &mut Memory, status: Status) -> Reaction {
    if status == Status::Running {
        return Reaction::answer(status);
    }
    if memory.at > 0 {
        memory.at = 0;
        return Reaction::finish(status);
    }
    let (chosen, other) = match status {
        Status::Success => (1, 2),
        Status::Failure => (2, 1),
        _ => return Reaction::fault("its condition was skipped"),
    };
    if chosen == memory.children {
        // There is no third child. An IfThenElse leaves its condition unchanged.
        return if kind == Kind::WhileDoElse { Reaction::finish(status) } else { Reaction::answer(status) };
    }
    memory.at = chosen;
    let reset = match kind {
        Kind::WhileDoElse if memory.children == 3 => Reset::Nth(other),
        _ => Reset::None,
    };
    Reaction::Do { reset, resume: Resume::Same, then: Then::Tick(Which::Nth(chosen)) }
}

fn react_try_catch(memory: &mut Memory, status: Status) -> Reaction {
    if memory.flag {
        if status == Status::Running {
            return Reaction::answer(status);
        }
        memory.flag = false;
        return Reaction::finish(Status::Failure);
    }
    // `at` counts the children of the sequence that are done; the last child, the catch block, is not among them.
    match status {
        Status::Running => Reaction::Do { reset: Reset::None, resume: Resume::Here, then: Then::Answer(status) },
        Status::Failure => {
            (memory.flag, memory.at) = (true, 0);
            Reaction::Do { reset: Reset::All, resume: Resume::First, then: Then::Tick(Which::Last) }
        }
        Status::Success | Status::Skipped => {
            memory.skipped += u32::from(status == Status::Skipped);
            memory.at += 1;
            if memory.at + 1 < memory.children {
                return Reaction::Next;
            }
            let all_skipped = memory.skipped == memory.at;
            (memory.at, memory.skipped) = (0, 0);
            Reaction::finish(if all_skipped { Status::Skipped } else { Status::Success })
        }
    }
}

fn react_repetition(kind: Kind, memory: &mut Memory, status: Status, answer: Answer) -> Reaction {
    if let PortReading::Numbers(limits) = answer.reading {
        memory.limits = limits;
    }
    let counted = if kind == Kind::Repeat { Status::Success } else { Status::Failure };
    match status {
        Status::Running => Reaction::answer(status),
        Status::Skipped => Reaction::finish(status),
        status if status == counted => {
            memory.count = memory.count.saturating_add(1);
            if !memory.may_go_on() {
                memory.count = 0;
                return Reaction::finish(status);
            }
            let then = if answer.was_idle { Then::Again } else { Then::Tick(Which::First) };
            Reaction::Do { reset: Reset::All, resume: Resume::First, then }
        }
        status => {
            memory.count = 0;
            Reaction::finish(status)
        }
    }
}
