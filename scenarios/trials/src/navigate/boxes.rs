//! The boxes of a trip: no map shows them, and they can be pushed.

use std::f64::consts::TAU;

use maps::{Point, Shape, pose};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sim::{ObstacleConfig, ObstacleMotion};

use super::beside::passable;
use super::course::{Course, Task};

/// Length of a box's sides, in meters, and its mass, in kg.
const SIDE_M: std::ops::Range<f64> = 0.3..0.5;
const MASS_KG: f64 = 10.0;

/// The boxes of a trip: as many as wanted, or as can be placed so that the robot can pass.
pub(super) fn boxes(course: &Course, task: &Task, count: usize, rng: &mut ChaCha8Rng) -> Vec<ObstacleConfig> {
    let mut boxes: Vec<ObstacleConfig> = Vec::new();
    for number in 1..=count {
        let standing: Vec<Point> = boxes.iter().map(|other| other.pose.translation.vector.into()).collect();
        let Some(at) = passable(course, task, &standing, rng) else { break };
        let shape = Shape::Box { length_m: rng.random_range(SIDE_M), width_m: rng.random_range(SIDE_M) };
        boxes.push(ObstacleConfig {
            name: format!("box {number}"),
            shape,
            pose: pose(at.x, at.y, TAU * rng.random::<f64>()),
            motion: ObstacleMotion::Movable { mass_kg: MASS_KG },
        });
    }
    boxes
}

#[cfg(test)]
mod tests {
    use robot::Streams;

    use super::*;

    #[test]
    fn boxes_leave_the_robot_room_on_all_sides() {
        let course = Course::new("house", "house.yaml".as_ref(), maps::house::map()).expect("the house has room");
        for seed in 0..20 {
            let streams = Streams::new(seed);
            let task = course.task(&mut streams.stream("navigate/task"));
            let boxes = boxes(&course, &task, 3, &mut streams.stream("navigate/boxes"));
            assert!(!boxes.is_empty(), "seed {seed}");
            for (number, one) in boxes.iter().enumerate() {
                let at = Point::from(one.pose.translation.vector);
                let needed_m = 2.0 * course.model().radius_m;
                assert!(course.clearance_m(&at) - one.shape.bounding_radius_m() >= needed_m, "{one:?}");
                for other in &boxes[..number] {
                    let gap_m = (other.pose.translation.vector - at.coords).norm()
                        - other.shape.bounding_radius_m()
                        - one.shape.bounding_radius_m();
                    assert!(gap_m >= needed_m, "{one:?} beside {other:?}");
                }
            }
        }
    }
}
