//! The accuracy of localization on a course.

use std::time::Duration;

use super::{Course, Waypoint};
use crate::median;

/// An estimate with a greater error is considered lost, in meters and radians (30°).
const LOST_M: f64 = 1.0;
const LOST_RAD: f64 = 0.524;

/// An estimate with a smaller error is considered right, in meters and radians (15°).
const FOUND_M: f64 = 0.3;
const FOUND_RAD: f64 = 0.262;

/// The robot counts as found only if the error then stays that small for this distance, in meters, or to the end of a
/// shorter course.
const STAYS_M: f64 = 5.0;

/// A stretch of a course, by the times of its first and last scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The first scan.
    pub from: Duration,
    /// The last scan.
    pub to: Duration,
}

/// The errors of the estimates: over all scans if the start was known, otherwise over those after the robot was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Number of scans that count.
    pub scans: usize,
    /// Distance driven between the first and the last of them, in meters.
    pub driven_m: f64,
    /// Median error of position, in meters.
    pub median_m: f64,
    /// Root mean square of the distances, in meters.
    pub rmse_m: f64,
    /// The greatest distance, in meters.
    pub max_m: f64,
    /// Median error of heading, in radians.
    pub median_rad: f64,
    /// Root mean square of the heading errors, in radians.
    pub rmse_rad: f64,
    /// When estimates had an error of more than 1 m or 30°.
    pub lost: Vec<Stretch>,
    /// The first scan after which the estimate stayed within 0.3 m and 15° for at least 5 m (or to the end of a shorter
    /// course); none if there is no such scan.
    pub converged_at: Option<Duration>,
    /// How far the robot had driven by then, in meters.
    pub converged_after_m: Option<f64>,
}

impl Score {
    /// The score of a course. All scans count if the robot was never found, or if its start was known.
    #[must_use]
    pub fn of(course: &Course) -> Self {
        let all = &course.waypoints;
        let found = converged(all);
        let counted = &all[found.filter(|_| course.from_nothing).unwrap_or(0)..];
        let meters = sorted(counted.iter().map(Waypoint::error_m));
        let radians = sorted(counted.iter().map(Waypoint::error_rad));
        Self {
            scans: counted.len(),
            driven_m: driven_m(counted),
            median_m: median(meters.iter().copied()).unwrap_or_default(),
            rmse_m: root_mean_square(&meters),
            max_m: meters.last().copied().unwrap_or_default(),
            median_rad: median(radians.iter().copied()).unwrap_or_default(),
            rmse_rad: root_mean_square(&radians),
            lost: lost(counted),
            converged_at: found.map(|found| all[found].time),
            converged_after_m: found.map(|found| driven_m(&all[..=found])),
        }
    }
}

/// The distance along waypoints, in meters.
fn driven_m(waypoints: &[Waypoint]) -> f64 {
    let step = |pair: &[Waypoint]| (pair[1].corrected.translation.vector - pair[0].corrected.translation.vector).norm();
    waypoints.windows(2).map(step).fold(0.0, |driven_m, step_m| driven_m + step_m)
}

fn converged(all: &[Waypoint]) -> Option<usize> {
    let mut since: Option<usize> = None;
    let stays_m = STAYS_M.min(driven_m(all));
    for (index, waypoint) in all.iter().enumerate() {
        if waypoint.error_m() > FOUND_M || waypoint.error_rad() > FOUND_RAD {
            since = None;
            continue;
        }
        let first = *since.get_or_insert(index);
        if driven_m(&all[first..=index]) >= stays_m {
            return since;
        }
    }
    None
}

fn lost(waypoints: &[Waypoint]) -> Vec<Stretch> {
    let is_lost = |waypoint: &Waypoint| waypoint.error_m() > LOST_M || waypoint.error_rad() > LOST_RAD;
    let stretches = waypoints.chunk_by(|a, b| is_lost(a) == is_lost(b)).filter(|stretch| is_lost(&stretch[0]));
    stretches.map(|stretch| Stretch { from: stretch[0].time, to: stretch[stretch.len() - 1].time }).collect()
}

fn sorted(errors: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = errors.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

fn root_mean_square(numbers: &[f64]) -> f64 {
    (numbers.iter().map(|number| number * number).sum::<f64>() / numbers.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use maps::pose;
    use nalgebra::Matrix3;

    use super::*;

    /// A drive along x, with one scan per meter and second and these errors to the side.
    fn course(errors_m: &[f64]) -> Course {
        let waypoint = |(second, error_m): (usize, &f64)| {
            let corrected = pose(second as f64, 0.0, 0.0);
            let (line, time) = (second + 1, Duration::from_secs(second as u64));
            let estimate = pose(second as f64, *error_m, 0.02);
            Waypoint { line, time, corrected, estimate, covariance: Matrix3::zeros(), odometry: corrected }
        };
        Course { waypoints: errors_m.iter().enumerate().map(waypoint).collect(), updates: 0, from_nothing: true }
    }

    #[test]
    fn a_robot_found_late_is_scored_from_then_on() {
        let score = Score::of(&course(&[7.0, 0.1, 7.0, 0.1, 0.2, 0.0, 0.1, 0.1, 0.1, 2.0, 3.0, 0.1]));
        assert_eq!(score.converged_at, Some(Duration::from_secs(3)), "one scan in passing does not count");
        assert_eq!((score.scans, score.converged_after_m), (9, Some(3.0)));
        assert_eq!(score.lost, [Stretch { from: Duration::from_secs(9), to: Duration::from_secs(10) }]);
        assert!((score.median_m - 0.1).abs() < 1e-12 && (score.max_m - 3.0).abs() < 1e-12);
        assert!((score.rmse_rad - 0.02).abs() < 1e-12);
    }

    #[test]
    fn a_robot_whose_start_is_known_is_scored_from_the_start() {
        let known = Course { from_nothing: false, ..course(&[7.0, 7.0, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]) };
        let score = Score::of(&known);
        assert_eq!((score.scans, score.converged_at), (9, Some(Duration::from_secs(2))));
        assert_eq!(score.lost, [Stretch { from: Duration::ZERO, to: Duration::from_secs(1) }]);
    }

    #[test]
    fn a_few_good_scans_at_the_end_are_not_enough() {
        let score = Score::of(&course(&[7.0, 7.0, 7.0, 7.0, 7.0, 7.0, 0.1, 0.1, 0.1]));
        assert_eq!((score.scans, score.converged_at), (9, None));
        assert_eq!(Score::of(&course(&[0.1, 0.1, 0.1])).converged_at, Some(Duration::ZERO), "all of a short course");
    }

    #[test]
    fn a_robot_that_is_never_found_is_lost_all_the_way() {
        let score = Score::of(&course(&[7.0; 20]));
        assert_eq!((score.converged_at, score.scans), (None, 20));
        assert_eq!(score.lost, [Stretch { from: Duration::ZERO, to: Duration::from_secs(19) }]);
    }
}
