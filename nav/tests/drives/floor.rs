//! Floors drawn in code.

use maps::{Cell, CellIndex, OccupancyGrid, Point, pose};

/// A floor of `width_m` × `height_m` at 0.05 m, free inside its outer walls, with its lower left corner at the origin.
pub(crate) fn hall(width_m: f64, height_m: f64) -> OccupancyGrid {
    let cells = |meters: f64| (meters / 0.05).round() as usize;
    let mut map = OccupancyGrid::new(cells(width_m), cells(height_m), 0.05, pose(0.0, 0.0, 0.0));
    fill(&mut map, [0.0, 0.0, width_m, height_m], Cell::Occupied);
    fill(&mut map, [0.1, 0.1, width_m - 0.1, height_m - 0.1], Cell::Free);
    map
}

/// Sets the cells whose centers lie in a rectangle: left, bottom, right, top in meters from the lower left corner.
pub(crate) fn fill(map: &mut OccupancyGrid, [left, bottom, right, top]: [f64; 4], cell: Cell) {
    let resolution_m = map.resolution_m();
    let cells = |from: f64, to: f64, most: usize| {
        let first = |meters: f64| (meters / resolution_m - 0.5 + 1e-9).ceil().max(0.0) as usize;
        first(from)..first(to).min(most)
    };
    for row in cells(bottom, top, map.height()) {
        for column in cells(left, right, map.width()) {
            map.set(CellIndex { column, row }, cell);
        }
    }
}

/// Occupies the cells whose centers lie in a disc around a point in meters from the lower left corner.
pub(crate) fn fill_disc(map: &mut OccupancyGrid, [x, y]: [f64; 2], radius_m: f64) {
    let resolution_m = map.resolution_m();
    let center = |cell: usize| (cell as f64 + 0.5) * resolution_m;
    let (width, height) = (map.width(), map.height());
    for index in (0..height).flat_map(|row| (0..width).map(move |column| CellIndex { column, row })) {
        let (x, y) = (center(index.column) - x, center(index.row) - y);
        if x * x + y * y < radius_m * radius_m {
            map.set(index, Cell::Occupied);
        }
    }
}

/// An office floor of 28 m × 22 m: two rows of rooms along corridors, doors of 1 m, furniture.
pub(crate) fn office() -> OccupancyGrid {
    let mut map = hall(28.0, 22.0);
    for y in [8.0, 10.5, 18.0] {
        fill(&mut map, [0.0, y, 28.0, y + 0.15], Cell::Occupied);
    }
    for room in 0..5 {
        let left = 5.6 * f64::from(room);
        fill(&mut map, [left, 0.0, left + 0.15, 8.0], Cell::Occupied);
        fill(&mut map, [left, 10.5, left + 0.15, 18.0], Cell::Occupied);
        for y in [8.0, 10.5, 18.0] {
            fill(&mut map, [left + 2.2, y, left + 3.2, y + 0.15], Cell::Free);
        }
        fill(
            &mut map,
            [left + 0.5, 1.0 + 0.3 * f64::from(room), left + 1.7, 1.8 + 0.3 * f64::from(room)],
            Cell::Occupied,
        );
        fill(&mut map, [left + 4.0, 5.0, left + 4.6, 6.5 - 0.2 * f64::from(room)], Cell::Occupied);
        fill(&mut map, [left + 0.8, 13.0, left + 1.2, 16.0 - 0.4 * f64::from(room)], Cell::Occupied);
        fill(&mut map, [left + 4.2, 15.5, left + 5.0, 16.3], Cell::Occupied);
    }
    map
}

/// Corners of a drive of about 60 m through the rooms of [`office`].
pub(crate) fn round_trip() -> Vec<Point> {
    let corners = [
        (2.7, 3.5),
        (2.7, 9.3),
        (13.9, 9.3),
        (13.9, 13.5),
        (13.9, 19.8),
        (25.1, 19.8),
        (25.1, 9.3),
        (19.5, 9.3),
        (19.5, 3.0),
    ];
    corners.map(|(x, y)| Point::new(x, y)).to_vec()
}

/// Two rooms of 4 m × 5 m with a doorway of this width in the wall between them, at x = 4 m.
pub(crate) fn two_rooms(doorway_m: f64) -> OccupancyGrid {
    let mut map = hall(8.2, 5.0);
    fill(&mut map, [4.0, 0.0, 4.2, 5.0], Cell::Occupied);
    fill(&mut map, [4.0, 2.5 - doorway_m / 2.0, 4.2, 2.5 + doorway_m / 2.0], Cell::Free);
    map
}
