//! The places where scans are taken.

use std::fmt;
use std::path::Path;

use diagnostics::from_disk;
use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose, load_map, pose};

use crate::floor;

/// The maximum number of poses per place.
const POSES: usize = 400;

/// A map, and poses in free places all over it, with various headings.
pub(crate) struct Place {
    name: &'static str,
    pub(crate) grid: OccupancyGrid,
    pub(crate) poses: Vec<Pose>,
}

/// The places: two built-in ones, and the map that `STEWARD_BENCH_MAP` names.
pub(crate) fn places() -> Vec<Place> {
    let drawn = [Place::new("floor", floor::floor()), Place::new("posts", posts())];
    let named = std::env::var_os("STEWARD_BENCH_MAP").map(|file| {
        let grid = load_map(Path::new(&file), &from_disk).expect("STEWARD_BENCH_MAP names a map");
        Place::new("STEWARD_BENCH_MAP", grid)
    });
    drawn.into_iter().chain(named).collect()
}

/// A square of almost 100 m with one random cell in 340 occupied: the worst case for a sweep, because hardly any two
/// beams end on the same wall and hardly any eight rows are free.
fn posts() -> OccupancyGrid {
    const SIDE: usize = 1984;
    let mut grid = OccupancyGrid::new(SIDE, SIDE, 0.05, pose(0.0, 0.0, 0.0));
    for offset in 0..SIDE * SIDE {
        let mixed = (offset as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let is_post = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32 & 1023 < 3;
        let index = CellIndex { column: offset % SIDE, row: offset / SIDE };
        grid.set(index, if is_post { Cell::Occupied } else { Cell::Free });
    }
    grid
}

impl Place {
    fn new(name: &'static str, grid: OccupancyGrid) -> Self {
        let anywhere = (0..8000).map(|n| {
            let n = f64::from(n);
            let (x, y) = ((n * 0.618_033_988_75).fract(), (n * 0.414_213_562_37).fract());
            let at = grid.from_grid(&Point::new(x * grid.width() as f64, y * grid.height() as f64));
            pose(at.x, at.y, n * 2.399_963)
        });
        let is_free = |at: &Pose| {
            let index = grid.index_of(&at.translation.vector.into());
            index.and_then(|index| grid.cell(index)) == Some(Cell::Free)
        };
        let poses = anywhere.filter(is_free).take(POSES).collect();
        Self { name, grid, poses }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}
