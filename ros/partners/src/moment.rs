//! Moments of real time, in which other programs live.

use std::time::Instant;

/// Now.
#[expect(clippy::disallowed_methods, reason = "nodes of ROS 2 live in real time")]
pub(crate) fn moment() -> Instant {
    Instant::now()
}
