//! The time at which messages are received.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A clock that counts nanoseconds since 1970 and never goes back: the system's is read only once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    started: Instant,
    started_ns: i64,
}

impl Clock {
    #[expect(clippy::disallowed_methods, reason = "messages are received in real time")]
    pub(crate) fn start() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { started: now(), started_ns: nanoseconds(since) }
    }

    pub(crate) fn now_ns(&self) -> i64 {
        self.started_ns.saturating_add(nanoseconds(self.started.elapsed()))
    }
}

#[expect(clippy::disallowed_methods, reason = "a robot is waited for in real time")]
pub(crate) fn now() -> Instant {
    Instant::now()
}

#[expect(clippy::disallowed_methods, reason = "a robot is waited for in real time")]
pub(crate) fn sleep(time: Duration) {
    std::thread::sleep(time);
}

fn nanoseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}
