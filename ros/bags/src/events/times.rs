//! When events are, and their numbers.

use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Message};

/// A stamp that is more ticks away than this is considered wrong.
const LONGEST_PAUSE: i64 = 10_000_000;

/// The ticks and messages that have been returned. The run begins with the first message.
pub(super) struct EventTimes {
    tick_ns: i64,
    pub(super) start_ns: Option<i64>,
    last_ns: i64,
    ticks: u64,
    steps: u64,
}

impl EventTimes {
    pub(super) fn of(tick_ns: i64) -> Self {
        Self { tick_ns, start_ns: None, last_ns: 0, ticks: 0, steps: 0 }
    }

    pub(super) fn since_start(&self, time_ns: i64) -> Duration {
        let start_ns = self.start_ns.unwrap_or(time_ns);
        Duration::from_nanos(time_ns.max(start_ns).abs_diff(start_ns))
    }

    /// Whether a time is wrong: it must not open a pause of millions of ticks, nor make all other messages late.
    /// `next_ns` is the time of what comes next, if something waits.
    pub(super) fn is_far_off(&self, time_ns: i64, next_ns: Option<i64>) -> bool {
        let Some(reference_ns) = next_ns.or(self.start_ns.and(Some(self.last_ns))) else { return false };
        let pause_ns = time_ns.saturating_sub(reference_ns).saturating_abs();
        pause_ns > self.tick_ns.saturating_mul(LONGEST_PAUSE)
    }

    /// When something of this time is returned: not before what has been.
    pub(super) fn in_order(&self, time_ns: i64) -> i64 {
        if self.ticks == 0 { time_ns } else { time_ns.max(self.last_ns) }
    }

    /// The next tick, if it is due by this time: never, if it would come after the last time that there is.
    pub(super) fn tick(&mut self, by_ns: i64) -> Option<Event> {
        let tick_ns = i128::from(self.start_ns?) + i128::from(self.ticks) * i128::from(self.tick_ns);
        let tick_ns = i64::try_from(tick_ns).ok().filter(|tick_ns| *tick_ns <= by_ns)?;
        let event =
            Event { step: self.steps, tick: self.ticks, time: self.since_start(tick_ns), kind: EventKind::Tick };
        self.ticks += 1;
        self.last_ns = tick_ns;
        Some(event)
    }

    /// The next message.
    pub(super) fn message(&mut self, now_ns: i64, channel: ChannelId, message: Message) -> Event {
        self.last_ns = now_ns;
        self.steps += 1;
        let kind = EventKind::Received { channel, message };
        Event { step: self.steps, tick: self.ticks - 1, time: self.since_start(now_ns), kind }
    }
}
