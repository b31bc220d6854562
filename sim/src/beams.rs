//! The directions of a scanner's beams.

use std::ops::Range;

use maps::Point;
use nalgebra::Vector2;
use robot::LaserSpec;

/// A scanner's beams as seen from the robot: one origin, and one unit vector per beam, in `base_link`.
///
/// The vectors are computed once. A scan rotates them, which is cheaper than a sine and a cosine per beam.
#[derive(Clone, Debug)]
pub struct Beams {
    origin: Point,
    directions: Vec<Vector2<f64>>,
    /// The beams divided into ranges, as long as possible, in which each beam is clearly counter-clockwise of the
    /// previous one: by at least 10⁻⁹ rad, so that rounding cannot change the order. Most scanners' beams are one arc.
    /// If a scanner ends where it began, its last beam is a separate arc.
    pub(crate) arcs: Vec<Range<usize>>,
}

impl Beams {
    /// The beams of this scanner.
    #[must_use]
    pub fn new(spec: &LaserSpec) -> Self {
        let direction = |index| {
            let (sin, cos) = libm::sincos(spec.beam_angle_rad(index));
            spec.mount.rotation * Vector2::new(cos, sin)
        };
        Self::from_directions(spec.mount.translation.vector.into(), (0..spec.beams).map(direction).collect())
    }

    /// Beams in any directions, none of them longer than 1.
    pub(crate) fn from_directions(origin: Point, directions: Vec<Vector2<f64>>) -> Self {
        let arcs = arcs(&directions);
        Self { origin, directions, arcs }
    }

    /// Where the beams start.
    #[must_use]
    pub fn origin(&self) -> Point {
        self.origin
    }

    /// Their directions.
    pub fn directions(&self) -> impl ExactSizeIterator<Item = &Vector2<f64>> {
        self.directions.iter()
    }
}

fn arcs(directions: &[Vector2<f64>]) -> Vec<Range<usize>> {
    let turns = |pair: &[Vector2<f64>]| {
        let lengths = (pair[0].norm_squared() * pair[1].norm_squared()).sqrt();
        pair[0].perp(&pair[1]) > 1e-9 * lengths
    };
    let ends = directions.windows(2).enumerate().filter(|(_, pair)| !turns(pair)).map(|(index, _)| index + 1);
    let mut start = 0;
    ends.chain([directions.len()]).map(|end| std::mem::replace(&mut start, end)..end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_end_where_beams_stop_turning_counter_clockwise() {
        let at = |angle_rad: f64| Vector2::new(libm::cos(angle_rad), libm::sin(angle_rad));
        let ends = |angles: &[f64]| {
            let beams = Beams::from_directions(Point::origin(), angles.iter().copied().map(at).collect());
            beams.arcs.iter().map(|arc| arc.end).collect::<Vec<_>>()
        };
        assert_eq!(ends(&[0.0, 1.0, 2.0, 4.0, 6.2, 7.0]), [6]);
        assert_eq!(ends(&[0.0, 1.0, 1.0, 2.0, 1.5]), [2, 4, 5]);
        assert_eq!(ends(&[0.0, 3.2, 3.3]), [1, 3]);
        assert_eq!(ends(&[1.0, 1.0 + 1e-12]), [1, 2]);
        assert_eq!(ends(&[f64::NAN, 1.0]), [1, 2]);
    }
}
