//! Occupancy grids.

use crate::{Point, Pose};

/// The largest map that is loaded or saved: 500 m × 500 m at 0.05 m.
pub const MAX_CELLS: usize = 100_000_000;

/// What is known about a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Cell {
    /// Seen to be empty.
    Free,
    /// A wall or other fixed obstacle.
    Occupied,
    /// Never seen: transparent to lasers, not solid in simulation, never planned through.
    #[default]
    Unknown,
}

/// A cell of a grid: column along the grid's x axis, row along its y axis, both counted from the origin's corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellIndex {
    /// Column, 0 at the origin.
    pub column: usize,
    /// Row, 0 at the origin, growing along y (upwards in an image of the map).
    pub row: usize,
}

/// A rectangular grid of cells with its pose in the `map` frame.
///
/// The origin is the pose of the lower left corner of cell (0, 0); its heading rotates the whole grid. Cells are half
/// open: cell (c, r) covers grid coordinates [c, c + 1) × [r, r + 1).
///
/// ```
/// use maps::{Cell, CellIndex, OccupancyGrid, Point, pose};
///
/// // 2 m × 1 m of free floor, with a wall along the left.
/// let mut grid = OccupancyGrid::from_cells(20, 10, 0.1, pose(0.0, 0.0, 0.0), vec![Cell::Free; 200]);
/// (0..10).for_each(|row| grid.set(CellIndex { column: 0, row }, Cell::Occupied));
/// assert_eq!(grid.index_of(&Point::new(0.05, 0.45)), Some(CellIndex { column: 0, row: 4 }));
/// assert!(grid.has_room(&Point::new(1.0, 0.5), 0.3));
/// assert!(!grid.has_room(&Point::new(0.3, 0.5), 0.3)); // 0.2 m from the wall
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyGrid {
    width: usize,
    height: usize,
    resolution_m: f64,
    origin: Pose,
    cells: Vec<Cell>,
}

impl OccupancyGrid {
    /// A grid of `width` × `height` unknown cells of side `resolution_m`.
    ///
    /// # Panics
    /// If the resolution is not a positive number.
    #[must_use]
    pub fn new(width: usize, height: usize, resolution_m: f64, origin: Pose) -> Self {
        Self::from_cells(width, height, resolution_m, origin, vec![Cell::Unknown; width * height])
    }

    /// A grid of `width` columns with the given cells, row by row from row 0.
    ///
    /// # Panics
    /// If there are not `width` × `height` cells, or the resolution is not a positive number.
    #[must_use]
    pub fn from_cells(width: usize, height: usize, resolution_m: f64, origin: Pose, cells: Vec<Cell>) -> Self {
        assert_eq!(cells.len(), width * height, "a grid must have one cell per column and row");
        assert!(resolution_m.is_finite() && resolution_m > 0.0, "a cell must have a size, not {resolution_m} m");
        Self { width, height, resolution_m, origin, cells }
    }

    /// Number of columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Side of a cell, in meters.
    #[must_use]
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Pose of the lower left corner of cell (0, 0) in the `map` frame.
    #[must_use]
    pub fn origin(&self) -> Pose {
        self.origin
    }

    /// All cells, row by row from row 0.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The cell at `index`, or `None` outside the grid.
    #[must_use]
    pub fn cell(&self, index: CellIndex) -> Option<Cell> {
        self.offset(index).map(|offset| self.cells[offset])
    }

    /// Sets a cell.
    ///
    /// # Panics
    /// If `index` lies outside the grid.
    pub fn set(&mut self, index: CellIndex, cell: Cell) {
        let offset = self.offset(index).expect("a cell that is set lies inside its grid");
        self.cells[offset] = cell;
    }

    /// Index of a cell in [`cells`](Self::cells), or `None` outside the grid.
    #[must_use]
    pub fn offset(&self, index: CellIndex) -> Option<usize> {
        (index.column < self.width && index.row < self.height).then(|| index.row * self.width + index.column)
    }

    /// A point of the `map` frame in grid coordinates: in cells from the origin's corner, along the grid's axes.
    #[must_use]
    pub fn to_grid(&self, point: &Point) -> Point {
        self.origin.inverse_transform_point(point) / self.resolution_m
    }

    /// A point in grid coordinates (cells from the origin's corner) in the `map` frame.
    #[must_use]
    pub fn from_grid(&self, point: &Point) -> Point {
        self.origin * (point * self.resolution_m)
    }

    /// The cell that contains a point of the `map` frame, or `None` outside the grid.
    #[must_use]
    pub fn index_of(&self, point: &Point) -> Option<CellIndex> {
        let grid = self.to_grid(point);
        let inside = grid.x >= 0.0 && grid.y >= 0.0 && grid.x < self.width as f64 && grid.y < self.height as f64;
        inside.then(|| CellIndex { column: grid.x as usize, row: grid.y as usize })
    }

    /// The center of a cell in the `map` frame.
    #[must_use]
    pub fn center(&self, index: CellIndex) -> Point {
        self.from_grid(&Point::new(index.column as f64 + 0.5, index.row as f64 + 0.5))
    }

    /// Whether a disc around a point of the `map` frame lies within the grid and touches only free cells, that is,
    /// whether a robot of this radius fits there. Touching includes the edge.
    #[must_use]
    pub fn has_room(&self, center: &Point, radius_m: f64) -> bool {
        let center = self.to_grid(center);
        let radius = radius_m / self.resolution_m;
        let fits = |at: f64, length: usize| at - radius >= 0.0 && at + radius < length as f64;
        if !fits(center.x, self.width) || !fits(center.y, self.height) {
            return false;
        }
        let span = |at: f64| (at - radius) as usize..=(at + radius) as usize;
        span(center.y).flat_map(|row| span(center.x).map(move |column| CellIndex { column, row })).all(|index| {
            let nearest = |at: f64, cell: usize| at - at.clamp(cell as f64, cell as f64 + 1.0);
            let (dx, dy) = (nearest(center.x, index.column), nearest(center.y, index.row));
            dx * dx + dy * dy > radius * radius || self.cell(index) == Some(Cell::Free)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose;

    #[test]
    fn a_cell_has_a_size() {
        for wrong in [0.0, -0.05, f64::NAN, f64::INFINITY] {
            let made = std::panic::catch_unwind(|| OccupancyGrid::new(2, 2, wrong, pose(0.0, 0.0, 0.0)));
            assert!(made.is_err(), "{wrong}");
        }
    }

    #[test]
    fn there_is_room_up_to_the_wall_and_no_further() {
        let mut grid = OccupancyGrid::from_cells(20, 20, 0.1, pose(-1.0, -1.0, 0.0), vec![Cell::Free; 400]);
        grid.set(CellIndex { column: 15, row: 10 }, Cell::Occupied);
        assert!(grid.has_room(&Point::new(0.0, 0.05), 0.49));
        assert!(!grid.has_room(&Point::new(0.0, 0.05), 0.51));
        // Past the corner of the cell, where its neighbors are free.
        assert!(grid.has_room(&Point::new(0.3, -0.2), 0.28));
        assert!(!grid.has_room(&Point::new(0.3, -0.2), 0.29));
    }

    #[test]
    fn there_is_no_room_on_the_edge_of_the_map_or_beside_the_unknown() {
        let mut grid = OccupancyGrid::from_cells(4, 4, 1.0, pose(0.0, 0.0, 0.0), vec![Cell::Free; 16]);
        assert!(!grid.has_room(&Point::new(0.9, 2.0), 1.0));
        assert!(grid.has_room(&Point::new(2.0, 2.0), 1.0));
        grid.set(CellIndex { column: 2, row: 2 }, Cell::Unknown);
        assert!(!grid.has_room(&Point::new(2.0, 2.0), 0.5));
        assert!(!grid.has_room(&Point::new(f64::NAN, 2.0), 0.5));
    }
}
