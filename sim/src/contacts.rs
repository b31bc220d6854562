//! Counts the robot's collisions.

use bevy_ecs::prelude::*;
use rapier2d::prelude::ColliderHandle;

use crate::physics::{Body, Physics, Touch};

/// A contact ends when the gap is wider than this, in metres; else a robot that trembles at a wall would collide with it
/// at every step.
const RELEASE_GAP_M: f32 = 0.005;

/// What the robot touches. All walls together are one thing: sliding from one along the next is one contact.
#[derive(Component, Clone, Debug, Default)]
pub(crate) struct Contacts {
    touching: Vec<ColliderHandle>,
    begun: u64,
}

impl Contacts {
    /// Number of contacts begun since the start.
    pub(crate) fn begun(&self) -> u64 {
        self.begun
    }

    /// Whether the robot touches anything now.
    pub(crate) fn is_touching(&self) -> bool {
        !self.touching.is_empty()
    }

    /// A contact begins when two bodies push each other, and ends when there is a gap between them.
    fn update(&mut self, touches: &[Touch]) {
        self.touching.retain(|held| touches.iter().any(|touch| touch.other == *held && touch.gap_m <= RELEASE_GAP_M));
        for touch in touches.iter().filter(|touch| touch.pushing) {
            if !self.touching.contains(&touch.other) {
                self.touching.push(touch.other);
                self.begun += 1;
            }
        }
    }
}

/// Counts the contacts that a step began.
pub(crate) fn count_contacts(physics: Res<Physics>, robot: Single<(&Body, &mut Contacts)>) {
    let (body, mut contacts) = robot.into_inner();
    let touches: Vec<Touch> = physics.touches(*body).collect();
    if !touches.is_empty() || contacts.is_touching() {
        contacts.update(&touches);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(other: u32, gap_m: f32, pushing: bool) -> Touch {
        Touch { other: ColliderHandle::from_raw_parts(other, 0), gap_m, pushing }
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
            contacts.update(&[touch(7, gap_m, pushing)]);
            assert_eq!(contacts.begun(), begun, "gap {gap_m}, pushing {pushing}");
        }
        contacts.update(&[]);
        assert!(!contacts.is_touching());
    }

    #[test]
    fn each_body_that_is_touched_counts() {
        let mut contacts = Contacts::default();
        contacts.update(&[touch(1, 0.0, true), touch(2, 0.0, true), touch(3, 0.01, false)]);
        assert_eq!(contacts.begun(), 2);
    }
}
