//! Following a polyline.

use maps::{Point, Pose};
use nalgebra::{UnitComplex, Vector2};

use crate::config::RouteEnd;

/// The progress of a body on a route.
#[derive(bevy_ecs::component::Component, Clone, Debug)]
pub(crate) struct Route {
    waypoints: Vec<Point>,
    speed_mps: f64,
    end: RouteEnd,
    /// The next waypoint; `None` at the end of the route.
    next: Option<usize>,
    backward: bool,
}

impl Route {
    pub(crate) fn new(waypoints: Vec<Point>, speed_mps: f64, end: RouteEnd) -> Self {
        let next = (!waypoints.is_empty()).then_some(0);
        Self { waypoints, speed_mps, end, next, backward: false }
    }

    /// The pose of a walker at `from` after `dt_s`, facing forward.
    pub(crate) fn advance(&mut self, from: &Pose, dt_s: f64) -> Pose {
        self.walk(from, self.speed_mps * dt_s, |_| false).0
    }

    /// The pose of a walker at `from` after this distance, facing forward, and whether it has reached a waypoint at
    /// which it `stops`: it then goes no farther.
    pub(crate) fn walk(&mut self, from: &Pose, way_m: f64, stops: impl Fn(usize) -> bool) -> (Pose, bool) {
        let mut at = *from;
        let mut left_m = way_m;
        // Waypoints may coincide: a step may pass several, but each at most once.
        for _ in 0..=self.waypoints.len() {
            let Some(next) = self.next else { break };
            let (then, left) = walk_to(&at, &self.waypoints[next], left_m);
            at = then;
            let Some(left) = left else { break };
            left_m = left;
            self.next = self.after(next);
            if stops(next) {
                return (at, true);
            }
        }
        (at, false)
    }

    /// The direction of the next waypoint from a place; `None` at the end of the route, or at the waypoint.
    pub(crate) fn direction(&self, from: &Pose) -> Option<Vector2<f64>> {
        (self.waypoints[self.next?].coords - from.translation.vector).try_normalize(0.0)
    }

    /// Heads for the previous waypoint, unless the route ends at its last one.
    pub(crate) fn turn_back(&mut self) {
        let (Some(next), last) = (self.next, self.waypoints.len().saturating_sub(1)) else { return };
        match self.end {
            RouteEnd::Stop => {}
            RouteEnd::Loop => {
                self.waypoints.reverse();
                self.next = Some((last - next + 1) % (last + 1));
            }
            RouteEnd::BackAndForth => {
                self.backward = !self.backward;
                self.next = Some(if self.backward { next.saturating_sub(1) } else { (next + 1).min(last) });
            }
        }
    }

    fn after(&mut self, reached: usize) -> Option<usize> {
        let last = self.waypoints.len() - 1;
        match self.end {
            RouteEnd::Stop => (reached < last).then_some(reached + 1),
            RouteEnd::Loop => Some((reached + 1) % (last + 1)),
            RouteEnd::BackAndForth => {
                if reached == if self.backward { 0 } else { last } {
                    self.backward = !self.backward;
                }
                Some(if self.backward { reached.saturating_sub(1) } else { (reached + 1).min(last) })
            }
        }
    }
}

/// The pose of a walker at `from` after this distance straight to a point, facing it, and the rest of the distance when
/// they have reached it; `None` if they have not.
pub(crate) fn walk_to(from: &Pose, to: &Point, way_m: f64) -> (Pose, Option<f64>) {
    let mut at = *from;
    let way = to.coords - from.translation.vector;
    let distance_m = way.norm();
    if distance_m > 0.0 {
        let ahead = way / distance_m;
        at.rotation = UnitComplex::from_cos_sin_unchecked(ahead.x, ahead.y);
    }
    if distance_m > way_m {
        at.translation.vector += way * (way_m / distance_m);
        return (at, None);
    }
    at.translation.vector = to.coords;
    (at, Some(way_m - distance_m))
}

#[cfg(test)]
mod tests {
    use maps::{heading, pose};

    use super::*;

    /// The positions after each of six seconds, at 1 m/s from (0, 0) around a square of 1 m.
    fn places(end: RouteEnd) -> Vec<(f64, f64)> {
        let square = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)].map(|(x, y)| Point::new(x, y));
        let mut route = Route::new(square.to_vec(), 1.0, end);
        let mut at = pose(0.0, 0.0, 0.5);
        let mut second = || {
            (0..4).for_each(|_| at = route.advance(&at, 0.25));
            (at.translation.x, at.translation.y)
        };
        (0..6).map(|_| second()).collect()
    }

    #[test]
    fn a_route_ends_as_configured() {
        let around = vec![(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        for (end, then) in [
            (RouteEnd::Stop, [(0.0, 0.0), (0.0, 0.0)]),
            (RouteEnd::Loop, [(1.0, 0.0), (1.0, 1.0)]),
            (RouteEnd::BackAndForth, [(0.0, 1.0), (1.0, 1.0)]),
        ] {
            assert_eq!(places(end), [around.clone(), then.to_vec()].concat(), "{end:?}");
        }
    }

    #[test]
    fn the_walker_faces_forward() {
        let mut route = Route::new(vec![Point::new(0.0, -3.0)], 1.0, RouteEnd::Stop);
        let at = route.advance(&pose(0.0, 0.0, 1.0), 0.5);
        assert!((heading(&at) + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn a_walker_that_turns_back_goes_to_the_previous_waypoint() {
        let line = [1.0, 2.0, 3.0].map(|x| Point::new(x, 0.0)).to_vec();
        for (end, before) in [(RouteEnd::Stop, 2.0), (RouteEnd::Loop, 1.0), (RouteEnd::BackAndForth, 1.0)] {
            let mut route = Route::new(line.clone(), 1.0, end);
            let at = route.advance(&pose(0.0, 0.0, 0.0), 1.5);
            route.turn_back();
            assert_eq!(route.waypoints[route.next.unwrap()].x, before, "{end:?}");
            let then = route.walk(&at, 0.5, |_| true);
            assert_eq!((then.0.translation.x, then.1), (before, true), "{end:?}");
        }
    }

    #[test]
    fn coinciding_waypoints_do_not_cause_an_endless_loop() {
        let mut route = Route::new(vec![Point::new(1.0, 1.0); 3], 1.0, RouteEnd::Loop);
        assert_eq!(route.advance(&pose(1.0, 1.0, 0.0), 10.0), pose(1.0, 1.0, 0.0));
    }
}
