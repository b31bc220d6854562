//! The time at which messages are received.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A clock that counts nanoseconds since 1970 and never goes back: it reads the system's clock only once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    started: Instant,
    started_ns: i64,
}

impl Clock {
    pub(crate) fn start() -> Self {
        Self { started: now(), started_ns: system_ns() }
    }

    /// A clock that is `ahead_ns` nanoseconds ahead of the system's. It agrees with an earlier clock that is as far
    /// ahead.
    #[cfg(feature = "dds")]
    pub(crate) fn ahead(ahead_ns: i64) -> Self {
        Self { started: now(), started_ns: system_ns().saturating_add(ahead_ns) }
    }

    /// How far it is ahead of the system's clock.
    #[cfg(feature = "dds")]
    pub(crate) fn is_ahead_ns(&self) -> i64 {
        self.now_ns().saturating_sub(system_ns())
    }

    pub(crate) fn now_ns(&self) -> i64 {
        self.started_ns.saturating_add(nanoseconds(self.started.elapsed()))
    }
}

#[expect(clippy::disallowed_methods, reason = "messages are received in real time")]
pub(crate) fn system_ns() -> i64 {
    nanoseconds(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default())
}

/// The current moment of real time.
#[expect(clippy::disallowed_methods, reason = "a robot is waited for in real time")]
#[must_use]
pub fn now() -> Instant {
    Instant::now()
}

#[expect(clippy::disallowed_methods, reason = "a robot is waited for in real time")]
pub(crate) fn sleep(time: Duration) {
    std::thread::sleep(time);
}

fn nanoseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}
