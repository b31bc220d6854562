//! Whether there is a path at all: much faster than finding the best one, or finding that there is none.
//!
//! Four neighbors are enough: a diagonal step of a path requires both adjacent cells to be free.

use maps::Point;

use super::standing::Ground;
use crate::Costmap;
use crate::grid_frame::GridFrame;

/// Whether a path leads from one cell to another.
///
/// Floods alternately from both ends, so a closed room is detected at the cost of that room.
pub(super) fn is_reachable(ground: &Ground<'_>, from: usize, to: usize) -> bool {
    if from == to {
        return true;
    }
    let frame = &ground.costmap.frame;
    let mut flooded = vec![NONE; ground.costmap.clearances().len()];
    let mut floods = [vec![from], vec![to]];
    (flooded[from], flooded[to]) = (0, 1);
    // One ring of cells at a time, of the flood whose shore is shorter: in a closed room it soon has no cell left,
    // while in the open it grows.
    loop {
        let side = usize::from(floods[1].len() < floods[0].len());
        let shore = std::mem::take(&mut floods[side]);
        if shore.is_empty() {
            return false;
        }
        for cell in shore {
            for neighbor in neighbors(frame, cell) {
                if flooded[neighbor] == 1 - side as u8 {
                    return true;
                }
                if flooded[neighbor] == NONE && ground.can_stand(neighbor) {
                    flooded[neighbor] = side as u8;
                    floods[side].push(neighbor);
                }
            }
        }
    }
}

/// No flood has reached the cell.
const NONE: u8 = 2;

/// Centers, in the `map` frame, of the cells of the largest connected part of a costmap in which a body with this
/// radius (in meters) touches nothing, in the order of the grid.
#[must_use]
pub fn largest_part(costmap: &Costmap, radius_m: f64) -> Vec<Point> {
    let parts = parts(&costmap.frame, costmap.clearances().len(), |cell| costmap.clearance_at_m(cell) >= radius_m);
    let mut sizes = vec![0_usize; parts.iter().max().map_or(0, |last| *last as usize) + 1];
    parts.iter().filter(|part| **part > 0).for_each(|part| sizes[*part as usize] += 1);
    // The first of the largest ones.
    let largest = (1..sizes.len()).rev().max_by_key(|part| sizes[*part]).unwrap_or_default() as u32;
    let inside = parts.iter().enumerate().filter(|(_, part)| **part == largest && largest > 0);
    inside.map(|(cell, _)| costmap.frame.center(cell)).collect()
}

/// The connected parts of a grid's open cells: the number of each cell's part, from 1 in the order of their first
/// cells, and 0 for cells that are not open.
pub(super) fn parts(frame: &GridFrame, cells: usize, is_open: impl Fn(usize) -> bool) -> Vec<u32> {
    let mut parts = vec![0; cells];
    let (mut count, mut shore) = (0, Vec::new());
    for first in 0..cells {
        if parts[first] > 0 || !is_open(first) {
            continue;
        }
        count += 1;
        parts[first] = count;
        shore.push(first);
        while let Some(cell) = shore.pop() {
            for neighbor in neighbors(frame, cell) {
                if parts[neighbor] == 0 && is_open(neighbor) {
                    parts[neighbor] = count;
                    shore.push(neighbor);
                }
            }
        }
    }
    parts
}

fn neighbors(frame: &GridFrame, cell: usize) -> impl Iterator<Item = usize> + use<> {
    let (width, height) = (frame.width, frame.height);
    let (column, row) = frame.column_and_row(cell);
    let beside = [
        (column > 0).then(|| cell - 1),
        (column + 1 < width).then_some(cell + 1),
        (row > 0).then(|| cell - width),
        (row + 1 < height).then_some(cell + width),
    ];
    beside.into_iter().flatten()
}
