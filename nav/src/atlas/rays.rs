//! Rays on the map: how long beams should be.

use maps::{Cell, OccupancyGrid};

use super::surface_field;

/// A beam in the robot's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    /// Where it starts, in meters.
    pub(crate) eye: [f32; 2],
    /// Its direction, of length one.
    pub(crate) direction: [f32; 2],
    /// Its length in meters; infinite if it hit nothing.
    pub(crate) range_m: f32,
    /// The maximum range of its laser, in meters.
    pub(crate) range_max_m: f32,
}

/// The length of a ray according to the map, in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Expected {
    /// It ends at an obstacle.
    Wall(f64),
    /// It enters unknown cells before any obstacle.
    Unknown(f64),
    /// It hits nothing within range.
    Nothing,
}

/// The length of a ray according to the map, from a point of the grid's frame, in meters, in a direction of length one.
///
/// Source: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987.
pub(crate) fn expected(map: &OccupancyGrid, from: [f64; 2], direction: [f64; 2], range_max_m: f64) -> Expected {
    let resolution_m = map.resolution_m();
    let at = from.map(|meters| meters / resolution_m);
    let mut cell = at.map(|cells| cells.floor() as i64);
    let axis = |along: f64, at: f64, cell: i64| match along {
        0.0 => (0, f64::INFINITY, f64::INFINITY),
        _ if along > 0.0 => (1, ((cell + 1) as f64 - at) / along, 1.0 / along),
        _ => (-1, (cell as f64 - at) / along, -1.0 / along),
    };
    // By axis: the direction of the next cell, the way to its border, and the way from one border to the next. The way
    // is in cells along the ray, since the direction has length one.
    let (step_x, mut next_x, width_x) = axis(direction[0], at[0], cell[0]);
    let (step_y, mut next_y, width_y) = axis(direction[1], at[1], cell[1]);
    let mut way = 0.0;
    while way * resolution_m < range_max_m {
        match surface_field::cell(map, cell[0], cell[1]) {
            Cell::Free => {}
            Cell::Occupied => return Expected::Wall(way * resolution_m),
            Cell::Unknown => return Expected::Unknown(way * resolution_m),
        }
        if next_x < next_y {
            (way, next_x, cell[0]) = (next_x, next_x + width_x, cell[0] + step_x);
        } else {
            (way, next_y, cell[1]) = (next_y, next_y + width_y, cell[1] + step_y);
        }
    }
    Expected::Nothing
}

#[cfg(test)]
mod tests {
    use maps::{CellIndex, pose};

    use super::*;

    /// Free from x = 1 m to 4 m; a wall on the right, unknown space on the left and all around.
    fn map() -> OccupancyGrid {
        let mut map = OccupancyGrid::new(60, 40, 0.1, pose(0.0, 0.0, 0.0));
        for row in 5..35 {
            (10..40).for_each(|column| map.set(CellIndex { column, row }, Cell::Free));
            map.set(CellIndex { column: 40, row }, Cell::Occupied);
        }
        map
    }

    #[test]
    fn rays_end_at_walls_and_in_unknown_space() {
        let from = [2.0, 2.0];
        assert_eq!(expected(&map(), from, [1.0, 0.0], 10.0), Expected::Wall(2.0));
        assert_eq!(expected(&map(), from, [1.0, 0.0], 1.5), Expected::Nothing);
        let Expected::Unknown(way_m) = expected(&map(), from, [-1.0, 0.0], 10.0) else { panic!("unknown") };
        assert!((way_m - 1.0).abs() < 1e-9);
        let Expected::Wall(way_m) = expected(&map(), from, [0.6, 0.8], 10.0) else { return };
        panic!("the unknown comes before a wall at {way_m}");
    }
}
