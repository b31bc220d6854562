//! What stands on the floor and blocks movement and view: walls, doors' leaves and fixed bodies.

use bevy_ecs::prelude::*;
use maps::{Point, Pose};
use parry2d::query::Ray;

use crate::building::Building;
use crate::convert::to_glam;
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::room::{distance_to, nearest_wall};

/// Marks obstacles that people do not see past: doors' leaves and fixed bodies.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Opaque;

/// The walls, and the opaque bodies among them.
pub(crate) struct Floor<'a> {
    building: &'a Building,
    bodies: Vec<(&'a Obstacle, Pose)>,
}

impl<'a> Floor<'a> {
    pub(crate) fn new(
        building: &'a Building,
        bodies: impl IntoIterator<Item = (&'a Obstacle, &'a ObstaclePose)>,
    ) -> Self {
        Self { building, bodies: bodies.into_iter().map(|(body, pose)| (body, pose.0)).collect() }
    }

    /// Whether nothing blocks the straight line from one point to another.
    pub(crate) fn sees(&self, from: &Point, to: &Point) -> bool {
        let (walls, frame) = (self.building.walls().rays(), self.building.frame);
        let origin = walls.to_grid(from);
        let ray = Ray::new(frame.point_to_glam(from), to_glam(to - from));
        let blocks = |(body, pose): &(&Obstacle, Pose)| {
            body.outline.cast_ray(&frame.pose_to_glam(pose), &ray, 1.0, true).is_some()
        };
        walls.cast(&origin, &(walls.to_grid(to) - origin), 1.0).is_none() && !self.bodies.iter().any(blocks)
    }

    /// Whether a person with this radius can walk straight from one point to another without touching anything.
    pub(crate) fn is_walkable(&self, from: &Point, to: &Point, radius_m: f64) -> bool {
        let walls = self.building.walls().rays();
        let looks = ((to - from).norm() / (2.0 * walls.resolution_m)).ceil().max(1.0);
        (0..=looks as u32).all(|look| {
            let at = from + (to - from) * (f64::from(look) / looks);
            walls.holds(&walls.to_grid(&at))
                && nearest_wall(walls, &at, radius_m).is_none()
                && self.bodies.iter().all(|(body, pose)| distance_to(&body.shape, pose, &at) >= radius_m)
        })
    }

    /// Whether a person with this radius can make this step past the bodies. A person who overlaps a body may still
    /// leave it.
    pub(crate) fn is_passable(&self, from: &Point, to: &Point, radius_m: f64) -> bool {
        let gap_m = |(body, pose): &(&Obstacle, Pose), at| distance_to(&body.shape, pose, at);
        self.bodies.iter().all(|body| gap_m(body, to) >= radius_m.min(gap_m(body, from)))
    }
}
