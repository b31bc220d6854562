//! Conversion between nalgebra's f64, used in this project, and glam's f32, used by rapier and parry.

use maps::{OccupancyGrid, Point, Pose};
use nalgebra::{Complex, UnitComplex, Vector2};
use parry2d::math::{Pose as GlamPose, Rotation as GlamRotation, Vector as GlamVector};

/// Origins of [`LocalFrame`]s are multiples of this, in meters.
const RASTER_M: f64 = 128.0;

/// The frame for f32 computations: the `map` frame, moved near the middle of the building.
///
/// An f32 has 24 bits: 5 km from the origin, neighboring numbers are half a millimeter apart. A starting robot moves
/// less than that in a step, and maps with UTM coordinates are even farther away. So the precision must depend on the
/// size of the building, not on its position.
///
/// The origin is the middle of the map, rounded to a grid: it is 0 for all maps whose middle is less than 64 m from the
/// `map` frame's origin in x and y, so their results have the same bits as without this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LocalFrame {
    /// In the `map` frame, in meters.
    origin: Vector2<f64>,
}

impl LocalFrame {
    /// The frame for computations on a map.
    pub(crate) fn of(grid: &OccupancyGrid) -> Self {
        let middle = grid.from_grid(&Point::new(grid.width() as f64 / 2.0, grid.height() as f64 / 2.0));
        Self { origin: middle.coords.map(|value| (value / RASTER_M).round() * RASTER_M) }
    }

    /// A point of the `map` frame, for rapier and parry.
    pub(crate) fn point_to_glam(&self, point: &Point) -> GlamVector {
        to_glam(point.coords - self.origin)
    }

    /// A pose in the `map` frame, for rapier and parry.
    pub(crate) fn pose_to_glam(&self, pose: &Pose) -> GlamPose {
        let rotation = GlamRotation::from_cos_sin_unchecked(pose.rotation.re as f32, pose.rotation.im as f32);
        GlamPose::from_parts(to_glam(pose.translation.vector - self.origin), rotation)
    }

    /// A pose of rapier or parry in the `map` frame.
    pub(crate) fn pose_from_glam(&self, pose: &GlamPose) -> Pose {
        let rotation = Complex::new(f64::from(pose.rotation.re), f64::from(pose.rotation.im));
        let translation = from_glam(pose.translation) + self.origin;
        Pose::from_parts(translation.into(), UnitComplex::new_normalize(rotation))
    }
}

/// A direction, a velocity or a difference.
pub(crate) fn to_glam(vector: Vector2<f64>) -> GlamVector {
    GlamVector::new(vector.x as f32, vector.y as f32)
}

/// A direction, a velocity or a difference of rapier or parry.
pub(crate) fn from_glam(vector: GlamVector) -> Vector2<f64> {
    Vector2::new(f64::from(vector.x), f64::from(vector.y))
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    fn frame_of(origin: Pose) -> LocalFrame {
        LocalFrame::of(&OccupancyGrid::new(400, 400, 0.05, origin))
    }

    #[test]
    fn maps_near_the_origin_are_not_moved() {
        for origin in [pose(0.0, 0.0, 0.0), pose(-73.0, 53.0, 0.0), pose(60.0, -60.0, 0.7)] {
            let frame = frame_of(origin);
            assert_eq!(frame.origin, Vector2::zeros());
            let at = pose(12.3, -4.5, 0.6);
            assert_eq!(frame.pose_to_glam(&at).translation, to_glam(at.translation.vector));
        }
    }

    #[test]
    fn distant_poses_are_converted_and_back_within_micrometers() {
        for (x_m, y_m, heading_rad) in [(5000.0, -5000.0, 1.0), (688_000.0, 5_335_000.0, -2.0)] {
            let frame = frame_of(pose(x_m, y_m, heading_rad));
            let at = pose(x_m + 3.21, y_m + 6.54, 0.3);
            let local = frame.pose_to_glam(&at);
            assert!(local.translation.length() < 128.0, "{local:?}");
            let off = at.inv_mul(&frame.pose_from_glam(&local));
            assert!(off.translation.vector.norm() < 1e-5 && off.rotation.angle().abs() < 1e-6, "{off}");
            assert_eq!(frame.point_to_glam(&at.translation.vector.into()), local.translation);
        }
    }
}
