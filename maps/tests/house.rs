//! The project's own map keeps the properties that scenarios rely on.

mod plan;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use maps::{Cell, CellIndex, OccupancyGrid, Place, Point, house};

use plan::HOUSE;

/// The robot is a disc of radius 0.30 m, which must fit everywhere with 0.1 m to spare.
const CLEARANCE_M: f64 = 0.40;

/// A planner that prefers distance from walls keeps this far away from them.
const COMFORT_M: f64 = 0.70;

#[test]
fn the_committed_map_is_what_the_generator_draws() {
    HOUSE.compare_files("house");
}

#[test]
fn the_committed_files_load_as_the_map() {
    assert_eq!(house::map(), HOUSE.draw());
}

#[test]
fn the_places_are_where_the_original_has_them() {
    let places = house::places();
    let goal = |name: &str| places.get(name).unwrap().goal_position();
    assert_eq!((goal("start"), goal("RechargingStation")), (Point::new(0.0, 0.0), Point::new(-7.5, 9.0)));
    assert_eq!(places.get("RechargingStation").unwrap().goal_heading(), Some(std::f64::consts::PI));
    let corners = [(-13.2, 15.6), (-10.0, 15.4), (-10.2, 12.6), (-13.4, 13.0)].map(|(x, y)| Point::new(x, y));
    assert_eq!(places.get("Destination"), Some(&Place::Area { corners: corners.to_vec() }));
}

#[test]
fn there_is_room_at_every_place() {
    let (map, places) = (house::map(), house::places());
    for (name, place) in places.iter() {
        assert!(map.has_room(&place.goal_position(), 0.5), "{name} is cramped");
    }
}

#[test]
fn every_room_can_be_reached() {
    let map = house::map();
    let distances = Distances::from(&map, &Point::new(0.0, 0.0), 0);
    let rooms = [
        ("corridor", (9.0, 6.8)),
        ("kitchen", (-12.0, 14.0)),
        ("broom closet", (-13.3, 9.5)),
        ("bedroom", (-7.0, 14.0)),
        ("meeting room", (0.0, 9.0)),
        ("study", (0.0, 14.0)),
        ("store", (7.8, 9.5)),
        ("workshop", (-10.0, 4.5)),
        ("cellar", (-12.0, -2.0)),
        ("office", (-6.0, 4.0)),
        ("bath", (-5.0, -1.5)),
        ("guest room", (10.0, 3.0)),
        ("dining room", (7.5, -2.0)),
    ];
    for (name, (x, y)) in rooms {
        assert!(distances.to(&map, &Point::new(x, y)).is_some(), "no way to the {name}");
    }
}

#[test]
fn the_station_is_on_the_way_but_not_in_the_way() {
    let (map, places) = (house::map(), house::places());
    let goal = |name: &str| places.get(name).unwrap().goal_position();
    let (start, station, destination) = (goal("start"), goal("RechargingStation"), goal("Destination"));
    // This must hold whether a planner cuts corners or keeps away from walls.
    for shyness in [0, 1, 4] {
        let route = Distances::from(&map, &start, shyness).route_to(&map, &destination);
        let length_m: f64 = route.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let nearest_m = route.iter().map(|point| (point - station).norm()).fold(f64::INFINITY, f64::min);
        assert!((25.0..30.0).contains(&length_m), "with shyness {shyness}, the route is {length_m} m long");
        assert!((1.2..2.0).contains(&nearest_m), "with shyness {shyness}, the route passes at {nearest_m} m");
    }
}

/// The lengths of the shortest paths from one cell to all others, through cells with room for the robot.
struct Distances {
    /// In millimeters, weighted near walls; `None` if there is no path.
    cost: Vec<Option<u64>>,
    before: Vec<Option<CellIndex>>,
}

impl Distances {
    /// Dijkstra's algorithm over eight neighbors. A step near a wall costs 1 + `shyness` times its length.
    fn from(map: &OccupancyGrid, start: &Point, shyness: u64) -> Self {
        let weights = weights(map, shyness);
        let start = map.index_of(start).expect("the start lies on the map");
        let mut found = Self { cost: vec![None; weights.len()], before: vec![None; weights.len()] };
        let mut queue = BinaryHeap::from([(Reverse(0), start, None)]);
        while let Some((Reverse(cost), index, before)) = queue.pop() {
            let offset = map.offset(index).expect("only cells of the map are queued");
            if found.cost[offset].is_some() {
                continue;
            }
            (found.cost[offset], found.before[offset]) = (Some(cost), before);
            for (neighbor, length_mm) in neighbors(index) {
                let Some(weight) = map.offset(neighbor).and_then(|offset| weights[offset]) else { continue };
                queue.push((Reverse(cost + length_mm * weight), neighbor, Some(index)));
            }
        }
        found
    }

    fn to(&self, map: &OccupancyGrid, point: &Point) -> Option<u64> {
        self.cost[map.offset(map.index_of(point)?)?]
    }

    fn route_to(&self, map: &OccupancyGrid, goal: &Point) -> Vec<Point> {
        let before = |index: &CellIndex| self.before[map.offset(*index)?];
        std::iter::successors(map.index_of(goal), before).map(|index| map.center(index)).collect()
    }
}

/// The cost of a step into each cell relative to its length; `None` where the robot does not fit.
fn weights(map: &OccupancyGrid, shyness: u64) -> Vec<Option<u64>> {
    let indices = (0..map.height()).flat_map(|row| (0..map.width()).map(move |column| CellIndex { column, row }));
    let weight = |index: CellIndex| {
        let (center, free) = (map.center(index), map.cell(index) == Some(Cell::Free));
        if !free || !map.has_room(&center, CLEARANCE_M) {
            return None;
        }
        Some(if shyness == 0 || map.has_room(&center, COMFORT_M) { 1 } else { 1 + shyness })
    };
    indices.map(weight).collect()
}

fn neighbors(index: CellIndex) -> impl Iterator<Item = (CellIndex, u64)> {
    let sides = [(1, 0), (0, 1), (-1, 0), (0, -1)].map(|step| (step, 50));
    let corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)].map(|step| (step, 71));
    sides.into_iter().chain(corners).filter_map(move |((dx, dy), length_mm)| {
        let (column, row) = (index.column.checked_add_signed(dx)?, index.row.checked_add_signed(dy)?);
        Some((CellIndex { column, row }, length_mm))
    })
}
