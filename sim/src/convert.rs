//! Between nalgebra's f64, in which this project speaks, and glam's f32, in which rapier and parry do.

use maps::Pose;
use nalgebra::{Complex, UnitComplex, Vector2};
use parry2d::math::{Pose as GlamPose, Rotation as GlamRotation, Vector as GlamVector};

pub(crate) fn to_glam(vector: Vector2<f64>) -> GlamVector {
    GlamVector::new(vector.x as f32, vector.y as f32)
}

pub(crate) fn from_glam(vector: GlamVector) -> Vector2<f64> {
    Vector2::new(f64::from(vector.x), f64::from(vector.y))
}

pub(crate) fn to_glam_pose(pose: &Pose) -> GlamPose {
    let rotation = GlamRotation::from_cos_sin_unchecked(pose.rotation.re as f32, pose.rotation.im as f32);
    GlamPose::from_parts(to_glam(pose.translation.vector), rotation)
}

pub(crate) fn from_glam_pose(pose: &GlamPose) -> Pose {
    let rotation = Complex::new(f64::from(pose.rotation.re), f64::from(pose.rotation.im));
    Pose::from_parts(from_glam(pose.translation).into(), UnitComplex::new_normalize(rotation))
}
