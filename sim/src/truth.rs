//! The true state, for reports.

use std::sync::Arc;
use std::time::Duration;

use bevy_ecs::prelude::*;
use maps::{Point, Pose, Shape};
use robot::{BatteryState, LaserScan, Odometry};

use crate::battery::Battery;
use crate::building::Building;
use crate::clock::Clock;
use crate::contacts::{Contact, Contacts};
use crate::docking::Dock;
use crate::doors::Leaf;
use crate::floor::{Floor, Opaque};
use crate::lasers::Laser;
use crate::motion::{Motion, RobotPose};
use crate::obstacles::{Obstacle, ObstaclePose, Obstacles, named};
use crate::odometer::Odometer;
use crate::room::{distance_to, wall_distance_m};

/// The true state of the simulated world.
///
/// Only for reports, pictures, trace hashes and tests: the robot's software must never see it, only the data of
/// [`robot::Robot`].
#[derive(Clone, Copy)]
pub struct Truth<'a> {
    pub(crate) world: &'a World,
    pub(crate) robot: Entity,
    pub(crate) lasers: &'a [Entity],
}

/// The true state of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObstacleTruth<'a> {
    /// Its name in the configuration or in the fault that added it.
    pub name: &'a str,
    /// Outline around its center.
    pub shape: Shape,
    /// Pose of its center in the `map` frame.
    pub pose: Pose,
}

impl ObstacleTruth<'_> {
    /// Its distance from a point in the `map` frame, in meters; 0 inside.
    #[must_use]
    pub fn distance_m(&self, point: &Point) -> f64 {
        distance_to(&self.shape, &self.pose, point)
    }
}

impl<'a> Truth<'a> {
    /// Time since the start of the run.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.clock().now
    }

    /// Pose of the robot (`base_link`) in the `map` frame.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.of::<RobotPose>(self.robot).0
    }

    /// Forward speed in the last step, in m/s.
    #[must_use]
    pub fn linear_mps(&self) -> f64 {
        self.of::<Motion>(self.robot).forward_m / self.clock().dt_s()
    }

    /// Turning rate in the last step, in rad/s, counter-clockwise.
    #[must_use]
    pub fn angular_radps(&self) -> f64 {
        self.of::<Motion>(self.robot).turn_rad / self.clock().dt_s()
    }

    /// Distance traveled by the robot's center since the start of the run, in meters.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        self.of::<Motion>(self.robot).travelled_m
    }

    /// Number of contacts between the robot and other bodies so far. All walls together count as one body; a contact
    /// ends when the gap is wider than 5 mm.
    #[must_use]
    pub fn collisions(&self) -> u64 {
        self.contacts().len() as u64
    }

    /// The contacts between the robot and other bodies so far, in order; [`collisions`](Self::collisions) counts them.
    #[must_use]
    pub fn contacts(&self) -> &'a [Contact] {
        &self.of::<Contacts>(self.robot).begun
    }

    /// Whether the robot touches anything.
    #[must_use]
    pub fn is_touching(&self) -> bool {
        self.of::<Contacts>(self.robot).is_touching()
    }

    /// Distance between the edge of a robot of this radius and the nearest wall or obstacle, in meters: 0 where they
    /// touch or overlap, infinite where there is neither.
    #[must_use]
    pub fn clearance_m(&self, radius_m: f64) -> f64 {
        let center = self.pose().translation.vector.into();
        let obstacles = self.obstacles().map(|obstacle| obstacle.distance_m(&center));
        let nearest_m = obstacles.fold(f64::INFINITY, f64::min);
        let wall_m = wall_distance_m(self.world.resource::<Building>().walls().rays(), &center, nearest_m);
        (nearest_m.min(wall_m) - radius_m).max(0.0)
    }

    /// Wheel odometry as measured in the last step, with its faults, whether or not it was read.
    #[must_use]
    pub fn odometry(&self) -> Odometry {
        self.of::<Odometer>(self.robot).latest
    }

    /// The true state of the battery, regardless of its readings.
    #[must_use]
    pub fn battery(&self) -> BatteryState {
        self.of::<Battery>(self.robot).state(&self.clock())
    }

    /// Whether the robot is docked to the charging station.
    #[must_use]
    pub fn is_docked(&self) -> bool {
        self.of::<Dock>(self.robot).is_docked()
    }

    /// The last scan of each laser, in the order of [`robot::RobotModel::lasers`], with its faults. Dead lasers have
    /// none.
    pub fn scans(&self) -> impl Iterator<Item = &'a Arc<LaserScan>> + use<'a> {
        let (world, lasers) = (self.world, self.lasers);
        lasers.iter().filter_map(move |laser| world.get::<Laser>(*laser)?.latest.as_ref())
    }

    /// All obstacles: those of [`SimConfig::obstacles`](crate::SimConfig::obstacles) in order, then those of
    /// [`Faults::bodies`](crate::Faults::bodies) that have been placed, in the order of their appearance. Boxes that
    /// have been [picked up](crate::Simulation::pick_up) are not among them.
    pub fn obstacles(&self) -> impl Iterator<Item = ObstacleTruth<'a>> + use<'a> {
        let world = self.world;
        world.resource::<Obstacles>().0.iter().filter_map(move |entity| {
            let obstacle = world.get::<Obstacle>(*entity)?;
            let pose = world.get::<ObstaclePose>(*entity)?.0;
            Some(ObstacleTruth { name: &obstacle.name, shape: obstacle.shape, pose })
        })
    }

    /// How far the door with this name is open: 0 is closed, 1 is open. `None` if there is no such door.
    #[must_use]
    pub fn door_opening(&self, name: &str) -> Option<f64> {
        Some(self.world.get::<Leaf>(named::<Leaf>(self.world, name)?)?.opening())
    }

    /// The doors, each with how far its leaf has moved from where it is closed: one that swings in radians,
    /// counter-clockwise; one that slides in meters.
    pub fn doors(&self) -> impl Iterator<Item = (&'a str, f64)> {
        let world = self.world;
        world.resource::<Obstacles>().0.iter().filter_map(move |entity| {
            let (obstacle, leaf) = world.get::<Obstacle>(*entity).zip(world.get::<Leaf>(*entity))?;
            Some((obstacle.name.as_str(), leaf.joint()))
        })
    }

    /// Whether nothing blocks the straight line from the robot's center to a point of the `map` frame. Walls, doors'
    /// leaves and fixed obstacles do; people and boxes that can be pushed do not.
    #[must_use]
    pub fn sees(&self, point: &Point) -> bool {
        let world = self.world;
        let opaque = world.resource::<Obstacles>().0.iter().filter(|entity| world.get::<Opaque>(**entity).is_some());
        let bodies = opaque.filter_map(|entity| world.get::<Obstacle>(*entity).zip(world.get::<ObstaclePose>(*entity)));
        Floor::new(world.resource::<Building>(), bodies).sees(&self.pose().translation.vector.into(), point)
    }

    fn clock(&self) -> Clock {
        *self.world.resource::<Clock>()
    }

    fn of<C: Component>(&self, entity: Entity) -> &'a C {
        self.world.get::<C>(entity).expect("robot and station keep the components that they are built with")
    }
}
