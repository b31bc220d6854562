//! The cells where the robot can be.

use std::ops::Range;

use maps::Point;

use crate::Costmap;
use crate::atlas::clearance;

/// Cost of a cell in the open; near obstacles a cell costs up to five times as much. Small numbers leave room for
/// long paths.
const OPEN_COST: u32 = 10;

/// How much a costmap's 252 adds to a cell's cost, as a multiple of the open cost.
const NEAR_FACTOR: u32 = 4;

/// The planner's view of a costmap's cells: can the robot's center be there, and at what cost?
pub(crate) struct Ground<'a> {
    pub(crate) costmap: &'a Costmap,
    clearances: &'a [u8],
    /// Cost by clearance; zero where the robot cannot be.
    costs: [u32; 256],
    /// The clearance that the robot needs, in meters.
    pub(crate) needed_m: f64,
}

impl<'a> Ground<'a> {
    /// The robot keeps half a cell more than its radius from obstacles, because it may be anywhere in a cell.
    pub(crate) fn new(costmap: &'a Costmap) -> Self {
        let needed_cells = costmap.parameters().robot_radius / costmap.frame.resolution_m + 0.5;
        let least = clearance::at_least(needed_cells);
        let costs = std::array::from_fn(|index| {
            let near = u32::from(costmap.cost_of_clearance(index as u8));
            if index as u8 >= least { OPEN_COST + OPEN_COST * NEAR_FACTOR * near / 252 } else { 0 }
        });
        let needed_m = clearance::in_cells(least) * costmap.frame.resolution_m;
        Self { costmap, clearances: costmap.clearances(), costs, needed_m }
    }

    /// Whether the robot's center can be anywhere in a cell.
    pub(crate) fn can_stand(&self, cell: usize) -> bool {
        self.cost(cell) > 0
    }

    /// The cost of a cell, [`OPEN_COST`] or more; zero where the robot cannot be.
    pub(crate) fn cost(&self, cell: usize) -> u32 {
        self.costs[usize::from(self.clearances[cell])]
    }

    /// The costs of adjacent cells.
    pub(crate) fn costs(&self, cells: Range<usize>) -> impl Iterator<Item = u32> {
        self.clearances[cells].iter().map(|clearance| self.costs[usize::from(*clearance)])
    }

    /// The least cost of a cell in which the robot can be.
    pub(crate) fn least_cost(&self) -> u32 {
        OPEN_COST
    }

    /// The cost at a point in grid coordinates; zero where the robot cannot be, including outside the grid.
    pub(crate) fn cost_in_grid(&self, at: &Point) -> u32 {
        self.costmap.frame.offset_in_grid(at).map_or(0, |cell| self.cost(cell))
    }
}

/// The cell nearest to `from` (`from` itself first) within `radius_m` that `is_good`.
pub(crate) fn nearest_cell(
    costmap: &Costmap,
    from: usize,
    radius_m: f64,
    is_good: impl Fn(usize) -> bool,
) -> Option<usize> {
    if is_good(from) {
        return Some(from);
    }
    let frame = &costmap.frame;
    let (column, row) = frame.column_and_row(from);
    let most = (radius_m / frame.resolution_m).ceil() as usize;
    let mut best: Option<(usize, usize)> = None;
    // Rings are squares: a cell in a corner of one may be farther away than the middle of a side of the next. So the
    // search ends only where a ring lies entirely beyond the best cell. Of equally near cells, the first by index.
    for ring in 1..=most {
        if best.is_some_and(|(squared, _)| squared < ring * ring) {
            break;
        }
        for (x, y) in ring_around(column, row, ring, frame.width, frame.height) {
            let squared = x.abs_diff(column).pow(2) + y.abs_diff(row).pow(2);
            let cell = y * frame.width + x;
            if best.is_none_or(|best| (squared, cell) < best) && squared <= most * most && is_good(cell) {
                best = Some((squared, cell));
            }
        }
    }
    best.map(|(_, cell)| cell)
}

/// The cells of a grid on the square ring with this distance from a cell.
fn ring_around(
    column: usize,
    row: usize,
    ring: usize,
    width: usize,
    height: usize,
) -> impl Iterator<Item = (usize, usize)> {
    let rows = row.saturating_sub(ring)..=(row + ring).min(height - 1);
    rows.flat_map(move |y| {
        let whole = y.abs_diff(row) == ring;
        let columns = column.saturating_sub(ring)..=(column + ring).min(width - 1);
        columns.filter(move |x| whole || x.abs_diff(column) == ring).map(move |x| (x, y))
    })
}
