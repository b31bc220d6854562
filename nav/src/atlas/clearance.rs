//! Clearances in one byte: the distance from a cell's center to the surface of the nearest obstacle.

use maps::{Cell, OccupancyGrid};

use crate::distance_transform::{NO_TARGET, squared_half_cells};

/// The cell is an obstacle.
pub(crate) const OBSTACLE: u8 = 0;

/// The cell is unknown.
pub(crate) const UNKNOWN: u8 = 1;

/// Steps of a clearance per side of a cell.
const STEPS: f64 = 4.0;

/// The greatest distance between cell centers that a byte can represent, in cells.
pub(crate) const FARTHEST_CELLS: f64 = (u8::MAX - 2) as f64 / STEPS;

/// The clearances of a map's cells, row by row.
pub(crate) fn of_map(map: &OccupancyGrid) -> Vec<u8> {
    let cells = map.cells();
    let squared = squared_half_cells(map.width(), map.height(), |offset| cells[offset] == Cell::Occupied);
    let clearance = |(cell, squared): (&Cell, u32)| match (cell, squared) {
        (Cell::Unknown, _) => UNKNOWN,
        (_, NO_TARGET) => u8::MAX,
        (_, squared) => from_squared_half_cells(squared),
    };
    cells.iter().zip(squared).map(clearance).collect()
}

/// The clearance of a cell whose center has this distance (in half cells, squared) from the nearest point of an
/// obstacle's cell.
pub(crate) fn from_squared_half_cells(squared: u32) -> u8 {
    if squared == 0 {
        return OBSTACLE;
    }
    let cells = f64::from(squared).sqrt() / 2.0;
    2 + (cells * STEPS).min(f64::from(u8::MAX - 2)) as u8
}

/// The clearance of a cell from an obstacle this many columns and rows away.
pub(crate) fn of_cell(across: i32, along: i32) -> u8 {
    let half_cells = |cells: i32| (2 * cells.unsigned_abs()).saturating_sub(1);
    from_squared_half_cells(half_cells(across).pow(2) + half_cells(along).pow(2))
}

/// The clearance in cells; zero for an obstacle and for unknown space.
pub(crate) fn in_cells(clearance: u8) -> f64 {
    f64::from(clearance.saturating_sub(2)) / STEPS
}

/// The least clearance of at least `cells`.
pub(crate) fn at_least(cells: f64) -> u8 {
    2 + (cells * STEPS - 1e-9).ceil().clamp(1.0, f64::from(u8::MAX - 2)) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clearances_grow_with_the_distance_and_are_never_too_large() {
        let all: Vec<u8> = (0..36_000).map(from_squared_half_cells).collect();
        assert!(all.windows(2).all(|pair| pair[0] <= pair[1]));
        for (squared, clearance) in (1_u32..).zip(&all[1..]) {
            assert!(in_cells(*clearance) <= f64::from(squared).sqrt() / 2.0);
        }
        assert_eq!([of_cell(0, 0), of_cell(0, 1), of_cell(-1, 0), of_cell(1, 1)], [OBSTACLE, 4, 4, 4]);
        assert_eq!([of_cell(3, 0), of_cell(-3, 3)].map(in_cells), [2.5, 3.5]);
    }

    #[test]
    fn the_least_clearance_for_a_distance_is_at_least_that_distance() {
        for cells in [0.1, 1.0, 5.999, 6.0, 6.5, 12.26] {
            let least = at_least(cells);
            assert!(in_cells(least) >= cells - 1e-8 && in_cells(least - 1) < cells);
        }
    }
}
