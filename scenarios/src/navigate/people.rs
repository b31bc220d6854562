//! The people of a trip: some stand where they leave room to pass, the others walk across the robot's way and back.

use std::time::Duration;

use maps::{Point, pose};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sim::{Manners, ObstacleConfig, ObstacleMotion, Pauses, RouteEnd, Shape, Walk};

use super::course::{Course, Task};

/// Radius of a person, in metres.
const RADIUS_M: f64 = 0.25;

/// One of so many stands still.
const ONE_STANDS_OF: usize = 3;

/// Whoever stands still is at least so far from walls, and twice as far from others who do, in metres: on both sides
/// remain 0.75 m for the robot.
const PASSABLE_M: f64 = 1.0;

/// Nobody begins or stands nearer to where the robot starts than this, in metres.
const START_FREE_M: f64 = 1.5;

/// Nobody stands nearer to the goal than this, in metres.
const GOAL_FREE_M: f64 = 1.2;

/// People come from and go to places within this of the robot's way, in metres.
const FROM_THE_WAY_M: f64 = 8.0;

/// How fast people walk, in m/s, and how long they stand at an end of their way at most.
const SPEED_MPS: std::ops::Range<f64> = 0.5..1.2;
const LONGEST_PAUSE_S: f64 = 5.0;

/// How often a place is drawn until one is good.
const TRIES: usize = 200;

/// So many people for a trip.
pub(super) fn people(course: &Course, task: &Task, count: usize, rng: &mut ChaCha8Rng) -> Vec<ObstacleConfig> {
    let mut people: Vec<ObstacleConfig> = Vec::new();
    for number in 1..=count {
        let standing: Vec<Point> = people.iter().filter(|person| stands(person)).map(place_of).collect();
        let stands = number % ONE_STANDS_OF == 0;
        let stander = stands.then(|| stander(course, task, &standing, rng)).flatten();
        let person = stander.or_else(|| walker(course, task, rng));
        people.extend(person.map(|(at, walk)| ObstacleConfig {
            name: format!("person {number}"),
            shape: Shape::Disc { radius_m: RADIUS_M },
            pose: pose(at.x, at.y, 0.0),
            motion: ObstacleMotion::Person(walk),
        }));
    }
    people
}

fn stands(person: &ObstacleConfig) -> bool {
    matches!(&person.motion, ObstacleMotion::Person(walk) if walk.waypoints.is_empty())
}

fn place_of(person: &ObstacleConfig) -> Point {
    person.pose.translation.vector.into()
}

/// Somebody who stands where the robot can pass.
fn stander(course: &Course, task: &Task, standing: &[Point], rng: &mut ChaCha8Rng) -> Option<(Point, Walk)> {
    let is_good = |at: &Point| {
        course.clearance_m(at) >= PASSABLE_M && standing.iter().all(|other| (other - at).norm() >= 2.0 * PASSABLE_M)
    };
    Some((near_the_way(course, task, is_good, rng)?, walk(Vec::new(), 1.0, Duration::ZERO)))
}

/// Somebody who walks from one place beside the robot's way to another, and back.
fn walker(course: &Course, task: &Task, rng: &mut ChaCha8Rng) -> Option<(Point, Walk)> {
    let from = near_the_way(course, task, |_| true, rng)?;
    let to = near_the_way(course, task, |at| (at - from).norm() > 2.0, rng)?;
    let waypoints = course.way(&from, &to)?;
    let speed_mps = rng.random_range(SPEED_MPS);
    let pause = Duration::from_secs_f64(LONGEST_PAUSE_S * rng.random::<f64>());
    Some((from, walk(waypoints, speed_mps, pause)))
}

fn walk(waypoints: Vec<Point>, speed_mps: f64, pause: Duration) -> Walk {
    Walk {
        waypoints,
        speed_mps,
        end: RouteEnd::BackAndForth,
        sets_out: Duration::ZERO,
        pause,
        pauses: Pauses::Ends,
        manners: Some(Manners::default()),
    }
}

/// A good place not far from the robot's way.
fn near_the_way(course: &Course, task: &Task, is_good: impl Fn(&Point) -> bool, rng: &mut ChaCha8Rng) -> Option<Point> {
    let start = Point::from(task.start.translation.vector);
    let goal = Point::from(task.goal.translation.vector);
    (0..TRIES).find_map(|_| {
        let (at, by) = (course.place(rng), task.way[rng.random_range(0..task.way.len())]);
        let free = (at - start).norm() >= START_FREE_M && (at - goal).norm() >= GOAL_FREE_M;
        (free && (at - by).norm() <= FROM_THE_WAY_M && is_good(&at)).then_some(at)
    })
}
