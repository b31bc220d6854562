//! Boxes that are picked up, and put down elsewhere.

use bevy_ecs::prelude::*;
use maps::{Point, Pose};
use parry2d::query::intersection_test;

use crate::building::Building;
use crate::drive::Drive;
use crate::error::{BoxError, Obstruction};
use crate::motion::RobotPose;
use crate::obstacles::{Movable, Obstacle, ObstaclePose, named};
use crate::physics::{Body, Physics};
use crate::room::distance_to;

/// Takes a box off the floor. Without a pose, it obstructs nothing and is seen by nothing.
pub(crate) fn pick_up(world: &mut World, name: &str) -> Result<(), BoxError> {
    let lifted = named::<Movable>(world, name).ok_or_else(|| BoxError::Unknown(name.to_owned()))?;
    world.entity_mut(lifted).take::<ObstaclePose>().ok_or_else(|| BoxError::Lifted(name.to_owned()))?;
    if let Some(body) = world.get::<Body>(lifted).copied() {
        world.resource_mut::<Physics>().lift(body);
    }
    Ok(())
}

/// Puts a lifted box down at a pose, at rest, if there is room for it.
pub(crate) fn put_down(world: &mut World, robot: Entity, name: &str, to: Pose) -> Result<(), BoxError> {
    let lifted = named::<Movable>(world, name).ok_or_else(|| BoxError::Unknown(name.to_owned()))?;
    if world.get::<ObstaclePose>(lifted).is_some() {
        return Err(BoxError::OnFloor(name.to_owned()));
    }
    if let Some(obstruction) = obstruction(world, robot, lifted, &to) {
        let (x_m, y_m) = (to.translation.x, to.translation.y);
        return Err(BoxError::NoRoom { name: name.to_owned(), x_m, y_m, obstruction });
    }
    world.entity_mut(lifted).insert(ObstaclePose(to));
    if let Some(body) = world.get::<Body>(lifted).copied() {
        world.resource_mut::<Physics>().put(body, &to);
    }
    Ok(())
}

/// The body that a box at a pose would overlap.
fn obstruction(world: &mut World, robot: Entity, lifted: Entity, to: &Pose) -> Option<Obstruction> {
    let mut obstacles = world.query::<(&Obstacle, &ObstaclePose)>();
    let (building, carried) = (world.resource::<Building>(), world.get::<Obstacle>(lifted)?);
    let at = Point::from(to.translation.vector);
    if !building.walls().rays().holds(&building.walls().rays().to_grid(&at)) || !to.rotation.angle().is_finite() {
        return Some(Obstruction::Edge);
    }
    let frame = building.frame;
    let here = frame.pose_to_glam(to);
    let overlaps = |pose: &_, outline: &dyn parry2d::shape::Shape| {
        let test = intersection_test(&here, &*carried.outline, pose, outline);
        test.expect("parry supports discs, boxes and compounds of boxes").intersecting
    };
    if building.blocks.as_ref().is_some_and(|walls| overlaps(&Default::default(), &**walls)) {
        return Some(Obstruction::Wall);
    }
    let (robot, drive) = (world.get::<RobotPose>(robot)?, world.get::<Drive>(robot)?);
    if distance_to(&carried.shape, to, &robot.0.translation.vector.into()) < drive.robot_radius_m() {
        return Some(Obstruction::Robot);
    }
    let mut others = obstacles.iter(world);
    let other = others.find(|(other, pose)| overlaps(&frame.pose_to_glam(&pose.0), &*other.outline));
    other.map(|(other, _)| Obstruction::Obstacle(other.name.clone()))
}
