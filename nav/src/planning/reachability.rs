//! Whether there is a way at all, which is found out much faster than the best one, or that there is none.

use super::standing::Ground;

/// Whether a path leads from one cell to another.
///
/// Floods from both ends in turns, so that a closed room is noticed at the cost of the room. Four neighbours are enough:
/// a diagonal step of a path needs both cells beside it.
pub(super) fn is_reachable(ground: &Ground<'_>, from: usize, to: usize) -> bool {
    if from == to {
        return true;
    }
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
            for neighbour in neighbours(ground, cell) {
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

fn neighbours(ground: &Ground<'_>, cell: usize) -> impl Iterator<Item = usize> + use<> {
    let (width, height) = (ground.costmap.frame.width, ground.costmap.frame.height);
    let (column, row) = (cell % width, cell / width);
    let beside = [
        (column > 0).then(|| cell - 1),
        (column + 1 < width).then_some(cell + 1),
        (row > 0).then(|| cell - width),
        (row + 1 < height).then_some(cell + width),
    ];
    beside.into_iter().flatten()
}
