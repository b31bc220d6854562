//! Global localization from many starts: how far a robot without an initial pose must drive until it is found.

use std::sync::Arc;
use std::time::Duration;

use nav::Atlas;
use robot::recorded::Recording;

use super::{Conditions, RecordingPart, Score, replay_part};

/// A robot must be found within this distance, in meters.
pub const WITHIN_M: f64 = 15.0;

/// The robot is followed for this much longer, in meters: it counts as found only if it stays found for 5 m, and the
/// next scan may come a little later.
const FOLLOWED_M: f64 = 7.0;

/// A start and its result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The line in the log where it is.
    pub line: usize,
    /// Time since the log's start.
    pub time: Duration,
    /// The distance after which the estimate was right and stayed right, in meters; none if there was no such distance
    /// while the robot was followed.
    pub found_after_m: Option<f64>,
}

impl Start {
    /// Whether the robot was found in time.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.found_after_m.is_some_and(|driven_m| driven_m <= WITHIN_M)
    }
}

/// Tries a number of starts, evenly distributed over the distance of the log. Each has its own random numbers.
#[must_use]
pub fn try_starts(recording: &Arc<Recording>, atlas: &Arc<Atlas>, conditions: &Conditions, count: usize) -> Vec<Start> {
    let scans: Vec<_> =
        recording.corrected_scans().map(|(record, _, pose)| (record, pose.translation.vector)).collect();
    let mut distances_m = Vec::with_capacity(scans.len());
    let mut driven_m = 0.0;
    for (index, (_, position)) in scans.iter().enumerate() {
        driven_m += scans[index.saturating_sub(1)].1.metric_distance(position);
        distances_m.push(driven_m);
    }
    let room_m = (driven_m - WITHIN_M - FOLLOWED_M).max(0.0);
    let start = |number: usize| {
        let first = distances_m.partition_point(|driven_m| *driven_m < room_m * number as f64 / count as f64);
        let conditions = Conditions { global: true, seed: conditions.seed.wrapping_add(number as u64), ..*conditions };
        let course =
            replay_part(recording, atlas, &conditions, RecordingPart { first, driven_m: WITHIN_M + FOLLOWED_M });
        let (record, _) = scans[first];
        Start { line: record.line, time: record.time, found_after_m: Score::of(&course).converged_after_m }
    };
    let numbers: Vec<usize> = (0..if scans.is_empty() { 0 } else { count }).collect();
    batch::run(&numbers, |number| start(*number), |_| {})
}
