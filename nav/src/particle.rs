//! A particle: one guess of the pose.

use maps::{Pose, heading, pose, wrap_angle};
use nalgebra::Matrix3;

/// Two poses nearer to each other than this are the same guess.
const SAME_M: f64 = 0.5;
const SAME_RAD: f64 = 0.3;

/// A guess of the pose in the grid's frame (meters from the map's origin, along the grid's axes), and its weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Particle {
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    pub(crate) heading_rad: f64,
    /// Cosine and sine of the heading, kept because every beam needs them.
    pub(crate) cos: f64,
    pub(crate) sin: f64,
    /// Normalized: the weights of all particles add up to one.
    pub(crate) weight: f64,
}

impl Particle {
    /// A particle of weight one.
    pub(crate) fn new(x_m: f64, y_m: f64, heading_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(heading_rad);
        Self { x_m, y_m, heading_rad, cos, sin, weight: 1.0 }
    }

    pub(crate) fn turn_to(&mut self, heading_rad: f64) {
        self.heading_rad = heading_rad;
        (self.sin, self.cos) = libm::sincos(heading_rad);
    }
}

/// A pose in the grid's frame with its covariance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gaussian {
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    pub(crate) heading_rad: f64,
    pub(crate) covariance: Matrix3<f64>,
}

/// A pose after a motion.
pub(crate) fn after(from: &Gaussian, moved: &Pose) -> Gaussian {
    let to = pose(from.x_m, from.y_m, from.heading_rad) * moved;
    Gaussian { x_m: to.translation.x, y_m: to.translation.y, heading_rad: heading(&to), ..*from }
}

/// Whether two poses are the same guess.
pub(crate) fn are_same(a: &Gaussian, b: &Gaussian) -> bool {
    let (x, y) = (a.x_m - b.x_m, a.y_m - b.y_m);
    x * x + y * y < SAME_M * SAME_M && wrap_angle(a.heading_rad - b.heading_rad).abs() < SAME_RAD
}
