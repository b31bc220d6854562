//! Clearances in a byte: how far a cell's centre is from the surface of the nearest obstacle.

use maps::{Cell, OccupancyGrid};

use crate::distance_transform::{NO_TARGET, squared_distances};

/// The cell is an obstacle.
pub(crate) const OBSTACLE: u8 = 0;

/// Nothing is known of the cell.
pub(crate) const UNKNOWN: u8 = 1;

/// Steps of a clearance in a cell's side.
const STEPS: f64 = 4.0;

/// The greatest distance between cell centres that a byte can tell apart from a greater one, in cells.
pub(crate) const FARTHEST_CELLS: f64 = (u8::MAX - 2) as f64 / STEPS;

/// The clearances of a map's cells, row by row.
pub(crate) fn of_map(map: &OccupancyGrid) -> Vec<u8> {
    let cells = map.cells();
    let squared = squared_distances(map.width(), map.height(), |offset| cells[offset] == Cell::Occupied);
    let clearance = |(cell, squared): (&Cell, u32)| match (cell, squared) {
        (Cell::Unknown, _) => UNKNOWN,
        (_, NO_TARGET) => u8::MAX,
        (_, squared) => from_squared_cells(squared),
    };
    cells.iter().zip(squared).map(clearance).collect()
}

/// The clearance of a cell whose centre lies `squared_cells` (in cells, squared) from that of the nearest obstacle.
pub(crate) fn from_squared_cells(squared_cells: u32) -> u8 {
    if squared_cells == 0 {
        return OBSTACLE;
    }
    // The surface is half a cell nearer than the centre of the obstacle's cell.
    let to_surface = f64::from(squared_cells).sqrt() - 0.5;
    2 + (to_surface * STEPS).min(f64::from(u8::MAX - 2)) as u8
}

/// The clearance in cells; zero for an obstacle and for the unknown.
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
    fn clearances_grow_with_the_distance_and_never_promise_too_much() {
        let all: Vec<u8> = (0..9000).map(from_squared_cells).collect();
        assert!(all.windows(2).all(|pair| pair[0] <= pair[1]));
        for (squared, clearance) in (1_u32..).zip(&all[1..]) {
            assert!(in_cells(*clearance) <= f64::from(squared).sqrt() - 0.5);
        }
        assert_eq!((all[0], all[1]), (OBSTACLE, 4));
    }

    #[test]
    fn the_least_clearance_of_a_distance_is_at_least_that() {
        for cells in [0.1, 1.0, 5.999, 6.0, 6.5, 12.26] {
            let least = at_least(cells);
            assert!(in_cells(least) >= cells - 1e-8 && in_cells(least - 1) < cells);
        }
    }
}
