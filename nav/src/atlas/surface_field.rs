//! The signed distance to the surfaces of the map, and its gradient.

use maps::{Cell, CellIndex, OccupancyGrid};

use crate::distance_transform::{NO_TARGET, squared_distances};

/// For each cell center near an obstacle, its distance from the obstacle's surface, negative inside.
///
/// Between cell centers it is interpolated, so it is zero on the faces of cells, where beams end. The field covers the
/// map's obstacles with a margin; outside it, the distance is the maximum.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceField {
    /// Grid coordinates of the field's first cell; it may lie outside the map.
    column: i64,
    row: i64,
    width: usize,
    height: usize,
    pub(crate) resolution_m: f64,
    farthest_m: f32,
    distances_m: Vec<f32>,
}

impl SurfaceField {
    /// The field of a map. Distances are cut off at `farthest_m`.
    pub(crate) fn new(map: &OccupancyGrid, farthest_m: f64) -> Self {
        let margin = (farthest_m / map.resolution_m()).ceil() as i64 + 1;
        let (columns, rows) = extent_of_obstacles(map);
        let (column, row) = (columns.0 - margin, rows.0 - margin);
        let width = (columns.1 + margin + 1 - column) as usize;
        let height = (rows.1 + margin + 1 - row) as usize;
        let occupied = |offset: usize| {
            let at = (column + (offset % width) as i64, row + (offset / width) as i64);
            cell(map, at.0, at.1) == Cell::Occupied
        };
        let outside = squared_distances(width, height, occupied);
        let inside = squared_distances(width, height, |offset| outside[offset] != 0);
        // Between two cell centers on either side of a surface, the surface is in the middle.
        let to_surface = |squared: u32| match squared {
            NO_TARGET => farthest_m,
            _ => ((f64::from(squared).sqrt() - 0.5) * map.resolution_m()).min(farthest_m),
        };
        let signed = |(outside, inside)| if outside == 0 { -to_surface(inside) } else { to_surface(outside) };
        let distances_m = outside.into_iter().zip(inside).map(|pair| signed(pair) as f32).collect();
        let resolution_m = map.resolution_m();
        Self { column, row, width, height, resolution_m, farthest_m: farthest_m as f32, distances_m }
    }

    /// Columns and rows of cells, and the grid coordinates of the first one's corner.
    pub(crate) fn window(&self) -> (usize, usize, i64, i64) {
        (self.width, self.height, self.column, self.row)
    }

    /// The distance at a point in grid coordinates (cells from the map's corner), in meters, and its gradient along the
    /// grid's axes, in meters per meter. `None` far from all surfaces.
    pub(crate) fn sample(&self, column: f64, row: f64) -> Option<(f64, [f64; 2])> {
        // The corner of the four cell centers around the point.
        let (u, v) = (column - self.column as f64 - 0.5, row - self.row as f64 - 0.5);
        if !(u >= 0.0 && v >= 0.0 && u < (self.width - 1) as f64 && v < (self.height - 1) as f64) {
            return None;
        }
        let first = v as usize * self.width + u as usize;
        let (across, along) = (u - u.floor(), v - v.floor());
        let corners = [first, first + 1, first + self.width, first + self.width + 1];
        if corners.iter().all(|&corner| self.distances_m[corner] >= self.farthest_m) {
            return None;
        }
        let [a, b, c, d] = corners.map(|corner| f64::from(self.distances_m[corner]));
        let (lower, upper) = (a + (b - a) * across, c + (d - c) * across);
        let gradient =
            [((b - a) + ((d - c) - (b - a)) * along) / self.resolution_m, (upper - lower) / self.resolution_m];
        Some((lower + (upper - lower) * along, gradient))
    }

    /// The greatest distance in the field, in meters.
    pub(crate) fn farthest_m(&self) -> f64 {
        f64::from(self.farthest_m)
    }
}

/// A cell by grid coordinates; unknown outside the map.
pub(crate) fn cell(map: &OccupancyGrid, column: i64, row: i64) -> Cell {
    match (usize::try_from(column), usize::try_from(row)) {
        (Ok(column), Ok(row)) => map.cell(CellIndex { column, row }).unwrap_or_default(),
        _ => Cell::Unknown,
    }
}

/// The first and last column and the first and last row with an occupied cell; the first cell if there is none.
fn extent_of_obstacles(map: &OccupancyGrid) -> ((i64, i64), (i64, i64)) {
    let mut extent: Option<((usize, usize), (usize, usize))> = None;
    for (offset, _) in map.cells().iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied) {
        let (column, row) = (offset % map.width(), offset / map.width());
        let (columns, rows) = extent.get_or_insert(((column, column), (row, row)));
        *columns = (columns.0.min(column), columns.1.max(column));
        rows.1 = row;
    }
    let ((left, right), (bottom, top)) = extent.unwrap_or_default();
    ((left as i64, right as i64), (bottom as i64, top as i64))
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    fn wall() -> OccupancyGrid {
        let mut map = OccupancyGrid::new(40, 30, 0.1, pose(0.0, 0.0, 0.0));
        (0..30).for_each(|row| map.set(CellIndex { column: 20, row }, Cell::Occupied));
        map
    }

    #[test]
    fn the_surface_is_where_the_distance_is_zero() {
        let field = SurfaceField::new(&wall(), 0.5);
        for (column, distance_m) in [(20.0, 0.0), (21.0, 0.0), (20.5, -0.05), (18.0, 0.2), (23.5, 0.25)] {
            let (found, gradient) = field.sample(column, 15.2).unwrap();
            assert!((found - distance_m).abs() < 1e-6, "{found} instead of {distance_m} at {column}");
            assert!(gradient[1].abs() < 1e-6);
        }
        assert!((field.sample(19.3, 15.0).unwrap().1[0] + 1.0).abs() < 1e-5, "one meter nearer per meter");
        assert!(field.sample(8.0, 15.0).is_none(), "far away");
    }

    #[test]
    fn a_map_without_obstacles_is_far_from_everything() {
        let field = SurfaceField::new(&OccupancyGrid::new(5, 5, 0.1, pose(0.0, 0.0, 0.0)), 0.5);
        assert!(field.sample(2.5, 2.5).is_none());
    }
}
