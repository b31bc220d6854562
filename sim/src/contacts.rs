//! Counts the robot's collisions and records their obstacles.

use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::Point;
use nalgebra::Vector2;
use rapier2d::prelude::ColliderHandle;

use crate::clock::Clock;
use crate::obstacles::{Obstacle, Rest};
use crate::physics::{Body, Physics, Touch};

/// A contact ends when the gap is wider than this, in meters; otherwise a robot that vibrates at a wall would collide
/// with it at every step.
const RELEASE_GAP_M: f32 = 0.005;

/// A contact of the robot, whichever body caused it.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// When it began, as time since the start of the run.
    pub time: Duration,
    /// The name of the obstacle; none for walls.
    pub obstacle: Option<String>,
    /// How long the obstacle had been at rest when it was touched.
    pub at_rest: Duration,
    /// Where it is on the robot's edge, in the robot's frame, `base_link`, in meters.
    pub at: Point,
    /// The direction in which the robot is pushed there, in the same frame: a unit vector.
    pub normal: Vector2<f64>,
    /// How deep the bodies overlap, in meters; 0 if they only touch.
    pub depth_m: f64,
}

/// The bodies that the robot touches. All walls together are one body: sliding from one to the next is a single
/// contact.
#[derive(Component, Clone, Debug, Default)]
pub(crate) struct Contacts {
    touching: Vec<ColliderHandle>,
    /// The contacts begun since the start.
    pub(crate) begun: Vec<Contact>,
}

impl Contacts {
    /// Whether the robot touches anything now.
    pub(crate) fn is_touching(&self) -> bool {
        !self.touching.is_empty()
    }

    /// A contact begins when two bodies push each other, and ends when there is a gap between them. `begin` records the
    /// touched body.
    fn update(&mut self, touches: &[Touch], begin: impl Fn(&Touch) -> Contact) {
        self.touching.retain(|held| touches.iter().any(|touch| touch.other == *held && touch.gap_m <= RELEASE_GAP_M));
        for touch in touches.iter().filter(|touch| touch.pushing) {
            if !self.touching.contains(&touch.other) {
                self.touching.push(touch.other);
                self.begun.push(begin(touch));
            }
        }
    }
}

/// Counts the contacts that began in a step.
pub(crate) fn count_contacts(
    clock: Res<Clock>,
    physics: Res<Physics>,
    robot: Single<(&Body, &mut Contacts)>,
    obstacles: Query<(&Body, &Obstacle, &Rest)>,
) {
    let (body, mut contacts) = robot.into_inner();
    let touches: Vec<Touch> = physics.touches(*body).collect();
    if touches.is_empty() && !contacts.is_touching() {
        return;
    }
    contacts.update(&touches, |touch| {
        let touched = obstacles.iter().find(|(body, ..)| body.has(touch.other));
        let since = touched.map_or(Duration::ZERO, |(.., rest)| rest.0);
        let obstacle = touched.map(|(_, obstacle, _)| obstacle.name.clone());
        Contact {
            time: clock.now,
            obstacle,
            at_rest: clock.now.saturating_sub(since),
            at: touch.at,
            normal: -touch.outwards,
            depth_m: f64::from(-touch.gap_m).max(0.0),
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(other: u32, gap_m: f32, pushing: bool) -> Touch {
        let (at, outwards) = (Point::origin(), Vector2::x());
        Touch { other: ColliderHandle::from_raw_parts(other, 0), gap_m, pushing, at, outwards }
    }

    fn wall(touch: &Touch) -> Contact {
        let (at, normal) = (touch.at, -touch.outwards);
        Contact { time: Duration::ZERO, obstacle: None, at_rest: Duration::ZERO, at, normal, depth_m: 0.0 }
    }

    #[test]
    fn a_contact_counts_once_until_there_is_a_gap() {
        let mut contacts = Contacts::default();
        for (gap_m, pushing, begun) in [
            (0.010, false, 0),
            (0.001, true, 1),
            (0.000, true, 1),
            (0.004, false, 1),
            (0.001, true, 1),
            (0.006, false, 1),
            (0.000, true, 2),
        ] {
            contacts.update(&[touch(7, gap_m, pushing)], wall);
            assert_eq!(contacts.begun.len(), begun, "gap {gap_m}, pushing {pushing}");
        }
        contacts.update(&[], wall);
        assert!(!contacts.is_touching());
    }

    #[test]
    fn each_touched_body_counts() {
        let mut contacts = Contacts::default();
        contacts.update(&[touch(1, 0.0, true), touch(2, 0.0, true), touch(3, 0.01, false)], wall);
        assert_eq!(contacts.begun.len(), 2);
    }
}
