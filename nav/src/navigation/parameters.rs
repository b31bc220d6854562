//! The parameters of the navigator.

use std::time::Duration;

use robot::RobotModel;

use crate::error::{check, require};
use crate::{CostmapParameters, Error, FollowingParameters};

/// Parameters of a [`Navigator`](crate::Navigator). All times are in simulated time, or the robot's time.
#[derive(Clone, Debug, PartialEq)]
pub struct NavigationParameters {
    /// How obstacles are inflated, marked and cleared.
    pub costmap: CostmapParameters,
    /// How paths are followed.
    pub following: FollowingParameters,
    /// How long to wait for an obstacle to go away before searching for another path. Default 4 s: a person walking by
    /// takes less.
    pub obstacle_patience: Duration,
    /// A detour that is longer than the rest of the path by at most this is taken without waiting, in meters. Default
    /// 2.
    pub detour_m: f64,
    /// Shortest time between two searches for a detour. Default 1 s.
    pub planning_period: Duration,
    /// How long to recover and retry when there is no path, while obstacles seen by lasers may be the reason. Default
    /// 90 s: four times through all recovery behaviors. Many people who talk in a doorway or at the robot's goal are
    /// still there after half of it. If the map alone is the reason, retrying is pointless and skipped.
    pub failing_patience: Duration,
    /// How long the robot may go without getting nearer to its goal before the path is replanned; the next time,
    /// recovery begins. After `stalls` such periods it gives up. Default 10 s.
    pub progress_patience: Duration,
    /// The maximum number of times in a row that progress may stop. Default 3.
    pub stalls: u32,
    /// The maximum number of blockages on one trip. Default 300: among people, the path is blocked every few seconds.
    pub blockages: u32,
    /// How long a laser may be silent while driving before the robot counts as blind where only that laser looks: it
    /// cannot continue without a laser that looks ahead, nor back up without one that looks behind. Default 1 s: ten
    /// scans of the default robot; at least three scans of the slowest laser.
    pub scan_patience: Duration,
    /// The path is replanned if the robot is farther from it than this, in meters. Default 0.5: it was pushed or driven
    /// away.
    pub off_path_m: f64,
}

impl Default for NavigationParameters {
    fn default() -> Self {
        Self {
            costmap: CostmapParameters::default(),
            following: FollowingParameters::default(),
            obstacle_patience: Duration::from_secs(4),
            detour_m: 2.0,
            planning_period: Duration::from_secs(1),
            failing_patience: Duration::from_secs(90),
            progress_patience: Duration::from_secs(10),
            stalls: 3,
            blockages: 300,
            scan_patience: Duration::from_secs(1),
            off_path_m: 0.5,
        }
    }
}

impl NavigationParameters {
    /// The defaults for a robot.
    #[must_use]
    pub fn of(model: &RobotModel) -> Self {
        let defaults = Self::default();
        let slowest = model.lasers.iter().map(|laser| laser.period).max().unwrap_or_default();
        Self {
            costmap: CostmapParameters::of(model),
            following: FollowingParameters::of(model),
            scan_patience: defaults.scan_patience.max(3 * slowest),
            ..defaults
        }
    }

    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first invalid one.
    pub fn check(&self) -> Result<(), Error> {
        self.costmap.check()?;
        self.following.check()?;
        check(&[
            require("detour_m", self.detour_m, self.detour_m >= 0.0, "zero or positive"),
            require("off_path_m", self.off_path_m, self.off_path_m > 0.0, "positive"),
        ])
    }
}
