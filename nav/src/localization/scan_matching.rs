//! Scan matching: the pose near a guess at which the beams end on surfaces best.
//!
//! Gauss–Newton on the beams' distances from the nearest surface, with a robust weight, so that what is not on the map
//! has little say, and with the guess's covariance as a prior, so that a corridor does not let the pose slide along it.

use nalgebra::{Matrix3, Vector3};

use super::likelihood_field::Endpoints;
use super::particle::Gaussian;
use super::surface_field::SurfaceField;
use maps::wrap_angle;

/// Most steps; two or three do as a rule.
const STEPS: usize = 6;

/// A step shorter than this, in metres and radians, is the last.
const CONVERGED: f64 = 1e-4;

/// Distance at which a beam has a quarter of its say, in metres.
const OUTLIER_M: f64 = 0.1;

/// Deviation of a beam's end from the surface, in metres: the map's cells and beams that depend on one another.
const DEVIATION_M: f64 = 0.05;

/// A match farther from the guess than this many of its deviations is another place.
const FARTHEST_DEVIATIONS: f64 = 5.0;

/// The smallest deviation of the prior, in metres and radians, squared: particles that have collapsed onto one another
/// must not forbid a correction.
const LEAST_VARIANCE: [f64; 3] = [1e-4, 1e-4, 2.5e-5];

/// The guess moved to where the beams match, or `None` if there is no match nearby.
pub(crate) fn matched(guess: &Gaussian, ends: &Endpoints, surfaces: &SurfaceField) -> Option<Gaussian> {
    let prior = guess.covariance + Matrix3::from_diagonal(&Vector3::from(LEAST_VARIANCE));
    let information = prior.try_inverse()?;
    let mut at = Vector3::new(guess.x_m, guess.y_m, guess.heading_rad);
    let off =
        |at: &Vector3<f64>| Vector3::new(at.x - guess.x_m, at.y - guess.y_m, wrap_angle(at.z - guess.heading_rad));
    for _ in 0..STEPS {
        let (curvature, slope) = normal_equations(&at, ends, surfaces);
        let step = (curvature + information).cholesky()?.solve(&-(slope + information * off(&at)));
        at += step;
        if step.amax() < CONVERGED {
            break;
        }
    }
    let off = off(&at);
    let near = (off.transpose() * information * off).x <= FARTHEST_DEVIATIONS * FARTHEST_DEVIATIONS;
    near.then(|| Gaussian { x_m: at.x, y_m: at.y, heading_rad: wrap_angle(at.z), covariance: guess.covariance })
}

/// Second and first derivatives of half the sum of the weighted squared distances.
fn normal_equations(at: &Vector3<f64>, ends: &Endpoints, surfaces: &SurfaceField) -> (Matrix3<f64>, Vector3<f64>) {
    let resolution_m = surfaces.resolution_m();
    let (sin, cos) = libm::sincos(at.z);
    let mut curvature = Matrix3::zeros();
    let mut slope = Vector3::zeros();
    for (x, y) in ends.x_m.iter().zip(&ends.y_m) {
        let (x, y) = (f64::from(*x), f64::from(*y));
        let (along, across) = (cos * x - sin * y, sin * x + cos * y);
        let sample = surfaces.sample((at.x + along) / resolution_m, (at.y + across) / resolution_m);
        let Some((distance_m, [gx, gy])) = sample else { continue };
        let outlier = distance_m / OUTLIER_M;
        let say = 1.0 / (1.0 + outlier * outlier);
        let weight = say * say / (DEVIATION_M * DEVIATION_M);
        let derivative = Vector3::new(gx, gy, gy * along - gx * across);
        curvature += derivative * derivative.transpose() * weight;
        slope += derivative * (distance_m * weight);
    }
    (curvature, slope)
}
