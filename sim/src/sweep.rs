//! All the beams of a quadrant against the walls, in one sweep.
//!
//! Neighbouring beams mostly go through the same cells and end on the same wall. So this does not follow beams but
//! *intervals* of them, and its cost goes with what is to be seen, not with the number of beams. The results are those
//! of the plain traversal ([`RayGrid::cast`](crate::RayGrid::cast)) to the last bit.
//!
//! # The method
//! **Fans.** The beams are divided by the axis that they follow most, and which way, into four fans (`quadrant`). Within a
//! fan a beam gains at most one column a row; where x is followed most, the grid's columns are the rows (`fan`).
//!
//! **Bits.** The walls are bitmaps, one with the grid's rows and one with its columns as rows, each with a coarse level
//! that has eight rows in one (`bit_rows`). Whether 57 cells of a row are free is one word and two shifts.
//!
//! **The march.** An interval, at first the whole fan, goes up row by row. Between its outer beams there lie some columns,
//! whose ends move on by an addition each; while no bit there is set, nothing else happens, and if none is set in the
//! coarse level, that goes for eight rows (`march`):
//!
//! ```text
//!   row 4    .  .  a  .  .  .  .  .  .  .  d  .     a and d: the outer beams of an interval
//!   row 3    .  .  a  b  .  .  .  .  c  .  d  .
//!   row 2    .  .  .  a  #  #  #  c  .  d  .  .     ###:     a run of occupied cells
//!   row 1    .  .  .  a  b  .  c  .  d  .  .  .     a to b:  go on, as an interval of their own
//!   row 0    .  .  .  .  .  o  .  .  .  .  .  .     c to d:  go on as well; those between b and c end in row 2
//! ```
//!
//! **Edges.** Which is the first beam that meets the run, and which the first that passes behind it? The beams are in the
//! order of their slopes, so each is an index, estimated from the angle of the run's corner. The beams beside the estimate
//! are then asked by the exact comparison of two products that the plain traversal makes at that corner (`edges`). This is
//! where the result is decided; the estimate, the fixed-point columns and their margin only say where to ask.
//!
//! **Outcomes.** The beams that end on a run are noted as one group. Whether one met the run's front or its side is the
//! same comparison again; then its distance is a single division (`outcome`).
//!
//! # Why it is exact
//! The plain traversal merges two ascending sequences of products: those of the lines between columns, and of the lines
//! between rows. Rounding keeps both in order, so whether line c comes before line r depends on these two products alone,
//! not on the cells before. A beam touches a run in row k if it comes to the run's near column before the end of the row,
//! and has not left its far column at the beginning: two such comparisons. As functions of the beam they change once, if
//! neighbours differ by more than rounding can turn about; [`Beams`](crate::Beams) divides a scan where they do not.

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
use march::{Interval, March};
use nalgebra::Vector2;
use outcome::{Outcome, measure};

pub(crate) use quadrant::{Quadrant, fans};

/// The walls of an occupancy grid, laid out for sweeps.
#[derive(Clone, Debug)]
pub(crate) struct Sweep {
    /// For fans along y.
    rows: BitRows,
    /// For fans along x.
    columns: BitRows,
}

/// What a sweep works with; kept from one to the next for its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct SweepMemory {
    beams: Vec<FanBeam>,
    waiting: Vec<Interval>,
    outcomes: Vec<Outcome>,
    distances: Vec<f64>,
}

impl Sweep {
    /// The walls of a grid, or `None` if it is too long for the sweep's numbers: more than half a million cells.
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

    /// Makes a cell a wall or none.
    pub(crate) fn set(&mut self, index: CellIndex, occupied: bool) {
        self.rows.set(index.row, index.column, occupied);
        self.columns.set(index.column, index.row, occupied);
    }

    /// How far away each beam of a fan meets a wall, in lengths of its direction; infinite if it meets none. Distances
    /// greater than `max` may be infinite as well.
    ///
    /// `origin` is in grid coordinates, within the grid and in no wall; `directions` are along the grid's axes, all in
    /// that quadrant, none longer than 1, and each counter-clockwise of the one before.
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

        let within_grid = if origin.forward { walls.rows() - origin.row } else { origin.row + 1 };
        let within_range = (max as usize).saturating_add(2);
        let rows = within_grid.min(within_range);
        March { walls, beams: &beams[..directions.len()], origin, edges: &edges, rows, waiting, outcomes }.run();

        measure(&edges, beams, outcomes, found);
        let found = &found[..directions.len()];
        if quadrant.is_reversed() {
            distances.iter_mut().zip(found.iter().rev()).for_each(|(distance, found)| *distance = *found);
        } else {
            distances.copy_from_slice(found);
        }
    }
}
