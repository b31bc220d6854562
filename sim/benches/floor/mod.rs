//! A furnished floor of 28 m × 22 m: a corridor between two rows of six rooms, with doorways, beds, tables and their
//! legs.

use maps::{Cell, CellIndex, OccupancyGrid, pose};

const WIDTH: usize = 560;
const HEIGHT: usize = 440;
/// Cells from the left wall of one room to that of the next.
const ROOM: usize = 93;

/// The floor with cells of 0.05 m, its lower left corner at the origin.
pub(crate) fn floor() -> OccupancyGrid {
    let mut grid = OccupancyGrid::new(WIDTH, HEIGHT, 0.05, pose(0.0, 0.0, 0.0));
    for index in (0..HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| CellIndex { column, row })) {
        let solid = is_wall(index) || is_furniture(index);
        grid.set(index, if solid { Cell::Occupied } else { Cell::Free });
    }
    grid
}

fn is_wall(CellIndex { column, row }: CellIndex) -> bool {
    let is_outer = column < 3 || row < 3 || column >= WIDTH - 3 || row >= HEIGHT - 3;
    let is_doorway = (40..60).contains(&(column % ROOM));
    let is_along_corridor = (197..200).contains(&row) || (240..243).contains(&row);
    let is_between_rooms = column % ROOM < 3 && !(200..240).contains(&row);
    is_outer || (is_along_corridor && !is_doorway) || is_between_rooms
}

fn is_furniture(CellIndex { column, row }: CellIndex) -> bool {
    // Rooms above the corridor mirror those below.
    let (x, y) = (column % ROOM, row.min(HEIGHT - 1 - row));
    let is_bed = (8..26).contains(&x) && (10..50).contains(&y);
    let is_sideboard = (50..88).contains(&x) && (5..13).contains(&y);
    let is_leg = |edge: usize, from: usize| edge == from || edge == from + 1 || (edge >= from + 24 && edge < from + 26);
    let is_table = is_leg(x, 55) && is_leg(y, 80) || is_leg(x, 20) && is_leg(y, 120);
    y < 197 && (is_bed || is_sideboard || is_table)
}
