//! The motion of wheels that turn too little or slip.

use crate::faults::BaseFaults;

/// A distance along an arc, in meters, and the turn on it, in radians.
pub(crate) type Roll = (f64, f64);

/// The actual motion of the wheels for an intended one.
pub(crate) fn turned(faults: &BaseFaults, (forward_m, turn_rad): Roll, wheel_separation_m: f64) -> Roll {
    let (left, right) = (sound_factor(faults.left_wheel_factor), sound_factor(faults.right_wheel_factor));
    if (left, right) == (1.0, 1.0) {
        return (forward_m, turn_rad);
    }
    let half_m = 0.5 * wheel_separation_m * turn_rad;
    let (left_m, right_m) = ((forward_m - half_m) * left, (forward_m + half_m) * right);
    (0.5 * (left_m + right_m), (right_m - left_m) / wheel_separation_m)
}

/// The part of it that slips.
pub(crate) fn slipped(faults: &BaseFaults, (forward_m, turn_rad): Roll) -> Roll {
    // NaN is not slip either.
    if faults.slip > 0.0 {
        let slip = faults.slip.min(1.0);
        (slip * forward_m, slip * turn_rad)
    } else {
        (0.0, 0.0)
    }
}

fn sound_factor(factor: f64) -> f64 {
    if factor.is_nan() { 1.0 } else { factor.clamp(0.0, 2.0) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn wheels(left_wheel_factor: f64, right_wheel_factor: f64) -> BaseFaults {
        BaseFaults { left_wheel_factor, right_wheel_factor, ..BaseFaults::default() }
    }

    #[test]
    fn the_robot_turns_about_a_blocked_wheel() {
        let (forward_m, turn_rad) = turned(&wheels(0.0, 1.0), (0.1, 0.0), 0.4);
        assert!((forward_m - 0.05).abs() < 1e-15 && (turn_rad - 0.25).abs() < 1e-15, "{forward_m} {turn_rad}");
    }

    proptest! {
        #[test]
        fn good_wheels_change_nothing(forward_m in -1.0..1.0_f64, turn_rad in -1.0..1.0_f64) {
            let faults = BaseFaults::default();
            prop_assert_eq!(turned(&faults, (forward_m, turn_rad), 0.4), (forward_m, turn_rad));
            prop_assert_eq!(slipped(&faults, (forward_m, turn_rad)), (0.0, 0.0));
        }

        #[test]
        fn equally_weak_wheels_keep_the_curvature(share in 0.0..2.0_f64, forward_m in 0.1..1.0_f64, turn_rad in -1.0..1.0_f64) {
            let (forward, turn) = turned(&wheels(share, share), (forward_m, turn_rad), 0.4);
            prop_assert!((forward - share * forward_m).abs() < 1e-12 && (turn - share * turn_rad).abs() < 1e-12);
        }

        #[test]
        fn the_robot_turns_to_the_side_of_the_weaker_wheel(left in 0.0..1.0_f64, right in 0.0..1.0_f64) {
            let (_, turn_rad) = turned(&wheels(left, right), (0.3, 0.0), 0.4);
            prop_assert_eq!(turn_rad > 0.0, left < right);
        }
    }
}
