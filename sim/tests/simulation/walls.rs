//! Scans by the million: the sweep equals the plain traversal.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use diagnostics::from_disk;
use maps::{Cell, CellIndex, OccupancyGrid, Point, load_map, pose};
use robot::{LaserSpec, RobotModel};
use sim::{Beams, ScanMemory, Walls};

/// 2000 scans of 720 beams over 360° and 30 m, wherever the map has room.
fn assert_scans_are_exact(grid: &OccupancyGrid) {
    let laser = LaserSpec {
        angle_min_rad: -PI,
        angle_increment_rad: TAU / 720.0,
        beams: 720,
        range_max_m: 30.0,
        ..RobotModel::default().lasers[0].clone()
    };
    let (walls, beams, mut memory) = (Walls::new(grid), Beams::new(&laser), ScanMemory::default());
    let (mut ranges_m, mut expected_m) = (Vec::new(), Vec::new());
    let (mut scans, mut hits) = (0, 0);
    for n in (0..).map(f64::from) {
        let (x, y) = ((n * 0.618_033_988_75).fract(), (n * 0.414_213_562_37).fract());
        let at = grid.from_grid(&Point::new(x * grid.width() as f64, y * grid.height() as f64));
        if grid.index_of(&at).and_then(|index| grid.cell(index)) != Some(Cell::Free) {
            continue;
        }
        let base = pose(at.x, at.y, n * 2.399_963);
        walls.ranges(&beams, &base, laser.range_max_m, &mut memory, &mut ranges_m);
        walls.rays().ranges(&beams, &base, laser.range_max_m, &mut expected_m);
        let differ =
            ranges_m.iter().zip(&expected_m).position(|(range, expected)| range.to_bits() != expected.to_bits());
        assert_eq!(differ, None, "the first such beam from {base}");
        hits += ranges_m.iter().filter(|range| range.is_finite()).count();
        scans += 1;
        if scans == 2000 {
            break;
        }
    }
    assert!(hits > 720_000, "only {hits} of 1.44 million beams met a wall");
}

/// Rooms of many sizes with open doors, and one cell in a thousand occupied.
fn building() -> OccupancyGrid {
    const SIDE: usize = 1984;
    let mut grid = OccupancyGrid::new(SIDE, SIDE, 0.05, pose(-50.0, -40.0, 0.4));
    for offset in 0..SIDE * SIDE {
        let (column, row) = (offset % SIDE, offset / SIDE);
        let (room_x, room_y) = (60 + row / 300 * 37, 90 + column / 400 * 23);
        let is_wall = (column % room_x < 3 && row % 71 > 20) || (row % room_y < 4 && column % 83 > 18);
        let mixed = (offset as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let is_clutter = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32 & 1023 == 0;
        grid.set(CellIndex { column, row }, if is_wall || is_clutter { Cell::Occupied } else { Cell::Free });
    }
    grid
}

#[test]
fn a_million_beams_in_a_building_are_exact() {
    assert_scans_are_exact(&building());
}

#[test]
#[ignore = "wants a map: STEWARD_BENCH_MAP=path/to/map.yaml cargo test -p steward-sim -- --ignored"]
fn a_million_beams_on_your_own_map_are_exact_on_demand() {
    let file = std::env::var_os("STEWARD_BENCH_MAP").expect("STEWARD_BENCH_MAP names a map");
    assert_scans_are_exact(&load_map(Path::new(&file), &from_disk).expect("the map can be read"));
}
