//! Planning, the costmap, and a control step.

#[path = "../tests/drives/floor.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod floor;
#[path = "../tests/drives/unicycle.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod unicycle;

use std::time::Duration;

use divan::Bencher;
use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose, pose};
use nalgebra::Matrix3;
use nav::{Costmap, CostmapParameters, Goal, NavigationParameters, Navigator, PoseEstimate, plan};
use unicycle::{Noise, Unicycle};

fn main() {
    divan::main();
}

/// A floor of 1984 × 1984 cells (99.2 m square): 256 rooms of 6 m, each with 1 m wide doors on all sides, which are not
/// aligned.
fn campus() -> OccupancyGrid {
    let mut map = floor::hall(99.2, 99.2);
    for wall in 1..16 {
        let at = 6.2 * f64::from(wall);
        floor::fill(&mut map, [at, 0.0, at + 0.15, 99.2], Cell::Occupied);
        floor::fill(&mut map, [0.0, at, 99.2, at + 0.15], Cell::Occupied);
    }
    for wall in 1..16 {
        for room in 0..16 {
            let (at, door) = (6.2 * f64::from(wall), 6.2 * f64::from(room) + 1.0 + 0.5 * f64::from((wall + room) % 7));
            floor::fill(&mut map, [at, door, at + 0.15, door + 1.0], Cell::Free);
            floor::fill(&mut map, [door, at, door + 1.0, at + 0.15], Cell::Free);
        }
    }
    map
}

/// The office of 28 m × 22 m on a map of 1984 × 1984 cells, the rest of which is unknown.
fn office_on_a_large_map() -> OccupancyGrid {
    let office = floor::office();
    let mut map = OccupancyGrid::new(1984, 1984, 0.05, pose(-50.0, -50.0, 0.0));
    for (offset, cell) in office.cells().iter().enumerate() {
        let (column, row) = (offset % office.width() + 800, offset / office.width() + 800);
        map.set(CellIndex { column, row }, *cell);
    }
    map
}

fn costmap(map: &OccupancyGrid) -> Costmap {
    Costmap::new(map, CostmapParameters::default()).expect("the parameters are valid")
}

/// Inflating 1984 × 1984 cells.
#[divan::bench(sample_count = 10)]
fn costmap_of_a_campus(bencher: Bencher) {
    let map = campus();
    bencher.bench_local(|| costmap(&map));
}

/// From one corner of 1984 × 1984 cells to the other, through 31 rooms: A* over cells alone would visit nearly all.
#[divan::bench(sample_count = 3)]
fn plan_across_a_campus(bencher: Bencher) {
    let costmap = costmap(&campus());
    bencher
        .bench_local(|| plan(&costmap, &Point::new(3.0, 3.0), &Point::new(96.0, 96.0), 0.05).expect("there is a way"));
}

/// Across 1984 × 1984 empty cells.
#[divan::bench(sample_count = 20)]
fn plan_across_an_empty_hall(bencher: Bencher) {
    let costmap = costmap(&floor::hall(99.2, 99.2));
    bencher
        .bench_local(|| plan(&costmap, &Point::new(3.0, 3.0), &Point::new(96.0, 80.0), 0.05).expect("there is a way"));
}

/// From a room at the lower left of the office to one at the upper right: 31 m.
#[divan::bench(sample_count = 20)]
fn plan_across_an_office(bencher: Bencher) {
    let costmap = costmap(&office_on_a_large_map());
    let (from, to) = (Point::new(-7.3, -6.5), Point::new(15.1, 3.0));
    bencher.bench_local(|| plan(&costmap, &from, &to, 0.05).expect("there is a way"));
}

fn estimate(robot: &Unicycle) -> PoseEstimate {
    PoseEstimate { time: robot.time, pose: robot.truth, covariance: Matrix3::zeros() }
}

/// A robot in the office, in a world that may contain more than the map.
fn set_up(world: OccupancyGrid, at: Pose) -> (Navigator, Unicycle) {
    let robot = Unicycle::new(world, at, Noise::default());
    let parameters = NavigationParameters::of(&robot.model);
    let navigator = Navigator::new(&floor::office(), &robot.model, parameters).expect("the parameters are valid");
    (navigator, robot)
}

/// Processing a scan that shows only the map.
#[divan::bench]
fn scan_of_the_map(bencher: Bencher) {
    let (mut navigator, mut robot) = set_up(floor::office(), pose(13.9, 9.3, 0.3));
    let (scans, estimate) = (robot.scans(), estimate(&robot));
    bencher.bench_local(|| navigator.scan(&scans[0], &estimate));
}

/// Processing a scan that shows a box that is not on the map, and one without it.
#[divan::bench]
fn scans_of_something_that_comes_and_goes(bencher: Bencher) {
    let mut world = floor::office();
    floor::fill(&mut world, [15.5, 9.0, 16.0, 9.5], Cell::Occupied);
    let (mut navigator, mut robot) = set_up(world, pose(13.9, 9.3, 0.3));
    let (with, estimate) = (robot.scans(), estimate(&robot));
    robot.world = floor::office();
    let without = robot.scans();
    bencher.bench_local(|| {
        navigator.scan(&with[0], &estimate);
        navigator.scan(&without[0], &estimate);
    });
}

/// A control step while driving along the corridor.
#[divan::bench]
fn step_of_control(bencher: Bencher) {
    let (mut navigator, mut robot) = set_up(floor::office(), pose(3.0, 9.3, 0.0));
    navigator.start(Goal::at(Point::new(25.0, 9.3), None));
    for _ in 0..300 {
        for scan in robot.scans() {
            navigator.scan(&scan, &estimate(&robot));
        }
        let command = navigator.update(robot.time, &estimate(&robot), &robot.odometry());
        robot.step(command);
    }
    let (now, odometry) = (estimate(&robot), robot.odometry());
    bencher.bench_local(|| navigator.update(robot.time, &now, &odometry));
}

/// All of navigation for ten simulated seconds of driving: 500 steps and 200 scans. The robot and its lasers are not
/// timed.
#[divan::bench(sample_count = 20)]
fn ten_seconds_of_driving(bencher: Bencher) {
    let (mut navigator, mut robot) = set_up(floor::office(), pose(3.0, 9.3, 0.0));
    navigator.start(Goal::at(Point::new(25.0, 9.3), None));
    navigator.update(Duration::ZERO, &estimate(&robot), &robot.odometry());
    let start = navigator.clone();
    let mut steps = Vec::new();
    for _ in 0..500 {
        let (scans, now, odometry) = (robot.scans(), estimate(&robot), robot.odometry());
        scans.iter().for_each(|scan| navigator.scan(scan, &now));
        robot.step(navigator.update(robot.time, &now, &odometry));
        steps.push((scans, now, odometry));
    }
    bencher.with_inputs(|| start.clone()).bench_local_values(|mut navigator| {
        for (scans, now, odometry) in &steps {
            scans.iter().for_each(|scan| navigator.scan(scan, now));
            navigator.update(now.time, now, odometry);
        }
        navigator
    });
}
