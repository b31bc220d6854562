//! Laser scanners and their scans.

use std::time::Duration;

use maps::{Point, Pose};

/// A planar laser scanner and its mount on the body.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserSpec {
    /// Name, unique on the robot, for example `front`.
    pub name: String,
    /// Pose of the scanner in `base_link`.
    pub mount: Pose,
    /// Angle of the first beam in the scanner's frame, in radians.
    pub angle_min_rad: f64,
    /// Angle between neighboring beams, in radians; positive, since beams are in counter-clockwise order.
    pub angle_increment_rad: f64,
    /// Number of beams.
    pub beams: usize,
    /// Time between scans.
    pub period: Duration,
    /// Shortest distance that can be measured, in meters.
    pub range_min_m: f64,
    /// Longest distance that can be measured, in meters.
    pub range_max_m: f64,
}

impl LaserSpec {
    /// Angle of beam `index` in the scanner's frame, in radians.
    #[must_use]
    pub fn beam_angle_rad(&self, index: usize) -> f64 {
        self.angle_min_rad + index as f64 * self.angle_increment_rad
    }
}

/// One sweep of a laser scanner.
///
/// Ranges follow ROS REP-117: a distance in meters from the scanner, `+∞` if nothing was hit within range, `−∞` if
/// something was nearer than the shortest range, NaN if the measurement failed.
///
/// ```
/// use std::time::Duration;
/// use maps::pose;
/// use robot::{LaserScan, RobotModel};
///
/// // The front laser's first beam looks backwards to the right, and ends there after 2 m; the others meet nothing.
/// let model = RobotModel::default();
/// let mut ranges_m = vec![f32::INFINITY; model.lasers[0].beams];
/// ranges_m[0] = 2.0;
/// let scan = LaserScan { time: Duration::from_millis(100), laser: 0, ranges_m };
/// let hits: Vec<_> = scan.hits(&model.lasers[scan.laser], &pose(1.0, 5.0, 0.0)).collect();
/// assert_eq!(hits.len(), 1);
/// assert!((hits[0].y - (5.0 - std::f64::consts::SQRT_2)).abs() < 1e-9);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LaserScan {
    /// When the scan was taken.
    pub time: Duration,
    /// Which scanner of [`RobotModel::lasers`](crate::RobotModel::lasers) took it.
    pub laser: usize,
    /// One range per beam, in the order of the beams.
    pub ranges_m: Vec<f32>,
}

impl LaserScan {
    /// The points that the beams hit. `laser` is the scanner that took the scan, `robot` the pose of the robot; the
    /// points are in the frame of that pose.
    pub fn hits<'a>(&'a self, laser: &'a LaserSpec, robot: &Pose) -> impl Iterator<Item = Point> + use<'a> {
        let at = robot * laser.mount;
        let ranges = self.ranges_m.iter().enumerate().filter(|(_, range)| range.is_finite());
        ranges.map(move |(beam, &range)| {
            let (sin, cos) = libm::sincos(laser.beam_angle_rad(beam));
            at * Point::new(f64::from(range) * cos, f64::from(range) * sin)
        })
    }
}
