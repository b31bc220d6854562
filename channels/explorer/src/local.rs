//! A state of a process or a monitor, with everything computed about it.

use std::time::Duration;

use channels::{Monitor, Pattern, Process, TransitionId, Verdict};

/// The number of a state that has not been computed yet.
pub(crate) const UNKNOWN: u32 = u32::MAX;
/// In place of a state's number: the message is not accepted.
pub(crate) const REFUSED: u32 = u32::MAX - 1;

/// The next state of a process, and how the numbers of its requests change for its peers: 0 if they do not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Step {
    pub(crate) next: u32,
    pub(crate) renaming: u32,
}

impl Step {
    pub(crate) const UNKNOWN: Self = Self { next: UNKNOWN, renaming: 0 };
    pub(crate) const REFUSED: Self = Self { next: REFUSED, renaming: 0 };
}

/// A state of a process in normal form, with what it offers.
#[derive(Debug)]
pub(crate) struct Local {
    pub(crate) process: Box<dyn Process>,
    /// The time until its next timer fires.
    pub(crate) timer: Option<Duration>,
    /// Whether it stays the same while time passes.
    pub(crate) is_timeless: bool,
    /// Steps that it can take alone: internal actions, and sends.
    pub(crate) own: Vec<Own>,
    pub(crate) receives: Vec<Receive>,
    /// The channels of the receives: bit `channel % 64` for each.
    pub(crate) awaits: u64,
    /// Its state after a span of time, by the number of the span.
    pub(crate) later: Vec<Step>,
    /// Its state after the environment reports a number to it, by the number.
    pub(crate) reported: Vec<Step>,
    /// Its state after the numbers of requests change, by the number of the renaming.
    pub(crate) renamed: Vec<u32>,
    /// The state of a tick generator when a tick is due.
    pub(crate) ticked: u32,
}

/// An internal action, or a send.
#[derive(Debug)]
pub(crate) struct Own {
    pub(crate) transition: TransitionId,
    /// The channel and the number of the message.
    pub(crate) sends: Option<(usize, u32)>,
    pub(crate) step: Step,
}

#[derive(Debug)]
pub(crate) struct Receive {
    pub(crate) transition: TransitionId,
    pub(crate) channel: usize,
    pub(crate) pattern: Pattern,
    /// By the number of the message.
    pub(crate) steps: Vec<Step>,
}

/// A state of a monitor in normal form.
#[derive(Debug)]
pub(crate) struct Watching {
    pub(crate) monitor: Box<dyn Monitor>,
    pub(crate) verdict: Verdict,
    /// By channel, and then by the number of the message.
    pub(crate) after: Vec<Vec<u32>>,
    /// After the first tick, and after any later one.
    pub(crate) ticked: [u32; 2],
}

/// A channel in a set of channels. Some channels share a bit: the set determines which ones it surely does not contain.
#[inline]
pub(crate) fn bit(channel: usize) -> u64 {
    1 << (channel % 64)
}

/// The entry at an index; unknown if the list is too short.
#[inline]
pub(crate) fn entry<T: Copy>(list: &[T], index: u32, unknown: T) -> T {
    list.get(index as usize).copied().unwrap_or(unknown)
}

/// Sets the entry at an index. Missing entries before it become unknown.
pub(crate) fn set<T: Copy>(list: &mut Vec<T>, index: u32, value: T, unknown: T) {
    let index = index as usize;
    if list.len() <= index {
        list.resize(index + 1, unknown);
    }
    list[index] = value;
}
