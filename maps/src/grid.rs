//! Occupancy grids.

use crate::{Point, Pose};

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Cell {
    /// Seen to be empty.
    Free,
    /// A wall or another fixed obstacle.
    Occupied,
    /// Never seen: transparent to lasers, not solid in simulation, never planned through.
    #[default]
    Unknown,
}

/// A cell's place in its grid: column along the grid's x axis, row along its y axis, both from the origin's corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellIndex {
    /// Column, 0 at the origin.
    pub column: usize,
    /// Row, 0 at the origin, growing along y (upwards in a picture of the map).
    pub row: usize,
}

/// A rectangular grid of cells with its place in the `map` frame.
///
/// The origin is the pose of the lower left corner of cell (0, 0); its heading turns the whole grid.
/// Cells are half open: cell (c, r) covers grid coordinates [c, c + 1) × [r, r + 1).
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
    #[must_use]
    pub fn new(width: usize, height: usize, resolution_m: f64, origin: Pose) -> Self {
        Self { width, height, resolution_m, origin, cells: vec![Cell::Unknown; width * height] }
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

    /// Side of a cell, in metres.
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

    /// Position of a cell in [`cells`](Self::cells), or `None` outside the grid.
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

    /// The cell that holds a point of the `map` frame, or `None` outside the grid.
    #[must_use]
    pub fn index_of(&self, point: &Point) -> Option<CellIndex> {
        let grid = self.to_grid(point);
        let inside = grid.x >= 0.0 && grid.y >= 0.0 && grid.x < self.width as f64 && grid.y < self.height as f64;
        inside.then(|| CellIndex { column: grid.x as usize, row: grid.y as usize })
    }

    /// The centre of a cell in the `map` frame.
    #[must_use]
    pub fn center(&self, index: CellIndex) -> Point {
        self.from_grid(&Point::new(index.column as f64 + 0.5, index.row as f64 + 0.5))
    }
}
