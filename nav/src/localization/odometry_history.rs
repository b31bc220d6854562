//! The odometry of the last two seconds, for the poses of scans.

use std::collections::VecDeque;
use std::time::Duration;

use maps::{Pose, heading, pose, wrap_angle};
use robot::Odometry;

/// How long readings are kept.
const KEPT: Duration = Duration::from_secs(2);

/// Readings that fit without further memory: 128 per second.
const ROOM: usize = 256;

/// How far odometry is extrapolated by its velocity. Later times are out of step with it.
const EXTRAPOLATED: Duration = Duration::from_millis(250);

/// Recent odometry, oldest first.
#[derive(Clone, Debug)]
pub(crate) struct OdometryHistory {
    readings: VecDeque<Odometry>,
}

impl OdometryHistory {
    pub(crate) fn new() -> Self {
        Self { readings: VecDeque::with_capacity(ROOM) }
    }

    /// Adds a reading. If it is older than the last one (a clock was set back), the history starts over.
    pub(crate) fn push(&mut self, odometry: Odometry) {
        if self.latest().is_some_and(|last| odometry.time < last.time) {
            self.readings.clear();
        }
        let oldest = odometry.time.saturating_sub(KEPT);
        // The last one before that time is kept for interpolation.
        while self.readings.get(1).is_some_and(|second| second.time <= oldest) {
            self.readings.pop_front();
        }
        self.readings.push_back(odometry);
    }

    pub(crate) fn latest(&self) -> Option<&Odometry> {
        self.readings.back()
    }

    /// The pose in the `odom` frame at `time`: interpolated between readings, or extrapolated for a moment after the
    /// latest. `None` before the oldest reading, and beyond the extrapolation limit.
    pub(crate) fn pose_at(&self, time: Duration) -> Option<Pose> {
        let before = self.readings.iter().rposition(|reading| reading.time <= time)?;
        let reading = self.readings.get(before)?;
        match self.readings.get(before + 1) {
            Some(after) => Some(between(reading, after, time)),
            None => (time - reading.time <= EXTRAPOLATED).then(|| extrapolated(reading, time)),
        }
    }
}

fn between(before: &Odometry, after: &Odometry, time: Duration) -> Pose {
    let share = (time - before.time).as_secs_f64() / (after.time - before.time).as_secs_f64();
    let way = after.pose.translation.vector - before.pose.translation.vector;
    let at = before.pose.translation.vector + way * share;
    let turn = wrap_angle(heading(&after.pose) - heading(&before.pose));
    pose(at.x, at.y, heading(&before.pose) + turn * share)
}

fn extrapolated(latest: &Odometry, time: Duration) -> Pose {
    let ahead_s = (time - latest.time).as_secs_f64();
    if ahead_s <= 0.0 {
        return latest.pose;
    }
    // A short arc is replaced with its chord, whose direction is that of the middle of the arc.
    let turn = latest.angular_radps * ahead_s;
    latest.pose * pose(0.0, 0.0, turn / 2.0) * pose(latest.linear_mps * ahead_s, 0.0, turn / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(time_ms: u64, x_m: f64, heading_rad: f64) -> Odometry {
        let time = Duration::from_millis(time_ms);
        Odometry { time, pose: pose(x_m, 0.0, heading_rad), linear_mps: 0.4, angular_radps: 0.0 }
    }

    #[test]
    fn poses_are_interpolated_and_extrapolated() {
        let mut history = OdometryHistory::new();
        assert!(history.pose_at(Duration::ZERO).is_none());
        history.push(reading(100, 1.0, 3.1));
        history.push(reading(120, 1.1, -3.1));
        let at = |time_ms| history.pose_at(Duration::from_millis(time_ms));
        let between = at(110).unwrap();
        assert!((between.translation.x - 1.05).abs() < 1e-12);
        assert!(heading(&between).abs() > 3.13, "the turn goes the short way round: {}", heading(&between));
        assert!((at(170).unwrap().translation.x - (1.1 + 0.4 * 0.05 * libm::cos(3.1))).abs() < 1e-12);
        assert!(at(370).is_some() && at(371).is_none(), "only for a moment");
        assert!(at(100).is_some() && at(99).is_none(), "nothing is known about the time before");
    }

    #[test]
    fn readings_are_kept_for_two_seconds_however_many_there_are() {
        let mut history = OdometryHistory::new();
        (0..5000).for_each(|time_ms| history.push(reading(time_ms, time_ms as f64, 0.0)));
        let x_m = |time_ms| history.pose_at(Duration::from_millis(time_ms)).map(|pose| pose.translation.x);
        assert_eq!([2999, 3500, 4999].map(x_m), [2999.0, 3500.0, 4999.0].map(Some));
        assert_eq!(x_m(2990), None);
        assert!(history.readings.len() < 2010);
    }

    #[test]
    fn a_clock_set_back_starts_over() {
        let mut history = OdometryHistory::new();
        history.push(reading(5000, 9.0, 0.0));
        history.push(reading(20, 1.0, 0.0));
        assert!((history.pose_at(Duration::from_millis(20)).unwrap().translation.x - 1.0).abs() < 1e-12);
    }
}
