//! Named places on a map: points with a heading and tolerances, and polygonal areas.

use std::collections::BTreeMap;

use crate::{Point, Pose, heading, wrap_angle};

/// A place that can be the robot's goal, and where its presence can be checked.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// A pose with tolerances.
    Point {
        /// Position and heading in the `map` frame.
        pose: Pose,
        /// How far from the position a robot may be and still be at the place, in meters.
        position_tolerance_m: f64,
        /// How far its heading may deviate, in radians.
        heading_tolerance_rad: f64,
    },
    /// An area: a robot anywhere inside it, with any heading, is at the place. As a goal, it stands for its centroid.
    Area {
        /// Corners in the `map` frame, at least three; the last is joined to the first.
        corners: Vec<Point>,
    },
}

impl Place {
    /// The position to drive to in order to reach the place.
    #[must_use]
    pub fn goal_position(&self) -> Point {
        match self {
            Self::Point { pose, .. } => pose.translation.vector.into(),
            Self::Area { corners } => centroid(corners),
        }
    }

    /// The heading at the goal, in radians, if the place has one.
    #[must_use]
    pub fn goal_heading(&self) -> Option<f64> {
        match self {
            Self::Point { pose, .. } => Some(heading(pose)),
            Self::Area { .. } => None,
        }
    }

    /// Whether a robot at this position (`map` frame), with any heading, is there.
    #[must_use]
    pub fn covers(&self, at: &Point) -> bool {
        match self {
            Self::Point { position_tolerance_m, .. } => self.distance_m(at) <= *position_tolerance_m,
            Self::Area { corners } => is_inside(corners, at),
        }
    }

    /// The distance from a point of the `map` frame, in meters: to the position, or to the area, 0 inside.
    #[must_use]
    pub fn distance_m(&self, at: &Point) -> f64 {
        match self {
            Self::Point { pose, .. } => (at.coords - pose.translation.vector).norm(),
            Self::Area { corners } => distance_to_area_m(corners, at),
        }
    }

    /// Whether a robot at `pose` (`map` frame) is there.
    #[must_use]
    pub fn contains(&self, at: &Pose) -> bool {
        match self {
            Self::Point { pose, heading_tolerance_rad, .. } => {
                let turn = wrap_angle(heading(at) - heading(pose)).abs();
                self.covers(&at.translation.vector.into()) && turn <= *heading_tolerance_rad
            }
            Self::Area { .. } => self.covers(&at.translation.vector.into()),
        }
    }
}

/// An area with a rule for the robots that drive there.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// The name of the area, which is also a place.
    pub name: String,
    /// Its corners, in the `map` frame.
    pub corners: Vec<Point>,
    /// Whether no part of the robot may be in it.
    pub keep_out: bool,
    /// The highest speed of a robot whose center is in it, in m/s.
    pub speed_mps: Option<f64>,
}

impl Zone {
    /// The distance from a point of the `map` frame to the area, in meters; 0 inside.
    #[must_use]
    pub fn distance_m(&self, at: &Point) -> f64 {
        distance_to_area_m(&self.corners, at)
    }
}

/// The distance from a point to a polygon with these corners, in meters; 0 inside. A single corner is a point.
#[must_use]
pub fn distance_to_area_m(corners: &[Point], at: &Point) -> f64 {
    match corners {
        [corner] => (at - corner).norm(),
        _ if is_inside(corners, at) => 0.0,
        _ => edges(corners).map(|(a, b)| to_segment_m(at, &a, &b)).fold(f64::INFINITY, f64::min),
    }
}

/// The distance from a point to a line segment, in meters.
fn to_segment_m(at: &Point, a: &Point, b: &Point) -> f64 {
    let along = b - a;
    let share = ((at - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (at - (a + along * share)).norm()
}

/// The centroid of a simple polygon (of its area, not of its corners).
fn centroid(corners: &[Point]) -> Point {
    let mut doubled_area = 0.0;
    let mut sum = nalgebra::Vector2::zeros();
    for (a, b) in edges(corners) {
        let cross = a.x * b.y - b.x * a.y;
        doubled_area += cross;
        sum += (a.coords + b.coords) * cross;
    }
    (sum / (3.0 * doubled_area)).into()
}

/// Whether a point lies inside a polygon with these corners (even–odd rule).
#[must_use]
pub fn is_inside(corners: &[Point], point: &Point) -> bool {
    edges(corners)
        .filter(|(a, b)| (a.y > point.y) != (b.y > point.y))
        .filter(|(a, b)| point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x))
        .count()
        % 2
        == 1
}

fn edges(corners: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
}

/// The places of a map by name, in alphabetical order.
///
/// ```
/// use maps::{Place, Places, Point, pose};
///
/// let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)].map(|(x, y)| Point::new(x, y));
/// let mut places = Places::default();
/// places.insert("Kitchen", Place::Area { corners: corners.to_vec() });
/// let kitchen = places.get("Kitchen").expect("it was put there");
/// assert!(kitchen.contains(&pose(1.0, 2.0, 0.0)));
/// assert_eq!(kitchen.goal_position(), Point::new(2.0, 1.5));
/// ```
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Places {
    by_name: BTreeMap<String, Place>,
    zones: Vec<Zone>,
}

impl Places {
    /// Adds a place, or replaces the one with this name.
    pub fn insert(&mut self, name: impl Into<String>, place: Place) {
        self.by_name.insert(name.into(), place);
    }

    /// Adds a rule for one of the areas.
    pub fn add_zone(&mut self, zone: Zone) {
        self.zones.push(zone);
    }

    /// The areas with rules.
    #[must_use]
    pub fn zones(&self) -> &[Zone] {
        &self.zones
    }

    /// The place with this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Place> {
        self.by_name.get(name)
    }

    /// All places with their names, in alphabetical order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Place)> {
        self.by_name.iter().map(|(name, place)| (name.as_str(), place))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::pose;

    fn kitchen() -> Place {
        let corners = [(-13.2, 15.6), (-10.0, 15.4), (-10.2, 12.6), (-13.4, 13.0)];
        Place::Area { corners: corners.map(|(x, y)| Point::new(x, y)).to_vec() }
    }

    #[test]
    fn an_area_contains_its_centroid_but_not_its_surroundings() {
        let goal = kitchen().goal_position();
        assert!(kitchen().contains(&pose(goal.x, goal.y, 1.0)));
        assert!(!kitchen().contains(&pose(-9.0, 14.0, 0.0)));
        let away_m = kitchen().distance_m(&Point::new(-9.0, 14.0));
        assert!((1.09..1.1).contains(&away_m), "to the nearest edge: {away_m}");
    }

    #[test]
    fn a_point_contains_poses_within_both_tolerances() {
        let station =
            Place::Point { pose: pose(-7.5, 9.0, PI), position_tolerance_m: 0.5, heading_tolerance_rad: 0.17 };
        assert!(station.contains(&pose(-7.2, 9.0, -3.10)));
        assert!(!station.contains(&pose(-7.2, 9.0, 2.9)));
        assert!(!station.contains(&pose(-6.9, 9.0, PI)));
    }
}
