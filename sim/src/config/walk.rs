//! How somebody walks.

use std::time::Duration;

use maps::Point;

/// How somebody walks: along a polyline from where they stand, facing where they go.
///
/// People walk through each other and through walls: whoever draws a route sees to it that it leads along the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// Corners of the polyline after the first pose, in the `map` frame.
    pub waypoints: Vec<Point>,
    /// Speed where nothing is in the way, in m/s.
    pub speed_mps: f64,
    /// What happens at the last waypoint.
    pub end: RouteEnd,
    /// When they set out, since the start of the run.
    pub sets_out: Duration,
    /// How long they stand where they pause.
    pub pause: Duration,
    /// Where they pause.
    pub pauses: Pauses,
    /// What they do about the robot; none walks on as if it were not there, and pushes it away.
    pub manners: Option<Manners>,
}

/// Where somebody pauses on their way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Pauses {
    /// At every waypoint.
    #[default]
    Waypoints,
    /// At the first and the last waypoint.
    Ends,
}

/// What somebody does about a robot in their way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manners {
    /// They slow down when the gap to the robot ahead of them is smaller than this, in metres. Default 1.2.
    pub slow_within_m: f64,
    /// They come no nearer than this, in metres. Default 0.3.
    pub stop_within_m: f64,
    /// How long the robot may hinder them, or face them from near as if it waited for them, until they make way for it.
    /// They step aside to where they leave it the way that it faces, let it pass, and go on. If there is no such place
    /// near, or if it has not helped, they turn and go back to where they came from, unless their route ends at its
    /// last waypoint. Default 3 s.
    pub patience: Duration,
}

impl Default for Manners {
    fn default() -> Self {
        Self { slow_within_m: 1.2, stop_within_m: 0.3, patience: Duration::from_secs(3) }
    }
}

/// What an obstacle does at the last waypoint of its route.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum RouteEnd {
    /// It stops.
    #[default]
    Stop,
    /// It goes on to the first waypoint.
    Loop,
    /// It turns and goes back through the waypoints, then forth again.
    BackAndForth,
}
