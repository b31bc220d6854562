//! A* on eight neighbors.
//!
//! A step costs its length (5 along an axis, 7 along a diagonal: 1.4 for √2) times the cost of the cell that it enters.
//! Corners are not cut: a diagonal step requires both adjacent cells to be free.
//!
//! The search is that of the crate `pathfinding`, which keeps visited cells in a hash map and open ones in a binary
//! heap. They account for most of the 5 ms that a path across 1984 × 1984 cells takes, although an array over the cells
//! filters useless steps before the hash map is accessed. Arrays for costs and parents, and a bucket queue, since costs
//! are small integers, would reduce this to 1.2 ms (measured for the same path). That would justify a search of our own
//! only if planning were frequent; but the path is replanned only when it is blocked. A search that visits very many
//! cells gives up, and [`blocks`](super::blocks) narrow it down.

use std::cell::Cell;

use super::standing::Ground;

/// Lengths of steps along an axis and along a diagonal.
pub(super) const STRAIGHT: u32 = 5;
pub(super) const DIAGONAL: u32 = 7;

/// The least cost of a path between two cells.
pub(super) fn remaining(ground: &Ground<'_>, from: u32, to: u32) -> u32 {
    let width = ground.costmap.frame.width as u32;
    let (across, along) = ((from % width).abs_diff(to % width), (from / width).abs_diff(to / width));
    let (short, long) = (across.min(along), across.max(along));
    (short * DIAGONAL + (long - short) * STRAIGHT) * ground.least_cost()
}

/// A search has visited as many cells as it may.
#[derive(Debug)]
pub(super) struct GaveUp;

/// The cells of the cheapest path from one cell to another, inclusive, or `None` if there is none; through these cells
/// only, or through any. Gives up after it has visited `most` cells.
pub(super) fn shortest_path(
    ground: &Ground<'_>,
    from: usize,
    to: usize,
    // Not generic: with two copies of the search, its heap is no longer inlined, and it takes 8 % longer.
    only: Option<&dyn Fn(usize) -> bool>,
    most: usize,
) -> Result<Option<Vec<usize>>, GaveUp> {
    let remaining = |cell: &u32| remaining(ground, *cell, to as u32);
    // The cost of the cheapest path to each cell so far, plus one; zero if there is none yet. No path is cheaper than
    // one to a cell that does not belong to the search.
    let cells = 0..ground.costmap.clearances().len();
    let mut reached: Vec<u32> = match only {
        None => vec![0; cells.len()],
        Some(is_one) => cells.map(|cell| u32::from(!is_one(cell))).collect(),
    };
    reached[from] = 1;
    let visits = Cell::new(0);
    let ways = |cell: &u32| {
        visits.set(visits.get() + 1);
        let here = reached[*cell as usize];
        let (mut cheaper, mut count) = ([(0, 0); 8], 0);
        for (next, cost) in successors(ground, *cell) {
            let known = &mut reached[next as usize];
            if *known == 0 || here + cost < *known {
                *known = here + cost;
                cheaper[count] = (next, cost);
                count += 1;
            }
        }
        cheaper.into_iter().take(count)
    };
    let ends = |cell: &u32| *cell == to as u32 || visits.get() > most;
    let found = pathfinding::prelude::astar(&(from as u32), ways, remaining, ends);
    let found = found.map(|(cells, _)| cells.into_iter().map(|cell| cell as usize).collect::<Vec<_>>());
    if found.as_ref().is_some_and(|cells| cells.last() != Some(&to)) { Err(GaveUp) } else { Ok(found) }
}

/// The cells that can be reached in a step, with the step's cost.
pub(crate) fn successors(ground: &Ground<'_>, cell: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (ground.costmap.frame.width as u32, ground.costmap.frame.height as u32);
    let (column, row) = (cell % width, cell / width);
    let cost = |inside: bool, neighbor: u32| if inside { ground.cost(neighbor as usize) } else { 0 };
    let east = cost(column + 1 < width, cell.wrapping_add(1));
    let west = cost(column > 0, cell.wrapping_sub(1));
    let north = cost(row + 1 < height, cell.wrapping_add(width));
    let south = cost(row > 0, cell.wrapping_sub(width));
    let diagonal = |a: u32, b: u32, neighbor: u32| cost(a > 0 && b > 0, neighbor) * DIAGONAL;
    let steps = [
        (cell.wrapping_add(1), east * STRAIGHT),
        (cell.wrapping_sub(1), west * STRAIGHT),
        (cell.wrapping_add(width), north * STRAIGHT),
        (cell.wrapping_sub(width), south * STRAIGHT),
        (cell.wrapping_add(width + 1), diagonal(north, east, cell.wrapping_add(width + 1))),
        (cell.wrapping_add(width).wrapping_sub(1), diagonal(north, west, cell.wrapping_add(width).wrapping_sub(1))),
        (cell.wrapping_sub(width).wrapping_add(1), diagonal(south, east, cell.wrapping_sub(width).wrapping_add(1))),
        (cell.wrapping_sub(width + 1), diagonal(south, west, cell.wrapping_sub(width + 1))),
    ];
    steps.into_iter().filter(|(_, cost)| *cost > 0)
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, OccupancyGrid, pose};
    use proptest::prelude::*;

    use super::super::reachability::is_reachable;
    use super::*;
    use crate::{Costmap, CostmapParameters};

    const WIDTH: usize = 16;
    const HEIGHT: usize = 12;

    /// A small map with cells as big as the robot, so that walls add costs around them but do not close everything.
    fn costmap(cells: &[Cell]) -> Costmap {
        let mut map = OccupancyGrid::new(WIDTH, HEIGHT, 0.5, pose(0.0, 0.0, 0.0));
        for (offset, cell) in cells.iter().enumerate() {
            map.set(CellIndex { column: offset % WIDTH, row: offset / WIDTH }, *cell);
        }
        let parameters = CostmapParameters { robot_radius: 0.1, inflation_radius: 1.5, ..CostmapParameters::default() };
        Costmap::new(&map, parameters).unwrap()
    }

    fn cells() -> impl Strategy<Value = Vec<Cell>> {
        let cell = prop_oneof![6 => Just(Cell::Free), 2 => Just(Cell::Occupied), 1 => Just(Cell::Unknown)];
        prop::collection::vec(cell, WIDTH * HEIGHT)
    }

    /// Costs of the cheapest paths from a cell, by relaxation until nothing changes.
    fn cheapest(ground: &Ground<'_>, from: usize) -> Vec<Option<u32>> {
        let mut costs = vec![None; WIDTH * HEIGHT];
        costs[from] = Some(0);
        let mut changed = true;
        while changed {
            changed = false;
            for cell in 0..costs.len() {
                let Some(cost) = costs[cell] else { continue };
                for (next, step) in successors(ground, cell as u32) {
                    if costs[next as usize].is_none_or(|known: u32| cost + step < known) {
                        costs[next as usize] = Some(cost + step);
                        changed = true;
                    }
                }
            }
        }
        costs
    }

    proptest! {
        #[test]
        fn paths_are_the_cheapest_and_touch_nothing(cells in cells(), from: prop::sample::Index, to: prop::sample::Index) {
            let costmap = costmap(&cells);
            let ground = Ground::new(&costmap);
            let standable: Vec<usize> = (0..WIDTH * HEIGHT).filter(|cell| ground.can_stand(*cell)).collect();
            let (from, to) = (*from.get(&standable), *to.get(&standable));
            let path = shortest_path(&ground, from, to, None, usize::MAX).unwrap();
            let expected = cheapest(&ground, from)[to];
            prop_assert_eq!(path.is_some(), expected.is_some());
            prop_assert_eq!(is_reachable(&ground, from, to), path.is_some());
            let Some(path) = path else { return Ok(()) };
            let mut cost = 0;
            for pair in path.windows(2) {
                let (column, row) = (pair[0] % WIDTH, pair[0] / WIDTH);
                let (next_column, next_row) = (pair[1] % WIDTH, pair[1] / WIDTH);
                prop_assert!(column.abs_diff(next_column) <= 1 && row.abs_diff(next_row) <= 1);
                for cell in [pair[1], row * WIDTH + next_column, next_row * WIDTH + column] {
                    prop_assert!(cells[cell] == Cell::Free, "through a wall, the unknown or a corner");
                }
                let diagonal = column != next_column && row != next_row;
                cost += ground.cost(pair[1]) * if diagonal { DIAGONAL } else { STRAIGHT };
            }
            prop_assert_eq!(Some(cost), expected);
        }
    }
}
