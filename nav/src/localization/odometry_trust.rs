//! How far off odometry is in truth, as a share of what the motion model allows for.
//!
//! The alphas are chosen for odometry that is bad, so that particles cover the truth wherever it may be. What is
//! reported between two updates should say how bad it is: that shows in how far scans have moved the estimate away from
//! where odometry had carried it.
//!
//! Source: R. K. Mehra, "On the Identification of Variances and Adaptive Kalman Filtering", IEEE Transactions on
//! Automatic Control 15(2), 1970: the covariance of the innovations tells that of the process.

use nalgebra::{Matrix3, Vector3};

/// How much an update counts: the last twenty or so matter.
const FOLLOWS: f64 = 0.05;

/// The share is never less than this: wheels may slip at any time.
const LEAST: f64 = 0.05;

/// A single update never counts as more than this, whatever has happened.
const MOST: f64 = 10.0;

/// Added to a covariance that may be singular, in m² and rad².
const REGULAR: f64 = 1e-9;

/// The share of the motion model's variance that odometry's errors have had of late.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OdometryTrust {
    share: f64,
}

impl OdometryTrust {
    /// Nothing is known but the motion model.
    pub(crate) fn new() -> Self {
        Self { share: 1.0 }
    }

    /// Takes in how far a scan has moved the estimate from where odometry had carried it: `off` (x and y in metres,
    /// heading in radians), where the motion has that noise by its model, and the poses before and after are known that
    /// well by themselves.
    pub(crate) fn observe(&mut self, off: &Vector3<f64>, noise: &Matrix3<f64>, poses: &Matrix3<f64>) {
        let Some(information) = (noise + Matrix3::identity() * REGULAR).try_inverse() else { return };
        let explained = (information * poses).trace();
        let share = ((off.dot(&(information * off)) - explained) / 3.0).clamp(0.0, MOST);
        self.share += FOLLOWS * (share - self.share);
    }

    /// The share of the motion model's variance to be reported.
    pub(crate) fn share(&self) -> f64 {
        self.share.max(LEAST)
    }
}

#[cfg(test)]
mod tests {
    use robot::normal;

    use super::*;

    #[test]
    fn the_share_is_found_from_what_scans_say() {
        let mut rng = robot::Streams::new(3).stream("innovations");
        let noise = Matrix3::from_diagonal(&Vector3::new(1e-4, 4e-4, 9e-4));
        let poses = Matrix3::identity() * 2e-5;
        for truth in [0.1_f64, 1.0, 4.0] {
            let mut trust = OdometryTrust::new();
            let mut shares = Vec::new();
            for _ in 0..4000 {
                let deviations = (noise.diagonal() * truth + poses.diagonal()).map(f64::sqrt);
                trust.observe(&deviations.map(|deviation| deviation * normal(&mut rng)), &noise, &poses);
                shares.push(trust.share());
            }
            let mean = shares[200..].iter().sum::<f64>() / 3800.0;
            assert!((mean / truth - 1.0).abs() < 0.2, "{mean} instead of {truth}");
        }
    }

    #[test]
    fn one_jump_does_not_ruin_it_and_perfect_odometry_is_not_trusted_blindly() {
        let mut trust = OdometryTrust::new();
        let noise = Matrix3::identity() * 1e-4;
        trust.observe(&Vector3::new(30.0, 0.0, 0.0), &noise, &Matrix3::zeros());
        assert!(trust.share() < 1.5);
        (0..500).for_each(|_| trust.observe(&Vector3::zeros(), &noise, &Matrix3::zeros()));
        assert_eq!(trust.share(), LEAST);
        trust.observe(&Vector3::zeros(), &Matrix3::zeros(), &Matrix3::zeros());
        assert!(trust.share().is_finite());
    }
}
