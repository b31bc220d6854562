//! Moments of real time, in which others live.

use std::time::Instant;

/// Now.
#[expect(clippy::disallowed_methods, reason = "other programs live in real time")]
pub(crate) fn moment() -> Instant {
    Instant::now()
}
