//! Goals to drive to.

use maps::{Place, Point};

/// The default tolerances of a goal, in meters and radians: 0.05 m and 0.6°, as in the original system.
const POSITION_TOLERANCE_M: f64 = 0.05;
const HEADING_TOLERANCE_RAD: f64 = 0.6 * std::f64::consts::PI / 180.0;

/// Share of a goal's tolerance by which a path may end beside it, because the robot does not fit there.
const SHARE_OF_PLAN: f64 = 0.6;

/// A place to drive to, with tolerances for the robot's own estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// The position, in the `map` frame.
    pub position: Point,
    /// The heading, in radians in the `map` frame, if it matters.
    pub heading_rad: Option<f64>,
    /// Distance from the position within which the goal is reached, in meters; positive.
    pub position_tolerance_m: f64,
    /// Deviation from the heading within which the goal is reached, in radians; positive.
    pub heading_tolerance_rad: f64,
    /// The area whose centroid is the position, if there is one: if the robot cannot reach the centroid, any other
    /// point inside is acceptable.
    pub area: Option<Place>,
}

impl Goal {
    /// A position, with any heading or with one in radians, within 0.05 m and 0.6°.
    #[must_use]
    pub fn at(position: Point, heading_rad: Option<f64>) -> Self {
        Self {
            position,
            heading_rad,
            position_tolerance_m: POSITION_TOLERANCE_M,
            heading_tolerance_rad: HEADING_TOLERANCE_RAD,
            area: None,
        }
    }

    /// A place, within 0.05 m and 0.6°: its pose, or the centroid of its area. The place's own tolerances determine
    /// whether a robot counts as being there; driving is more precise.
    #[must_use]
    pub fn to(place: &Place) -> Self {
        let area = matches!(place, Place::Area { .. }).then(|| place.clone());
        Self { area, ..Self::at(place.goal_position(), place.goal_heading()) }
    }

    /// How far beside the goal a path may end, in meters.
    pub(crate) fn plan_tolerance_m(&self) -> f64 {
        SHARE_OF_PLAN * self.position_tolerance_m
    }

    /// Whether all numbers are finite and the tolerances positive.
    pub(crate) fn is_valid(&self) -> bool {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        self.position.coords.iter().all(|coordinate| coordinate.is_finite())
            && self.heading_rad.is_none_or(f64::is_finite)
            && positive(self.position_tolerance_m)
            && positive(self.heading_tolerance_rad)
    }
}
