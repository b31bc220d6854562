//! A number that changes continuously.

use std::time::Duration;

/// The simplified line is never farther from the noted values than this.
const TOLERANCE: f64 = 0.05;

/// A number over time, as a line through few points: where it is straight, only the ends are kept.
///
/// The points are chosen by a swing filter (Elmeleegy et al., "Online piece-wise linear approximation of numerical
/// streams with precision guarantees", 2009), whose ends are noted values.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Course {
    points: Vec<(Duration, f64)>,
    /// The latest value, if it is not a point.
    latest: Option<(Duration, f64)>,
    /// The range of slopes, per second, of lines from the last point that come close enough to all values after it.
    slopes: Option<(f64, f64)>,
}

impl Course {
    /// Notes the value now. Times must increase.
    pub fn note(&mut self, now: Duration, value: f64) {
        let Some(&(since, from)) = self.points.last() else {
            self.points.push((now, value));
            return;
        };
        let elapsed_s = now.saturating_sub(since).as_secs_f64();
        if elapsed_s <= 0.0 {
            return;
        }
        // Every line from the last point within the range of slopes comes close enough to all values since. The range
        // shrinks with each value; one that lies outside it needs a new point, at the value before it.
        let slope = |value: f64| (value - from) / elapsed_s;
        let (low, high) = (slope(value - TOLERANCE), slope(value + TOLERANCE));
        match self.slopes {
            Some((least, most)) if slope(value) < least || slope(value) > most => {
                self.points.extend(self.latest.take());
                self.slopes = None;
                self.note(now, value);
            }
            Some((least, most)) => {
                self.slopes = Some((least.max(low), most.min(high)));
                self.latest = Some((now, value));
            }
            None => {
                self.slopes = Some((low, high));
                self.latest = Some((now, value));
            }
        }
    }

    /// The points of the line, oldest first.
    #[must_use]
    pub fn points(&self) -> Vec<(Duration, f64)> {
        self.points.iter().chain(&self.latest).copied().collect()
    }

    pub(super) fn until(&self, time: Duration) -> Self {
        let points = self.points.iter().copied().filter(|(at, _)| *at <= time).collect();
        let latest = self.latest.filter(|(at, _)| *at <= time).or_else(|| Some((time, self.at(time)?)));
        Self { points, latest, slopes: None }
    }

    /// The value at a time; `None` without points.
    #[must_use]
    pub fn at(&self, time: Duration) -> Option<f64> {
        let points = self.points();
        let after = points.partition_point(|(at, _)| *at <= time);
        let (before, next) = (points.get(after.saturating_sub(1))?, points.get(after));
        let Some(next) = next.filter(|_| after > 0) else { return Some(before.1) };
        let part = (time - before.0).as_secs_f64() / (next.0 - before.0).as_secs_f64();
        Some(before.1 + (next.1 - before.1) * part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(values: impl IntoIterator<Item = (f64, f64)>) -> Course {
        let mut course = Course::default();
        for (time_s, value) in values {
            course.note(Duration::from_secs_f64(time_s), value);
        }
        course
    }

    #[test]
    fn a_straight_line_has_two_points() {
        let line = course((0..10_000).map(|i| f64::from(i) * 0.02).map(|time_s| (time_s, 80.0 - 0.05 * time_s)));
        assert_eq!(line.points().len(), 2);
    }

    #[test]
    fn a_step_stays_steep() {
        let level = |time_s: f64| if time_s < 20.5 { 80.0 - 0.05 * time_s } else { 10.0 - 0.05 * (time_s - 20.5) };
        let line = course((0..5000).map(|i| f64::from(i) * 0.02).map(|time_s| (time_s, level(time_s))));
        let points = line.points();
        assert!(points.len() <= 6, "{points:?}");
        let step = points.windows(2).find(|pair| pair[0].1 - pair[1].1 > 60.0).expect("the step exists");
        assert!(step[1].0 - step[0].0 <= Duration::from_millis(21), "{step:?}");
    }

    #[test]
    fn the_line_comes_close_to_every_value() {
        let value = |time_s: f64| 50.0 + time_s * (40.0 - time_s) / 10.0;
        let values: Vec<(f64, f64)> =
            (0..2000).map(|i| f64::from(i) * 0.02).map(|time_s| (time_s, value(time_s))).collect();
        let line = course(values.iter().copied());
        assert!(line.points().len() < 100, "{} points", line.points().len());
        for (time_s, value) in values {
            let drawn = line.at(Duration::from_secs_f64(time_s)).expect("there are points");
            assert!((drawn - value).abs() <= 2.0 * TOLERANCE, "{drawn} for {value} at {time_s} s");
        }
    }
}
