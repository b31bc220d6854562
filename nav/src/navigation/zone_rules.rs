//! Which zones are in force for a robot.
//!
//! A robot that is inside an area to keep out of ignores that area until it has left it: otherwise it would find no way
//! out.

use std::sync::Arc;

use maps::Point;

use crate::atlas::zones::Zones;

/// A robot whose center is this close to an area, in cells, stands in a cell that the area closes: the diagonal of a
/// cell, and a little more.
const INSIDE_CELLS: f64 = 1.5;

/// The speed of an area holds from this distance on, in meters: localization may be off, and a command takes a while.
const MARGIN_M: f64 = 0.1;

/// Which zones are in force for a robot.
#[derive(Clone, Debug)]
pub(crate) struct ZoneRules {
    zones: Zones,
    /// The zones, by index, that navigation ignores for no good reason.
    ignored: Vec<bool>,
    /// The areas, by index, that are closed.
    closed: Vec<bool>,
}

impl ZoneRules {
    pub(crate) fn new(zones: &Zones) -> Self {
        let closed = zones.list.iter().map(|zone| zone.keep_out).collect();
        Self { zones: zones.clone(), ignored: vec![false; zones.list.len()], closed }
    }

    /// Ignores these zones from now on, and no others.
    pub(crate) fn ignore(&mut self, is_ignored: impl Fn(&str) -> bool) {
        self.ignored = self.zones.list.iter().map(|zone| is_ignored(&zone.name)).collect();
    }

    /// The clearances of the map for a robot at this point of the `map` frame, if other areas are closed than before.
    pub(crate) fn changed(&mut self, at: &Point) -> Option<Arc<Vec<u8>>> {
        let inside_m = INSIDE_CELLS * self.zones.map.resolution_m();
        let zones = self.zones.list.iter().zip(&self.ignored);
        let closed: Vec<bool> =
            zones.map(|(zone, ignored)| zone.keep_out && !ignored && zone.distance_m(at) > inside_m).collect();
        if closed == self.closed {
            return None;
        }
        self.closed = closed;
        Some(self.zones.with_closed(&self.closed))
    }

    /// Whether a closed area is what lies within this distance of the cell at a point of the `map` frame, in meters.
    pub(crate) fn closes(&self, at: &Point, within_m: f64) -> bool {
        let reach_m = within_m + INSIDE_CELLS * self.zones.map.resolution_m();
        let closed = self.zones.list.iter().zip(&self.closed).filter(|(_, closed)| **closed);
        closed.map(|(zone, _)| zone).any(|zone| zone.distance_m(at) <= reach_m)
    }

    /// The highest speed at a point of the `map` frame that the robot reaches after `way_m` meters, in m/s, if it
    /// brakes with this deceleration, in m/s².
    pub(crate) fn speed_mps(&self, at: &Point, way_m: f64, braking_mps2: f64) -> f64 {
        let zones = self.zones.list.iter().zip(&self.ignored).filter(|(_, ignored)| !**ignored);
        let limits = zones.filter_map(|(zone, _)| zone.speed_mps.filter(|_| zone.distance_m(at) <= MARGIN_M));
        limits.map(|limit| (limit * limit + 2.0 * braking_mps2 * way_m).sqrt()).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use maps::{Cell, OccupancyGrid, Zone, pose};

    use super::*;

    fn map() -> Arc<OccupancyGrid> {
        let cells = vec![Cell::Free; 40 * 30];
        Arc::new(OccupancyGrid::from_cells(40, 30, 0.1, pose(1.0, -2.0, 0.4), cells))
    }

    fn zone(name: &str, corners: [(f64, f64); 3], speed_mps: Option<f64>) -> Zone {
        let corners = corners.map(|(x, y)| map().origin() * Point::new(x, y)).to_vec();
        Zone { name: name.to_owned(), corners, keep_out: speed_mps.is_none(), speed_mps }
    }

    #[test]
    fn an_area_is_open_while_the_robot_is_inside_or_navigation_ignores_it() {
        let map = map();
        let lab = zone("Lab", [(1.0, 1.0), (3.0, 1.0), (2.0, 2.5)], None);
        let mut rules = ZoneRules::new(&Zones::new(&map, &[lab]));
        let at = |x: f64, y: f64| map.origin() * Point::new(x, y);
        let (inside, outside) = (at(2.0, 1.5), at(0.5, 0.5));
        assert!(rules.changed(&outside).is_none(), "it is closed from the start");
        let open = rules.changed(&inside).expect("it opens");
        assert_eq!(open, rules.zones.with_closed(&[false]));
        assert!(!rules.closes(&inside, 1.0));
        assert!(rules.changed(&inside).is_none());
        assert_eq!(rules.changed(&outside), Some(Arc::clone(&rules.zones.all_closed)));
        assert!(rules.closes(&inside, 0.0) && !rules.closes(&outside, 0.2));
        rules.ignore(|name| name == "Lab");
        assert!(rules.changed(&outside).is_some());
        rules.ignore(|_| false);
        assert!(rules.changed(&outside).is_some());
    }

    #[test]
    fn a_speed_holds_inside_and_before_as_far_as_braking_takes() {
        let map = map();
        let slow = zone("Slow", [(1.0, 1.0), (3.0, 1.0), (2.0, 2.5)], Some(0.2));
        let rules = ZoneRules::new(&Zones::new(&map, &[slow]));
        let at = |x: f64, y: f64| map.origin() * Point::new(x, y);
        assert_eq!(rules.speed_mps(&at(2.0, 1.5), 0.0, 0.5), 0.2);
        assert_eq!(rules.speed_mps(&at(2.0, 0.5), 0.0, 0.5), f64::INFINITY);
        let ahead = rules.speed_mps(&at(2.0, 1.5), 0.3, 0.5);
        assert!((ahead * ahead - 0.34).abs() < 1e-12, "{ahead}");
    }
}
