//! A particle: one guess of the pose.

use nalgebra::Matrix3;

/// A guess of the pose in the grid's frame (metres from the map's origin, along the grid's axes), and its weight.
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
