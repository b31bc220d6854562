//! One trip to one goal.

use std::time::Duration;

use maps::Point;

use super::Goal;
use crate::following::Follower;

/// What belongs to one goal.
#[derive(Clone, Debug)]
pub(super) struct Trip {
    pub(super) goal: Goal,
    pub(super) follower: Option<Follower>,
    pub(super) started: Option<Duration>,
    /// When the present status began.
    pub(super) since: Duration,
    /// When the robot last could not move, since it last could.
    pub(super) stuck_since: Option<Duration>,
    /// What keeps the robot from moving.
    pub(super) obstacle: Option<Point>,
    /// When the way was seen to be free again, since it last was not.
    pub(super) free_since: Option<Duration>,
    pub(super) next_plan: Duration,
    /// The least way left so far on this path, and when it was reached.
    pub(super) least_left_m: f64,
    pub(super) progress_at: Duration,
    pub(super) stalls: u32,
    pub(super) blockages: u32,
    pub(super) forgotten: u32,
    /// The costmap's generation at the last look along the path, and what was seen: the way to what blocks it.
    pub(super) looked_at: Option<u64>,
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
            forgotten: 0,
            looked_at: None,
            blocked_m: None,
        }
    }
}
