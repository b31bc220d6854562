//! Adding obstacles to the world, and removing them.

use bevy_ecs::prelude::*;
use maps::Pose;

use crate::config::{ObstacleConfig, ObstacleMotion};
use crate::doors::Leaf;
use crate::floor::Opaque;
use crate::obstacles::{Movable, Obstacle, ObstaclePose, Obstacles, Rest};
use crate::people::{Follower, Walker};
use crate::physics::{Body, Physics, parry_shape};
use crate::route::Route;

/// The initial pose of an obstacle: that of its configuration or, for an open door, that of its leaf.
pub(crate) fn first_pose(config: &ObstacleConfig) -> Pose {
    match &config.motion {
        ObstacleMotion::Door(door) => Leaf::new(door, &config.shape, config.pose).pose(),
        _ => config.pose,
    }
}

pub(crate) fn spawn_obstacle(world: &mut World, config: &ObstacleConfig) -> Entity {
    let outline = parry_shape(&config.shape);
    let pose = first_pose(config);
    let body = world.resource_mut::<Physics>().add_obstacle(config, &pose, outline.clone());
    let obstacle = Obstacle { name: config.name.clone(), shape: config.shape, outline };
    let mut entity = world.spawn((obstacle, ObstaclePose(pose), Rest::default(), body));
    match &config.motion {
        ObstacleMotion::Fixed => {
            entity.insert(Opaque);
        }
        ObstacleMotion::Person(walk) => {
            entity.insert(Walker::new(walk));
        }
        ObstacleMotion::Follower(follow) => {
            entity.insert(Follower::new(follow));
        }
        ObstacleMotion::Door(door) => {
            entity.insert((Leaf::new(door, &config.shape, config.pose), Opaque));
        }
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

pub(crate) fn remove_obstacle(world: &mut World, obstacle: Entity) {
    if let Some(body) = world.get::<Body>(obstacle).copied() {
        world.resource_mut::<Physics>().remove(body);
    }
    world.resource_mut::<Obstacles>().0.retain(|other| *other != obstacle);
    world.despawn(obstacle);
}
