//! Bodies that appear and disappear with faults.

use bevy_ecs::prelude::*;

use crate::check::is_sound;
use crate::config::ObstacleConfig;
use crate::drive::Drive;
use crate::faults::Faults;
use crate::motion::RobotPose;
use crate::room::distance_to;
use crate::spawning::{remove_obstacle, spawn_obstacle};

/// The bodies of [`Faults::bodies`] that have been placed, with their descriptions.
#[derive(Resource, Default)]
pub(crate) struct ExtraBodies(Vec<(ObstacleConfig, Entity)>);

impl ExtraBodies {
    /// Whether these are exactly the bodies in the world.
    fn are(&self, wanted: &[ObstacleConfig]) -> bool {
        self.0.len() == wanted.len() && self.0.iter().all(|(body, _)| wanted.contains(body))
    }
}

/// Removes the bodies that are no longer in the list, and places new ones if they do not overlap the robot.
pub(crate) fn place_bodies(world: &mut World) {
    let wanted = &world.resource::<Faults>().bodies;
    if world.resource::<ExtraBodies>().are(wanted) {
        return;
    }
    let wanted = wanted.clone();
    let mut bodies = std::mem::take(&mut world.resource_mut::<ExtraBodies>().0);
    bodies.retain(|(body, entity)| {
        let stays = wanted.contains(body);
        if !stays {
            remove_obstacle(world, *entity);
        }
        stays
    });
    for body in wanted {
        if bodies.iter().all(|(present, _)| *present != body) && is_sound(&body) && leaves_room(world, &body) {
            let entity = spawn_obstacle(world, &body);
            bodies.push((body, entity));
        }
    }
    world.resource_mut::<ExtraBodies>().0 = bodies;
}

/// Whether a body does not overlap the robot.
fn leaves_room(world: &mut World, body: &ObstacleConfig) -> bool {
    let mut robots = world.query::<(&RobotPose, &Drive)>();
    robots.iter(world).all(|(robot, drive)| {
        distance_to(&body.shape, &body.pose, &robot.0.translation.vector.into()) >= drive.robot_radius_m()
    })
}
