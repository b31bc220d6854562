//! Poses and angles, in meters and radians (ROS REP-103: x forward, y left, angles counter-clockwise).

use std::f64::consts::PI;

/// A point in the plane, in meters, in the frame that its name or context indicates.
pub type Point = nalgebra::Point2<f64>;

/// A position and heading in the plane; as a transform, it maps points of the body's frame to the outer frame.
pub type Pose = nalgebra::Isometry2<f64>;

/// The pose at (`x_m`, `y_m`) that faces `heading_rad`, counter-clockwise from the x axis.
#[must_use]
pub fn pose(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
    Pose::new(nalgebra::Vector2::new(x_m, y_m), heading_rad)
}

/// A pose with a rotation in space, as a quaternion (x, y, z, w), seen from above.
#[must_use]
pub fn seen_from_above([x, y]: [f64; 2], [a, b, c, w]: [f64; 4]) -> Pose {
    pose(x, y, libm::atan2(2.0 * (w * c + a * b), 1.0 - 2.0 * (b * b + c * c)))
}

/// The heading of a pose, in radians in (−π, π].
#[must_use]
pub fn heading(pose: &Pose) -> f64 {
    wrap_angle(pose.rotation.angle())
}

/// The same angle in (−π, π]. The result is NaN if the angle is not finite.
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let turns = ((angle_rad + PI) / (2.0 * PI)).floor();
    let wrapped = angle_rad - turns * 2.0 * PI;
    if wrapped <= -PI { PI } else { wrapped.min(PI) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapped_angles_lie_in_the_half_open_circle() {
        for (angle, wrapped) in [(0.0, 0.0), (PI, PI), (-PI, PI), (3.0 * PI, PI), (1.5 * PI, -0.5 * PI)] {
            assert!((wrap_angle(angle) - wrapped).abs() < 1e-12, "{angle} gave {}", wrap_angle(angle));
        }
    }
}
