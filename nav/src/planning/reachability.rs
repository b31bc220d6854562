//! Whether there is a way at all, which is found out much faster than the best one, or that there is none.
//!
//! Four neighbours are enough: a diagonal step of a path needs both cells beside it.

use maps::Point;

use super::standing::Ground;
use crate::Costmap;
use crate::grid_frame::GridFrame;

/// Whether a path leads from one cell to another.
///
/// Floods from both ends in turns, so that a closed room is noticed at the cost of the room.
pub(super) fn is_reachable(ground: &Ground<'_>, from: usize, to: usize) -> bool {
    if from == to {
        return true;
    }
    let frame = &ground.costmap.frame;
    let mut flooded = vec![NONE; ground.costmap.clearances().len()];
    let mut floods = [vec![from], vec![to]];
    (flooded[from], flooded[to]) = (0, 1);
    loop {
        let side = usize::from(floods[1].len() < floods[0].len());
        let shore = std::mem::take(&mut floods[side]);
        if shore.is_empty() {
            return false;
        }
        for cell in shore {
            for neighbour in neighbours(frame, cell) {
                if flooded[neighbour] == 1 - side as u8 {
                    return true;
                }
                if flooded[neighbour] == NONE && ground.can_stand(neighbour) {
                    flooded[neighbour] = side as u8;
                    floods[side].push(neighbour);
                }
            }
        }
    }
}

/// No flood has come to the cell.
const NONE: u8 = 2;

/// Centres, in the `map` frame, of the cells of the largest connected part of a costmap in which a body of that radius
/// (in metres) touches nothing, in the order of the grid.
#[must_use]
pub fn largest_part(costmap: &Costmap, radius_m: f64) -> Vec<Point> {
    let frame = &costmap.frame;
    let is_open = |cell: usize| costmap.clearance_at_m(cell) >= radius_m;
    let mut seen = vec![false; costmap.clearances().len()];
    let mut largest = Vec::new();
    for first in 0..seen.len() {
        if seen[first] || !is_open(first) {
            continue;
        }
        seen[first] = true;
        let mut part = vec![first];
        let mut next = 0;
        while let Some(&cell) = part.get(next) {
            next += 1;
            for neighbour in neighbours(frame, cell) {
                if !seen[neighbour] && is_open(neighbour) {
                    seen[neighbour] = true;
                    part.push(neighbour);
                }
            }
        }
        if part.len() > largest.len() {
            largest = part;
        }
    }
    largest.sort_unstable();
    largest.into_iter().map(|cell| frame.center(cell)).collect()
}

fn neighbours(frame: &GridFrame, cell: usize) -> impl Iterator<Item = usize> + use<> {
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
