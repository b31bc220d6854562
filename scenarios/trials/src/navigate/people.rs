//! The people of a trip: some stand where the robot can pass, the others walk back and forth across its path.

use std::time::Duration;

use maps::{Point, Shape, pose};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sim::{Manners, ObstacleConfig, ObstacleMotion, Pauses, RouteEnd, Walk};

use super::beside::{near_path, passable};
use super::course::{Course, Task};

/// Radius of a person, in meters.
const RADIUS_M: f64 = 0.25;

/// One out of this many people stands still.
const ONE_STANDS_OF: usize = 3;

/// The speed of people, in m/s, and their longest pause at an end of their walk.
const SPEED_MPS: std::ops::Range<f64> = 0.5..1.2;
const LONGEST_PAUSE_S: f64 = 5.0;

/// The maximum number of walks that are drawn to find one that avoids all boxes, and the minimum distance to boxes, in
/// meters.
const TRIES: usize = 20;
const BESIDE_M: f64 = 0.1;

/// The people of a trip: as many as wanted, or as can be placed among the boxes.
pub(super) fn people(
    course: &Course,
    task: &Task,
    boxes: &[ObstacleConfig],
    count: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<ObstacleConfig> {
    let mut people: Vec<ObstacleConfig> = Vec::new();
    for number in 1..=count {
        let standing = people.iter().filter(|person| stands(person));
        let standing: Vec<Point> = boxes.iter().chain(standing).map(place_of).collect();
        let stands = number % ONE_STANDS_OF == 0;
        let stander = stands.then(|| stander(course, task, &standing, rng)).flatten();
        let person = stander.or_else(|| walker(course, task, boxes, rng));
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

fn place_of(body: &ObstacleConfig) -> Point {
    body.pose.translation.vector.into()
}

/// A person who stands where the robot can pass.
fn stander(course: &Course, task: &Task, standing: &[Point], rng: &mut ChaCha8Rng) -> Option<(Point, Walk)> {
    Some((passable(course, task, standing, rng)?, walk(Vec::new(), 1.0, Duration::ZERO)))
}

/// A person who walks back and forth between two places beside the robot's path.
fn walker(course: &Course, task: &Task, boxes: &[ObstacleConfig], rng: &mut ChaCha8Rng) -> Option<(Point, Walk)> {
    for _ in 0..TRIES {
        let from = near_path(course, task, |_| true, rng)?;
        let to = near_path(course, task, |at| (at - from).norm() > 2.0, rng)?;
        let waypoints = course.path(&from, &to)?;
        if boxes.iter().any(|one| is_in_the_way(one, &waypoints)) {
            continue;
        }
        let speed_mps = rng.random_range(SPEED_MPS);
        let pause = Duration::from_secs_f64(LONGEST_PAUSE_S * rng.random::<f64>());
        return Some((from, walk(waypoints, speed_mps, pause)));
    }
    None
}

/// Whether a person on this walk would collide with a box.
fn is_in_the_way(one: &ObstacleConfig, walk: &[Point]) -> bool {
    let (center, needed_m) = (place_of(one), one.shape.bounding_radius_m() + RADIUS_M + BESIDE_M);
    walk.windows(2).any(|ends| distance_m(&center, &ends[0], &ends[1]) < needed_m)
}

/// Distance between a point and the line through two others.
fn distance_m(point: &Point, from: &Point, to: &Point) -> f64 {
    let along = to - from;
    let share = ((point - from).dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
    (from + along * share - point).norm()
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

#[cfg(test)]
mod tests {
    use robot::Streams;

    use super::*;
    use crate::navigate::boxes::boxes;

    #[test]
    fn people_neither_stand_in_boxes_nor_walk_through_them() {
        let course = Course::new("house", "house.yaml".as_ref(), maps::house::map()).expect("the house has room");
        let (mut boxes_about, mut people_about) = (0, 0);
        for seed in 0..10 {
            let streams = Streams::new(seed);
            let task = course.task(&mut streams.stream("navigate/task"));
            let boxes = boxes(&course, &task, 2, &mut streams.stream("navigate/boxes"));
            let people = people(&course, &task, &boxes, 6, &mut streams.stream("navigate/people"));
            (boxes_about, people_about) = (boxes_about + boxes.len(), people_about + people.len());
            for (person, one) in people.iter().flat_map(|person| boxes.iter().map(move |one| (person, one))) {
                let ObstacleMotion::Person(walk) = &person.motion else { panic!("{person:?}") };
                let box_at = place_of(one);
                let corners: Vec<Point> =
                    std::iter::once(place_of(person)).chain(walk.waypoints.iter().copied()).collect();
                let apart_m = RADIUS_M + one.shape.bounding_radius_m();
                assert!(corners.iter().all(|at| (at - box_at).norm() >= apart_m), "{person:?} and {one:?}");
                let mut middles = corners.windows(2).map(|ends| nalgebra::center(&ends[0], &ends[1]));
                assert!(middles.all(|at| (at - box_at).norm() >= apart_m), "{person:?} and {one:?}");
            }
        }
        assert!(boxes_about >= 10 && people_about >= 50, "{boxes_about} boxes, {people_about} people");
    }
}
