//! What a place must be like, whatever the format.

use diagnostics::{Problem, Span, Spanned};

use crate::map_file::MAX_COORDINATE_M;
use crate::{Place, Point, polygon, pose};

/// How far from a point still counts as there unless the file says otherwise, in metres. Less than the 0.5 m within
/// which the robot docks, so that a robot that believes to be at its station can charge.
pub const DEFAULT_POSITION_TOLERANCE_M: f64 = 0.3;

/// How far from a heading still counts as there unless the file says otherwise, in degrees. Less than the 10° within
/// which the robot docks.
pub const DEFAULT_HEADING_TOLERANCE_DEG: f64 = 6.0;

/// The area with these corners, which stand at `span` all together.
pub(super) fn area(corners: Vec<Spanned<Point>>, span: &Span) -> Result<Place, Vec<Problem>> {
    let problems = polygon::problems(&corners, span);
    if !problems.is_empty() {
        return Err(problems);
    }
    let area = Place::Area { corners: corners.into_iter().map(|corner| corner.value).collect() };
    let goal = area.goal_position();
    if area.contains(&pose(goal.x, goal.y, 0.0)) {
        return Ok(area);
    }
    let problem = span.problem("the area's centroid lies outside it, so that nobody sent there would arrive");
    Err(vec![problem.with_label(format!("the centroid is ({:.2}, {:.2})", goal.x, goal.y))])
}

/// The point at a position that faces so, with the tolerances of a file that says nothing of them.
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
