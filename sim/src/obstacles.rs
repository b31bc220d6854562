//! What stands or moves in the world beside walls and robot.

use bevy_ecs::prelude::*;
use maps::Pose;
use parry2d::shape::SharedShape;

use crate::clock::Clock;
use crate::config::{ObstacleConfig, ObstacleMotion, Shape};
use crate::physics::{Body, Physics, parry_shape};
use crate::route::Route;

/// An obstacle's name and outline.
#[derive(Component, Clone)]
pub(crate) struct Obstacle {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    /// The outline for rays.
    pub(crate) outline: SharedShape,
}

/// An obstacle's pose in the `map` frame.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct ObstaclePose(pub(crate) Pose);

/// The obstacle can be pushed.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Movable;

/// All obstacles: those of the configuration in its order, then those that came with faults, in the order in which they
/// came.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Obstacles(pub(crate) Vec<Entity>);

/// Puts an obstacle into the world.
pub(crate) fn spawn_obstacle(world: &mut World, config: &ObstacleConfig) -> Entity {
    let outline = parry_shape(&config.shape);
    let body = world.resource_mut::<Physics>().add_obstacle(config, outline.clone());
    let obstacle = Obstacle { name: config.name.clone(), shape: config.shape, outline };
    let mut entity = world.spawn((obstacle, ObstaclePose(config.pose), body));
    match &config.motion {
        ObstacleMotion::Fixed => {}
        ObstacleMotion::Route { waypoints, speed_mps, end } => {
            entity.insert(Route::new(waypoints.clone(), *speed_mps, *end));
        }
        ObstacleMotion::Movable { .. } => {
            entity.insert(Movable);
        }
    }
    let id = entity.id();
    world.resource_mut::<Obstacles>().0.push(id);
    id
}

/// Takes an obstacle out of the world.
pub(crate) fn remove_obstacle(world: &mut World, obstacle: Entity) {
    if let Some(body) = world.get::<Body>(obstacle).copied() {
        world.resource_mut::<Physics>().remove(body);
    }
    world.resource_mut::<Obstacles>().0.retain(|other| *other != obstacle);
    world.despawn(obstacle);
}

/// Takes those that follow routes a step on.
pub(crate) fn move_obstacles(
    clock: Res<Clock>,
    mut physics: ResMut<Physics>,
    mut obstacles: Query<(&Body, &mut ObstaclePose, &mut Route)>,
) {
    for (body, mut pose, mut route) in &mut obstacles {
        pose.0 = route.advance(&pose.0, clock.dt_s());
        physics.carry(*body, &pose.0);
    }
}

/// Takes over where the step has brought those that were pushed.
pub(crate) fn settle_obstacles(physics: Res<Physics>, mut obstacles: Query<(&Body, &mut ObstaclePose), With<Movable>>) {
    for (body, mut pose) in &mut obstacles {
        pose.0 = physics.pose(*body);
    }
}
