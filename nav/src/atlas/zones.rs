//! Zones: areas that navigation keeps out of, and areas in which it is slow.
//!
//! For the costmap, an area to keep out of is an obstacle of the map, so planning keeps the whole body out of it.
//! Lasers do not see it, and localization does not know it.

use std::sync::Arc;

use maps::{Cell, CellIndex, OccupancyGrid, Zone};

use super::clearance;

/// The map with the cells of these areas closed: those that the areas touch.
#[must_use]
pub fn closed_map<'z>(map: &OccupancyGrid, zones: impl IntoIterator<Item = &'z Zone>) -> OccupancyGrid {
    let mut closed = map.clone();
    let half_diagonal_m = map.resolution_m() * std::f64::consts::FRAC_1_SQRT_2;
    for zone in zones {
        for index in around(map, zone) {
            if zone.distance_m(&map.center(index)) <= half_diagonal_m {
                closed.set(index, Cell::Occupied);
            }
        }
    }
    closed
}

/// The cells of the smallest rectangle of the grid that contains an area.
fn around(map: &OccupancyGrid, zone: &Zone) -> impl Iterator<Item = CellIndex> + use<> {
    let corners = zone.corners.iter().map(|corner| map.origin().inverse_transform_point(corner) / map.resolution_m());
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in corners {
        for axis in 0..2 {
            (low[axis], high[axis]) = (low[axis].min(corner[axis]), high[axis].max(corner[axis]));
        }
    }
    let [columns, rows] = [(0, map.width()), (1, map.height())]
        .map(|(axis, size)| (low[axis] - 1.0).max(0.0) as usize..((high[axis] + 2.0).max(0.0) as usize).min(size));
    rows.flat_map(move |row| columns.clone().map(move |column| CellIndex { column, row }))
}

/// The zones of a map, shared by all navigators on it.
#[derive(Clone, Debug)]
pub(crate) struct Zones {
    pub(crate) map: Arc<OccupancyGrid>,
    pub(crate) list: Arc<[Zone]>,
    /// The clearances where all areas to keep out of are closed.
    pub(crate) all_closed: Arc<Vec<u8>>,
}

impl Zones {
    pub(crate) fn new(map: &Arc<OccupancyGrid>, zones: &[Zone]) -> Self {
        let kept_out = zones.iter().filter(|zone| zone.keep_out);
        let all_closed = Arc::new(clearance::of_map(&closed_map(map, kept_out)));
        Self { map: Arc::clone(map), list: zones.into(), all_closed }
    }

    /// The clearances where only these areas, by index, are closed.
    pub(crate) fn with_closed(&self, is_closed: &[bool]) -> Arc<Vec<u8>> {
        let closed = self.list.iter().zip(is_closed).filter(|(_, closed)| **closed).map(|(zone, _)| zone);
        Arc::new(clearance::of_map(&closed_map(&self.map, closed)))
    }
}

#[cfg(test)]
mod tests {
    use maps::{Point, pose};
    use proptest::prelude::*;

    use super::*;

    fn map() -> Arc<OccupancyGrid> {
        let cells = vec![Cell::Free; 40 * 30];
        Arc::new(OccupancyGrid::from_cells(40, 30, 0.1, pose(1.0, -2.0, 0.4), cells))
    }

    proptest! {
        /// No point of an area is in an open cell, and no closed cell is far from the area.
        #[test]
        fn an_area_closes_every_cell_that_it_touches(
            corners in prop::array::uniform3((-0.5..4.5_f64, -0.5..3.5_f64)), shares in prop::array::uniform2(0.0..1.0_f64),
        ) {
            let map = map();
            let corners = corners.map(|(x, y)| map.origin() * Point::new(x, y)).to_vec();
            let zone = Zone { name: "Lab".to_owned(), corners, keep_out: true, speed_mps: None };
            let closed = closed_map(&map, [&zone]);
            let [a, b, c] = [0, 1, 2].map(|corner| zone.corners[corner]);
            let edge = a + (b - a) * shares[0];
            let inside = edge + (c - edge) * shares[1];
            if let Some(cell) = map.index_of(&inside) {
                prop_assert_eq!(closed.cell(cell), Some(Cell::Occupied));
            }
            for index in (0..30).flat_map(|row| (0..40).map(move |column| CellIndex { column, row })) {
                let (is_closed, away_m) = (closed.cell(index) == Some(Cell::Occupied), zone.distance_m(&map.center(index)));
                prop_assert!(if is_closed { away_m < 0.071 } else { away_m > 0.07 }, "{index:?}");
            }
        }
    }
}
