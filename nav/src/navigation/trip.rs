//! One trip to one goal.

use std::time::Duration;

use maps::Point;

use super::recovery::Attempt;
use crate::Goal;
use crate::following::Follower;

/// The robot waits in the same place again if it has moved less than this, in meters.
const SAME_PLACE_M: f64 = 0.5;

/// This many futile waits in the same place are enough.
const WAITS_IN_VAIN: u32 = 2;

/// The data of one goal.
#[derive(Clone, Debug)]
pub(super) struct Trip {
    pub(super) goal: Goal,
    pub(super) follower: Option<Follower>,
    pub(super) started: Option<Duration>,
    /// When the current status began.
    pub(super) since: Duration,
    /// When the robot became unable to move.
    pub(super) stuck_since: Option<Duration>,
    /// The obstacle that keeps the robot from moving.
    pub(super) obstacle: Option<Point>,
    /// When the path became free again.
    pub(super) free_since: Option<Duration>,
    pub(super) next_plan: Duration,
    /// The shortest remaining distance so far on this path, and when it was reached.
    pub(super) least_left_m: f64,
    pub(super) progress_at: Duration,
    pub(super) stalls: u32,
    pub(super) blockages: u32,
    /// The current recovery behavior, and the number of them since the path was lost.
    pub(super) attempt: Option<Attempt>,
    pub(super) recoveries: usize,
    /// Where the robot last waited in vain, and how often it has waited there.
    waited_at: Option<Point>,
    waits_in_vain: u32,
    /// The costmap's generation and the remaining distance at the last check of the path, in meters, and the result:
    /// the distance to the blockage.
    pub(super) looked: Option<(u64, f64)>,
    pub(super) blocked_m: Option<f64>,
}

impl Trip {
    pub(super) fn new(goal: Goal) -> Self {
        Self {
            goal,
            follower: None,
            started: None,
            since: Duration::ZERO,
            stuck_since: None,
            obstacle: None,
            free_since: None,
            next_plan: Duration::ZERO,
            least_left_m: f64::INFINITY,
            progress_at: Duration::ZERO,
            stalls: 0,
            blockages: 0,
            attempt: None,
            recoveries: 0,
            waited_at: None,
            waits_in_vain: 0,
            looked: None,
            blocked_m: None,
        }
    }

    /// Records a futile wait. Returns true if this has happened so often here that waiting is no longer useful.
    pub(super) fn wait_in_vain(&mut self, at: &Point) -> bool {
        if self.waited_at.is_none_or(|before| (before - at).norm() > SAME_PLACE_M) {
            (self.waited_at, self.waits_in_vain) = (Some(*at), 0);
        }
        self.waits_in_vain += 1;
        self.waits_in_vain.is_multiple_of(WAITS_IN_VAIN)
    }
}
