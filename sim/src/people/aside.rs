//! Stepping aside: where people go when they are in the robot's way, and how they come back.

use std::f64::consts::TAU;
use std::time::Duration;

use maps::{Point, Pose};
use nalgebra::{UnitComplex, Vector2};

use crate::drive::Drive;
use crate::floor::Floor;
use crate::motion::RobotPose;
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::route::walk_to;

/// The side clearance to the robot's path when stepping aside, in meters.
const ROOM_M: f64 = 0.2;

/// Places to step aside to are searched for in this many directions and at these distances, in meters, nearest first.
const DIRECTIONS: u32 = 24;
const FARTHEST_M: f64 = 1.8;
const STEP_M: f64 = 0.15;

/// A robot this far away no longer needs the room, in meters.
const FAR_M: f64 = 2.5;

/// The longest time that people with a route stand aside.
pub(super) const LONGEST: Duration = Duration::from_secs(8);

/// The shortest time that they stand aside.
const SHORTEST: Duration = Duration::from_secs(1);

/// A person and the robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) at: Pose,
    pub(super) robot: Pose,
    pub(super) radius_m: f64,
    /// Distance of the two centers at which they touch, in meters.
    pub(super) apart_m: f64,
}

impl Meeting {
    /// A person with the pose and the body of an obstacle, and the robot.
    pub(super) fn new(at: &ObstaclePose, person: &Obstacle, (robot, drive): (&RobotPose, &Drive)) -> Self {
        let radius_m = person.shape.bounding_radius_m();
        Self { at: at.0, robot: robot.0, radius_m, apart_m: radius_m + drive.robot_radius_m() }
    }

    /// Where the person is.
    pub(super) fn place(&self) -> Point {
        self.at.translation.vector.into()
    }

    pub(super) fn robot_place(&self) -> Point {
        self.robot.translation.vector.into()
    }

    /// The distance of the two centers, in meters.
    pub(super) fn distance_m(&self) -> f64 {
        (self.at.translation.vector - self.robot.translation.vector).norm()
    }

    /// Whether the robot faces the person across a gap of at most `gap_m` meters.
    pub(super) fn is_faced_within(&self, gap_m: f64) -> bool {
        let seen = self.robot.inverse_transform_point(&self.at.translation.vector.into());
        seen.x > 0.0 && seen.y.abs() < self.apart_m && seen.coords.norm() <= self.apart_m + gap_m
    }

    /// The distance of a place from the robot's path ahead, in meters; from the robot itself, if the place is behind
    /// it.
    fn beside_m(&self, place: &Vector2<f64>) -> f64 {
        let seen = self.robot.inverse_transform_point(&Point::from(*place));
        if seen.x > 0.0 { seen.y.abs() } else { seen.coords.norm() }
    }

    /// The smallest distance to the robot on a straight path to a place, in meters.
    fn nearest_m(&self, place: &Vector2<f64>) -> f64 {
        let (from, robot) = (self.at.translation.vector, self.robot.translation.vector);
        let way = place - from;
        let share = ((robot - from).dot(&way) / way.norm_squared().max(1e-9)).clamp(0.0, 1.0);
        (from + way * share - robot).norm()
    }
}

/// A place to step aside to.
#[derive(Clone, Copy, Debug)]
pub(super) struct WayOut(Point);

impl WayOut {
    /// The nearest place with a straight, free path that does not come nearer to the robot than the person already is
    /// or the robot needs, and from which the robot's path ahead is free. Of several equally near places, the one with
    /// the most room for the robot.
    pub(super) fn find(meeting: &Meeting, floor: &Floor<'_>) -> Option<Self> {
        let from = meeting.at.translation.vector;
        let needed_m = meeting.apart_m + ROOM_M;
        let from_robot_m = needed_m.min((from - meeting.robot.translation.vector).norm() - 1e-6);
        let is_good = |place: &Vector2<f64>| {
            meeting.beside_m(place) >= needed_m
                && meeting.nearest_m(place) >= from_robot_m
                && floor.is_walkable(&from.into(), &(*place).into(), meeting.radius_m)
        };
        let distances = (1..).map(|step| f64::from(step) * STEP_M).take_while(|distance_m| *distance_m <= FARTHEST_M);
        distances.map(|distance_m| around(&from, distance_m)).find_map(|places| {
            let good = places.filter(|place| is_good(place));
            good.max_by(|a, b| meeting.beside_m(a).total_cmp(&meeting.beside_m(b))).map(|place| Self(place.into()))
        })
    }
}

/// Places around a point, at a distance.
fn around(center: &Vector2<f64>, distance_m: f64) -> impl Iterator<Item = Vector2<f64>> {
    let turn = move |direction: u32| UnitComplex::new(TAU * f64::from(direction) / f64::from(DIRECTIONS));
    let center = *center;
    (0..DIRECTIONS).map(move |direction| center + turn(direction) * Vector2::x() * distance_m)
}

/// A person who has left the route to let the robot pass.
#[derive(Clone, Debug, Default)]
pub(super) struct Aside {
    /// The place to stand; `None` on the way back.
    to: Option<Point>,
    /// Since when they have stood there.
    stands_since: Option<Duration>,
    /// The way back to the route, its end first.
    way_back: Vec<Point>,
}

impl Aside {
    /// Leaves a place for another.
    pub(super) fn leave(&mut self, at: &Pose, WayOut(to): WayOut) {
        self.way_back.push(at.translation.vector.into());
        (self.to, self.stands_since) = (Some(to), None);
    }

    /// Whether they stand and let the robot pass: until it is far away or past the place where they left their route,
    /// or until they have stood for the longest time.
    pub(super) fn stands(&mut self, meeting: &Meeting, now: Duration, longest: Duration) -> bool {
        let Some(since) = self.stands_since else { return false };
        let lasted = now.saturating_sub(since);
        let robot = Point::from(meeting.robot.translation.vector);
        let left = self.way_back.last().copied().unwrap_or(robot);
        let seen = meeting.robot.inverse_transform_point(&left);
        let is_past = seen.x < 0.0 && seen.coords.norm() > meeting.apart_m + ROOM_M;
        let is_far = (robot - left).norm() > FAR_M;
        if lasted < SHORTEST || (lasted < longest && !is_past && !is_far) {
            return true;
        }
        (self.to, self.stands_since) = (None, None);
        false
    }

    fn aim(&self) -> Option<Point> {
        self.to.or_else(|| self.way_back.last().copied())
    }

    /// The direction from a place in which they walk next.
    pub(super) fn direction(&self, from: &Pose) -> Option<Vector2<f64>> {
        (self.aim()?.coords - from.translation.vector).try_normalize(0.0)
    }

    /// Walks a distance, facing forward. Returns whether they are back on their route.
    pub(super) fn go(&mut self, from: &Pose, way_m: f64, now: Duration) -> (Pose, bool) {
        let Some(aim) = self.aim() else { return (*from, true) };
        let (at, left_m) = walk_to(from, &aim, way_m);
        if left_m.is_none() {
            return (at, false);
        }
        if self.to.is_some() {
            self.stands_since = Some(now);
        } else {
            self.way_back.pop();
        }
        (at, self.to.is_none() && self.way_back.is_empty())
    }
}
