//! Rules for places in either format.

use std::f64::consts::{PI, TAU};

use diagnostics::{Problem, Span, Spanned};

use crate::map_file::MAX_COORDINATE_M;
use crate::{Place, Point, polygon, pose};

/// The default position tolerance of a point, in meters. It is less than the 0.5 m within which the robot docks, so a
/// robot whose estimate is at its station can charge.
pub const DEFAULT_POSITION_TOLERANCE_M: f64 = 0.3;

/// The default heading tolerance of a point, in degrees. It is less than the 10° within which the robot docks.
pub const DEFAULT_HEADING_TOLERANCE_DEG: f64 = 6.0;

/// The area with these corners; `span` covers all of them. One to keep out of is no goal.
pub(super) fn area(corners: Vec<Spanned<Point>>, span: &Span, keep_out: bool) -> Result<Place, Vec<Problem>> {
    let problems = polygon::problems(&corners, span);
    if !problems.is_empty() {
        return Err(problems);
    }
    let area = Place::Area { corners: corners.into_iter().map(|corner| corner.value).collect() };
    let goal = area.goal_position();
    if keep_out || area.contains(&pose(goal.x, goal.y, 0.0)) {
        return Ok(area);
    }
    let problem = span.problem("the area's centroid lies outside it, so a robot sent there would never arrive");
    Err(vec![problem.with_label(format!("the centroid is ({:.2}, {:.2})", goal.x, goal.y))])
}

/// A point with this position and heading, with the default tolerances.
pub(super) fn point_at([x_m, y_m]: [f64; 2], heading_deg: f64) -> Place {
    Place::Point {
        pose: pose(x_m, y_m, heading_deg.to_radians()),
        position_tolerance_m: DEFAULT_POSITION_TOLERANCE_M,
        heading_tolerance_rad: DEFAULT_HEADING_TOLERANCE_DEG.to_radians(),
    }
}

pub(super) fn near_enough(position: &[f64; 2]) -> bool {
    position.iter().all(|coordinate| coordinate.abs() <= MAX_COORDINATE_M)
}

pub(super) fn near_enough_text() -> String {
    format!("lie within {} km of the frame's origin", MAX_COORDINATE_M / 1e3)
}

/// How far a number of two or three digits may be from the angle that it stands for: 0.26 and 0.785 are 15° and 45° in
/// radians. Chosen, not measured.
const ROUNDED: f64 = 0.007;

/// The warning about a heading in degrees that looks like radians: like a multiple of 15°, with two or more digits
/// after the point.
#[must_use]
pub fn heading_concern(heading_deg: f64, span: &Span) -> Option<Problem> {
    let steps = (heading_deg * 12.0 / PI).round();
    let angle_rad = steps * PI / 12.0;
    let is_near = steps != 0.0 && (heading_deg - angle_rad).abs() <= ROUNDED * angle_rad.abs();
    let tenths = heading_deg * 10.0;
    if !is_near || angle_rad.abs() > TAU || (tenths - tenths.round()).abs() < 1e-6 {
        return None;
    }
    let problem = span.problem(format!("a heading of {heading_deg}° looks like radians")).as_warning();
    let help = format!("headings are in degrees: {heading_deg} rad would be {}°", steps * 15.0);
    Some(problem.with_label("in degrees").with_help(help))
}
