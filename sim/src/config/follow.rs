//! How a person follows the robot.

use std::time::Duration;

/// How a person follows the robot: where it went, facing forward.
///
/// They stand at their first pose until they meet it: until it is near and in view, and the straight way to it is wide
/// enough for them. So their whole body must be on free floor. From then on, they walk where the robot has been, or
/// straight to it where they would meet it again. They skip its loops. They stop in front of closed doors, never walk
/// into the robot, and step aside when it faces them from nearby for 3 s. If it is suddenly moved elsewhere, they stand
/// still until they meet it again.
///
/// People walk through each other: give those who follow together different distances.
#[derive(Clone, Debug, PartialEq)]
pub struct Follow {
    /// The distance that they keep from the robot's center, in meters, or slightly more than it takes not to touch it,
    /// if that is larger. Default 1.2.
    pub distance_m: f64,
    /// How near the robot's center must be for them to meet it, in meters. Default 2.
    pub meets_within_m: f64,
    /// Their highest speed, in m/s. Default 1.
    pub speed_mps: f64,
    /// The intervals of the run's time in which they stand still, whatever the robot does. After each, they catch up
    /// with it. Default none.
    pub stands: Vec<(Duration, Duration)>,
}

impl Default for Follow {
    fn default() -> Self {
        Self { distance_m: 1.2, meets_within_m: 2.0, speed_mps: 1.0, stands: Vec::new() }
    }
}

impl Follow {
    /// Whether they stand still at the given time.
    pub(crate) fn stands_at(&self, now: Duration) -> bool {
        self.stands.iter().any(|(from, to)| *from <= now && now < *to)
    }
}
