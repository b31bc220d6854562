//! Bodies in the world other than walls and robot.

use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::{Pose, Shape};
use parry2d::shape::SharedShape;

use crate::clock::Clock;
use crate::physics::{Body, Physics};
use crate::route::Route;

/// An obstacle's name and outline.
#[derive(Component, Clone)]
pub(crate) struct Obstacle {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    /// The outline for rays.
    pub(crate) outline: SharedShape,
}

/// An obstacle's pose in the `map` frame. A box that has been picked up has none.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(crate) struct ObstaclePose(pub(crate) Pose);

/// The time since which an obstacle has been at rest: the start, if it never moved.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Rest(pub(crate) Duration);

/// Marks obstacles that can be pushed.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Movable;

/// All obstacles: those of the configuration in order, then those of faults, in the order of their appearance.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Obstacles(pub(crate) Vec<Entity>);

/// The obstacle with this name, if it has such a component.
pub(crate) fn named<C: Component>(world: &World, name: &str) -> Option<Entity> {
    let is_it = |entity: &&Entity| {
        world.get::<C>(**entity).and(world.get::<Obstacle>(**entity)).is_some_and(|obstacle| obstacle.name == name)
    };
    world.resource::<Obstacles>().0.iter().find(is_it).copied()
}

/// Moves obstacles with routes by one step.
pub(crate) fn move_obstacles(
    clock: Res<Clock>,
    mut physics: ResMut<Physics>,
    mut obstacles: Query<(&Body, &mut ObstaclePose, &mut Route)>,
) {
    for (body, mut pose, mut route) in &mut obstacles {
        let at = route.advance(&pose.0, clock.dt_s());
        pose.set_if_neq(ObstaclePose(at));
        physics.carry(*body, &at);
    }
}

/// Takes over the poses of pushed obstacles after the step.
pub(crate) fn settle_obstacles(physics: Res<Physics>, mut obstacles: Query<(&Body, &mut ObstaclePose), With<Movable>>) {
    for (body, mut pose) in &mut obstacles {
        pose.set_if_neq(ObstaclePose(physics.pose(*body)));
    }
}

/// Records which obstacles moved in this step.
pub(crate) fn note_rest(clock: Res<Clock>, mut moved: Query<&mut Rest, Changed<ObstaclePose>>) {
    for mut rest in &mut moved {
        rest.0 = clock.now;
    }
}
