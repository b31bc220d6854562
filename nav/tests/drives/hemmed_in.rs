//! Localization of a robot that cannot see the map because of doors or people, or that has been moved elsewhere.

use maps::{Cell, CellIndex, OccupancyGrid, Pose, pose};
use nav::{InitialPose, Localization, LocalizationParameters};
use robot::{Streams, VelocityCommand};

use crate::floor::{fill, fill_disc, hall, office};
use crate::unicycle::{Noise, Unicycle};

const REST: VelocityCommand = VelocityCommand::STOP;
const TURN: VelocityCommand = VelocityCommand { linear_mps: 0.0, angular_radps: 0.5 };
const SMALL_CIRCLE: VelocityCommand = VelocityCommand { linear_mps: 0.1, angular_radps: 0.5 };
const CIRCLE: VelocityCommand = VelocityCommand { linear_mps: 0.2, angular_radps: 0.5 };

/// A robot in a world that differs from its map, with a localization on its map.
struct Drive {
    robot: Unicycle,
    localization: Localization,
}

impl Drive {
    fn new(map: &OccupancyGrid, start: Pose, seed: u64) -> Self {
        let robot = Unicycle::new(map.clone(), start, Noise { drift: 0.01, scatter: 0.05, laser_m: 0.01 });
        let rng = Streams::new(seed).stream("localization");
        let parameters = LocalizationParameters::default();
        let initial = InitialPose::at(start);
        let localization = Localization::new(map, &robot.model, parameters, &initial, rng).expect("they make sense");
        Self { robot, localization }
    }

    /// Drives with this command for some time. Returns the largest error of the estimate, in meters.
    fn go(&mut self, seconds: u32, command: VelocityCommand) -> f64 {
        let mut worst_m = 0.0_f64;
        for _ in 0..50 * seconds {
            self.robot.step(command);
            self.localization.odometry(&self.robot.odometry());
            for scan in self.robot.scans() {
                self.localization.scan(&scan);
            }
            worst_m = worst_m.max(self.off_m());
        }
        worst_m
    }

    fn off_m(&self) -> f64 {
        (self.robot.truth.translation.vector - self.localization.estimate().pose.translation.vector).norm()
    }
}

/// Closes four sides of a square around a place, at this distance.
fn close_in(world: &mut OccupancyGrid, at: &Pose, away_m: f64) {
    let (x, y) = (at.translation.x, at.translation.y);
    let (left, right, bottom, top) = (x - away_m, x + away_m, y - away_m, y + away_m);
    for leaf in [
        [left, bottom, left + 0.05, top],
        [right, bottom, right + 0.05, top],
        [left, bottom, right, bottom + 0.05],
        [left, top, right + 0.05, top + 0.05],
    ] {
        fill(world, leaf, Cell::Occupied);
    }
}

/// People in a ring around a place.
fn surround(world: &mut OccupancyGrid, at: &Pose, people: u32, away_m: f64) {
    for person in 0..people {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(person) / f64::from(people));
        fill_disc(world, [at.translation.x + away_m * cos, at.translation.y + away_m * sin], 0.25);
    }
}

#[test]
fn closing_and_opening_doors_around_a_robot_leave_its_pose_unchanged() {
    let places = [(pose(2.7, 3.5, 1.0), 1.2), (pose(13.9, 9.3, 0.3), 0.9), (pose(8.6, 3.4, -2.0), 1.0)];
    for (seed, (start, away_m)) in (0..).zip(places) {
        let mut drive = Drive::new(&office(), start, seed);
        assert!(drive.go(10, CIRCLE) < 0.1);
        let truth = drive.robot.truth;
        close_in(&mut drive.robot.world, &truth, away_m);
        let closed = [drive.go(20, REST), drive.go(20, TURN), drive.go(20, REST)];
        assert!(drive.localization.doubt() > 0.5, "hardly anything is seen of the map");
        drive.robot.world = office();
        let open = [drive.go(10, REST), drive.go(10, CIRCLE)];
        let start = start.translation;
        println!("{start:?}, {away_m} m: {closed:.3?} m off, then {open:.3?}");
        assert!(closed.into_iter().chain(open).all(|worst_m| worst_m < 0.15));
        assert!(drive.localization.doubt() < 0.5 && drive.off_m() < 0.05);
    }
}

#[test]
fn people_around_a_robot_leave_its_pose_unchanged() {
    let places = [(pose(2.7, 3.5, 1.0), 14, 1.2), (pose(13.9, 9.3, 0.3), 12, 1.0), (pose(8.6, 3.2, 0.5), 18, 1.4)];
    for (seed, (start, people, away_m)) in (0..).zip(places) {
        let mut drive = Drive::new(&office(), start, seed);
        surround(&mut drive.robot.world, &start, people, away_m);
        // From the first scan on, at rest and while starting; then they step aside.
        let hidden = [drive.go(30, REST), drive.go(15, TURN), drive.go(15, SMALL_CIRCLE)];
        drive.robot.world = office();
        let seen = [drive.go(10, REST), drive.go(10, CIRCLE)];
        let start = start.translation;
        println!("{start:?}, {people} people: {hidden:.3?} m off, then {seen:.3?}");
        assert!(hidden.into_iter().chain(seen).all(|worst_m| worst_m < 0.3));
        assert!(drive.off_m() < 0.05);
    }
}

/// A hall of 14 m × 10 m with a pillar and a recess, and beside it two rooms of 3 m × 4 m with different furniture.
fn hall_and_rooms() -> OccupancyGrid {
    let mut map = hall(17.2, 10.0);
    fill(&mut map, [14.0, 0.0, 14.1, 10.0], Cell::Occupied);
    fill(&mut map, [14.1, 4.0, 17.2, 4.1], Cell::Occupied);
    fill(&mut map, [14.1, 8.2, 17.2, 8.3], Cell::Occupied);
    fill(&mut map, [14.0, 1.0, 14.1, 2.0], Cell::Free);
    fill(&mut map, [14.0, 5.0, 14.1, 6.0], Cell::Free);
    fill(&mut map, [11.0, 8.0, 11.4, 8.4], Cell::Occupied);
    fill(&mut map, [0.0, 7.5, 1.5, 10.0], Cell::Occupied);
    fill(&mut map, [16.4, 0.0, 17.1, 1.2], Cell::Occupied);
    fill(&mut map, [14.1, 6.9, 15.9, 8.2], Cell::Occupied);
    map
}

#[test]
fn a_robot_moved_at_rest_into_a_small_room_is_found() {
    for (seed, room) in [(0, pose(15.5, 2.4, 0.4)), (1, pose(15.6, 6.0, -2.2)), (2, pose(15.3, 2.9, 3.0))] {
        let start = pose(6.5, 4.6, 0.3);
        let mut drive = Drive::new(&hall_and_rooms(), start, seed);
        assert!(drive.go(5, REST) < 0.1);
        drive.robot.truth = room;
        drive.go(4, REST);
        assert_eq!(drive.localization.doubt(), 1.0, "not noticed within 4 s");
        assert!((drive.localization.estimate().pose.translation.vector - start.translation.vector).norm() < 0.1);
        drive.go(11, REST);
        println!("{:?}: {:.3} m off at rest", room.translation, drive.off_m());
        assert!(drive.off_m() < 0.1, "not found within 15 s");
        drive.go(20, CIRCLE);
        assert!(drive.off_m() < 0.1 && drive.localization.doubt() < 0.5, "still believed lost while it drives");
    }
}

#[test]
fn a_robot_moved_into_a_small_changed_room_is_found_as_it_drives() {
    let mut drive = Drive::new(&hall_and_rooms(), pose(6.5, 4.6, 0.3), 1);
    assert!(drive.go(5, REST) < 0.1);
    drive.robot.truth = pose(15.4, 1.9, 0.4);
    // A box along a wall: not a crowd, but not quite the map either.
    fill(&mut drive.robot.world, [14.5, 3.65, 15.6, 3.95], Cell::Occupied);
    assert!(drive.go(3, REST) > 9.0);
    drive.go(15, CIRCLE);
    println!("{:.3} m off after 15 s", drive.off_m());
    assert!(drive.off_m() < 0.1, "{} m off", drive.off_m());
    drive.go(50, CIRCLE);
    assert!(drive.off_m() < 0.1 && drive.localization.doubt() < 0.5, "{} m off", drive.off_m());
}

/// A world in which the walls on the map around `there` also stand around `here`.
fn walled_in(map: &OccupancyGrid, there: [f64; 4], here: [f64; 2]) -> OccupancyGrid {
    let mut world = map.clone();
    let cells = |meters: f64| (meters / map.resolution_m()).round() as usize;
    let [left, bottom, right, top] = there.map(cells);
    for (row, column) in (bottom..top).flat_map(|row| (left..right).map(move |column| (row, column))) {
        let cell = map.cell(CellIndex { column, row }).expect("it is on the map");
        world.set(CellIndex { column: column - left + cells(here[0]), row: row - bottom + cells(here[1]) }, cell);
    }
    world
}

#[test]
fn a_robot_surrounded_by_misleading_walls_returns_to_its_pose_when_they_are_gone() {
    // A room with its walls, as it might stand around the robot in the hall.
    let (room, hall) = ([14.0, 0.0, 17.2, 4.2], [5.0, 3.0]);
    for (seed, command) in [(0, REST), (1, CIRCLE)] {
        let map = hall_and_rooms();
        let start = pose(6.4, 5.0, 0.4);
        let mut drive = Drive::new(&map, start, seed);
        assert!(drive.go(5, REST) < 0.1);
        drive.robot.world = walled_in(&map, room, hall);
        fill(&mut drive.robot.world, [5.0, 4.0, 5.1, 5.0], Cell::Occupied);
        assert!(drive.go(9, REST) < 0.1);
        drive.go(5, REST);
        assert!(drive.off_m() > 5.0, "no laser can tell");
        drive.go(25, command);
        drive.robot.world = map;
        drive.go(10, command);
        println!("{:.3} m off", drive.off_m());
        assert!(drive.off_m() < 0.1);
        drive.go(20, CIRCLE);
        assert!(drive.off_m() < 0.05 && drive.localization.doubt() < 0.5);
    }
}
