//! The directions of a scanner's beams.

use maps::Point;
use nalgebra::Vector2;
use robot::LaserSpec;

/// A scanner's beams as seen from the robot: one origin and a unit vector a beam, in `base_link`.
///
/// The vectors are computed once; a scan rotates them, which is cheaper than a sine and a cosine a beam.
#[derive(Clone, Debug)]
pub struct Beams {
    origin: Point,
    directions: Vec<Vector2<f64>>,
}

impl Beams {
    /// The beams of that scanner.
    #[must_use]
    pub fn new(spec: &LaserSpec) -> Self {
        let direction = |index| {
            let (sin, cos) = libm::sincos(spec.beam_angle_rad(index));
            spec.mount.rotation * Vector2::new(cos, sin)
        };
        Self { origin: spec.mount.translation.vector.into(), directions: (0..spec.beams).map(direction).collect() }
    }

    /// Where the beams start.
    #[must_use]
    pub fn origin(&self) -> Point {
        self.origin
    }

    /// Where they go.
    pub fn directions(&self) -> impl ExactSizeIterator<Item = &Vector2<f64>> {
        self.directions.iter()
    }
}
