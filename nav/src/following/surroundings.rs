//! The lasers' view of the robot's immediate surroundings, for stopping in time.
//!
//! It uses only the latest scans, not the map, so an error of the pose cannot hide an obstacle. Unseen space does not
//! count as free: it also checks whether the lasers see the space into which the robot would drive.

use std::time::Duration;

use maps::{Point, Pose};
use nalgebra::UnitComplex;
use robot::{LaserScan, LaserSpec, RobotModel};

use crate::beams::Beams;

/// Hits farther from the laser than this are ignored, in meters, unless the robot needs longer to brake.
const FARTHEST_M: f64 = 1.3;

/// Objects too near to be measured are assumed to be at this distance, as a share of the shortest range: a laser is
/// mounted behind the body's edge, and an obstacle that vanishes just before contact must not seem to leave room.
const TOO_NEAR_SHARE: f64 = 0.5;

/// Distance between the positions along an arc that are checked, in meters.
const LOOK_M: f64 = 0.04;

/// An obstacle is still there while there is a hit within this distance of it, in meters.
const STILL_THERE_M: f64 = 0.1;

/// How much nearer the robot may get to an obstacle that is already too near, in meters: ranges are noisy, and a wall
/// along the path seems to come and go. But it never gets nearer than its radius.
const NEARER_M: f64 = 0.005;

/// A laser sees where the robot would drive if it sees positions at this distance from the body's edge, in meters, in
/// these directions, in radians.
const BEFORE_BODY_M: f64 = 0.05;
const AROUND_RAD: [f64; 3] = [-0.5, 0.0, 0.5];

/// The hits near the robot of each laser's latest scan, in the `map` frame.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    radius_m: f64,
    /// Hits farther from the laser than this are ignored.
    farthest_m: f64,
    views: Vec<View>,
}

/// The view of one laser.
#[derive(Clone, Debug)]
struct View {
    hits: Vec<Point>,
    /// Time of a scan that [`update`](Surroundings::update) has not processed yet, and of the latest one that it has.
    fresh: Option<Duration>,
    scanned: Option<Duration>,
    /// Whether the laser sees the positions in front of the body, and those behind it.
    ahead: [bool; AROUND_RAD.len()],
    behind: [bool; AROUND_RAD.len()],
}

/// The free distance of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FreeWay {
    /// Distance along the arc, in meters; at most the checked distance.
    pub(crate) way_m: f64,
    pub(crate) obstacle: Option<Point>,
}

impl Surroundings {
    /// `horizon_m` is the greatest distance for which [`free_way`](Self::free_way) will be called, in meters.
    pub(crate) fn new(model: &RobotModel, horizon_m: f64) -> Self {
        let sees = |laser: &LaserSpec, direction_rad: f64| {
            AROUND_RAD.map(|around_rad| {
                let turn = UnitComplex::new(direction_rad + around_rad);
                sees(laser, &(turn * Point::new(model.radius_m + BEFORE_BODY_M, 0.0)))
            })
        };
        let view = |laser: &LaserSpec| View {
            hits: Vec::new(),
            fresh: None,
            scanned: None,
            ahead: sees(laser, 0.0),
            behind: sees(laser, std::f64::consts::PI),
        };
        // From a laser behind the robot's center to what the body would touch at the end of its way.
        let farthest_m = FARTHEST_M.max(horizon_m + 2.0 * model.radius_m + BEFORE_BODY_M);
        Self { radius_m: model.radius_m, farthest_m, views: model.lasers.iter().map(view).collect() }
    }

    /// Processes the scan of a laser on a robot at `robot` in the `map` frame, which replaces the laser's last scan.
    pub(crate) fn take_in(&mut self, scan: &LaserScan, beams: &Beams, robot: &Pose) {
        let radius_m = self.radius_m;
        let view = &mut self.views[scan.laser];
        view.hits.clear();
        let nearest_m = TOO_NEAR_SHARE * beams.spec.range_min_m;
        let ends = beams.ends(scan, beams.eye(&Pose::identity()), nearest_m, self.farthest_m, 0.0);
        view.hits.extend(ends.map(|end| robot * outside_of_the_body(end, radius_m)));
        view.fresh = Some(scan.time);
    }

    /// Sets the time, and forgets the view of a laser that has been silent for longer than `patience`.
    pub(crate) fn update(&mut self, now: Duration, patience: Duration) {
        for view in &mut self.views {
            // A scan from the future counts as one from now.
            view.scanned = view.scanned.max(view.fresh.take().map(|time| time.min(now)));
            if !view.is_current(now, patience) {
                view.hits.clear();
            }
        }
    }

    /// Whether the lasers that look ahead have seen the space ahead within the last `patience`.
    pub(crate) fn sees_ahead(&self, now: Duration, patience: Duration) -> bool {
        let is_seen = |place: usize| {
            let mut looking = self.views.iter().filter(|view| view.ahead[place]).peekable();
            looking.peek().is_none() || looking.any(|view| view.is_current(now, patience))
        };
        (0..AROUND_RAD.len()).all(is_seen)
    }

    /// For how long no laser has seen the space ahead since the time `since`; `None` if no laser looks there.
    pub(crate) fn blind_ahead_for(&self, now: Duration, since: Duration) -> Option<Duration> {
        let newest = |place: usize| {
            let looking = self.views.iter().filter(|view| view.ahead[place]);
            looking.map(|view| view.scanned.map_or(since, |scanned| scanned.max(since))).max()
        };
        (0..AROUND_RAD.len()).filter_map(newest).min().map(|scanned| now.saturating_sub(scanned))
    }

    /// Whether lasers have seen the space behind the robot within the last `patience`.
    pub(crate) fn sees_behind(&self, now: Duration, patience: Duration) -> bool {
        let is_seen = |place| self.views.iter().any(|view| view.behind[place] && view.is_current(now, patience));
        (0..AROUND_RAD.len()).all(is_seen)
    }

    /// How far a disc of radius `needed_m` at `from` can drive along an arc of this curvature (1/m, positive to the
    /// left), at most `horizon_m`, without coming near a hit. If a hit is nearer already, it may not come nearer.
    pub(crate) fn free_way(&self, from: &Pose, curvature: f64, horizon_m: f64, needed_m: f64) -> FreeWay {
        let here = Point::from(from.translation.vector);
        let now_m = self.nearest(&here).map_or(f64::INFINITY, |(_, distance_m)| distance_m);
        let needed_m = needed_m.min((now_m - NEARER_M).max(self.radius_m));
        let looks = (horizon_m / LOOK_M).ceil().max(1.0) as usize;
        for look in 1..=looks {
            let way_m = horizon_m * look as f64 / looks as f64;
            let at = from * along_arc(way_m, curvature);
            if let Some(obstacle) = self.nearest_approached(&here, &at, needed_m) {
                let way_m = horizon_m * (look - 1) as f64 / looks as f64;
                return FreeWay { way_m, obstacle: Some(obstacle) };
            }
        }
        FreeWay { way_m: horizon_m, obstacle: None }
    }

    /// Whether something is still seen where it was.
    pub(crate) fn is_near(&self, obstacle: &Point) -> bool {
        self.nearest(obstacle).is_some_and(|(_, distance_m)| distance_m < STILL_THERE_M)
    }

    fn hits(&self) -> impl Iterator<Item = &Point> {
        self.views.iter().flat_map(|view| &view.hits)
    }

    /// The hit nearest to a point, and how far it is, in meters.
    fn nearest(&self, at: &Point) -> Option<(Point, f64)> {
        let mut best: Option<(Point, f64)> = None;
        for hit in self.hits() {
            let squared = (hit - at).norm_squared();
            if best.is_none_or(|(_, least)| squared < least) {
                best = Some((*hit, squared));
            }
        }
        best.map(|(hit, squared)| (hit, squared.sqrt()))
    }

    /// The hit nearest to `at` among those within `within_m` of it that are nearer to it than to `here`.
    fn nearest_approached(&self, here: &Point, at: &Point, within_m: f64) -> Option<Point> {
        let mut best: Option<(Point, f64)> = None;
        let within = within_m * within_m;
        for hit in self.hits() {
            let squared = (hit - at).norm_squared();
            let nearest = squared < best.map_or(within, |(_, least)| least);
            if nearest && squared < (hit - here).norm_squared() {
                best = Some((*hit, squared));
            }
        }
        best.map(|(hit, _)| hit)
    }
}

impl View {
    fn is_current(&self, now: Duration, patience: Duration) -> bool {
        self.scanned.is_some_and(|scanned| now.saturating_sub(scanned) <= patience)
    }
}

/// Whether a place, in `base_link`, is within a laser's field of view.
fn sees(laser: &LaserSpec, place: &Point) -> bool {
    let seen = laser.mount.inverse_transform_point(place);
    let turn = libm::atan2(seen.y, seen.x) - laser.angle_min_rad;
    let field_rad = laser.angle_increment_rad * laser.beams.saturating_sub(1) as f64;
    turn.rem_euclid(std::f64::consts::TAU) <= field_rad
}

/// A hit cannot be inside the body: if a hit, in `base_link`, seems to be, it is moved to the edge.
fn outside_of_the_body(hit: Point, radius_m: f64) -> Point {
    let distance_m = hit.coords.norm();
    if distance_m < radius_m && distance_m > 0.0 { hit * (radius_m / distance_m) } else { hit }
}

/// The position on an arc from the origin along x after a distance.
fn along_arc(way_m: f64, curvature: f64) -> Point {
    let turn = way_m * curvature;
    if turn.abs() < 1e-6 {
        return Point::new(way_m, way_m * turn / 2.0);
    }
    let (sin, cos) = libm::sincos(turn);
    Point::new(sin / curvature, (1.0 - cos) / curvature)
}

#[cfg(test)]
mod tests {
    use maps::pose;
    use proptest::prelude::*;

    use super::*;

    fn with_hits(hits: &[(f64, f64)]) -> Surroundings {
        let mut surroundings = Surroundings::new(&RobotModel::default(), 0.5);
        surroundings.views[1].hits = hits.iter().map(|(x, y)| Point::new(*x, *y)).collect();
        surroundings
    }

    /// A scan of the default model's laser with this index that hits something at this distance with its beam 180,
    /// straight away from the robot, and nothing else.
    fn scan(laser: usize, second: u64, range_m: f32) -> LaserScan {
        let mut ranges_m = vec![f32::INFINITY; 360];
        ranges_m[180] = range_m;
        LaserScan { time: Duration::from_secs(second), laser, ranges_m }
    }

    fn take_in(surroundings: &mut Surroundings, scan: &LaserScan) {
        let model = RobotModel::default();
        surroundings.take_in(scan, &Beams::new(&model.lasers[scan.laser]), &Pose::identity());
    }

    #[test]
    fn the_free_distance_ends_before_an_obstacle() {
        let surroundings = with_hits(&[(1.0, 0.1), (0.2, 0.6)]);
        let straight = surroundings.free_way(&pose(0.0, 0.0, 0.0), 0.0, 1.0, 0.3);
        assert!(straight.way_m <= 1.0 - 0.28 && straight.way_m > 0.62, "{straight:?}");
        assert_eq!(straight.obstacle, Some(Point::new(1.0, 0.1)));
        let around = surroundings.free_way(&pose(0.0, 0.0, 0.0), -1.5, 1.0, 0.3);
        assert_eq!(around, FreeWay { way_m: 1.0, obstacle: None });
    }

    #[test]
    fn a_robot_too_near_to_a_wall_may_leave_but_not_approach() {
        let surroundings = with_hits(&[(0.0, 0.25)]);
        assert!(surroundings.free_way(&pose(0.0, 0.0, -1.5), 0.0, 0.4, 0.3).obstacle.is_none());
        assert!(surroundings.free_way(&pose(0.0, 0.0, 1.5), 0.0, 0.4, 0.3).way_m < 0.01);
    }

    #[test]
    fn a_near_object_does_not_hide_farther_ones() {
        // Dirt on the glass of the left side, a wall ahead.
        let surroundings = with_hits(&[(0.0, 0.2), (0.6, 0.0)]);
        let ahead = surroundings.free_way(&pose(0.0, 0.0, 0.0), 0.0, 1.0, 0.315);
        assert!(ahead.way_m <= 0.3 && ahead.obstacle == Some(Point::new(0.6, 0.0)), "{ahead:?}");
    }

    proptest! {
        #[test]
        fn the_robot_does_not_creep_towards_a_wall(slope_rad in 0.0..1.5_f64, from_m in 0.301..0.5_f64) {
            let wall: Vec<(f64, f64)> = (-400..400).map(|at| (f64::from(at) * 0.01, from_m)).collect();
            let surroundings = with_hits(&wall);
            let mut at = pose(-2.0, 0.0, slope_rad);
            for _ in 0..1000 {
                let way_m = surroundings.free_way(&at, 0.0, 0.2, 0.315).way_m.min(0.005);
                at *= pose(way_m, 0.0, 0.0);
            }
            prop_assert!(from_m - at.translation.y >= 0.3 - 1e-6, "{} m from the wall", from_m - at.translation.y);
        }
    }

    #[test]
    fn objects_too_near_to_be_measured_are_at_the_edge_of_the_body() {
        let mut surroundings = Surroundings::new(&RobotModel::default(), 0.5);
        let mut near = scan(0, 1, f32::INFINITY);
        near.ranges_m[10] = f32::NEG_INFINITY;
        take_in(&mut surroundings, &near);
        let hits: Vec<&Point> = surroundings.hits().collect();
        assert!(hits.len() == 1 && (hits[0].coords.norm() - 0.3).abs() < 1e-9, "{hits:?}");
    }

    #[test]
    fn a_silent_laser_leaves_the_robot_blind_where_no_other_laser_looks() {
        let (second, patience) = (Duration::from_secs, Duration::from_secs(1));
        let mut surroundings = Surroundings::new(&RobotModel::default(), 0.5);
        assert_eq!(surroundings.blind_ahead_for(second(3), second(1)), Some(second(2)), "never scanned");
        for time in 1..=5 {
            take_in(&mut surroundings, &scan(1, time, 0.5));
            if time <= 2 {
                take_in(&mut surroundings, &scan(0, time, 0.5));
            }
            surroundings.update(second(time), patience);
        }
        assert_eq!(surroundings.blind_ahead_for(second(5), Duration::ZERO), Some(second(3)));
        assert!(surroundings.sees_ahead(second(3), patience) && !surroundings.sees_ahead(second(4), patience));
        assert!(surroundings.sees_behind(second(5), patience) && !surroundings.sees_behind(second(7), patience));
        assert_eq!(surroundings.hits().count(), 1, "what the front laser saw is forgotten");
    }

    #[test]
    fn a_scan_from_the_future_does_not_stay_fresh_forever() {
        let mut surroundings = Surroundings::new(&RobotModel::default(), 0.5);
        take_in(&mut surroundings, &scan(0, 1000, 0.5));
        surroundings.update(Duration::from_secs(1), Duration::from_secs(1));
        assert_eq!(surroundings.blind_ahead_for(Duration::from_secs(4), Duration::ZERO), Some(Duration::from_secs(3)));
    }

    #[test]
    fn a_robot_without_a_forward_laser_is_never_blinded() {
        let mut model = RobotModel::default();
        model.lasers.remove(0);
        let surroundings = Surroundings::new(&model, 0.5);
        assert_eq!(surroundings.blind_ahead_for(Duration::from_secs(9), Duration::ZERO), None);
        assert!(surroundings.sees_ahead(Duration::from_secs(9), Duration::from_secs(1)));
    }
}
