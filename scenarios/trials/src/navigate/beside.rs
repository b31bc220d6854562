//! Places beside the robot's path, for the people and boxes of a trip.

use maps::Point;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::course::{Course, Task};

/// The minimum distance of standing people and boxes from walls, in meters. Their distance from each other is at least
/// twice as large. So 0.75 m remain for the robot on both sides of a person.
const PASSABLE_M: f64 = 1.0;

/// The minimum distance of people and boxes from the robot's start, in meters.
const START_FREE_M: f64 = 1.5;

/// The minimum distance of people and boxes from the goal, in meters.
const GOAL_FREE_M: f64 = 1.2;

/// People walk between places within this distance from the robot's path, in meters. Boxes stand at such places.
const FROM_PATH_M: f64 = 8.0;

/// The maximum number of places that are drawn to find a suitable one.
const TRIES: usize = 200;

/// A suitable place close to the robot's path.
pub(super) fn near_path(
    course: &Course,
    task: &Task,
    is_good: impl Fn(&Point) -> bool,
    rng: &mut ChaCha8Rng,
) -> Option<Point> {
    let start = Point::from(task.start.translation.vector);
    let goal = Point::from(task.goal.translation.vector);
    (0..TRIES).find_map(|_| {
        let (at, by) = (course.place(rng), task.path[rng.random_range(0..task.path.len())]);
        let free = (at - start).norm() >= START_FREE_M && (at - goal).norm() >= GOAL_FREE_M;
        (free && (at - by).norm() <= FROM_PATH_M && is_good(&at)).then_some(at)
    })
}

/// A place close to the robot's path for a standing person or a box. The robot can still pass between it and those that
/// already stand there.
pub(super) fn passable(course: &Course, task: &Task, standing: &[Point], rng: &mut ChaCha8Rng) -> Option<Point> {
    let is_good = |at: &Point| {
        course.clearance_m(at) >= PASSABLE_M && standing.iter().all(|other| (other - at).norm() >= 2.0 * PASSABLE_M)
    };
    near_path(course, task, is_good, rng)
}
