//! The parameters of the navigator.

use std::time::Duration;

use robot::RobotModel;

use crate::{CostmapParameters, Error, FollowingParameters};

/// Parameters of a [`Navigator`](crate::Navigator). All times are simulated (or the robot's) time.
#[derive(Clone, Debug, PartialEq)]
pub struct NavigationParameters {
    /// How obstacles are inflated, marked and cleared.
    pub costmap: CostmapParameters,
    /// How paths are followed.
    pub following: FollowingParameters,
    /// How long to wait for something in the way to go away before looking for another way. Default 4 s: a person who
    /// walks by takes less.
    pub obstacle_patience: Duration,
    /// A way around that is at most so much longer than the rest of the path is taken without waiting, in metres.
    /// Default 2.
    pub detour_m: f64,
    /// Shortest time between two looks for a way around. Default 1 s.
    pub planning_period: Duration,
    /// How long to recover and try again when there is no way, while something that the lasers have seen may be the
    /// reason. Default 90 s: four times through all recovery behaviours. Of those who talk in a doorway or just where
    /// the robot is to go, many have not moved on after half of it.
    /// If the map alone is the reason, trying again is pointless and left out.
    pub failing_patience: Duration,
    /// How long the robot may come no nearer to its goal before the path is planned anew, and the next time recovery
    /// begins; after as many times as `stalls` it gives up. Default 10 s.
    pub progress_patience: Duration,
    /// How often in a row progress may stop. Default 3.
    pub stalls: u32,
    /// How often the way may be blocked on one trip. Default 300: among people it is so every few seconds.
    pub blockages: u32,
    /// How long a laser may be silent while driving before the robot is blind where only that one looks: it cannot go
    /// on without one that looks ahead, nor back up without one that looks behind. Default 1 s: ten scans.
    pub scan_patience: Duration,
    /// Plan anew if the robot is farther from its path than this, in metres. Default 0.5: it was pushed or driven away.
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
        Self { costmap: CostmapParameters::of(model), following: FollowingParameters::of(model), ..Self::default() }
    }

    /// Whether the values make sense.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first that does not.
    pub fn check(&self) -> Result<(), Error> {
        self.costmap.check()?;
        self.following.check()?;
        crate::error::check(&[
            ("detour_m", self.detour_m, self.detour_m >= 0.0, "zero or positive"),
            ("off_path_m", self.off_path_m, self.off_path_m > 0.0, "positive"),
        ])
    }
}
