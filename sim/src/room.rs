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
    let (width_m, height_m) = (width as f64 * walls.resolution_m, height as f64 * walls.resolution_m);
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
    let reach = within_m / walls.resolution_m;
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
            (index, (dx * dx + dy * dy).sqrt() * walls.resolution_m)
        })
        .filter(|(_, distance_m)| *distance_m < within_m)
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((walls.to_map(&Point::new(cell.column as f64 + 0.5, cell.row as f64 + 0.5)), distance_m))
}

/// The distance of a point from the nearest wall, in meters, if it is below `within_m`, and infinite otherwise.
pub(crate) fn wall_distance_m(walls: &RayGrid, point: &Point, within_m: f64) -> f64 {
    let (width, height) = walls.extent();
    let farthest_m = ((width + height) as f64 * walls.resolution_m).min(within_m);
    // The cells to be searched grow with the square of the distance, and a wall is mostly near.
    let mut reach_m = farthest_m.min(0.5);
    loop {
        match nearest_wall(walls, point, reach_m) {
            Some((_, distance_m)) => return distance_m,
            None if reach_m >= farthest_m => return f64::INFINITY,
            None => reach_m = (2.0 * reach_m).min(farthest_m),
        }
    }
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

#[cfg(test)]
mod tests {
    use maps::{Cell, OccupancyGrid, pose};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_nearest_wall_is_found_however_far_it_is(
            walls in prop::collection::vec((0..60_usize, 0..40_usize), 0..5),
            (x, y) in (-1.0..31.0, -1.0..21.0),
            within_m in 0.0..50.0,
        ) {
            let mut grid = OccupancyGrid::new(60, 40, 0.5, pose(0.0, 0.0, 0.0));
            for row in 0..40 {
                for column in 0..60 {
                    grid.set(CellIndex { column, row }, Cell::Free);
                }
            }
            for (column, row) in &walls {
                grid.set(CellIndex { column: *column, row: *row }, Cell::Occupied);
            }
            let to_cell = |(column, row): &(usize, usize)| {
                let near = |value: f64, first: usize| value.clamp(first as f64 * 0.5, (first + 1) as f64 * 0.5);
                Point::new(x - near(x, *column), y - near(y, *row)).coords.norm()
            };
            let nearest_m = walls.iter().map(to_cell).fold(f64::INFINITY, f64::min);
            let expected = if nearest_m < within_m { nearest_m } else { f64::INFINITY };
            let found = wall_distance_m(&RayGrid::new(&grid), &Point::new(x, y), within_m);
            prop_assert!(found == expected || (found - expected).abs() < 1e-9, "{found} m, not {expected} m");
        }
    }
}
