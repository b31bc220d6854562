//! All the beams of a quadrant against the walls, in one sweep.
//!
//! Neighboring beams mostly pass through the same cells and end on the same wall. So the sweep does not follow beams
//! but *intervals* of beams, and its cost depends on the visible walls, not on the number of beams. The results equal
//! those of the plain traversal ([`RayGrid::cast`](crate::RayGrid::cast)) to the last bit.
//!
//! # The method
//! **Fans.** The beams are divided into four fans by their dominant axis and its direction (`quadrant`). Within a fan,
//! a beam gains at most one column per row; in fans along x, the grid's columns are the rows (`fan`).
//!
//! **Bits.** The walls are bitmaps, one with the grid's rows and one with its columns as rows, each with a coarse level
//! that combines eight rows (`bit_rows`). Checking whether 57 cells of a row are free takes one word and two shifts.
//!
//! **The march.** An interval, initially the whole fan, advances row by row. Between its outer beams is a range of
//! columns, whose ends advance by one addition each. While no bit in the range is set, nothing else happens; if none is
//! set in the coarse level, this holds for eight rows (`march`):
//!
//! ```text
//!   row 4    .  .  a  .  .  .  .  .  .  .  d  .     a and d: the outer beams of an interval
//!   row 3    .  .  a  b  .  .  .  .  c  .  d  .
//!   row 2    .  .  .  a  #  #  #  c  .  d  .  .     ###:     a run of occupied cells
//!   row 1    .  .  .  a  b  .  c  .  d  .  .  .     a to b:  go on, as an interval of their own
//!   row 0    .  .  .  .  .  o  .  .  .  .  .  .     c to d:  go on as well; those between b and c end in row 2
//! ```
//!
//! **Edges.** Which is the first beam that hits the run, and which is the first that passes behind it? The beams are
//! sorted by slope, so each answer is an index, which is estimated from the angle of the run's corner. The beams next
//! to the estimate are then checked with the exact comparison of two products that the plain traversal makes at that
//! corner (`edges`). Only this check determines the result; the estimate, the fixed-point columns and their margin only
//! select the beams to check.
//!
//! **Outcomes.** The beams that end on a run form one group. The same comparison decides whether a beam hit the run's
//! front or its side; then its distance is a single division (`outcome`).
//!
//! # Why it is exact
//! The plain traversal merges two ascending sequences of products: those of the lines between columns, and of the lines
//! between rows. Rounding keeps both in order, so whether line c comes before line r depends on these two products
//! alone, not on the cells before. A beam touches a run in row k if it reaches the run's near column before the end of
//! the row, and has not left its far column at the beginning: two such comparisons. As functions of the beam they
//! change only once, if neighbors differ by more than rounding errors; [`Beams`](crate::Beams) divides a scan where
//! they do not.

mod bit_rows;
mod edges;
mod fan;
mod fixed;
mod march;
mod outcome;
mod quadrant;

use bit_rows::BitRows;
use edges::Edges;
use fan::{FanBeam, Origin, lay_out};
use maps::{Cell, CellIndex, OccupancyGrid, Point};
use march::{BeamInterval, March};
use nalgebra::Vector2;
use outcome::{Outcome, measure};

pub(crate) use quadrant::{Quadrant, fans};

/// The walls of an occupancy grid, prepared for sweeps.
#[derive(Clone, Debug)]
pub(crate) struct Sweep {
    /// For fans along y.
    rows: BitRows,
    /// For fans along x.
    columns: BitRows,
}

/// Working memory of a sweep, kept for reuse.
#[derive(Clone, Debug, Default)]
pub(crate) struct SweepMemory {
    beams: Vec<FanBeam>,
    waiting: Vec<BeamInterval>,
    outcomes: Vec<Outcome>,
    distances: Vec<f64>,
}

impl Sweep {
    /// The walls of a grid, or `None` if it is too large for the sweep's numbers: longer than half a million cells.
    pub(crate) fn new(grid: &OccupancyGrid) -> Option<Self> {
        let (width, height) = (grid.width(), grid.height());
        if width + height >= fixed::LIMIT {
            return None;
        }
        let mut sweep = Self { rows: BitRows::new(height, width), columns: BitRows::new(width, height) };
        for (row, cells) in grid.cells().chunks(width.max(1)).enumerate() {
            for (column, _) in cells.iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied) {
                sweep.set(CellIndex { column, row }, true);
            }
        }
        Some(sweep)
    }

    /// Makes a cell occupied or free.
    pub(crate) fn set(&mut self, index: CellIndex, occupied: bool) {
        self.rows.set(index.row, index.column, occupied);
        self.columns.set(index.column, index.row, occupied);
    }

    /// The distance at which each beam of a fan hits a wall, in lengths of its direction; infinite if it hits none.
    /// Distances greater than `max` may be infinite as well.
    ///
    /// `origin` is in grid coordinates, inside the grid and not in a wall. `directions` are along the grid's axes, all
    /// in this quadrant, at most of length 1, and each counter-clockwise of the previous one.
    pub(crate) fn distances(
        &self,
        quadrant: Quadrant,
        origin: &Point,
        directions: &[Vector2<f64>],
        max: f64,
        memory: &mut SweepMemory,
        distances: &mut [f64],
    ) {
        let SweepMemory { beams, waiting, outcomes, distances: found } = memory;
        let walls = if quadrant.is_along_x() { &self.columns } else { &self.rows };
        let origin = Origin::new(origin, quadrant);
        lay_out(quadrant, origin, directions, beams);
        outcomes.resize(directions.len(), Outcome::default());
        found.resize(beams.len(), f64::INFINITY);
        let edges = Edges::new(&beams[..directions.len()], origin, quadrant.is_along_x());

        // Line k is at least k − 1 cells away, and a direction is at most 1 long: beams of length `max` reach rows 0 to
        // max + 1.
        let within_grid = if origin.forward { walls.rows - origin.row } else { origin.row + 1 };
        let within_range = (max as usize).saturating_add(2);
        let rows = within_grid.min(within_range);
        March { walls, beams: &beams[..directions.len()], origin, edges: &edges, rows, waiting, outcomes }.run();

        measure(&edges, beams, outcomes, found);
        let found = &found[..directions.len()];
        // The march needs the beams in ascending order of their slope.
        if quadrant.is_reversed() {
            distances.iter_mut().zip(found.iter().rev()).for_each(|(distance, found)| *distance = *found);
        } else {
            distances.copy_from_slice(found);
        }
    }
}
