//! Places beside the robot's path, for the people and boxes of a trip.

use maps::Point;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::course::{Course, Task};

/// Everything that stands still is at least this far from walls, and twice as far from other standing things, in
/// meters: on both sides of a person, 0.75 m remain for the robot.
const PASSABLE_M: f64 = 1.0;

/// Nobody starts or stands closer than this to the robot's start, in meters.
const START_FREE_M: f64 = 1.5;

/// Nobody stands closer than this to the goal, in meters.
const GOAL_FREE_M: f64 = 1.2;

/// People walk between places within this distance of the robot's path, in meters; boxes stand there.
const FROM_THE_WAY_M: f64 = 8.0;

/// How many places are drawn at most to find a suitable one.
const TRIES: usize = 200;

/// A suitable place close to the robot's path.
pub(super) fn near_the_way(
    course: &Course,
    task: &Task,
    is_good: impl Fn(&Point) -> bool,
    rng: &mut ChaCha8Rng,
) -> Option<Point> {
    let start = Point::from(task.start.translation.vector);
    let goal = Point::from(task.goal.translation.vector);
    (0..TRIES).find_map(|_| {
        let (at, by) = (course.place(rng), task.way[rng.random_range(0..task.way.len())]);
        let free = (at - start).norm() >= START_FREE_M && (at - goal).norm() >= GOAL_FREE_M;
        (free && (at - by).norm() <= FROM_THE_WAY_M && is_good(&at)).then_some(at)
    })
}

/// A place close to the robot's path for something that stands still. The robot can still pass, given everything that
/// already stands there.
pub(super) fn passable(course: &Course, task: &Task, standing: &[Point], rng: &mut ChaCha8Rng) -> Option<Point> {
    let is_good = |at: &Point| {
        course.clearance_m(at) >= PASSABLE_M && standing.iter().all(|other| (other - at).norm() >= 2.0 * PASSABLE_M)
    };
    near_the_way(course, task, is_good, rng)
}
