//! What the lasers see right around the robot, for stopping in time.
//!
//! Taken from the latest scans alone, without the map, so that an error of the pose cannot hide an obstacle.

use maps::{Point, Pose};
use robot::LaserScan;

use crate::beams::Beams;

/// Hits farther from the laser than this are no concern, in metres: braking from full speed takes 0.2 m.
const FARTHEST_M: f64 = 1.3;

/// What is too near to be measured is taken to be this near, as a share of the shortest range: a laser stands behind
/// the body's edge, and an obstacle that vanishes when it is nearly touched must not seem to leave room.
const TOO_NEAR_SHARE: f64 = 0.5;

/// Distance between the places along an arc that are looked at, in metres.
const LOOK_M: f64 = 0.04;

/// An obstacle is still there while something is seen within this of it, in metres.
const STILL_THERE_M: f64 = 0.1;

/// How much nearer to an obstacle than it is already the robot may get when it is nearer than it should be, in metres.
const NEARER_M: f64 = 0.005;

/// The hits near the robot of each laser's latest scan, in the `map` frame.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    hits: Vec<Vec<Point>>,
}

/// How far the robot can go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FreeWay {
    /// Way along the arc, in metres; at most as far as was looked.
    pub(crate) way_m: f64,
    /// What is in the way.
    pub(crate) obstacle: Option<Point>,
}

impl Surroundings {
    pub(crate) fn new(lasers: usize) -> Self {
        Self { hits: vec![Vec::new(); lasers] }
    }

    /// Takes in the scan of a laser on a robot at `robot` in the `map` frame, in place of the laser's last.
    pub(crate) fn take_in(&mut self, scan: &LaserScan, beams: &Beams, robot: &Pose) {
        let hits = &mut self.hits[scan.laser];
        hits.clear();
        let nearest_m = TOO_NEAR_SHARE * beams.spec.range_min_m;
        hits.extend(beams.ends(scan, beams.eye(robot), nearest_m, FARTHEST_M, 0.0));
    }

    /// How far a disc of radius `needed_m` at `from` can drive along an arc of that curvature (1/m, positive to the
    /// left), at most `horizon_m`, without coming near a hit, or nearer than it is.
    pub(crate) fn free_way(&self, from: &Pose, curvature: f64, horizon_m: f64, needed_m: f64) -> FreeWay {
        let now_m = self.nearest(&from.translation.vector.into()).map_or(f64::INFINITY, |(_, distance_m)| distance_m);
        let needed_m = needed_m.min(now_m - NEARER_M);
        let looks = (horizon_m / LOOK_M).ceil().max(1.0) as usize;
        for look in 1..=looks {
            let way_m = horizon_m * look as f64 / looks as f64;
            let at = from * along_arc(way_m, curvature);
            match self.nearest(&at) {
                Some((obstacle, distance_m)) if distance_m < needed_m => {
                    let way_m = horizon_m * (look - 1) as f64 / looks as f64;
                    return FreeWay { way_m, obstacle: Some(obstacle) };
                }
                _ => {}
            }
        }
        FreeWay { way_m: horizon_m, obstacle: None }
    }

    /// Whether something is still seen where it was.
    pub(crate) fn is_near(&self, obstacle: &Point) -> bool {
        self.nearest(obstacle).is_some_and(|(_, distance_m)| distance_m < STILL_THERE_M)
    }

    /// The hit nearest to a point, and how far it is, in metres.
    fn nearest(&self, at: &Point) -> Option<(Point, f64)> {
        let mut best: Option<(Point, f64)> = None;
        for hit in self.hits.iter().flatten() {
            let squared = (hit - at).norm_squared();
            if best.is_none_or(|(_, least)| squared < least) {
                best = Some((*hit, squared));
            }
        }
        best.map(|(hit, squared)| (hit, squared.sqrt()))
    }
}

/// Where an arc from the origin along x has got to after a way.
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

    use super::*;

    fn with_hits(hits: &[(f64, f64)]) -> Surroundings {
        Surroundings { hits: vec![Vec::new(), hits.iter().map(|(x, y)| Point::new(*x, *y)).collect()] }
    }

    #[test]
    fn the_way_ends_before_what_is_in_it() {
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
}
