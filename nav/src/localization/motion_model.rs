//! The odometry motion model of a differential drive, with four alphas.
//!
//! A motion is a turn, a straight line and another turn, each with its own noise. Source: S. Thrun, W. Burgard, D. Fox,
//! "Probabilistic Robotics", MIT Press 2005, table 5.6.

use maps::{Pose, heading, wrap_angle};
use nalgebra::{Matrix3, Rotation2, Vector2};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::particle::Particle;

/// Below this distance, the first turn is noise of the odometry, in meters.
const SHORTEST_WAY_M: f64 = 0.01;

/// A motion according to odometry, and its noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DifferentialMotion {
    /// Direction of the line relative to the heading at its start.
    direction_rad: f64,
    way_m: f64,
    turn_rad: f64,
    first_turn_deviation_rad: f64,
    way_deviation_m: f64,
    last_turn_deviation_rad: f64,
}

impl DifferentialMotion {
    /// The motion between two poses in the `odom` frame, with the noise of the alphas α1 to α4.
    pub(crate) fn between(from: &Pose, to: &Pose, [a1, a2, a3, a4]: [f64; 4]) -> Self {
        let moved = from.inv_mul(to);
        let way_m = moved.translation.vector.norm();
        let turn_rad = heading(&moved);
        let direction_rad =
            if way_m > 0.0 { libm::atan2(moved.translation.vector.y, moved.translation.vector.x) } else { 0.0 };
        // Driving backwards has the same noise as driving forwards, not that of two half turns.
        let first = if way_m < SHORTEST_WAY_M { 0.0 } else { nearest_to_straight(direction_rad) };
        let last = if way_m < SHORTEST_WAY_M { turn_rad.abs() } else { nearest_to_straight(turn_rad - direction_rad) };
        let turn_deviation = |turn: f64| (a1 * turn * turn + a2 * way_m * way_m).sqrt();
        Self {
            direction_rad,
            way_m,
            turn_rad,
            first_turn_deviation_rad: turn_deviation(first),
            way_deviation_m: (a3 * way_m * way_m + a4 * (first * first + last * last)).sqrt(),
            last_turn_deviation_rad: turn_deviation(last),
        }
    }

    /// Moves a particle, with fresh noise.
    pub(crate) fn sample(&self, particle: &mut Particle, rng: &mut ChaCha8Rng) {
        let first = self.first_turn_deviation_rad * bell(rng);
        let way = self.way_m + self.way_deviation_m * bell(rng);
        let last = self.last_turn_deviation_rad * bell(rng);
        let (sin, cos) = libm::sincos(particle.heading_rad + self.direction_rad + first);
        particle.x_m += way * cos;
        particle.y_m += way * sin;
        particle.turn_to(wrap_angle(particle.heading_rad + self.turn_rad + first + last));
    }

    /// The covariance of x, y and heading after the motion from a pose with this heading and covariance, to first
    /// order.
    pub(crate) fn propagate(&self, heading_rad: f64, before: &Matrix3<f64>) -> Matrix3<f64> {
        let turned = Rotation2::new(heading_rad + self.direction_rad);
        let way = turned * Vector2::new(self.way_m, 0.0);
        let jacobian = Matrix3::new(1.0, 0.0, -way.y, 0.0, 1.0, way.x, 0.0, 0.0, 1.0);
        let along = turned * Vector2::x() * self.way_deviation_m;
        let first = Vector2::new(-way.y, way.x).push(1.0) * self.first_turn_deviation_rad;
        let last = nalgebra::Vector3::z() * self.last_turn_deviation_rad;
        let along = along.push(0.0);
        let noise = along * along.transpose() + first * first.transpose() + last * last.transpose();
        jacobian * before * jacobian.transpose() + noise
    }
}

/// The size of a turn, or of the remaining turn when driving backwards.
fn nearest_to_straight(angle_rad: f64) -> f64 {
    let turn = wrap_angle(angle_rad).abs();
    turn.min(std::f64::consts::PI - turn)
}

/// A random number with mean 0, variance 1 and a bell-shaped density, never beyond ± 3.5: the sum of four uniform ones.
///
/// It is three times as fast as a normal one, and the shorter tails do no harm to particles.
pub(crate) fn bell(rng: &mut ChaCha8Rng) -> f64 {
    /// Standard deviation of the sum of four uniform numbers from 0 to 65 535: √((65536² − 1) / 3).
    const DEVIATION: f64 = 37_837.227_240_418_89;
    let bits = rng.random::<u64>();
    let sum: u64 = (0..4).map(|quarter| (bits >> (16 * quarter)) & 0xffff).sum();
    (sum as f64 - 131_070.0) / DEVIATION
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    fn sampled(motion: &DifferentialMotion, count: usize) -> Vec<Particle> {
        let mut rng = robot::Streams::new(5).stream("motion");
        let start = Particle::new(1.0, 2.0, 0.3);
        (0..count)
            .map(|_| {
                let mut particle = start;
                motion.sample(&mut particle, &mut rng);
                particle
            })
            .collect()
    }

    #[test]
    fn bell_shaped_samples_have_mean_zero_and_variance_one() {
        let mut rng = robot::Streams::new(7).stream("bell");
        let numbers: Vec<f64> = (0..40_000).map(|_| bell(&mut rng)).collect();
        let mean = numbers.iter().sum::<f64>() / 40_000.0;
        let variance = numbers.iter().map(|x| x * x).sum::<f64>() / 40_000.0;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03, "mean {mean}, variance {variance}");
    }

    #[test]
    fn without_noise_particles_follow_the_odometry() {
        for to in [pose(3.1, -0.4, 1.9), pose(0.004, 0.003, -2.0), pose(-0.5, 0.1, 0.0), pose(0.0, 0.0, 0.0)] {
            let motion = DifferentialMotion::between(&pose(0.0, 0.0, 0.0), &to, [0.0; 4]);
            let expected = pose(1.0, 2.0, 0.3) * to;
            for particle in sampled(&motion, 2) {
                assert!((particle.x_m - expected.translation.x).abs() < 1e-9);
                assert!((particle.y_m - expected.translation.y).abs() < 1e-9);
                assert!(wrap_angle(particle.heading_rad - heading(&expected)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_covariance_agrees_with_the_samples() {
        let motion =
            DifferentialMotion::between(&pose(0.0, 0.0, 0.0), &pose(0.4, 0.1, 0.5), [0.02, 0.01, 0.015, 0.005]);
        let particles = sampled(&motion, 20_000);
        let rows = particles.iter().map(|p| nalgebra::Vector3::new(p.x_m, p.y_m, p.heading_rad));
        let mean = rows.clone().sum::<nalgebra::Vector3<f64>>() / 20_000.0;
        let sampled = rows.map(|row| (row - mean) * (row - mean).transpose()).sum::<Matrix3<f64>>() / 20_000.0;
        let predicted = motion.propagate(0.3, &Matrix3::zeros());
        let difference = (sampled - predicted).abs().max();
        assert!(difference < 0.04 * predicted.diagonal().max(), "{sampled} instead of {predicted}");
    }

    #[test]
    fn driving_backwards_is_as_noisy_as_driving_forwards() {
        let alphas = [0.02, 0.01, 0.015, 0.005];
        let way = |x| DifferentialMotion::between(&pose(0.0, 0.0, 0.0), &pose(x, 0.0, 0.0), alphas);
        assert!((way(0.3).first_turn_deviation_rad - way(-0.3).first_turn_deviation_rad).abs() < 1e-9);
        assert!((way(0.3).last_turn_deviation_rad - way(-0.3).last_turn_deviation_rad).abs() < 1e-9);
    }
}
