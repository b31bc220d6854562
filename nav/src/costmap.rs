//! The costmap: how near each cell is to an obstacle that is on the map or seen by the lasers.
//!
//! It stores clearances instead of costs, which follow from clearances by a table: the planner reads costs, the path
//! follower reads distances. Obstacles seen by lasers are a list of marked cells. A mark changes only its surroundings,
//! and a scan that shows only the map changes nothing.

mod lasers;
mod parameters;

use std::sync::Arc;

use maps::{OccupancyGrid, Point};
use wide::u8x16;

use crate::atlas::clearance::{self, FARTHEST_CELLS, OBSTACLE, UNKNOWN};
use crate::grid_frame::GridFrame;
use crate::{Atlas, Error};

pub use parameters::CostmapParameters;

/// Cost of a cell where the robot collides if its center is there, as in Nav2.
pub const INSCRIBED_COST: u8 = 253;

/// Cost of an obstacle, as in Nav2.
pub const LETHAL_COST: u8 = 254;

/// Cost of an unknown cell, as in Nav2.
pub const UNKNOWN_COST: u8 = 255;

/// A map with inflated obstacles, kept up to date by laser scans.
///
/// ```
/// use maps::{Cell, CellIndex, OccupancyGrid, Point, pose};
/// use nav::{Costmap, CostmapParameters, INSCRIBED_COST, LETHAL_COST};
///
/// // 5 m × 5 m of free floor, with a wall along the left.
/// let mut map = OccupancyGrid::from_cells(100, 100, 0.05, pose(0.0, 0.0, 0.0), vec![Cell::Free; 10_000]);
/// (0..100).for_each(|row| map.set(CellIndex { column: 0, row }, Cell::Occupied));
/// let costmap = Costmap::new(&map, CostmapParameters::default())?;
/// assert_eq!(costmap.cost(&Point::new(0.01, 2.5)), LETHAL_COST);
/// assert_eq!(costmap.cost(&Point::new(0.2, 2.5)), INSCRIBED_COST); // the robot would touch the wall
/// assert_eq!(costmap.cost(&Point::new(2.5, 2.5)), 0);
/// # Ok::<(), nav::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Costmap {
    parameters: CostmapParameters,
    pub(crate) frame: GridFrame,
    /// Clearance from the map's obstacles.
    fixed: Arc<Vec<u8>>,
    /// Clearance from all obstacles.
    clearances: Vec<u8>,
    /// Offsets of the cells where lasers have seen an obstacle that is not on the map.
    marks: Vec<u32>,
    /// The clearances around a single obstacle, row by row.
    stamp: Vec<StampRow>,
    stamp_radius: i64,
    costs: [u8; 256],
    generation: u64,
}

#[derive(Clone, Debug)]
struct StampRow {
    /// The row, counted from the obstacle's.
    row: i64,
    /// How many columns it extends to both sides of the obstacle's.
    reach: i64,
    clearances: Vec<u8>,
}

impl Costmap {
    /// The costmap of a map, without marks.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter is invalid.
    pub fn new(map: &OccupancyGrid, parameters: CostmapParameters) -> Result<Self, Error> {
        Self::with(GridFrame::of(map), Arc::new(clearance::of_map(map)), parameters)
    }

    /// The costmap of an atlas's map and zones, without marks.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter is invalid.
    pub fn on(atlas: &Atlas, parameters: CostmapParameters) -> Result<Self, Error> {
        let fixed = atlas.zones.as_ref().map_or(&atlas.clearances, |zones| &zones.all_closed);
        Self::with(GridFrame::of(atlas.map()), Arc::clone(fixed), parameters)
    }

    fn with(frame: GridFrame, fixed: Arc<Vec<u8>>, parameters: CostmapParameters) -> Result<Self, Error> {
        parameters.check()?;
        // Half a cell to the obstacle's surface, and the rounding of clearances.
        let stamp_radius = (parameters.inflation_radius / frame.resolution_m + 1.0).min(FARTHEST_CELLS);
        Ok(Self {
            clearances: fixed.to_vec(),
            fixed,
            marks: Vec::new(),
            stamp: stamp_of(stamp_radius),
            stamp_radius: stamp_radius as i64,
            costs: costs(&parameters, frame.resolution_m),
            frame,
            parameters,
            generation: 0,
        })
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &CostmapParameters {
        &self.parameters
    }

    /// The cost at a point of the `map` frame: 0 in the open, growing towards obstacles, then [`INSCRIBED_COST`] and
    /// [`LETHAL_COST`]; [`UNKNOWN_COST`] in unknown space and outside the map.
    #[must_use]
    pub fn cost(&self, point: &Point) -> u8 {
        self.frame.offset_at(point).map_or(UNKNOWN_COST, |offset| self.cost_at(offset))
    }

    /// The distance from the cell that contains a point of the `map` frame to the surface of the nearest obstacle, in
    /// meters: exact to a quarter of a cell, obstacles seen by lasers only up to the inflation radius. Zero in
    /// obstacles, in unknown space and outside the map.
    #[must_use]
    pub fn clearance_m(&self, point: &Point) -> f64 {
        self.frame.offset_at(point).map_or(0.0, |offset| self.clearance_at_m(offset))
    }

    /// Centers of the cells where lasers have seen obstacles that are not on the map, in the `map` frame.
    pub fn marked(&self) -> impl ExactSizeIterator<Item = Point> {
        self.marks.iter().map(|offset| self.frame.center(*offset as usize))
    }

    /// A number that changes whenever a cell does.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Forgets everything that lasers have seen.
    pub fn forget_marks(&mut self) {
        if !self.marks.is_empty() {
            self.marks.clear();
            self.clearances.copy_from_slice(&self.fixed);
            self.generation += 1;
        }
    }

    /// Takes other clearances from the map's obstacles; marks stay.
    pub(crate) fn put_on(&mut self, fixed: Arc<Vec<u8>>) {
        self.clearances.copy_from_slice(&fixed);
        self.fixed = fixed;
        for index in 0..self.marks.len() {
            self.stamp_onto(self.marks[index] as usize);
        }
        self.generation += 1;
    }

    pub(crate) fn cost_at(&self, offset: usize) -> u8 {
        self.costs[usize::from(self.clearances[offset])]
    }

    pub(crate) fn cost_of_clearance(&self, clearance: u8) -> u8 {
        self.costs[usize::from(clearance)]
    }

    /// Whether a line between two points of the `map` frame crosses an obstacle or leaves the grid.
    pub(crate) fn line_meets_obstacle(&self, from: &Point, to: &Point) -> bool {
        let (from, to) = (self.frame.in_grid(from), self.frame.in_grid(to));
        let looks = (2.0 * (to - from).norm()).ceil().max(1.0);
        let obstacle = |look: f64| {
            let offset = self.frame.offset_in_grid(&(from + (to - from) * (look / looks)));
            offset.is_none_or(|offset| self.clearances[offset] == OBSTACLE)
        };
        (0..=looks as usize).any(|look| obstacle(look as f64))
    }

    pub(crate) fn clearance_at_m(&self, offset: usize) -> f64 {
        clearance::in_cells(self.clearances[offset]) * self.frame.resolution_m
    }

    /// Clearances of all cells, row by row.
    pub(crate) fn clearances(&self) -> &[u8] {
        &self.clearances
    }

    /// Whether the map itself has an obstacle in the cell.
    pub(crate) fn is_on_map(&self, offset: usize) -> bool {
        self.fixed[offset] == OBSTACLE
    }

    /// Whether the robot cannot be at a point of the `map` frame because of obstacles seen by lasers, although the map
    /// permits it.
    pub(crate) fn is_blocked_by_marks(&self, point: &Point) -> bool {
        let inscribed = |clearance: u8| self.costs[usize::from(clearance)] >= INSCRIBED_COST;
        let blocked = |offset: usize| inscribed(self.clearances[offset]) && !inscribed(self.fixed[offset]);
        self.frame.offset_at(point).is_some_and(blocked)
    }

    /// Marks the cell at a point of the `map` frame as an obstacle, unless it is one already or outside the grid.
    pub(crate) fn mark(&mut self, point: &Point) {
        if let Some(offset) = self.frame.offset_at(point) {
            self.mark_cell(offset);
        }
    }

    fn mark_cell(&mut self, offset: usize) {
        if self.clearances[offset] != OBSTACLE {
            self.marks.push(offset as u32);
            self.stamp_onto(offset);
            self.generation += 1;
        }
    }

    /// Removes the marks for which `is_gone` holds.
    fn clear_marks(&mut self, mut is_gone: impl FnMut(&GridFrame, usize) -> bool) {
        let frame = self.frame;
        // The corners of the bounding box of all removed marks.
        let mut gone: Option<(usize, usize)> = None;
        self.marks.retain(|mark| {
            let mark = *mark as usize;
            let is_gone = is_gone(&frame, mark);
            if is_gone {
                let (first, last) = gone.unwrap_or((mark, mark));
                gone = Some(spanning(&frame, first, last, mark));
            }
            !is_gone
        });
        if let Some((first, last)) = gone {
            self.restore_around(first, last);
        }
    }

    /// Recomputes the cells that marks between two corners may have changed.
    fn restore_around(&mut self, first: usize, last: usize) {
        let ((left, bottom), (right, top)) = (self.frame.column_and_row(first), self.frame.column_and_row(last));
        let reach = self.stamp_radius as usize;
        let columns = left.saturating_sub(reach)..(right + reach + 1).min(self.frame.width);
        let rows = bottom.saturating_sub(reach)..(top + reach + 1).min(self.frame.height);
        for row in rows.clone() {
            let cells = row * self.frame.width + columns.start..row * self.frame.width + columns.end;
            self.clearances[cells.clone()].copy_from_slice(&self.fixed[cells]);
        }
        for index in 0..self.marks.len() {
            let mark = self.marks[index] as usize;
            let (column, row) = self.frame.column_and_row(mark);
            let touches = column + reach >= columns.start
                && column < columns.end + reach
                && row + reach >= rows.start
                && row < rows.end + reach;
            if touches {
                self.stamp_onto(mark);
            }
        }
        self.generation += 1;
    }

    fn stamp_onto(&mut self, offset: usize) {
        let (column, row) = self.frame.column_and_row(offset);
        let (width, height) = (self.frame.width as i64, self.frame.height as i64);
        for StampRow { row: above, reach, clearances } in &self.stamp {
            let row = row as i64 + above;
            let (first, end) = (column as i64 - reach, column as i64 + reach + 1);
            let (left, right) = (first.max(0), end.min(width));
            if (0..height).contains(&row) && left < right {
                let cells = &mut self.clearances[(row * width + left) as usize..(row * width + right) as usize];
                lower(cells, &clearances[(left - first) as usize..(right - first) as usize]);
            }
        }
    }
}

/// Lowers cells to the clearances of a stamp, 16 at a time: where people walk, this takes a tenth of a run.
fn lower(cells: &mut [u8], stamp: &[u8]) {
    let ((blocks, cells), (stamp_blocks, stamp)) = (cells.as_chunks_mut(), stamp.as_chunks());
    for (cells, stamp) in blocks.iter_mut().zip(stamp_blocks) {
        *cells = u8x16::new(*cells).min(u8x16::new(*stamp)).to_array();
    }
    cells.iter_mut().zip(stamp).for_each(|(cell, clearance)| *cell = (*cell).min(*clearance));
}

/// The corners of the smallest box that contains another box and a cell.
fn spanning(frame: &GridFrame, first: usize, last: usize, cell: usize) -> (usize, usize) {
    let ((left, bottom), (right, top)) = (frame.column_and_row(first), frame.column_and_row(last));
    let (column, row) = frame.column_and_row(cell);
    (bottom.min(row) * frame.width + left.min(column), top.max(row) * frame.width + right.max(column))
}

/// The clearances around an obstacle, up to this many cells.
fn stamp_of(radius: f64) -> Vec<StampRow> {
    let reach = radius as i32;
    let rows = (-reach..=reach).map(|row| {
        let is_near = |column: &i32| f64::from(column * column + row * row) <= radius * radius;
        let reach = (0..=reach).rev().find(is_near).unwrap_or(0);
        let clearances = (-reach..=reach).map(|column| clearance::of_cell(column, row)).collect();
        StampRow { row: row.into(), reach: reach.into(), clearances }
    });
    rows.collect()
}

/// The cost of each clearance.
fn costs(parameters: &CostmapParameters, resolution_m: f64) -> [u8; 256] {
    std::array::from_fn(|index| {
        let distance_m = clearance::in_cells(index as u8) * resolution_m;
        match index as u8 {
            OBSTACLE => LETHAL_COST,
            UNKNOWN => UNKNOWN_COST,
            _ if distance_m < parameters.robot_radius => INSCRIBED_COST,
            _ if distance_m > parameters.inflation_radius => 0,
            _ => {
                let beyond_m = distance_m - parameters.robot_radius;
                (252.0 * libm::exp(-parameters.cost_scaling_factor * beyond_m)) as u8
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, pose};
    use proptest::prelude::*;

    use super::*;

    fn costmap(walls: &[(usize, usize)]) -> Costmap {
        let mut map = OccupancyGrid::new(60, 50, 0.1, pose(0.0, 0.0, 0.0));
        for row in 0..50 {
            (0..60).for_each(|column| map.set(CellIndex { column, row }, Cell::Free));
        }
        for &(column, row) in walls {
            map.set(CellIndex { column, row }, Cell::Occupied);
        }
        Costmap::new(&map, CostmapParameters::default()).unwrap()
    }

    #[test]
    fn costs_fall_from_the_obstacle_to_the_inflation_radius() {
        let costmap = costmap(&[(30, 25)]);
        let costs: Vec<u8> =
            (0..15).map(|cells| costmap.cost(&Point::new(3.05 + 0.1 * f64::from(cells), 2.55))).collect();
        assert_eq!(costs[..4], [LETHAL_COST, INSCRIBED_COST, INSCRIBED_COST, INSCRIBED_COST]);
        assert!(costs[3..].windows(2).all(|pair| pair[0] >= pair[1]));
        assert!(costs[4] < INSCRIBED_COST && costs[7] > 0 && costs[9] == 0, "{costs:?}");
        assert_eq!(costmap.cost(&Point::new(-1.0, 0.0)), UNKNOWN_COST);
    }

    proptest! {
        /// Marking and clearing in any order gives the same result as a map with the remaining obstacles.
        #[test]
        fn marks_come_and_go_without_a_trace(
            walls in prop::collection::vec((0_usize..60, 0_usize..50), 0..4),
            marks in prop::collection::vec((0_usize..60, 0_usize..50, any::<bool>()), 0..12),
        ) {
            let mut seen = costmap(&walls);
            let point = |column: usize, row: usize| Point::new(0.05 + 0.1 * column as f64, 0.05 + 0.1 * row as f64);
            for (column, row, _) in &marks {
                seen.mark(&point(*column, *row));
            }
            let stays = |offset: usize| {
                marks.iter().any(|(column, row, stays)| *stays && row * 60 + column == offset)
            };
            seen.clear_marks(|_, offset| !stays(offset));
            let mut all = walls.clone();
            all.extend(marks.iter().filter(|mark| mark.2).map(|mark| (mark.0, mark.1)));
            let expected = costmap(&all);
            let wrong = (0..3000).find(|offset| seen.cost_at(*offset) != expected.cost_at(*offset));
            prop_assert_eq!(wrong, None);
            seen.forget_marks();
            prop_assert!(seen.clearances == *seen.fixed);
        }
    }
}
