//! How a person walks.

use std::time::Duration;

use maps::Point;

/// How a person walks: along a polyline from the start, facing forward.
///
/// People walk through each other and through walls, so routes must lead along free floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// Corners of the polyline after the first pose, in the `map` frame.
    pub waypoints: Vec<Point>,
    /// Undisturbed speed, in m/s.
    pub speed_mps: f64,
    /// The behavior at the last waypoint.
    pub end: RouteEnd,
    /// When they start, as time since the beginning of the run.
    pub sets_out: Duration,
    /// How long they stand at each pause.
    pub pause: Duration,
    /// Where they pause.
    pub pauses: Pauses,
    /// How they react to the robot. Without manners, they walk on as if it did not exist and push it away.
    pub manners: Option<Manners>,
}

/// Where a person pauses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Pauses {
    /// At every waypoint.
    #[default]
    Waypoints,
    /// At the first and the last waypoint.
    Ends,
}

/// How a person reacts to a robot in the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manners {
    /// Below this gap to the robot ahead, they slow down, in meters. Default 1.2.
    pub slow_within_m: f64,
    /// The smallest gap that they keep, in meters. Default 0.3.
    pub stop_within_m: f64,
    /// How long the robot may block them, or face them from nearby as if it waited for them. After that time, they step
    /// aside to clear the robot's path, let it pass, and continue. If there is no suitable place nearby, or if stepping
    /// aside did not help, they turn and walk back to where they came from, unless their route ends at its last
    /// waypoint. Default 3 s.
    pub patience: Duration,
}

impl Default for Manners {
    fn default() -> Self {
        Self { slow_within_m: 1.2, stop_within_m: 0.3, patience: Duration::from_secs(3) }
    }
}

/// The behavior of an obstacle at the last waypoint of its route.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum RouteEnd {
    /// It stops.
    #[default]
    Stop,
    /// It continues with the first waypoint.
    Loop,
    /// It turns and goes back through the waypoints, and so on.
    BackAndForth,
}
