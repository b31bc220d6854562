//! Rays against the walls of an occupancy grid, exactly.
//!
//! This is the plain grid traversal (Amanatides and Woo, *A Fast Voxel Traversal Algorithm*, 1987): from cell to cell,
//! across the nearer of the next two grid lines. Its convention is what "exact" means to whatever is tested against it:
//!
//! - Cells are half open; a ray starts in the cell (⌊x⌋, ⌊y⌋). If that cell is occupied, the distance is 0.
//! - A step goes along x only if `ex · |dy| < ey · |dx|`, where `ex` and `ey` are the distances to the next grid lines
//!   across x and across y; so a ray through a corner steps along y first. A component that is 0 never crosses a line.
//! - Both sides are products: reciprocals would break the ties of rational slopes.
//! - Unknown cells are transparent, and beyond the grid there is nothing.

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose};
use nalgebra::Vector2;

use crate::beams::Beams;

const TRANSPARENT: u8 = 0;
const OCCUPIED: u8 = 1;
const BORDER: u8 = 2;

/// The walls of an occupancy grid, laid out for casting rays.
#[derive(Clone, Debug)]
pub struct RayGrid {
    /// Row by row, with a border of one cell all around, so that a ray need not look where the grid ends.
    cells: Vec<u8>,
    /// Length of a row with its border.
    stride: usize,
    width: usize,
    height: usize,
    resolution_m: f64,
    /// Takes the `map` frame to the grid's.
    from_map: Pose,
}

/// Where a ray meets a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance from the origin, in lengths of the ray's direction.
    pub distance: f64,
    /// Position in the bordered grid.
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

    /// The distances at which a scanner's beams meet a wall, in metres, in the order of the beams; infinite where there
    /// is none within `range_max_m`. `base` is the pose of the robot (`base_link`) in the `map` frame.
    pub fn ranges(&self, beams: &Beams, base: &Pose, range_max_m: f64, ranges_m: &mut Vec<f64>) {
        let base = self.from_map * base;
        let origin = base * beams.origin() / self.resolution_m;
        let max = range_max_m / self.resolution_m;
        ranges_m.clear();
        ranges_m.extend(beams.directions().map(|direction| {
            let hit = self.cast(&origin, &(base.rotation * direction), max);
            hit.map_or(f64::INFINITY, |hit| hit.distance * self.resolution_m)
        }));
    }

    /// Where the ray from `origin` (grid coordinates: cells from the grid's corner) along `direction` (grid axes, any
    /// length) meets the first occupied cell, if it does within `max` lengths of the direction. A ray from inside an
    /// occupied cell meets it at 0.
    #[must_use]
    pub fn cast(&self, origin: &Point, direction: &Vector2<f64>, max: f64) -> Option<RayHit> {
        let inside =
            origin.x >= 0.0 && origin.y >= 0.0 && origin.x < self.width as f64 && origin.y < self.height as f64;
        if inside { self.cast_inside(origin, direction, max) } else { self.cast_from_outside(origin, direction, max) }
    }

    /// The occupied cell that was hit.
    #[must_use]
    pub fn cell(&self, hit: &RayHit) -> CellIndex {
        CellIndex { column: hit.offset % self.stride - 1, row: hit.offset / self.stride - 1 }
    }

    fn cast_inside(&self, origin: &Point, direction: &Vector2<f64>, max: f64) -> Option<RayHit> {
        let (column, row) = (origin.x as usize, origin.y as usize);
        let mut offset = (row + 1) * self.stride + column + 1;
        if self.cells[offset] == OCCUPIED {
            return Some(RayHit { distance: 0.0, offset });
        }
        let x = Axis::new(origin.x, column as f64, direction.x);
        let y = Axis::new(origin.y, row as f64, direction.y);
        let (right, up) = (x.step(1), y.step(self.stride));
        let (mut to_x, mut to_y) = (x.to_line, y.to_line);
        for _ in 0..x.lines_within(max).saturating_add(y.lines_within(max)) {
            // The two arms look alike, but predicting which comes next is twice as fast as selecting without a branch.
            if to_x * y.speed < to_y * x.speed {
                offset = offset.wrapping_add(right);
                match self.cells[offset] {
                    TRANSPARENT => to_x += 1.0,
                    OCCUPIED => return Some(RayHit { distance: to_x / x.speed, offset }),
                    _ => return None,
                }
            } else {
                offset = offset.wrapping_add(up);
                match self.cells[offset] {
                    TRANSPARENT => to_y += 1.0,
                    OCCUPIED => return Some(RayHit { distance: to_y / y.speed, offset }),
                    _ => return None,
                }
            }
        }
        None
    }

    /// The same walk over cells that may lie outside the grid; slower, for a robot that has left the map.
    #[cold]
    fn cast_from_outside(&self, origin: &Point, direction: &Vector2<f64>, max: f64) -> Option<RayHit> {
        let x = Axis::new(origin.x, origin.x.floor(), direction.x);
        let y = Axis::new(origin.y, origin.y.floor(), direction.y);
        let (mut column, mut row) = (origin.x.floor(), origin.y.floor());
        let (mut to_x, mut to_y) = (x.to_line, y.to_line);
        for _ in 0..x.lines_within(max).saturating_add(y.lines_within(max)) {
            if x.leaves(column, self.width) || y.leaves(row, self.height) {
                return None;
            }
            let distance = if to_x * y.speed < to_y * x.speed {
                column += if x.backward { -1.0 } else { 1.0 };
                to_x += 1.0;
                (to_x - 1.0) / x.speed
            } else {
                row += if y.backward { -1.0 } else { 1.0 };
                to_y += 1.0;
                (to_y - 1.0) / y.speed
            };
            let inside = column >= 0.0 && row >= 0.0 && column < self.width as f64 && row < self.height as f64;
            let offset = if inside { (row as usize + 1) * self.stride + column as usize + 1 } else { 0 };
            if self.cells[offset] == OCCUPIED {
                return Some(RayHit { distance, offset });
            }
        }
        None
    }
}

/// A ray's way along one axis of the grid.
#[derive(Clone, Copy)]
struct Axis {
    /// Size of the direction's component.
    speed: f64,
    backward: bool,
    /// Distance to the next grid line across the axis, in cells; infinite if the ray never crosses one.
    to_line: f64,
}

impl Axis {
    /// `cell` is ⌊`origin`⌋.
    fn new(origin: f64, cell: f64, component: f64) -> Self {
        let to_line = if component > 0.0 {
            cell + 1.0 - origin
        } else if component < 0.0 {
            origin - cell
        } else {
            f64::INFINITY
        };
        Self { speed: component.abs(), backward: component < 0.0, to_line }
    }

    /// What a step along the axis adds to an offset, modulo 2⁶⁴.
    fn step(&self, stride: usize) -> usize {
        if self.backward { stride.wrapping_neg() } else { stride }
    }

    /// How many grid lines the ray crosses within `max` lengths of its direction.
    fn lines_within(&self, max: f64) -> usize {
        let rest = max * self.speed - self.to_line;
        if rest >= 0.0 { (rest as usize).saturating_add(1) } else { 0 }
    }

    /// Whether a ray at that cell has left the grid, of that many cells, for good.
    fn leaves(&self, cell: f64, cells: usize) -> bool {
        (cell < 0.0 && (self.backward || self.speed == 0.0))
            || (cell >= cells as f64 && (!self.backward || self.speed == 0.0))
    }
}

#[cfg(test)]
mod tests;
