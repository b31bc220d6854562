//! The robot's trail, for a person who follows it.

use std::collections::VecDeque;

use maps::{Point, Pose};

use crate::route::walk_to;

/// Distance between the recorded places, in meters.
const SPACING_M: f64 = 0.1;

/// A robot that is farther than this from its last recorded place, in meters, has not driven there.
const JUMP_M: f64 = 0.3;

/// The places where the robot has been since the person met it.
///
/// It has no loops: a robot that comes back to an earlier place shortens it. So the size of the floor limits its
/// length, however long the robot drives.
#[derive(Clone, Debug)]
pub(super) struct Trail {
    /// The places still ahead of the follower, the next one first.
    ahead: VecDeque<Point>,
    last: Point,
}

impl Trail {
    /// The trail of a robot that stands here.
    pub(super) fn new(robot: Point) -> Self {
        Self { ahead: VecDeque::from([robot]), last: robot }
    }

    /// Whether the robot can have driven here from its last recorded place.
    pub(super) fn leads_to(&self, robot: &Point) -> bool {
        (robot - self.last).norm() <= JUMP_M
    }

    /// Records the robot's place, if it differs enough from the last one; returns whether it does.
    pub(super) fn record(&mut self, robot: Point) -> bool {
        if (robot - self.last).norm() < SPACING_M {
            return false;
        }
        // Between two of the robot's places that are this close, the way is free for any body that is no wider than the
        // robot.
        if let Some(earlier) = self.ahead.iter().position(|place| (robot - place).norm() < SPACING_M) {
            self.ahead.truncate(earlier + 1);
        }
        self.ahead.push_back(robot);
        self.last = robot;
        true
    }

    /// The length of the way from here to the robot, in meters.
    pub(super) fn length_m(&self, from: &Point, robot: &Point) -> f64 {
        let places = self.ahead.iter().chain([robot]);
        places.fold((0.0, *from), |(length_m, from), to| (length_m + (to - from).norm(), *to)).0
    }

    /// The pose of a follower at `from` after this distance, facing forward, and how many places they have then passed.
    pub(super) fn walk(&self, from: &Pose, way_m: f64) -> (Pose, usize) {
        let (mut at, mut left_m) = (*from, way_m);
        for (passed, place) in self.ahead.iter().enumerate() {
            let (next, left) = walk_to(&at, place, left_m);
            at = next;
            match left {
                Some(left) => left_m = left,
                None => return (at, passed),
            }
        }
        (at, self.ahead.len())
    }

    /// Forgets the next places: the follower has passed them.
    pub(super) fn pass(&mut self, places: usize) {
        self.ahead.drain(..places);
    }
}

#[cfg(test)]
mod tests {
    use maps::pose;
    use proptest::prelude::*;

    use super::*;

    fn drive(trail: &mut Trail, places: impl IntoIterator<Item = (f64, f64)>) {
        places.into_iter().for_each(|(x, y)| {
            trail.record(Point::new(x, y));
        });
    }

    fn along(count: u32) -> impl DoubleEndedIterator<Item = (f64, f64)> {
        (1..=count).map(|step| (f64::from(step) * 0.02, 0.0))
    }

    #[test]
    fn a_follower_walks_where_the_robot_drove() {
        let mut trail = Trail::new(Point::origin());
        drive(&mut trail, along(100));
        drive(&mut trail, along(100).map(|(x, y)| (2.0 + y, x)));
        assert!((trail.length_m(&Point::new(-1.0, 0.0), &Point::new(2.0, 2.0)) - 5.0).abs() < 1e-9);
        let (mut at, passed) = trail.walk(&pose(-1.0, 0.0, 2.0), 4.0);
        assert!((at.translation.vector - Point::new(2.0, 1.0).coords).norm() < 1e-9, "{at}");
        assert!((at.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{at}");
        trail.pass(passed);
        (at, _) = trail.walk(&at, 9.0);
        assert!((at.translation.vector - Point::new(2.0, 2.0).coords).norm() < 0.1, "{at}");
    }

    #[test]
    fn loops_are_left_out() {
        let mut trail = Trail::new(Point::origin());
        drive(&mut trail, along(100));
        drive(&mut trail, along(99).rev());
        assert!(trail.ahead.len() <= 3, "{trail:?}");
    }

    #[test]
    fn a_robot_that_was_carried_away_left_no_trail() {
        let mut trail = Trail::new(Point::origin());
        drive(&mut trail, along(100));
        assert!(trail.leads_to(&Point::new(2.1, 0.1)) && !trail.leads_to(&Point::new(0.0, 0.0)));
    }

    proptest! {
        #[test]
        fn a_trail_has_no_gaps_and_is_only_as_long_as_the_floor_is_large(
            turns in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 1..30)
        ) {
            let mut trail = Trail::new(Point::origin());
            let mut at = Point::origin();
            // A robot that is drawn to one corner after another of a square of 2 m.
            for (x, y) in turns {
                for _ in 0..100 {
                    at += (Point::new(x, y) - at).cap_magnitude(0.03);
                    trail.record(at);
                }
            }
            let places: Vec<Point> = trail.ahead.iter().copied().collect();
            let far = |pair: &[Point]| (pair[1] - pair[0]).norm();
            prop_assert!(places.windows(2).all(|pair| far(pair) < 0.14), "{places:?}");
            // Every second place is at least 0.1 m from all others: discs of 0.05 m around them do not overlap.
            prop_assert!(places.len() <= 2 * (2.1_f64 * 2.1 / (std::f64::consts::PI * 0.05 * 0.05)) as usize);
            for (first, second) in (0..places.len()).flat_map(|second| (0..second).map(move |first| (first, second))) {
                let distance_m = far(&[places[first], places[second]]);
                prop_assert!(second == first + 1 || distance_m >= 0.1, "{first} {second}: {distance_m}");
            }
        }
    }
}
