//! People who walk along routes: they pause at corners, and turn back where they cannot make way.

use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::Pose;

use super::aside::{Aside, LONGEST, Meeting, WayOut};
use crate::building::Building;
use crate::clock::Clock;
use crate::config::{Pauses, Walk};
use crate::drive::Drive;
use crate::floor::Floor;
use crate::motion::RobotPose;
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::physics::{Body, Physics};
use crate::route::Route;

/// The side clearance to the robot when passing it, in meters.
const BESIDE_M: f64 = 0.1;

/// A person who could walk only at less than this share of their speed stands still.
const LEAST_SHARE: f64 = 0.1;

/// A person who could walk only at less than this share of their speed is blocked, and loses patience.
const HINDERED_SHARE: f64 = 0.5;

/// A walking person.
#[derive(Component, Clone, Debug)]
pub(crate) struct Walker {
    route: Route,
    walk: Walk,
    /// They stand at a waypoint until this time.
    stands_until: Duration,
    /// Since when the robot has blocked them.
    hindered_since: Option<Duration>,
    /// They have left their route to let the robot pass.
    aside: Option<Aside>,
    /// How often they have stepped aside since the robot last let them continue.
    made_way: u32,
}

impl Walker {
    pub(crate) fn new(walk: &Walk) -> Self {
        Self {
            route: Route::new(walk.waypoints.clone(), walk.speed_mps, walk.end),
            stands_until: walk.sets_out,
            hindered_since: None,
            aside: None,
            made_way: 0,
            walk: walk.clone(),
        }
    }

    /// The pose after one step.
    fn advance(&mut self, meeting: &Meeting, floor: &Floor<'_>, clock: &Clock) -> Pose {
        let now = clock.now;
        if now < self.walk.sets_out || self.walk.waypoints.is_empty() {
            return meeting.at;
        }
        let share = self.haste(meeting);
        if self.is_in_the_way(meeting) || (!self.stands(meeting, now) && share < HINDERED_SHARE) {
            self.lose_patience(meeting, floor, now);
        } else {
            self.hindered_since = None;
        }
        if share < LEAST_SHARE || self.stands(meeting, now) {
            return meeting.at;
        }
        self.go(&meeting.at, share * self.walk.speed_mps * clock.dt_s(), now)
    }

    /// Whether they stand at a waypoint, or aside.
    fn stands(&mut self, meeting: &Meeting, now: Duration) -> bool {
        self.aside.as_mut().map_or(now < self.stands_until, |aside| aside.stands(meeting, now, LONGEST))
    }

    /// Walks a distance along the route, or beside it.
    fn go(&mut self, from: &Pose, way_m: f64, now: Duration) -> Pose {
        if let Some(aside) = &mut self.aside {
            let (at, is_back) = aside.go(from, way_m, now);
            if is_back {
                self.aside = None;
            }
            return at;
        }
        let last = self.walk.waypoints.len().saturating_sub(1);
        let (pauses, pause) = (self.walk.pauses, self.walk.pause);
        let stops = |waypoint| !pause.is_zero() && (pauses == Pauses::Waypoints || waypoint == 0 || waypoint == last);
        let (at, stopped) = self.route.walk(from, way_m, stops);
        if stopped {
            self.stands_until = now + pause;
            self.made_way = 0;
        }
        at
    }

    /// The share of their speed that the robot permits.
    fn haste(&self, meeting: &Meeting) -> f64 {
        let ahead = match &self.aside {
            Some(aside) => aside.direction(&meeting.at),
            None => self.route.direction(&meeting.at),
        };
        let (Some(manners), Some(ahead)) = (self.walk.manners, ahead) else { return 1.0 };
        let way = meeting.robot.translation.vector - meeting.at.translation.vector;
        let beside_m = way.perp(&ahead).abs();
        if way.dot(&ahead) <= 0.0 || beside_m > meeting.apart_m + BESIDE_M {
            return 1.0;
        }
        let gap_m = way.norm() - meeting.apart_m;
        ((gap_m - manners.stop_within_m) / (manners.slow_within_m - manners.stop_within_m)).min(1.0)
    }

    /// Whether the robot faces them and is near enough to be waiting for them.
    fn is_in_the_way(&self, meeting: &Meeting) -> bool {
        self.walk.manners.is_some_and(|manners| meeting.is_faced_within(manners.slow_within_m))
    }

    /// Is blocked for another step; steps aside when patience has run out.
    fn lose_patience(&mut self, meeting: &Meeting, floor: &Floor<'_>, now: Duration) {
        let Some(manners) = self.walk.manners else { return };
        let since = *self.hindered_since.get_or_insert(now);
        if now.saturating_sub(since) < manners.patience {
            return;
        }
        self.hindered_since = None;
        self.made_way += 1;
        let steps_aside = !self.made_way.is_multiple_of(2);
        match steps_aside.then(|| WayOut::find(meeting, floor)).flatten() {
            Some(way_out) => self.aside.get_or_insert_default().leave(&meeting.at, way_out),
            None if self.aside.is_some() => {}
            None if now < self.stands_until => self.stands_until = now,
            None => self.route.turn_back(),
        }
    }
}

/// Moves all people by one step.
pub(crate) fn walk(
    clock: Res<Clock>,
    building: Res<Building>,
    mut physics: ResMut<Physics>,
    robot: Single<(&RobotPose, &Drive)>,
    mut people: Query<(&Body, &Obstacle, &mut ObstaclePose, &mut Walker)>,
) {
    let floor = Floor::new(&building, []);
    for (body, obstacle, mut pose, mut walker) in &mut people {
        let at = walker.advance(&Meeting::new(&pose, obstacle, *robot), &floor, &clock);
        if at != pose.0 {
            pose.0 = at;
            physics.carry(*body, &at);
        }
    }
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, OccupancyGrid, Point, pose};

    use super::*;
    use crate::config::{Manners, RouteEnd};

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

    /// A floor along x with this width and walls on both sides.
    fn floor(width_m: f64) -> Building {
        let mut map = OccupancyGrid::new(200, 120, 0.05, pose(-3.0, -3.0, 0.0));
        for index in (0..120).flat_map(|row| (0..200).map(move |column| CellIndex { column, row })) {
            let wall = map.center(index).y.abs() > width_m / 2.0;
            map.set(index, if wall { Cell::Occupied } else { Cell::Free });
        }
        Building::new(&map)
    }

    /// The walker's position after each second, with a robot that faces it.
    fn walk_on(building: &Building, mut walker: Walker, robot: impl Fn(f64) -> Point, seconds: u32) -> Vec<Point> {
        let floor = &Floor::new(building, []);
        let mut at = pose(0.0, 0.0, 0.0);
        let mut clock = Clock { now: Duration::ZERO, dt: Duration::from_millis(20) };
        let mut second = || {
            for _ in 0..50 {
                clock.now += clock.dt;
                let robot = robot(clock.now.as_secs_f64());
                let robot = pose(robot.x, robot.y, std::f64::consts::PI);
                at = walker.advance(&Meeting { at, robot, radius_m: 0.25, apart_m: 0.55 }, floor, &clock);
                let gap_m = (at.translation.vector - robot.translation.vector).norm() - 0.55;
                assert!(gap_m > 0.0 || walker.walk.manners.is_none(), "walked into the robot at {at}");
            }
            at.translation.vector.into()
        };
        (0..seconds).map(|_| second()).collect()
    }

    /// The walker's position along a narrow corridor after each second.
    fn places(walker: Walker, robot: Point, seconds: u32) -> Vec<f64> {
        let places = walk_on(&floor(0.9), walker, |_| robot, seconds);
        places.iter().map(|at| (at.x * 10.0).round() / 10.0).collect()
    }

    #[test]
    fn people_start_walk_and_pause_at_their_corners() {
        let far = Point::new(0.0, 9.0);
        assert_eq!(places(walk_along_x(None), far, 10), [0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 3.0, 2.0, 1.0]);
    }

    #[test]
    fn polite_people_stop_in_front_of_the_robot_and_turn_back_when_patience_runs_out() {
        let places = places(walk_along_x(Some(Manners::default())), Point::new(2.0, 0.1), 30);
        let nearest = places.iter().copied().fold(0.0, f64::max);
        assert!(nearest <= 2.0 - 0.55 - 0.3 + 0.05 && nearest > 1.0, "{places:?}");
        assert!(places.iter().skip(12).any(|x| *x < 0.5), "never back: {places:?}");
    }

    #[test]
    fn impolite_people_walk_on_and_a_robot_beside_the_route_blocks_nobody() {
        assert_eq!(places(walk_along_x(None), Point::new(2.0, 0.0), 5)[4], 4.0);
        let beside = places(walk_along_x(Some(Manners::default())), Point::new(2.0, 0.7), 5);
        assert_eq!(beside[4], 4.0);
    }

    #[test]
    fn with_enough_room_people_step_aside_let_the_robot_pass_and_continue() {
        // The robot is in the way for 12 s, then drives on.
        let robot = |time_s: f64| Point::new(2.0 - 0.5 * (time_s - 12.0).max(0.0), 0.0);
        let places = walk_on(&floor(3.0), walk_along_x(Some(Manners::default())), robot, 40);
        assert!(places[..13].iter().any(|at| at.y.abs() > 0.6), "nobody stepped aside: {places:?}");
        assert!(places.iter().any(|at| at.x > 3.9 && at.y.abs() < 1e-9), "nobody continued: {places:?}");
    }

    #[test]
    fn people_whom_the_robot_still_faces_turn_back_in_the_end() {
        let places = walk_on(&floor(3.0), walk_along_x(Some(Manners::default())), |_| Point::new(2.0, 0.0), 60);
        assert!(places[20..].iter().any(|at| at.x < 0.1), "never back: {places:?}");
    }
}
