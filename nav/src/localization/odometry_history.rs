//! The odometry of the last second or so, to be asked for the pose at a scan's time.

use std::collections::VecDeque;
use std::time::Duration;

use maps::{Pose, heading, pose, wrap_angle};
use robot::Odometry;

/// How many readings are kept: 1.28 s at 50 Hz.
const KEPT: usize = 64;

/// How far odometry is extrapolated by its velocity, in seconds.
const EXTRAPOLATED_S: f64 = 0.1;

/// Recent odometry, oldest first.
#[derive(Clone, Debug)]
pub(crate) struct OdometryHistory {
    readings: VecDeque<Odometry>,
}

impl OdometryHistory {
    pub(crate) fn new() -> Self {
        Self { readings: VecDeque::with_capacity(KEPT) }
    }

    /// Takes in a reading. One that is older than the last (a clock that was set back) starts the history anew.
    pub(crate) fn push(&mut self, odometry: Odometry) {
        if self.latest().is_some_and(|last| odometry.time < last.time) {
            self.readings.clear();
        }
        if self.readings.len() == KEPT {
            self.readings.pop_front();
        }
        self.readings.push_back(odometry);
    }

    pub(crate) fn latest(&self) -> Option<&Odometry> {
        self.readings.back()
    }

    /// The pose in the `odom` frame at `time`: interpolated between readings, held before the oldest, extrapolated for
    /// a moment after the latest. `None` while there is no reading.
    pub(crate) fn pose_at(&self, time: Duration) -> Option<Pose> {
        let after = self.readings.iter().rposition(|reading| reading.time <= time).map_or(0, |before| before + 1);
        let before = after.checked_sub(1).and_then(|before| self.readings.get(before));
        match (before, self.readings.get(after)) {
            (Some(before), Some(after)) => Some(between(before, after, time)),
            (Some(latest), None) => Some(extrapolated(latest, time)),
            (None, oldest) => oldest.map(|reading| reading.pose),
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
    let ahead_s = (time - latest.time).as_secs_f64().min(EXTRAPOLATED_S);
    if ahead_s <= 0.0 {
        return latest.pose;
    }
    // A short arc is its chord, seen from halfway round.
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
    fn poses_are_interpolated_held_and_extrapolated() {
        let mut history = OdometryHistory::new();
        assert!(history.pose_at(Duration::ZERO).is_none());
        history.push(reading(100, 1.0, 3.1));
        history.push(reading(120, 1.1, -3.1));
        let at = |time_ms| history.pose_at(Duration::from_millis(time_ms)).unwrap();
        assert!((at(110).translation.x - 1.05).abs() < 1e-12);
        assert!(heading(&at(110)).abs() > 3.13, "the turn goes the short way round: {}", heading(&at(110)));
        assert!((at(50).translation.x - 1.0).abs() < 1e-12);
        assert!((at(170).translation.x - (1.1 + 0.4 * 0.05 * libm::cos(3.1))).abs() < 1e-12);
        assert!((at(900).translation.x - at(220).translation.x).abs() < 1e-12, "only for a moment");
    }

    #[test]
    fn a_clock_set_back_starts_anew() {
        let mut history = OdometryHistory::new();
        history.push(reading(5000, 9.0, 0.0));
        history.push(reading(20, 1.0, 0.0));
        assert!((history.pose_at(Duration::from_millis(20)).unwrap().translation.x - 1.0).abs() < 1e-12);
    }
}
