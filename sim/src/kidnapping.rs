//! Moving the robot elsewhere.

use bevy_ecs::prelude::*;
use maps::{Point, Pose, Shape};

use crate::building::Building;
use crate::docking::Dock;
use crate::drive::Drive;
use crate::error::{BadSetting, Placement, SimError};
use crate::motion::{Motion, RobotPose};
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::physics::{Body, Physics};
use crate::room::check_room;

/// Puts the robot at rest at a pose; its wheels do not notice.
pub(crate) fn kidnap(world: &mut World, robot: Entity, to: Pose) -> Result<(), SimError> {
    check(world, robot, &to)?;
    let mut robots = world.query::<(&Body, &mut RobotPose, &mut Motion, &mut Drive, &mut Dock)>();
    let (body, mut pose, mut motion, mut drive, mut dock) =
        robots.get_mut(world, robot).expect("the robot keeps the components that it is built with");
    let body = *body;
    pose.0 = to;
    *motion = Motion { at_rest: true, travelled_m: motion.travelled_m, ..Motion::default() };
    drive.put_down(&to);
    dock.leave();
    world.resource_mut::<Physics>().put(body, &to);
    Ok(())
}

/// Fails if the robot can never be there, because of a wall or the edge of the map.
pub(crate) fn check_walls(world: &World, robot: Entity, to: &Pose) -> Result<(), SimError> {
    let heading_rad = to.rotation.angle();
    if !heading_rad.is_finite() {
        let accepted = "a finite number";
        let setting = "kidnapping.heading".to_owned();
        return Err(SimError::Settings(vec![BadSetting { setting, value: heading_rad.to_string(), accepted }]));
    }
    check_beside(world, robot, to, std::iter::empty())
}

/// Fails if the robot cannot be there now.
fn check(world: &mut World, robot: Entity, to: &Pose) -> Result<(), SimError> {
    check_walls(world, robot, to)?;
    let mut obstacles = world.query::<(&Obstacle, &ObstaclePose)>();
    let obstacles = obstacles.iter(world).map(|(obstacle, pose)| (obstacle.name.as_str(), &obstacle.shape, &pose.0));
    check_beside(world, robot, to, obstacles)
}

fn check_beside<'w>(
    world: &'w World,
    robot: Entity,
    to: &Pose,
    obstacles: impl Iterator<Item = (&'w str, &'w Shape, &'w Pose)>,
) -> Result<(), SimError> {
    let radius_m = world.get::<Drive>(robot).map_or(0.0, Drive::robot_radius_m);
    let at: Point = to.translation.vector.into();
    check_room(world.resource::<Building>().walls().rays(), obstacles, radius_m, Placement::Kidnapping, &at)
}
