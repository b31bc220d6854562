//! The motion of a body on two wheels: arcs of circles.

use maps::Pose;
use nalgebra::Vector2;

/// The final pose of a body on two wheels, relative to its first pose, after rolling `forward_m` along a circle while
/// turning by `turn_rad`.
pub(crate) fn arc(forward_m: f64, turn_rad: f64) -> Pose {
    let half = 0.5 * turn_rad;
    let chord_m = forward_m * sinc(half);
    Pose::new(Vector2::new(chord_m * libm::cos(half), chord_m * libm::sin(half)), turn_rad)
}

/// The motion of the wheels when a body moves from a pose to `to`, relative to that pose: the distance along the arc
/// and the turn. Motion across the wheels, which they cannot measure, is ignored.
pub(crate) fn rolled(to: &Pose) -> (f64, f64) {
    let turn_rad = to.rotation.angle();
    let half = 0.5 * turn_rad;
    let along_m = to.translation.x * libm::cos(half) + to.translation.y * libm::sin(half);
    (along_m / sinc(half), turn_rad)
}

/// `from`, moved along an arc; the rotation keeps its length of 1.
pub(crate) fn moved(from: &Pose, forward_m: f64, turn_rad: f64) -> Pose {
    let mut to = from * arc(forward_m, turn_rad);
    to.rotation.renormalize_fast();
    to
}

/// sin(x) / x.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { libm::sin(x) / x }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_quarter_circle_ends_beside_its_center() {
        let end = arc(FRAC_PI_2 * 2.0, FRAC_PI_2);
        assert!((end.translation.vector - Vector2::new(2.0, 2.0)).norm() < 1e-12, "{end}");
    }

    #[test]
    fn a_straight_line_stays_exactly_on_its_axis() {
        let mut pose = Pose::identity();
        (0..1000).for_each(|_| pose = moved(&pose, 0.009, 0.0));
        assert_eq!((pose.translation.y, pose.rotation.im), (0.0, 0.0));
    }

    proptest! {
        #[test]
        fn rolled_is_the_inverse_of_arc(forward_m in -0.5..0.5_f64, turn_rad in -0.9 * PI..0.9 * PI) {
            let (forward, turn) = rolled(&arc(forward_m, turn_rad));
            prop_assert!((forward - forward_m).abs() < 1e-12 && (turn - turn_rad).abs() < 1e-12);
        }
    }
}
