//! The latest scan of a laser, transformed to the robot's current pose.

use std::time::Duration;

use maps::Pose;
use robot::{LaserScan, LaserSpec};

use crate::LocalizationParameters;
use crate::atlas::likelihood_field::Endpoints;
use crate::atlas::rays::Ray;

/// A laser and its latest scan.
#[derive(Clone, Debug)]
pub(crate) struct LaserMemory {
    /// The position of the laser in the robot's frame, in meters.
    mount: [f32; 2],
    /// Cosine and sine of each beam's angle in the robot's frame.
    directions: Vec<[f32; 2]>,
    range_min_m: f32,
    range_max_m: f32,
    surface_depth_m: f32,
    /// To the faces of cells.
    ranges_m: Vec<f32>,
    period: Duration,
    taken: Option<Taken>,
    is_used: bool,
}

/// When and where the latest scan was taken.
#[derive(Clone, Copy, Debug)]
struct Taken {
    time: Duration,
    odometry: Pose,
}

impl LaserMemory {
    pub(crate) fn new(spec: &LaserSpec, parameters: &LocalizationParameters) -> Self {
        let direction = |beam| {
            let unit =
                spec.mount.rotation * nalgebra::Rotation2::new(spec.beam_angle_rad(beam)) * nalgebra::Vector2::x();
            [unit.x as f32, unit.y as f32]
        };
        Self {
            mount: [spec.mount.translation.x as f32, spec.mount.translation.y as f32],
            directions: (0..spec.beams).map(direction).collect(),
            range_min_m: spec.range_min_m.max(parameters.laser_min_range) as f32,
            range_max_m: spec.range_max_m.min(parameters.laser_max_range) as f32,
            surface_depth_m: parameters.surface_depth as f32,
            ranges_m: Vec::with_capacity(spec.beams),
            period: spec.period,
            taken: None,
            is_used: false,
        }
    }

    /// Keeps a scan and the odometry at its time.
    pub(crate) fn keep(&mut self, scan: &LaserScan, odometry: Pose) {
        self.ranges_m.clear();
        let to_the_face = |range_m: &f32| range_m - self.surface_depth_m;
        self.ranges_m.extend(scan.ranges_m.iter().take(self.directions.len()).map(to_the_face));
        self.taken = Some(Taken { time: scan.time, odometry });
        self.is_used = false;
    }

    /// Whether a scan is expected soon, so that an update at `time` should wait for it: the latest is more than half a
    /// period old, but not so old that the laser seems silent. A laser without any scan since the first one, at
    /// `first`, is given one period.
    pub(crate) fn is_due(&self, time: Duration, first: Duration) -> bool {
        let latest = self.taken.map_or(first.saturating_sub(self.period), |taken| taken.time);
        let age = time.saturating_sub(latest);
        age * 2 > self.period && age * 2 <= self.period * 3
    }

    /// Whether there is a scan that no update has used and that was taken at `oldest` or later.
    pub(crate) fn is_fresh(&self, oldest: Duration) -> bool {
        !self.is_used && self.taken.is_some_and(|taken| taken.time >= oldest)
    }

    /// Forgets the latest scan.
    pub(crate) fn forget(&mut self) {
        self.taken = None;
    }

    pub(crate) fn mark_used(&mut self) {
        self.is_used = true;
    }

    /// Every `step`-th beam from `first` on that hit something: its end, in the frame of a robot with odometry `now`.
    /// Beams that hit nothing, failed, or are below the laser's minimum range are left out.
    pub(crate) fn append_ends(&self, now: &Pose, first: usize, step: usize, ends: &mut Endpoints) {
        let Some(taken) = self.taken else { return };
        let moved = now.inv_mul(&taken.odometry);
        let (cos, sin) = (moved.rotation.re as f32, moved.rotation.im as f32);
        let (x0, y0) = (moved.translation.x as f32, moved.translation.y as f32);
        for (range_m, direction) in self.ranges_m.iter().zip(&self.directions).skip(first).step_by(step) {
            if *range_m >= self.range_min_m && *range_m < self.range_max_m {
                let (x, y) = (self.mount[0] + range_m * direction[0], self.mount[1] + range_m * direction[1]);
                ends.push(x0 + cos * x - sin * y, y0 + sin * x + cos * y);
            }
        }
    }

    /// The same beams as rays, including those that hit nothing.
    pub(crate) fn append_rays(&self, now: &Pose, first: usize, step: usize, rays: &mut Vec<Ray>) {
        let Some(taken) = self.taken else { return };
        let moved = now.inv_mul(&taken.odometry);
        let (cos, sin) = (moved.rotation.re as f32, moved.rotation.im as f32);
        let turned = |[x, y]: [f32; 2]| [cos * x - sin * y, sin * x + cos * y];
        let mount = turned(self.mount);
        let eye = [moved.translation.x as f32 + mount[0], moved.translation.y as f32 + mount[1]];
        for (range_m, direction) in self.ranges_m.iter().zip(&self.directions).skip(first).step_by(step) {
            if *range_m >= self.range_min_m {
                let range_m = if *range_m < self.range_max_m { *range_m } else { f32::INFINITY };
                rays.push(Ray { eye, direction: turned(*direction), range_m, range_max_m: self.range_max_m });
            }
        }
    }

    /// The stride with which at most `most` of the laser's beams are used.
    pub(crate) fn stride(&self, most: usize) -> usize {
        self.directions.len().div_ceil(most).max(1)
    }
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    #[test]
    fn surfaces_are_hit_before_the_ends_of_beams_by_their_depth() {
        let spec = robot::RobotModel::default().lasers.swap_remove(0);
        let parameters = LocalizationParameters { surface_depth: 0.025, ..LocalizationParameters::default() };
        let mut memory = LaserMemory::new(&spec, &parameters);
        memory.keep(
            &LaserScan { time: Duration::ZERO, laser: 0, ranges_m: vec![1.0, f32::INFINITY, f32::NAN] },
            pose(0.0, 0.0, 0.0),
        );
        let mut rays = Vec::new();
        memory.append_rays(&pose(0.0, 0.0, 0.0), 0, 1, &mut rays);
        let ranges_m: Vec<f32> = rays.iter().map(|ray| ray.range_m).collect();
        assert_eq!(ranges_m, [0.975, f32::INFINITY]);
    }

    #[test]
    fn ends_are_relative_to_the_robots_current_pose() {
        let spec = LaserSpec {
            name: "back".to_owned(),
            mount: pose(-0.2, 0.0, std::f64::consts::PI),
            angle_min_rad: 0.0,
            angle_increment_rad: std::f64::consts::FRAC_PI_2,
            beams: 4,
            period: Duration::from_millis(100),
            range_min_m: 0.1,
            range_max_m: 10.0,
        };
        let mut memory = LaserMemory::new(&spec, &LocalizationParameters::default());
        let ranges_m = vec![1.0, f32::INFINITY, f32::NAN, f32::NEG_INFINITY, 3.0];
        memory.keep(&LaserScan { time: Duration::from_secs(1), laser: 0, ranges_m }, pose(5.0, 5.0, 0.0));
        let mut ends = Endpoints::default();
        memory.append_ends(&pose(5.5, 5.0, std::f64::consts::FRAC_PI_2), 0, 1, &mut ends);
        assert_eq!(ends.len(), 1, "one beam hit something; the fifth does not exist");
        assert!(ends.x_m[0].abs() < 1e-6 && (ends.y_m[0] - 1.7).abs() < 1e-6, "{ends:?}");
        assert!(memory.is_fresh(Duration::from_secs(1)) && !memory.is_fresh(Duration::from_secs(2)));
        memory.mark_used();
        assert!(!memory.is_fresh(Duration::from_secs(1)));
        let due = |millis| memory.is_due(Duration::from_millis(millis), Duration::ZERO);
        assert_eq!([1000, 1040, 1100, 1140, 1200].map(due), [false, false, true, true, false]);
    }
}
