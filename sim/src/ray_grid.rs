//! Rays against the walls of an occupancy grid, exactly.
//!
//! This is the plain grid traversal (Amanatides and Woo, *A Fast Voxel Traversal Algorithm*, 1987): from cell to cell,
//! across the nearer of the next two grid lines. Its conventions define "exact" for everything that is tested against
//! it, above all the sweep that casts whole scans:
//!
//! - Cells are half open; a ray starts in the cell (⌊x⌋, ⌊y⌋). If that cell is occupied, the distance is 0.
//! - A step goes along x only if `ex · |dy| < ey · |dx|`, where `ex` and `ey` are the distances to the next grid lines
//!   across x and across y; so a ray through a corner steps along y first. A component that is 0 never crosses a line.
//! - Both sides are products: reciprocals would break the ties of rational slopes. `ex` is the difference of the line's
//!   coordinate and the origin's, rounded once and not with every step; so the order of two lines does not depend on
//!   the ray's earlier path, and neither does the distance `ex / |dx|` of a wall behind the line.
//! - A wall counts if its distance is not greater than the maximum. Unknown cells are transparent, and the space
//!   outside the grid is empty.

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose};
use nalgebra::{UnitComplex, Vector2};

use crate::beams::Beams;

const TRANSPARENT: u8 = 0;
const OCCUPIED: u8 = 1;
const BORDER: u8 = 2;

/// The walls of an occupancy grid, prepared for casting single rays.
#[derive(Clone, Debug)]
pub struct RayGrid {
    /// Row by row, with a border of one cell on all sides, so that a ray need not check for the end of the grid.
    cells: Vec<u8>,
    /// Length of a row with its border.
    stride: usize,
    width: usize,
    height: usize,
    pub(crate) resolution_m: f64,
    /// Transforms the `map` frame to the grid's.
    from_map: Pose,
}

/// The point where a ray hits a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance from the origin, in lengths of the ray's direction.
    pub distance: f64,
    /// Index in the bordered grid.
    offset: usize,
}

impl RayGrid {
    /// The walls of a grid: its occupied cells.
    #[must_use]
    pub fn new(grid: &OccupancyGrid) -> Self {
        let (width, height, stride) = (grid.width(), grid.height(), grid.width() + 2);
        let mut cells = vec![BORDER; stride * (height + 2)];
        for row in 0..height {
            let from = &grid.cells()[row * width..][..width];
            let to = &mut cells[(row + 1) * stride + 1..][..width];
            for (to, from) in to.iter_mut().zip(from) {
                *to = if *from == Cell::Occupied { OCCUPIED } else { TRANSPARENT };
            }
        }
        Self { cells, stride, width, height, resolution_m: grid.resolution_m(), from_map: grid.origin().inverse() }
    }

    /// Changes a cell.
    ///
    /// # Panics
    /// If `index` lies outside the grid.
    pub fn set(&mut self, index: CellIndex, cell: Cell) {
        assert!(index.column < self.width && index.row < self.height, "a cell that is set lies inside its grid");
        let offset = self.offset(index.column, index.row);
        self.cells[offset] = if cell == Cell::Occupied { OCCUPIED } else { TRANSPARENT };
    }

    /// The distances at which a scanner's beams hit a wall, in meters, in the order of the beams; infinite if there is
    /// none within `range_max_m`. `base` is the pose of the robot (`base_link`) in the `map` frame.
    ///
    /// Beams are cast one by one: [`Walls::ranges`](crate::Walls::ranges) gives the same numbers much faster.
    pub fn ranges(&self, beams: &Beams, base: &Pose, range_max_m: f64, ranges_m: &mut Vec<f64>) {
        let (origin, rotation) = self.place(beams, base);
        let max = range_max_m / self.resolution_m;
        ranges_m.clear();
        ranges_m.extend(beams.directions().map(|direction| {
            let hit = self.cast(&origin, &(rotation * direction), max);
            hit.map_or(f64::INFINITY, |hit| hit.distance * self.resolution_m)
        }));
    }

    /// The point where the ray from `origin` (grid coordinates: cells from the grid's corner) along `direction` (grid
    /// axes, any length) hits the first occupied cell, if it does within `max` lengths of the direction. A ray from
    /// inside an occupied cell hits it at 0.
    #[must_use]
    pub fn cast(&self, origin: &Point, direction: &Vector2<f64>, max: f64) -> Option<RayHit> {
        if self.holds(origin) {
            self.cast_inside(origin, direction, max)
        } else {
            self.cast_from_outside(origin, direction, max)
        }
    }

    /// The occupied cell of a hit.
    #[must_use]
    pub fn cell(&self, hit: &RayHit) -> CellIndex {
        CellIndex { column: hit.offset % self.stride - 1, row: hit.offset / self.stride - 1 }
    }

    /// Number of columns and of rows.
    pub(crate) fn extent(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Whether a cell of the grid is a wall.
    pub(crate) fn is_occupied(&self, index: CellIndex) -> bool {
        self.cells[self.offset(index.column, index.row)] == OCCUPIED
    }

    /// A point of the `map` frame in grid coordinates.
    pub(crate) fn to_grid(&self, point: &Point) -> Point {
        self.from_map * point / self.resolution_m
    }

    /// A point in grid coordinates in the `map` frame.
    pub(crate) fn to_map(&self, point: &Point) -> Point {
        self.from_map.inverse_transform_point(&(point * self.resolution_m))
    }

    /// The origin of a scanner's beams, in grid coordinates, and the rotation to the grid's axes.
    pub(crate) fn place(&self, beams: &Beams, base: &Pose) -> (Point, UnitComplex<f64>) {
        let base = self.from_map * base;
        (base * beams.origin() / self.resolution_m, base.rotation)
    }

    /// Whether a point in grid coordinates is inside the grid and not in a wall.
    pub(crate) fn is_clear(&self, point: &Point) -> bool {
        self.holds(point) && self.cells[self.offset(point.x as usize, point.y as usize)] == TRANSPARENT
    }

    /// Whether a point in grid coordinates is inside the grid.
    pub(crate) fn holds(&self, point: &Point) -> bool {
        point.x >= 0.0 && point.y >= 0.0 && point.x < self.width as f64 && point.y < self.height as f64
    }

    fn offset(&self, column: usize, row: usize) -> usize {
        (row + 1) * self.stride + column + 1
    }

    fn cast_inside(&self, origin: &Point, direction: &Vector2<f64>, max: f64) -> Option<RayHit> {
        let (column, row) = (origin.x as usize, origin.y as usize);
        let mut offset = self.offset(column, row);
        if self.cells[offset] == OCCUPIED {
            return Some(RayHit { distance: 0.0, offset });
        }
        let mut x = Axis::new(origin.x, column as f64, direction.x);
        let mut y = Axis::new(origin.y, row as f64, direction.y);
        let (right, up) = (x.offset_step(1), y.offset_step(self.stride));
        for _ in 0..x.lines_within(max).saturating_add(y.lines_within(max)) {
            // Both branches look alike, but branch prediction is twice as fast here as a branchless selection.
            if x.crosses_before(&y) {
                offset = offset.wrapping_add(right);
                match self.cells[offset] {
                    TRANSPARENT => x.advance(),
                    OCCUPIED => return x.hit(offset, max),
                    _ => return None,
                }
            } else {
                offset = offset.wrapping_add(up);
                match self.cells[offset] {
                    TRANSPARENT => y.advance(),
                    OCCUPIED => return y.hit(offset, max),
                    _ => return None,
                }
            }
        }
        None
    }

    /// The same traversal over cells that may be outside the grid; slower, for a robot that has left the map.
    #[cold]
    fn cast_from_outside(&self, origin: &Point, direction: &Vector2<f64>, max: f64) -> Option<RayHit> {
        let mut cell = Point::new(origin.x.floor(), origin.y.floor());
        let mut x = Axis::new(origin.x, cell.x, direction.x);
        let mut y = Axis::new(origin.y, cell.y, direction.y);
        for _ in 0..x.lines_within(max).saturating_add(y.lines_within(max)) {
            if x.leaves(cell.x, self.width) || y.leaves(cell.y, self.height) {
                return None;
            }
            let (axis, coordinate) = if x.crosses_before(&y) { (&mut x, &mut cell.x) } else { (&mut y, &mut cell.y) };
            *coordinate += axis.step;
            let offset = if self.holds(&cell) { self.offset(cell.x as usize, cell.y as usize) } else { 0 };
            if self.cells[offset] == OCCUPIED {
                return axis.hit(offset, max);
            }
            axis.advance();
        }
        None
    }
}

/// A ray's progress along one axis of the grid.
#[derive(Clone, Copy)]
struct Axis {
    origin: f64,
    /// Size of the direction's component.
    speed: f64,
    /// From a line to the next: 1 or −1.
    step: f64,
    /// The next grid line across the axis that the ray crosses; infinite if it never crosses one.
    line: f64,
    /// Distance to that line along the axis.
    to_line: f64,
}

impl Axis {
    /// `cell` is ⌊`origin`⌋.
    fn new(origin: f64, cell: f64, component: f64) -> Self {
        let line = if component > 0.0 {
            cell + 1.0
        } else if component < 0.0 {
            cell
        } else {
            f64::INFINITY
        };
        let step = if component < 0.0 { -1.0 } else { 1.0 };
        Self { origin, speed: component.abs(), step, line, to_line: (line - origin).abs() }
    }

    /// Whether the ray crosses this axis's next line before the other's.
    fn crosses_before(&self, other: &Self) -> bool {
        self.to_line * other.speed < other.to_line * self.speed
    }

    /// Crosses the next line.
    fn advance(&mut self) {
        self.line += self.step;
        self.to_line = (self.line - self.origin).abs();
    }

    /// The hit of a wall behind the next line, if it is near enough.
    fn hit(&self, offset: usize, max: f64) -> Option<RayHit> {
        let distance = self.to_line / self.speed;
        (distance <= max).then_some(RayHit { distance, offset })
    }

    /// The change of an offset in a step along the axis, modulo 2⁶⁴.
    fn offset_step(&self, stride: usize) -> usize {
        if self.step < 0.0 { stride.wrapping_neg() } else { stride }
    }

    /// The number of grid lines that the ray crosses within `max` lengths of its direction, or one more.
    fn lines_within(&self, max: f64) -> usize {
        let rest = max * self.speed - self.to_line;
        if rest >= -1.0 { (rest as usize).saturating_add(2) } else { 0 }
    }

    /// Whether a ray at this cell has left a grid of this many cells for good.
    fn leaves(&self, cell: f64, cells: usize) -> bool {
        (cell < 0.0 && (self.step < 0.0 || self.speed == 0.0))
            || (cell >= cells as f64 && (self.step > 0.0 || self.speed == 0.0))
    }
}

#[cfg(test)]
mod tests;
