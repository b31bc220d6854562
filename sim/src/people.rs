//! People: they walk along routes, stop at corners, and wait for a robot that is in their way.

use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::{Point, Pose};

use crate::clock::Clock;
use crate::config::{RouteEnd, Shape};
use crate::drive::{Drive, RobotPose};
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::physics::{Body, Physics};
use crate::route::Route;

/// Whoever passes the robot leaves it this much room to the side, in metres.
const BESIDE_M: f64 = 0.1;

/// Whoever could only walk at less than this share of their speed stands.
const LEAST_SHARE: f64 = 0.1;

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
    /// How long they stand before the robot until they turn and go back to where they came from, if their route does
    /// not end at its last waypoint. Default 3 s.
    pub patience: Duration,
}

impl Default for Manners {
    fn default() -> Self {
        Self { slow_within_m: 1.2, stop_within_m: 0.3, patience: Duration::from_secs(3) }
    }
}

/// Somebody on their way.
#[derive(Component, Clone, Debug)]
pub(crate) struct Walker {
    route: Route,
    walk: Walk,
    /// They stand at a waypoint until then.
    stands_until: Duration,
    /// Since when the robot has kept them from going on.
    waits_since: Option<Duration>,
}

impl Walker {
    pub(crate) fn new(walk: &Walk) -> Self {
        Self {
            route: Route::new(walk.waypoints.clone(), walk.speed_mps, walk.end),
            stands_until: walk.sets_out,
            waits_since: None,
            walk: walk.clone(),
        }
    }

    /// Where somebody at `from` of that radius is after a step, with a robot of another radius about.
    fn advance(&mut self, from: &Pose, radius_m: f64, robot: &Point, robot_radius_m: f64, clock: &Clock) -> Pose {
        if clock.now < self.stands_until {
            return *from;
        }
        let share = self.haste(from, robot, radius_m + robot_radius_m);
        if share < LEAST_SHARE {
            self.wait(clock.now);
            return *from;
        }
        self.waits_since = None;
        let last = self.walk.waypoints.len().saturating_sub(1);
        let (pauses, pause) = (self.walk.pauses, self.walk.pause);
        let stops = |waypoint| !pause.is_zero() && (pauses == Pauses::Waypoints || waypoint == 0 || waypoint == last);
        let (at, stopped) = self.route.walk(from, share * self.walk.speed_mps * clock.dt_s(), stops);
        if stopped {
            self.stands_until = clock.now + pause;
        }
        at
    }

    /// Which share of their speed the robot leaves somebody who must keep their centre so far from its own.
    fn haste(&self, from: &Pose, robot: &Point, apart_m: f64) -> f64 {
        let (Some(manners), Some(ahead)) = (self.walk.manners, self.route.direction(from)) else { return 1.0 };
        let way = robot.coords - from.translation.vector;
        let beside_m = way.perp(&ahead).abs();
        if way.dot(&ahead) <= 0.0 || beside_m > apart_m + BESIDE_M {
            return 1.0;
        }
        let gap_m = way.norm() - apart_m;
        ((gap_m - manners.stop_within_m) / (manners.slow_within_m - manners.stop_within_m)).min(1.0)
    }

    fn wait(&mut self, now: Duration) {
        let since = *self.waits_since.get_or_insert(now);
        let patience = self.walk.manners.map_or(Duration::MAX, |manners| manners.patience);
        if now.saturating_sub(since) >= patience {
            self.route.turn_back();
            self.waits_since = None;
        }
    }
}

/// Takes everybody a step on.
pub(crate) fn walk(
    clock: Res<Clock>,
    mut physics: ResMut<Physics>,
    robot: Single<(&RobotPose, &Drive)>,
    mut people: Query<(&Body, &Obstacle, &mut ObstaclePose, &mut Walker)>,
) {
    let (robot, robot_radius_m) = (Point::from(robot.0.0.translation.vector), robot.1.robot_radius_m());
    for (body, obstacle, mut pose, mut walker) in &mut people {
        let radius_m = match obstacle.shape {
            Shape::Disc { radius_m } => radius_m,
            shape @ Shape::Box { .. } => shape.bounding_radius_m(),
        };
        let at = walker.advance(&pose.0, radius_m, &robot, robot_radius_m, &clock);
        if at != pose.0 {
            pose.0 = at;
            physics.carry(*body, &at);
        }
    }
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    fn walk_along_x(manners: Option<Manners>) -> Walker {
        Walker::new(&Walk {
            waypoints: vec![Point::new(4.0, 0.0), Point::new(0.0, 0.0)],
            speed_mps: 1.0,
            end: RouteEnd::Loop,
            sets_out: Duration::from_secs(1),
            pause: Duration::from_secs(2),
            pauses: Pauses::Waypoints,
            manners,
        })
    }

    /// Where the walker is at each of so many seconds, with a robot at a place.
    fn places(mut walker: Walker, robot: Point, seconds: u32) -> Vec<f64> {
        let mut at = pose(0.0, 0.0, 0.0);
        let mut clock = Clock { now: Duration::ZERO, dt: Duration::from_millis(20) };
        let mut second = || {
            for _ in 0..50 {
                clock.now += clock.dt;
                at = walker.advance(&at, 0.25, &robot, 0.3, &clock);
            }
            (at.translation.x * 10.0).round() / 10.0
        };
        (0..seconds).map(|_| second()).collect()
    }

    #[test]
    fn people_set_out_walk_and_stand_at_their_corners() {
        let far = Point::new(0.0, 9.0);
        assert_eq!(places(walk_along_x(None), far, 10), [0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 3.0, 2.0, 1.0]);
    }

    #[test]
    fn those_with_manners_stop_before_the_robot_and_turn_back_when_patience_is_over() {
        let places = places(walk_along_x(Some(Manners::default())), Point::new(2.0, 0.1), 30);
        let nearest = places.iter().copied().fold(0.0, f64::max);
        assert!(nearest <= 2.0 - 0.55 - 0.3 + 0.05 && nearest > 1.0, "{places:?}");
        assert!(places.iter().skip(12).any(|x| *x < 0.5), "never back: {places:?}");
    }

    #[test]
    fn those_without_walk_on_and_a_robot_beside_the_way_hinders_nobody() {
        assert_eq!(places(walk_along_x(None), Point::new(2.0, 0.0), 5)[4], 4.0);
        let beside = places(walk_along_x(Some(Manners::default())), Point::new(2.0, 0.7), 5);
        assert_eq!(beside[4], 4.0);
    }
}
