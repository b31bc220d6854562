//! Scan matching: the pose near a guess at which the beams fit surfaces best.
//!
//! Gauss–Newton on the beams' distances from the nearest surface, with a robust weight, so that unmapped objects have
//! little influence, and with the guess's covariance as a prior, so that the pose does not slide along a corridor.

use nalgebra::{Matrix3, Vector3};

use crate::atlas::likelihood_field::Endpoints;
use crate::atlas::surface_field::SurfaceField;
use crate::particle::Gaussian;
use maps::wrap_angle;

/// Maximum number of steps; two or three are usually enough.
const STEPS: usize = 6;

/// A step shorter than this, in meters and radians, is the last.
const CONVERGED: f64 = 1e-4;

/// Distance at which a beam has a quarter of its weight, in meters.
const OUTLIER_M: f64 = 0.1;

/// Deviation of a beam's end from the surface, in meters: the map's cells, and the dependence of beams.
const DEVIATION_M: f64 = 0.03;

/// The smallest deviation of beams from surfaces, in meters: the position of a cell's face is not known better.
const LEAST_DEVIATION_M: f64 = 0.01;

/// A match farther from the guess than this many deviations is another place.
const FARTHEST_DEVIATIONS: f64 = 5.0;

/// The smallest deviation of the prior, in meters and radians, squared: collapsed particles must not prevent a
/// correction.
const LEAST_VARIANCE: [f64; 3] = [6.25e-4, 6.25e-4, 6.25e-4];

/// The guess, moved to where the beams match, with the remaining covariance. Without a match nearby the guess stays,
/// with a slightly larger covariance.
pub(crate) fn matched(guess: &Gaussian, ends: &Endpoints, surfaces: &SurfaceField) -> Gaussian {
    let covariance = guess.covariance + Matrix3::from_diagonal(&Vector3::from(LEAST_VARIANCE));
    let prior = Gaussian { covariance, ..*guess };
    best_match(&prior, ends, surfaces).unwrap_or(prior)
}

/// How precisely the scan determines a matched pose: the remaining covariance of the original guess.
///
/// The deviation of beams from surfaces is taken from the beams themselves, so a scan that fits badly is less
/// informative. All beams together count as at most `independent` ones, because unmapped or wrongly mapped objects
/// mislead many neighbors at once.
pub(crate) fn remaining_covariance(
    guess: &Gaussian,
    matched: &Gaussian,
    ends: &Endpoints,
    surfaces: &SurfaceField,
    independent: f64,
) -> Matrix3<f64> {
    let prior = guess.covariance + Matrix3::from_diagonal(&Vector3::from(LEAST_VARIANCE));
    let at = Vector3::new(matched.x_m, matched.y_m, matched.heading_rad);
    let (curvature, _) = normal_equations(&at, ends, surfaces);
    let variance = variance_of_ends(&at, ends, surfaces).max(LEAST_DEVIATION_M * LEAST_DEVIATION_M);
    let share = (independent / ends.len() as f64).min(1.0) * DEVIATION_M * DEVIATION_M / variance;
    let information = prior.try_inverse().unwrap_or_default() + curvature * share;
    information.try_inverse().unwrap_or(prior)
}

/// The weighted mean of the squared distances of beams' ends from surfaces, in m².
fn variance_of_ends(at: &Vector3<f64>, ends: &Endpoints, surfaces: &SurfaceField) -> f64 {
    let resolution_m = surfaces.resolution_m;
    let (sin, cos) = libm::sincos(at.z);
    let (mut squared, mut says) = (0.0, 0.0);
    for (x, y) in ends.x_m.iter().zip(&ends.y_m) {
        let (x, y) = (f64::from(*x), f64::from(*y));
        let (x, y) = (at.x + cos * x - sin * y, at.y + sin * x + cos * y);
        let Some((distance_m, _)) = surfaces.sample(x / resolution_m, y / resolution_m) else { continue };
        let outlier = distance_m / OUTLIER_M;
        let say = 1.0 / (1.0 + outlier * outlier);
        (squared, says) = (squared + say * distance_m * distance_m, says + say);
    }
    if says > 0.0 { squared / says } else { OUTLIER_M * OUTLIER_M }
}

fn best_match(prior: &Gaussian, ends: &Endpoints, surfaces: &SurfaceField) -> Option<Gaussian> {
    let information = prior.covariance.try_inverse()?;
    let mut covariance = prior.covariance;
    let mut off = Vector3::zeros();
    let moved = |off: &Vector3<f64>| Vector3::new(prior.x_m + off.x, prior.y_m + off.y, prior.heading_rad + off.z);
    for _ in 0..STEPS {
        let (curvature, slope) = normal_equations(&moved(&off), ends, surfaces);
        covariance = (curvature + information).try_inverse()?;
        let step = -covariance * (slope + information * off);
        off += step;
        if step.amax() < CONVERGED {
            break;
        }
    }
    let at = moved(&off);
    let near = off.dot(&(information * off)) <= FARTHEST_DEVIATIONS * FARTHEST_DEVIATIONS;
    near.then(|| Gaussian { x_m: at.x, y_m: at.y, heading_rad: wrap_angle(at.z), covariance })
}

/// Second and first derivatives of half the sum of the weighted squared distances.
fn normal_equations(at: &Vector3<f64>, ends: &Endpoints, surfaces: &SurfaceField) -> (Matrix3<f64>, Vector3<f64>) {
    let resolution_m = surfaces.resolution_m;
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

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, OccupancyGrid, pose};

    use super::*;

    /// A corridor along x between walls whose faces are at y = 1 m and y = 3 m, closed at x = 6 m if it `ends`.
    fn corridor(ends: bool) -> SurfaceField {
        let mut map = OccupancyGrid::new(140, 90, 0.05, pose(0.0, 0.0, 0.0));
        for column in 0..140 {
            for row in 0..90 {
                let wall = !(20..60).contains(&row) || (ends && column >= 120);
                map.set(CellIndex { column, row }, if wall { Cell::Occupied } else { Cell::Free });
            }
        }
        SurfaceField::new(&map, 0.5)
    }

    /// Points on those faces as seen from (3, 2), heading along x.
    fn seen(ends: bool) -> Endpoints {
        let mut points = Endpoints::default();
        for i in 0..60 {
            let along = i as f32 * 0.04;
            points.push(along - 1.2, -1.0);
            points.push(along - 1.2, 1.0);
            if ends {
                points.push(3.0, along - 1.2);
            }
        }
        points
    }

    fn guess(x_m: f64, y_m: f64, heading_rad: f64) -> Gaussian {
        Gaussian { x_m, y_m, heading_rad, covariance: Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.01)) }
    }

    #[test]
    fn a_nearby_guess_moves_to_the_truth() {
        let found = matched(&guess(3.12, 1.9, 0.08), &seen(true), &corridor(true));
        assert!((found.x_m - 3.0).abs() < 3e-3 && (found.y_m - 2.0).abs() < 3e-3, "{found:?}");
        assert!(found.heading_rad.abs() < 3e-3, "{found:?}");
    }

    #[test]
    fn a_corridor_does_not_move_the_guess_along_it() {
        let found = matched(&guess(3.12, 1.9, 0.08), &seen(false), &corridor(false));
        assert!((found.x_m - 3.12).abs() < 0.02 && (found.y_m - 2.0).abs() < 3e-3, "{found:?}");
    }

    #[test]
    fn without_beams_the_guess_stays() {
        let found = matched(&guess(3.12, 1.9, 0.08), &Endpoints::default(), &corridor(true));
        assert!((found.x_m - 3.12).abs() < 1e-9 && (found.heading_rad - 0.08).abs() < 1e-9);
    }
}
