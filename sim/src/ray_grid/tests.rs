use proptest::prelude::*;

use super::*;

const SIZE: usize = 24;

/// A grid of 1 m cells at the origin, occupied where the function is true.
fn grid(occupied: impl Fn(usize, usize) -> bool) -> OccupancyGrid {
    let mut grid = OccupancyGrid::new(SIZE, SIZE, 1.0, Pose::identity());
    for (column, row) in (0..SIZE).flat_map(|row| (0..SIZE).map(move |column| (column, row))) {
        if occupied(column, row) {
            grid.set(CellIndex { column, row }, Cell::Occupied);
        }
    }
    grid
}

/// The unit in which coordinates and components of directions are integers; products of two are exact in f64.
const UNIT: f64 = 1.0 / 1_048_576.0;

/// The same ray by brute force, with integers only: all grid lines that it crosses, sorted by distance, with those
/// across y first if they coincide; then the cells between them in this order.
fn by_brute_force(
    grid: &OccupancyGrid,
    origin: [i128; 2],
    direction: [i128; 2],
    max: i128,
) -> Option<(f64, CellIndex)> {
    const ONE: i128 = 1_048_576;
    let mut cell = origin.map(|o| o.div_euclid(ONE));
    let occupied = |cell: [i128; 2]| {
        let index = CellIndex { column: usize::try_from(cell[0]).ok()?, row: usize::try_from(cell[1]).ok()? };
        (grid.cell(index) == Some(Cell::Occupied)).then_some(index)
    };
    if let Some(index) = occupied(cell) {
        return Some((0.0, index));
    }
    // A line at distance p / q along the ray, across axis 0 or 1. A ray that goes down from a line crosses it at once.
    let mut lines: Vec<(i128, i128, usize)> = Vec::new();
    for axis in (0..2).filter(|axis| direction[*axis] != 0) {
        let d = direction[axis];
        let ways = (-100..100).map(|line| (line * ONE - origin[axis]) * d.signum());
        let crossed = ways.filter(|p| (*p > 0 || (*p == 0 && d < 0)) && *p <= max * d.abs());
        lines.extend(crossed.map(|p| (p, d.abs(), axis)));
    }
    lines.sort_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)).then(b.2.cmp(&a.2)));
    for (p, q, axis) in lines {
        cell[axis] += direction[axis].signum();
        if let Some(index) = occupied(cell) {
            return Some((p as f64 / q as f64, index));
        }
    }
    None
}

/// Coordinates from −4 to 28: lattice points, cell centers, quarters, and anything.
fn coordinate() -> impl Strategy<Value = i128> {
    prop_oneof![
        (-4..28_i128).prop_map(|n| n * 1_048_576),
        (-4..28_i128).prop_map(|n| n * 1_048_576 + 524_288),
        (-16..112_i128).prop_map(|n| n * 262_144),
        -4 * 1_048_576..28 * 1_048_576_i128,
    ]
}

/// Directions along the axes, at 45°, of small rational slopes, and any.
fn direction() -> impl Strategy<Value = [i128; 2]> {
    let any = -1_048_576..=1_048_576_i128;
    prop_oneof![
        prop_oneof![Just([1, 0]), Just([-1, 0]), Just([0, 1]), Just([0, -1])],
        prop_oneof![Just([1, 1]), Just([-1, 1]), Just([1, -1]), Just([-1, -1])],
        [-7..=7_i128, -7..=7_i128],
        [any.clone(), any],
    ]
    .prop_filter("a direction", |d| *d != [0, 0])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_ray_ends_in_the_cell_and_at_the_distance_found_by_brute_force(
        seed in any::<u64>(),
        density in 1..40_u64,
        origin in [coordinate(), coordinate()],
        direction in direction(),
        reach in 1..60_i128,
    ) {
        // In lengths of the direction: enough to cross about `reach` cells.
        let max = reach * 1_048_576 / direction[0].abs().max(direction[1].abs());
        let occupied = |c: usize, r: usize| {
            let mixed = (seed ^ (c * SIZE + r) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32 & 127 < density
        };
        let grid = grid(occupied);
        let expected = by_brute_force(&grid, origin, direction, max);
        let ray_grid = RayGrid::new(&grid);
        let from = Point::new(origin[0] as f64 * UNIT, origin[1] as f64 * UNIT);
        let along = Vector2::new(direction[0] as f64, direction[1] as f64);
        let hit = ray_grid.cast(&from, &along, max as f64 * UNIT);
        let found = hit.map(|hit| (hit.distance, ray_grid.cell(&hit)));
        prop_assert_eq!(found.map(|f| f.1), expected.map(|e| e.1));
        if let (Some((found, _)), Some((expected, _))) = (found, expected) {
            prop_assert!((found - expected * UNIT).abs() <= 1e-15 * expected, "{} and {}", found, expected * UNIT);
        }
    }
}

#[test]
fn a_ray_through_a_corner_steps_along_y_first() {
    let beside = RayGrid::new(&grid(|c, r| (c, r) == (6, 5)));
    let above = RayGrid::new(&grid(|c, r| (c, r) == (5, 6)));
    let (origin, diagonal) = (Point::new(5.5, 5.5), Vector2::new(1.0, 1.0));
    assert_eq!(beside.cast(&origin, &diagonal, 20.0), None);
    assert_eq!(above.cast(&origin, &diagonal, 20.0).map(|hit| hit.distance), Some(0.5));
}

#[test]
fn unknown_cells_are_transparent_and_a_ray_from_inside_a_wall_hits_it_at_once() {
    let grid = RayGrid::new(&grid(|c, _| c == 10));
    let hit = grid.cast(&Point::new(2.25, 3.5), &Vector2::new(0.6, 0.0), 100.0).expect("the wall is ahead");
    assert_eq!((hit.distance, grid.cell(&hit)), (7.75 / 0.6, CellIndex { column: 10, row: 3 }));
    assert_eq!(grid.cast(&Point::new(10.5, 3.5), &Vector2::new(1.0, 0.0), 9.0).map(|hit| hit.distance), Some(0.0));
}

#[test]
fn rays_that_never_return_end() {
    let grid = RayGrid::new(&grid(|_, _| true));
    for (x, y, dx, dy) in [(-3.0, 5.0, -1.0, 0.1), (30.0, 5.0, 0.0, 1.0), (5.0, -2.0, 1.0, 0.0)] {
        assert_eq!(grid.cast(&Point::new(x, y), &Vector2::new(dx, dy), f64::INFINITY), None);
    }
    assert_eq!(grid.cast(&Point::new(f64::NAN, 0.0), &Vector2::new(1.0, 0.0), 10.0), None);
}
