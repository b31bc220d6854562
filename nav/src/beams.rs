//! A laser's beams with precomputed directions.

use maps::{Point, Pose};
use nalgebra::Vector2;
use robot::{LaserScan, LaserSpec};

/// A laser and the unit vector of each of its beams in its frame.
#[derive(Clone, Debug)]
pub(crate) struct Beams {
    pub(crate) spec: LaserSpec,
    directions: Vec<Vector2<f64>>,
}

impl Beams {
    pub(crate) fn new(spec: &LaserSpec) -> Self {
        let direction = |beam| {
            let (sin, cos) = libm::sincos(spec.beam_angle_rad(beam));
            Vector2::new(cos, sin)
        };
        Self { directions: (0..spec.beams).map(direction).collect(), spec: spec.clone() }
    }

    /// The pose of the laser when the robot is at `robot`, in the frame of that pose.
    pub(crate) fn eye(&self, robot: &Pose) -> Pose {
        robot * self.spec.mount
    }

    /// The ends of the beams shorter than `farthest_m`, lengthened by `behind_m`, in the frame of `eye`. A hit too near
    /// to be measured counts as one at `nearest_m`; failed beams and beams beyond the model are left out.
    pub(crate) fn ends(
        &self,
        scan: &LaserScan,
        eye: Pose,
        nearest_m: f64,
        farthest_m: f64,
        behind_m: f64,
    ) -> impl Iterator<Item = Point> {
        let farthest_m = farthest_m.min(self.spec.range_max_m) as f32;
        let near = scan.ranges_m.iter().zip(&self.directions).filter(move |(range_m, _)| **range_m < farthest_m);
        near.map(move |(range_m, direction)| {
            let measured_m = f64::from(*range_m);
            let reach_m = if measured_m < self.spec.range_min_m { nearest_m } else { measured_m } + behind_m;
            eye * Point::from(direction * reach_m)
        })
    }
}
