//! The inputs of an update.

use std::time::Duration;

use maps::{Point, Pose};
use robot::Odometry;

/// The inputs of an update.
#[derive(Clone, Copy)]
pub(super) struct Now<'a> {
    pub(super) time: Duration,
    pub(super) at: &'a Pose,
    pub(super) odometry: &'a Odometry,
}

impl Now<'_> {
    pub(super) fn position(&self) -> Point {
        self.at.translation.vector.into()
    }
}
