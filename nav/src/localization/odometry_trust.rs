//! The actual error of odometry, as a share of the error that the motion model allows.
//!
//! The alphas are chosen for bad odometry, so that particles cover the truth in any case. The uncertainty reported
//! between two updates should reflect the actual error, which shows in how far scans have moved the estimate away from
//! the prediction by odometry.
//!
//! Source: R. K. Mehra, "On the Identification of Variances and Adaptive Kalman Filtering", IEEE Transactions on
//! Automatic Control 15(2), 1970: the covariance of the innovations determines that of the process.

use nalgebra::{Matrix3, Vector3};

/// The weight of an update: the last twenty or so matter.
const FOLLOWS: f64 = 0.05;

/// The lower limit of the share: wheels may slip at any time.
const LEAST: f64 = 0.05;

/// The upper limit for a single update.
const MOST: f64 = 10.0;

/// Added to a covariance that may be singular, in m² and rad².
const REGULAR: f64 = 1e-9;

/// The recent share of odometry's errors in the motion model's variance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OdometryTrust {
    share: f64,
}

impl OdometryTrust {
    /// Initially, only the motion model is known.
    pub(crate) fn new() -> Self {
        Self { share: 1.0 }
    }

    /// Records how far a scan has moved the estimate from the prediction by odometry: `off` (x and y in meters, heading
    /// in radians), the noise of the motion according to the model, and the uncertainties of the poses before and
    /// after.
    pub(crate) fn observe(&mut self, off: &Vector3<f64>, noise: &Matrix3<f64>, poses: &Matrix3<f64>) {
        let Some(information) = (noise + Matrix3::identity() * REGULAR).try_inverse() else { return };
        let explained = (information * poses).trace();
        let share = ((off.dot(&(information * off)) - explained) / 3.0).clamp(0.0, MOST);
        self.share += FOLLOWS * (share - self.share);
    }

    /// The share of the motion model's variance to report.
    pub(crate) fn share(&self) -> f64 {
        self.share.max(LEAST)
    }
}

#[cfg(test)]
mod tests {
    use robot::normal;

    use super::*;

    #[test]
    fn the_share_is_learned_from_scans() {
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
    fn one_jump_does_not_ruin_it_and_perfect_odometry_is_not_trusted_completely() {
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
