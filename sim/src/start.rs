//! Checks that the robot has room where it starts.

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose};

use crate::config::{ObstacleConfig, Shape};
use crate::error::SimError;

/// Fails if a robot of that radius does not fit where it starts, or the station is not on the map.
pub(crate) fn check_places(
    grid: &OccupancyGrid,
    obstacles: &[ObstacleConfig],
    radius_m: f64,
    start: &Pose,
    station: &Pose,
) -> Result<(), SimError> {
    let at: Point = start.translation.vector.into();
    let (width_m, height_m) = (grid.width() as f64 * grid.resolution_m(), grid.height() as f64 * grid.resolution_m());
    if grid.index_of(&at).is_none() {
        return Err(SimError::StartOutsideMap { x_m: at.x, y_m: at.y, width_m, height_m });
    }
    let station: Point = station.translation.vector.into();
    if grid.index_of(&station).is_none() {
        return Err(SimError::StationOutsideMap { x_m: station.x, y_m: station.y, width_m, height_m });
    }
    if let Some((wall, distance_m)) = nearest_wall(grid, &at, radius_m) {
        let wall = grid.center(wall);
        let (wall_x_m, wall_y_m) = (wall.x, wall.y);
        return Err(SimError::StartInWall { x_m: at.x, y_m: at.y, radius_m, distance_m, wall_x_m, wall_y_m });
    }
    for obstacle in obstacles {
        let distance_m = distance_to(&obstacle.shape, &obstacle.pose.inverse_transform_point(&at));
        if distance_m < radius_m {
            let obstacle = obstacle.name.clone();
            return Err(SimError::StartInObstacle { x_m: at.x, y_m: at.y, radius_m, distance_m, obstacle });
        }
    }
    Ok(())
}

/// The occupied cell nearest to a point and how far it is, if nearer than `within_m`.
fn nearest_wall(grid: &OccupancyGrid, point: &Point, within_m: f64) -> Option<(CellIndex, f64)> {
    let at = grid.to_grid(point);
    let reach = within_m / grid.resolution_m();
    let span = |center: f64, cells: usize| {
        let last = ((center + reach).max(0.0) as usize).min(cells.saturating_sub(1));
        (center - reach).max(0.0) as usize..=last
    };
    let columns = span(at.x, grid.width());
    span(at.y, grid.height())
        .flat_map(|row| columns.clone().map(move |column| CellIndex { column, row }))
        .filter(|index| grid.cell(*index) == Some(Cell::Occupied))
        .map(|index| {
            let dx = outside(at.x, index.column as f64, index.column as f64 + 1.0);
            let dy = outside(at.y, index.row as f64, index.row as f64 + 1.0);
            (index, (dx * dx + dy * dy).sqrt() * grid.resolution_m())
        })
        .filter(|(_, distance_m)| *distance_m < within_m)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Distance from a shape to a point in the shape's frame; 0 inside.
fn distance_to(shape: &Shape, point: &Point) -> f64 {
    match shape {
        Shape::Disc { radius_m } => (point.coords.norm() - radius_m).max(0.0),
        Shape::Box { length_m, width_m } => {
            let dx = outside(point.x, -0.5 * length_m, 0.5 * length_m);
            let dy = outside(point.y, -0.5 * width_m, 0.5 * width_m);
            (dx * dx + dy * dy).sqrt()
        }
    }
}

/// How far a value lies outside an interval.
fn outside(value: f64, low: f64, high: f64) -> f64 {
    (low - value).max(value - high).max(0.0)
}
