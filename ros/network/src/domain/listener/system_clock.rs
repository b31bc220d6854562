//! The system's clock, which may be set back: rustdds holds samples back until it has caught up.

use rustdds::Timestamp;

use crate::clock::Clock;
use crate::domain::readers::{Readers, nanoseconds};

/// How long it may take to read two clocks, in nanoseconds.
const LONGEST_READING: i64 = 1_000_000;

/// The longest step back that does not matter.
const LONGEST_STEP: i64 = 50_000_000;

/// The system's clock, compared with ours.
pub(super) struct SystemClock {
    clock: Clock,
    /// The system's clock minus ours.
    offset_ns: i64,
    /// The time of our clock at which the system's has caught up, if that was set back a little.
    behind_ns: i64,
}

impl SystemClock {
    pub(super) fn beside(clock: Clock) -> Self {
        let offset_ns = nanoseconds(Timestamp::now()) - clock.now_ns();
        Self { clock, offset_ns, behind_ns: i64::MIN }
    }

    /// Why rustdds would hold samples back for long, if it would: the clock was set back. After a small step back, the
    /// readers are read until it has caught up.
    pub(super) fn is_set_back(&mut self, readers: &Readers) -> Option<String> {
        let before_ns = self.clock.now_ns();
        let system_ns = nanoseconds(Timestamp::now());
        if self.clock.now_ns().saturating_sub(before_ns) > LONGEST_READING {
            // The thread was interrupted between the two readings.
            return None;
        }
        let back_ns = self.offset_ns - (system_ns - before_ns);
        self.offset_ns -= back_ns;
        if back_ns > LONGEST_READING {
            self.behind_ns = before_ns.saturating_add(2 * back_ns);
        }
        if before_ns <= self.behind_ns {
            // Samples that rustdds holds back do not wake the thread once they can be read.
            readers.wake_all();
        }
        let words = || format!("the clock of this machine was set back by {:.3} s", back_ns as f64 * 1e-9);
        (back_ns > LONGEST_STEP).then(words)
    }
}
