use std::f64::consts::{PI, TAU};

use maps::{Point, pose};
use nalgebra::UnitComplex;
use proptest::prelude::*;
use robot::{LaserSpec, RobotModel};

use super::*;

/// Longest side of a grid, in cells.
const SIZE: usize = 90;

/// A grid of any size up to [`SIZE`], with random occupied cells at this density in 1/1000 and some straight walls.
fn grid(resolution_m: f64, origin: Pose) -> impl Strategy<Value = OccupancyGrid> {
    let density = prop_oneof![Just(0), Just(3), Just(30), Just(200), Just(600)];
    let wall = (0..SIZE, 0..SIZE, 1..SIZE, any::<bool>());
    (1..=SIZE, 1..=SIZE, density, any::<u64>(), prop::collection::vec(wall, 0..6)).prop_map(
        move |(width, height, density, seed, walls)| {
            let mut grid = OccupancyGrid::new(width, height, resolution_m, origin);
            let mut occupy = |column: usize, row: usize| {
                if column < width && row < height {
                    grid.set(CellIndex { column, row }, Cell::Occupied);
                }
            };
            for cell in 0..width * height {
                let mixed = (seed ^ cell as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                if (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32 & 1023 < density {
                    occupy(cell % width, cell / width);
                }
            }
            for (column, row, length, is_along_row) in walls {
                (0..length).for_each(|n| if is_along_row { occupy(column + n, row) } else { occupy(column, row + n) });
            }
            grid
        },
    )
}

/// Coordinates in and around a grid of 1 m cells: lattice points, cell centers, quarters, and anything.
fn coordinate() -> impl Strategy<Value = f64> {
    let size = SIZE as i32;
    prop_oneof![
        (-2..size + 2).prop_map(f64::from),
        (-2..size + 2).prop_map(|n| f64::from(n) + 0.5),
        (-8..4 * size + 8).prop_map(|n| f64::from(n) / 4.0),
        -2.0..f64::from(size) + 2.0,
    ]
}

/// Quarter turns, for which directions stay exact, and arbitrary ones.
fn rotation() -> impl Strategy<Value = UnitComplex<f64>> {
    let quarter = |(cos, sin)| UnitComplex::from_cos_sin_unchecked(cos, sin);
    prop_oneof![
        prop_oneof![Just((1.0, 0.0)), Just((0.0, 1.0)), Just((-1.0, 0.0)), Just((0.0, -1.0))].prop_map(quarter),
        (-PI..PI).prop_map(UnitComplex::new),
    ]
}

fn range_max() -> impl Strategy<Value = f64> {
    prop_oneof![Just(f64::INFINITY), Just(0.0), 0.0..200.0_f64, (0..60).prop_map(f64::from)]
}

/// Every direction with small integer components, counter-clockwise: axes, 45°, rational slopes, many of them
/// repeatedly.
fn rational_beams() -> Beams {
    let mut directions: Vec<Vector2<f64>> = (-8..=8)
        .flat_map(|x| (-8..=8).map(move |y| Vector2::new(f64::from(x), f64::from(y)) / 16.0))
        .filter(|direction| *direction != Vector2::zeros())
        .collect();
    directions.sort_by(|a, b| libm::atan2(a.y, a.x).total_cmp(&libm::atan2(b.y, b.x)));
    Beams::from_directions(Point::origin(), directions)
}

/// Various scanners: full circles, one with the last beam on the first; 270°; narrow; eight beams at 45°; several
/// turns; clockwise; with arbitrary mounts.
fn scanner() -> impl Strategy<Value = Beams> {
    let field = prop_oneof![
        (2..900_usize).prop_map(|beams| (-PI, TAU / beams as f64, beams)),
        (2..900_usize).prop_map(|beams| (-PI, TAU / (beams - 1) as f64, beams)),
        (2..500_usize).prop_map(|beams| (-0.75 * PI, 1.5 * PI / beams as f64, beams)),
        (-PI..PI, 1e-6..1e-3_f64, 1..300_usize),
        Just((-PI, 0.25 * PI, 8)),
        (-PI..PI, 0.05..7.0_f64, 1..200_usize),
        (-PI..PI, -0.1..0.0_f64, 1..100_usize),
    ];
    let mount = prop_oneof![
        Just(Pose::identity()),
        (-0.3..0.3_f64, -0.3..0.3_f64, -PI..PI).prop_map(|(x, y, yaw)| pose(x, y, yaw))
    ];
    (field, mount).prop_map(|((angle_min_rad, angle_increment_rad, beams), mount)| {
        let laser = RobotModel::default().lasers[0].clone();
        Beams::new(&LaserSpec { mount, angle_min_rad, angle_increment_rad, beams, ..laser })
    })
}

/// Fails unless a scan gives the same bits as the plain traversal.
fn assert_exact(walls: &Walls, beams: &Beams, base: &Pose, range_max_m: f64, memory: &mut ScanMemory) {
    let (mut ranges_m, mut expected_m) = (Vec::new(), Vec::new());
    walls.ranges(beams, base, range_max_m, memory, &mut ranges_m);
    walls.rays().ranges(beams, base, range_max_m, &mut expected_m);
    assert_eq!(ranges_m.len(), expected_m.len());
    for (index, (range_m, expected_m)) in ranges_m.iter().zip(&expected_m).enumerate() {
        let same = range_m.to_bits() == expected_m.to_bits();
        assert!(same, "beam {index} of {}: {range_m} instead of {expected_m}", ranges_m.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn a_scan_with_rational_slopes_equals_the_plain_traversal(
        grid in grid(1.0, Pose::identity()),
        at in [coordinate(), coordinate()],
        rotation in rotation(),
        range_max_m in range_max(),
    ) {
        let base = Pose::from_parts(Vector2::from(at).into(), rotation);
        assert_exact(&Walls::new(&grid), &rational_beams(), &base, range_max_m, &mut ScanMemory::default());
    }

    #[test]
    fn a_scan_of_any_scanner_equals_the_plain_traversal(
        grid in grid(1.0, Pose::identity()),
        scanners in prop::collection::vec(scanner(), 1..4),
        at in [coordinate(), coordinate()],
        rotation in rotation(),
        range_max_m in range_max(),
    ) {
        let (walls, mut memory) = (Walls::new(&grid), ScanMemory::default());
        let base = Pose::from_parts(Vector2::from(at).into(), rotation);
        scanners.iter().for_each(|beams| assert_exact(&walls, beams, &base, range_max_m, &mut memory));
    }

    #[test]
    fn scans_are_exact_on_a_rotated_map_with_small_cells(
        grid in grid(0.05, pose(-12.3, 4.5, 0.7)),
        beams in scanner(),
        at in [coordinate(), coordinate()],
        heading_rad in -PI..PI,
        range_max_m in range_max(),
    ) {
        let base = grid.origin() * pose(0.05 * at[0], 0.05 * at[1], heading_rad);
        assert_exact(&Walls::new(&grid), &beams, &base, 0.1 * range_max_m, &mut ScanMemory::default());
    }

    #[test]
    fn scans_are_exact_after_cells_have_changed(
        mut grid in grid(1.0, Pose::identity()),
        changes in prop::collection::vec((0..SIZE, 0..SIZE, any::<bool>()), 1..100),
        beams in scanner(),
        at in [coordinate(), coordinate()],
    ) {
        let mut walls = Walls::new(&grid);
        for (column, row, occupied) in changes {
            let index = CellIndex { column: column % grid.width(), row: row % grid.height() };
            let cell = if occupied { Cell::Occupied } else { Cell::Free };
            walls.set(index, cell);
            grid.set(index, cell);
        }
        let (mut changed_m, mut new_m) = (Vec::new(), Vec::new());
        let base = pose(at[0], at[1], 0.3);
        walls.ranges(&beams, &base, 50.0, &mut ScanMemory::default(), &mut changed_m);
        Walls::new(&grid).rays().ranges(&beams, &base, 50.0, &mut new_m);
        prop_assert_eq!(changed_m, new_m);
    }
}

#[test]
fn beams_in_any_order_and_without_direction_are_cast_correctly() {
    let mut grid = OccupancyGrid::new(30, 30, 1.0, Pose::identity());
    (0..30).for_each(|n| grid.set(CellIndex { column: n, row: 29 - n / 3 }, Cell::Occupied));
    let mixed = (0..200).map(|n| Vector2::new(f64::from(n * 37 % 101) - 50.0, f64::from(n * 53 % 97) - 48.0) / 128.0);
    let odd = [Vector2::zeros(), Vector2::new(f64::NAN, 1.0), Vector2::new(0.0, -0.0)];
    let beams = Beams::from_directions(Point::new(0.1, 0.2), mixed.chain(odd).collect());
    assert_exact(&Walls::new(&grid), &beams, &pose(9.9, 7.8, 0.0), 40.0, &mut ScanMemory::default());
    let none = Beams::from_directions(Point::origin(), Vec::new());
    assert_exact(&Walls::new(&grid), &none, &pose(9.9, 7.8, 0.0), 40.0, &mut ScanMemory::default());
}

#[test]
fn beams_closer_than_rounding_errors_are_cast_correctly() {
    let mut grid = OccupancyGrid::new(60, 60, 1.0, Pose::identity());
    (20..60).for_each(|row| grid.set(CellIndex { column: 35 + row % 2, row }, Cell::Occupied));
    (0..60).for_each(|column| grid.set(CellIndex { column, row: 59 }, Cell::Occupied));
    let walls = Walls::new(&grid);
    let mantissa = |value: f64| i128::from(value.to_bits() & ((1 << 52) - 1) | 1 << 52);
    let is_below =
        |a: &Vector2<f64>, b: &Vector2<f64>| (mantissa(a.y) * mantissa(b.x)).cmp(&(mantissa(b.y) * mantissa(a.x)));
    for n in 0..400 {
        // At a corner of the wall, and some bits next to it; counter-clockwise to the last bit.
        let origin = Point::new(0.3 + f64::from(n) * 0.007, 0.9 - f64::from(n) * 0.0011);
        let corner = (Point::new(35.0, 21.0) - origin) / 64.0;
        let beside = |value: f64, bits: i64| f64::from_bits(value.to_bits().wrapping_add_signed(bits));
        let mut directions: Vec<_> =
            (0..400).map(|n| Vector2::new(beside(corner.x, n % 20), beside(corner.y, n / 20))).collect();
        directions.sort_by(is_below);
        let beams = Beams::from_directions(origin, directions);
        assert_exact(&walls, &beams, &Pose::identity(), 400.0, &mut ScanMemory::default());
    }
}

#[test]
fn a_grid_too_large_for_sweeps_is_still_scanned() {
    let mut grid = OccupancyGrid::new(600_000, 1, 0.05, Pose::identity());
    grid.set(CellIndex { column: 500_000, row: 0 }, Cell::Occupied);
    let mut walls = Walls::new(&grid);
    walls.set(CellIndex { column: 300_000, row: 0 }, Cell::Occupied);
    let beams = Beams::from_directions(Point::origin(), vec![Vector2::x(), Vector2::y(), -Vector2::x()]);
    let mut ranges_m = Vec::new();
    walls.ranges(&beams, &pose(10.0, 0.02, 0.0), f64::INFINITY, &mut ScanMemory::default(), &mut ranges_m);
    assert_eq!(ranges_m, [14_990.0, f64::INFINITY, f64::INFINITY]);
}
