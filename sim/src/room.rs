//! Checks whether there is room for the robot.

use maps::{CellIndex, Point, Pose, Shape};

use crate::error::{Placement, SimError};
use crate::ray_grid::RayGrid;

/// Fails if something is outside the map.
pub(crate) fn check_on_map(walls: &RayGrid, what: Placement, at: &Point) -> Result<(), SimError> {
    let (width, height) = walls.extent();
    if walls.holds(&walls.to_grid(at)) {
        return Ok(());
    }
    let (width_m, height_m) = (width as f64 * walls.resolution_m(), height as f64 * walls.resolution_m());
    Err(SimError::OutsideMap { what, x_m: at.x, y_m: at.y, width_m, height_m })
}

/// Fails if a robot with this radius at a point is outside the map, or overlaps a wall or one of the obstacles.
pub(crate) fn check_room<'a>(
    walls: &RayGrid,
    obstacles: impl Iterator<Item = (&'a str, &'a Shape, &'a Pose)>,
    radius_m: f64,
    what: Placement,
    at: &Point,
) -> Result<(), SimError> {
    check_on_map(walls, what, at)?;
    let (x_m, y_m) = (at.x, at.y);
    if let Some((wall, distance_m)) = nearest_wall(walls, at, radius_m) {
        let (wall_x_m, wall_y_m) = (wall.x, wall.y);
        return Err(SimError::InWall { what, x_m, y_m, radius_m, distance_m, wall_x_m, wall_y_m });
    }
    for (name, shape, pose) in obstacles {
        let distance_m = distance_to(shape, pose, at);
        if distance_m < radius_m {
            return Err(SimError::InObstacle { what, x_m, y_m, radius_m, distance_m, obstacle: name.to_owned() });
        }
    }
    Ok(())
}

/// The center of the occupied cell nearest to a point, and its distance, if that is below `within_m`.
pub(crate) fn nearest_wall(walls: &RayGrid, point: &Point, within_m: f64) -> Option<(Point, f64)> {
    let at = walls.to_grid(point);
    let (width, height) = walls.extent();
    let reach = within_m / walls.resolution_m();
    let span = |center: f64, cells: usize| {
        let last = ((center + reach).max(0.0) as usize).min(cells.saturating_sub(1));
        (center - reach).max(0.0) as usize..=last
    };
    let columns = span(at.x, width);
    let (cell, distance_m) = span(at.y, height)
        .flat_map(|row| columns.clone().map(move |column| CellIndex { column, row }))
        .filter(|index| walls.is_occupied(*index))
        .map(|index| {
            let dx = outside(at.x, index.column as f64, index.column as f64 + 1.0);
            let dy = outside(at.y, index.row as f64, index.row as f64 + 1.0);
            (index, (dx * dx + dy * dy).sqrt() * walls.resolution_m())
        })
        .filter(|(_, distance_m)| *distance_m < within_m)
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((walls.to_map(&Point::new(cell.column as f64 + 0.5, cell.row as f64 + 0.5)), distance_m))
}

/// Distance from a shape at a pose to a point; 0 inside.
pub(crate) fn distance_to(shape: &Shape, pose: &Pose, point: &Point) -> f64 {
    let point = pose.inverse_transform_point(point);
    match shape {
        Shape::Disc { radius_m } => (point.coords.norm() - radius_m).max(0.0),
        Shape::Box { length_m, width_m } => {
            let dx = outside(point.x, -0.5 * length_m, 0.5 * length_m);
            let dy = outside(point.y, -0.5 * width_m, 0.5 * width_m);
            (dx * dx + dy * dy).sqrt()
        }
    }
}

/// The distance of a value from an interval.
fn outside(value: f64, low: f64, high: f64) -> f64 {
    (low - value).max(value - high).max(0.0)
}
