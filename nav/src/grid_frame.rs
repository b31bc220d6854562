//! The geometry of an occupancy grid without its cells.

use maps::{OccupancyGrid, Point, Pose};

/// Size, cell side and pose of a grid in the `map` frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GridFrame {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) resolution_m: f64,
    origin: Pose,
}

impl GridFrame {
    pub(crate) fn of(map: &OccupancyGrid) -> Self {
        Self { width: map.width(), height: map.height(), resolution_m: map.resolution_m(), origin: map.origin() }
    }

    /// A point of the `map` frame in cells from the origin's corner.
    pub(crate) fn in_grid(&self, point: &Point) -> Point {
        self.origin.inverse_transform_point(point) / self.resolution_m
    }

    /// A point in cells from the origin's corner in the `map` frame.
    pub(crate) fn in_map(&self, point: &Point) -> Point {
        self.origin * (point * self.resolution_m)
    }

    /// A pose of the `map` frame in meters from the origin's corner, along the grid's axes.
    pub(crate) fn pose_in_grid(&self, pose: &Pose) -> Pose {
        self.origin.inv_mul(pose)
    }

    /// Offset of the cell that contains a point of the `map` frame, or `None` outside the grid (and for NaN).
    pub(crate) fn offset_at(&self, point: &Point) -> Option<usize> {
        self.offset_in_grid(&self.in_grid(point))
    }

    /// Offset of the cell that contains a point given in cells from the origin's corner.
    pub(crate) fn offset_in_grid(&self, at: &Point) -> Option<usize> {
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.width as f64 && at.y < self.height as f64;
        inside.then(|| at.y as usize * self.width + at.x as usize)
    }

    pub(crate) fn column_and_row(&self, offset: usize) -> (usize, usize) {
        (offset % self.width, offset / self.width)
    }

    /// Center of a cell in the `map` frame.
    pub(crate) fn center(&self, offset: usize) -> Point {
        let (column, row) = self.column_and_row(offset);
        self.in_map(&Point::new(column as f64 + 0.5, row as f64 + 0.5))
    }
}
