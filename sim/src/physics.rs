//! Bodies and contacts: the world of rapier2d.

use bevy_ecs::prelude::*;
use maps::{Point, Pose, Shape};
use nalgebra::Vector2;
use parry2d::shape::SharedShape;
use rapier2d::prelude::{
    ColliderBuilder, ColliderHandle, IntegrationParameters, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};

use crate::building::Building;
use crate::config::{ObstacleConfig, ObstacleMotion};
use crate::convert::{LocalFrame, from_glam, to_glam};

/// Friction between floor and movable obstacles, as the decay rate of their motion, in 1/s.
const FLOOR_DAMPING_PER_S: f32 = 5.0;

#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Body {
    rigid: RigidBodyHandle,
    collider: ColliderHandle,
}

impl Body {
    pub(crate) fn has(&self, collider: ColliderHandle) -> bool {
        self.collider == collider
    }
}

/// A pair of bodies that touch or nearly touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    /// The other body's collider.
    pub(crate) other: ColliderHandle,
    /// The gap between them; negative if they overlap.
    pub(crate) gap_m: f32,
    /// Whether they push each other.
    pub(crate) pushing: bool,
    /// Where they are nearest to each other, or overlap most: a point on the body's edge, in its own frame; and the
    /// direction from there out of the body, a unit vector.
    pub(crate) at: Point,
    pub(crate) outwards: Vector2<f64>,
}

/// All bodies. Rapier computes in the building's frame; poses in this interface are in the `map` frame.
#[derive(Resource)]
pub(crate) struct Physics {
    world: PhysicsWorld,
    frame: LocalFrame,
    /// Coefficient of friction between any two bodies.
    friction: f32,
}

impl Physics {
    /// A building seen from above: no gravity. Its walls are solid, as one body. All bodies have the same coefficient
    /// of friction.
    pub(crate) fn within(building: &Building, dt_s: f64, friction: f64) -> Self {
        // Recycled contacts would report distances that are up to 5 cm out of date.
        let integration_parameters =
            IntegrationParameters { dt: dt_s as f32, contact_recycling: false, ..IntegrationParameters::default() };
        let gravity = to_glam(Vector2::zeros());
        let mut world = PhysicsWorld { gravity, integration_parameters, ..PhysicsWorld::default() };
        let friction = friction as f32;
        if let Some(blocks) = &building.blocks {
            world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(blocks.clone()).friction(friction));
        }
        Self { world, frame: building.frame, friction }
    }

    /// Adds the robot's body.
    pub(crate) fn add_robot(&mut self, pose: &Pose, radius_m: f64, mass_kg: f64) -> Body {
        let rigid = RigidBodyBuilder::dynamic().pose(self.frame.pose_to_glam(pose)).can_sleep(false);
        let disc = ColliderBuilder::ball(radius_m as f32).mass(mass_kg as f32).friction(self.friction);
        let (rigid, collider) = self.world.insert(rigid, disc);
        Body { rigid, collider }
    }

    /// Adds an obstacle at a pose.
    pub(crate) fn add_obstacle(&mut self, obstacle: &ObstacleConfig, pose: &Pose, shape: SharedShape) -> Body {
        let collider = ColliderBuilder::new(shape).friction(self.friction);
        let (rigid, collider) = match obstacle.motion {
            ObstacleMotion::Fixed
            | ObstacleMotion::Route { .. }
            | ObstacleMotion::Person(_)
            | ObstacleMotion::Follower(_)
            | ObstacleMotion::Door(_) => (RigidBodyBuilder::kinematic_position_based(), collider),
            ObstacleMotion::Movable { mass_kg } => {
                let damped = RigidBodyBuilder::dynamic()
                    .linear_damping(FLOOR_DAMPING_PER_S)
                    .angular_damping(FLOOR_DAMPING_PER_S);
                (damped, collider.mass(mass_kg as f32))
            }
        };
        let (rigid, collider) = self.world.insert(rigid.pose(self.frame.pose_to_glam(pose)), collider);
        Body { rigid, collider }
    }

    pub(crate) fn remove(&mut self, body: Body) {
        self.world.remove_body(body.rigid);
    }

    /// Takes a body out of the world until it is [put](Self::put) back.
    pub(crate) fn lift(&mut self, body: Body) {
        self.world.bodies[body.rigid].set_enabled(false);
    }

    /// Moves a body elsewhere, at rest.
    pub(crate) fn put(&mut self, body: Body, pose: &Pose) {
        let rigid = &mut self.world.bodies[body.rigid];
        rigid.set_enabled(true);
        rigid.set_position(self.frame.pose_to_glam(pose), true);
        rigid.set_linvel(to_glam(Vector2::zeros()), true);
        rigid.set_angvel(0.0, true);
    }

    /// Gives a body the velocity that takes it to `target` in the next step, unless something is in the way.
    pub(crate) fn steer(&mut self, body: Body, target: &Pose, dt_s: f64) {
        let from = self.pose(body);
        let linear = (target.translation.vector - from.translation.vector) / dt_s;
        let angular = from.rotation.rotation_to(&target.rotation).angle() / dt_s;
        let rigid = &mut self.world.bodies[body.rigid];
        rigid.set_linvel(to_glam(linear), true);
        rigid.set_angvel(angular as f32, true);
    }

    /// Moves an obstacle that cannot be stopped to `target` in the next step.
    pub(crate) fn carry(&mut self, body: Body, target: &Pose) {
        self.world.bodies[body.rigid].set_next_kinematic_position(self.frame.pose_to_glam(target));
    }

    pub(crate) fn pose(&self, body: Body) -> Pose {
        self.frame.pose_from_glam(self.world.bodies[body.rigid].position())
    }

    /// The bodies that touch a body, or nearly do.
    pub(crate) fn touches(&self, body: Body) -> impl Iterator<Item = Touch> + '_ {
        self.world.narrow_phase.contact_pairs_with(body.collider).filter_map(move |pair| {
            let (manifold, deepest) = pair.find_deepest_contact()?;
            let (other, at, outwards) = match pair.collider1 == body.collider {
                true => (pair.collider2, deepest.local_p1, manifold.local_n1),
                false => (pair.collider1, deepest.local_p2, manifold.local_n2),
            };
            let (at, outwards) = (from_glam(at).into(), from_glam(outwards));
            Some(Touch { other, gap_m: deepest.dist, pushing: pair.total_impulse_magnitude() > 0.0, at, outwards })
        })
    }
}

/// Performs one step.
pub(crate) fn step_physics(mut physics: ResMut<Physics>) {
    physics.world.step();
}

pub(crate) fn parry_shape(shape: &Shape) -> SharedShape {
    match *shape {
        Shape::Disc { radius_m } => SharedShape::ball(radius_m as f32),
        Shape::Box { length_m, width_m } => SharedShape::cuboid(0.5 * length_m as f32, 0.5 * width_m as f32),
    }
}
