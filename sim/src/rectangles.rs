//! Merges occupied cells into rectangles, so that the physics has fewer bodies.

use maps::{Cell, OccupancyGrid};

/// A block of cells, in cells of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rectangle {
    pub(crate) column: usize,
    pub(crate) row: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Rectangles that together cover every occupied cell exactly once.
///
/// Greedy: from the first remaining cell, as far as possible along its row, then this whole run as far up as possible.
pub(crate) fn rectangles(grid: &OccupancyGrid) -> Vec<Rectangle> {
    let (width, height) = (grid.width(), grid.height());
    let mut left: Vec<bool> = grid.cells().iter().map(|cell| *cell == Cell::Occupied).collect();
    let mut rectangles = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let start = row * width + column;
            if !left[start] {
                continue;
            }
            let run = left[start..(row + 1) * width].iter().take_while(|left| **left).count();
            let is_full = |row: &usize| left[row * width + column..][..run].iter().all(|left| *left);
            let rows = (row..height).take_while(is_full).count();
            (row..row + rows).for_each(|row| left[row * width + column..][..run].fill(false));
            rectangles.push(Rectangle { column, row, width: run, height: rows });
        }
    }
    rectangles
}

#[cfg(test)]
mod tests {
    use maps::{CellIndex, Pose};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_occupied_cell_is_covered_exactly_once_and_no_other(cells in prop::collection::vec(0..3_u8, 12 * 9)) {
            let mut grid = OccupancyGrid::new(12, 9, 0.05, Pose::identity());
            for (offset, cell) in cells.iter().enumerate() {
                let index = CellIndex { column: offset % 12, row: offset / 12 };
                grid.set(index, if *cell < 2 { Cell::Occupied } else { Cell::Free });
            }
            let mut covered = vec![0; 12 * 9];
            for Rectangle { column, row, width, height } in rectangles(&grid) {
                for row in row..row + height {
                    covered[row * 12 + column..][..width].iter_mut().for_each(|times| *times += 1);
                }
            }
            let expected: Vec<i32> = cells.iter().map(|cell| i32::from(*cell < 2)).collect();
            prop_assert_eq!(covered, expected);
        }
    }

    #[test]
    fn a_straight_wall_is_one_rectangle() {
        let mut grid = OccupancyGrid::new(100, 10, 0.05, Pose::identity());
        for (column, row) in (5..95).flat_map(|column| (3..6).map(move |row| (column, row))) {
            grid.set(CellIndex { column, row }, Cell::Occupied);
        }
        assert_eq!(rectangles(&grid), [Rectangle { column: 5, row: 3, width: 90, height: 3 }]);
    }
}
