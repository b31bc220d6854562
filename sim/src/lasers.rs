//! The laser scanners.

mod troubles;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use maps::Pose;
use parry2d::query::Ray;
use rand_chacha::ChaCha8Rng;
use robot::{LaserScan, LaserSpec, Reading, Streams, normal};

use crate::beams::Beams;
use crate::building::Building;
use crate::clock::{Clock, Periodic};
use crate::config::LaserConfig;
use crate::convert::{LocalFrame, to_glam};
use crate::faults::Faults;
use crate::motion::RobotPose;
use crate::obstacles::{Obstacle, ObstaclePose};
use crate::readings::Readings;
use crate::walls::ScanMemory;
use troubles::{TroubleStreams, Troubles};

#[derive(Component, Clone, Debug)]
pub(crate) struct Laser {
    /// Its index in the robot's model.
    index: usize,
    spec: LaserSpec,
    beams: Beams,
    /// The scanner's displacement from its `spec`.
    displacement: Option<Pose>,
    range_sigma_m: f64,
    rng: ChaCha8Rng,
    trouble_streams: TroubleStreams,
    due: Periodic,
    /// Distances of the current scan; kept to reuse the memory.
    distances_m: Vec<f64>,
    memory: ScanMemory,
    /// The last scan; `None` if the scanner is dead.
    pub(crate) latest: Option<Arc<LaserScan>>,
}

impl Laser {
    pub(crate) fn new(index: usize, spec: &LaserSpec, config: &LaserConfig, streams: &Streams) -> Self {
        Self {
            index,
            spec: spec.clone(),
            beams: Beams::new(spec),
            displacement: None,
            range_sigma_m: config.range_sigma_m,
            rng: streams.stream(&format!("sim/laser_{}", spec.name)),
            trouble_streams: TroubleStreams::new(streams, &spec.name),
            due: Periodic::new(spec.period),
            distances_m: Vec::with_capacity(spec.beams),
            memory: ScanMemory::default(),
            latest: None,
        }
    }

    /// Mounts the scanner with this displacement.
    fn sit(&mut self, displacement: Option<Pose>) {
        if self.displacement != displacement {
            let mount = displacement.map_or(self.spec.mount, |displacement| self.spec.mount * displacement);
            self.beams = Beams::new(&LaserSpec { mount, ..self.spec.clone() });
            self.displacement = displacement;
        }
    }

    /// The scanner's ranges for the true distances. Its own noise is drawn even if it has troubles.
    fn measure(&mut self, troubles: &Troubles) -> Vec<f32> {
        let Self { spec, rng, range_sigma_m, trouble_streams, distances_m, .. } = self;
        if *range_sigma_m > 0.0 {
            // Every beam draws, so the noise of a beam does not depend on what other beams hit.
            distances_m.iter_mut().for_each(|distance_m| *distance_m += *range_sigma_m * normal(rng));
        }
        troubles.spoil(trouble_streams, distances_m);
        distances_m.iter().map(|distance_m| classify(*distance_m, spec)).collect()
    }

    /// The scanner's scan, if it gives one.
    fn report(&mut self, troubles: &Troubles, clock: &Clock) -> Option<Arc<LaserScan>> {
        let mut ranges_m = self.measure(troubles);
        if let Some(last) = self.latest.take_if(|_| troubles.stuck) {
            ranges_m.clone_from(&last.ranges_m);
        }
        let scan = || Arc::new(LaserScan { time: clock.now, laser: self.index, ranges_m });
        self.latest = (!troubles.dead).then(scan);
        self.latest.clone()
    }
}

/// A distance as a range of REP-117: infinite beyond the longest range, negative infinite below the shortest.
fn classify(distance_m: f64, spec: &LaserSpec) -> f32 {
    if distance_m > spec.range_max_m {
        f32::INFINITY
    } else if distance_m < spec.range_min_m {
        f32::NEG_INFINITY
    } else {
        distance_m as f32
    }
}

/// Shortens the distances of the beams that hit an obstacle first. `base` is the robot's pose; rays are cast in
/// `frame`.
fn see_obstacle(
    frame: &LocalFrame,
    beams: &Beams,
    base: &Pose,
    obstacle: &Obstacle,
    pose: &Pose,
    range_max_m: f64,
    distances_m: &mut [f64],
) {
    let origin = base * beams.origin();
    let offset = pose.translation.vector - origin.coords;
    let radius_m = obstacle.shape.bounding_radius_m();
    if offset.norm() > range_max_m + radius_m {
        return;
    }
    let (glam_origin, glam_pose) = (frame.point_to_glam(&origin), frame.pose_to_glam(pose));
    for (direction, distance_m) in beams.directions().zip(distances_m) {
        let direction = base.rotation * direction;
        // Rays against outlines are the costly part of a scan, and most beams miss even the disc around an obstacle.
        let passes_by = offset.perp(&direction).abs() > radius_m || offset.dot(&direction) < -radius_m;
        if passes_by {
            continue;
        }
        let ray = Ray::new(glam_origin, to_glam(direction));
        let farthest_m = distance_m.min(range_max_m) as f32;
        if let Some(hit_m) = obstacle.outline.cast_ray(&glam_pose, &ray, farthest_m, true) {
            *distance_m = distance_m.min(f64::from(hit_m));
        }
    }
}

/// Takes the scans that are due.
pub(crate) fn scan(
    clock: Res<Clock>,
    faults: Res<Faults>,
    building: Res<Building>,
    mut readings: ResMut<Readings>,
    robot: Single<&RobotPose>,
    obstacles: Query<(&Obstacle, &ObstaclePose)>,
    mut lasers: Query<&mut Laser>,
) {
    let (base, frame) = (robot.0, building.frame);
    for mut laser in &mut lasers {
        let laser = &mut *laser;
        if !laser.due.is_due(clock.now) {
            continue;
        }
        let troubles = Troubles::of(&faults.lasers, &laser.spec.name);
        laser.sit(troubles.displacement);
        let range_max_m = laser.spec.range_max_m;
        building.walls().ranges(&laser.beams, &base, range_max_m, &mut laser.memory, &mut laser.distances_m);
        for (obstacle, pose) in &obstacles {
            see_obstacle(&frame, &laser.beams, &base, obstacle, &pose.0, range_max_m, &mut laser.distances_m);
        }
        // Walls and bodies are the true distances of the world; what only the scanner sees comes last.
        troubles.see_ghosts(&laser.spec, &mut laser.distances_m);
        readings.extend(laser.report(&troubles, &clock).map(Reading::Scan));
    }
}

#[cfg(test)]
mod tests {
    use robot::RobotModel;

    use super::*;

    #[test]
    fn distances_beyond_the_limits_are_infinite() {
        let spec = &RobotModel::default().lasers[0];
        assert_eq!(classify(0.0999, spec), f32::NEG_INFINITY);
        assert_eq!(classify(0.1, spec), 0.1);
        assert_eq!(classify(10.0, spec), 10.0);
        assert_eq!(classify(10.001, spec), f32::INFINITY);
        assert_eq!(classify(f64::INFINITY, spec), f32::INFINITY);
    }

    #[test]
    fn noise_has_the_configured_spread_and_does_not_affect_misses() {
        let spec = LaserSpec { beams: 20_000, ..RobotModel::default().lasers[0].clone() };
        let mut laser = Laser::new(0, &spec, &LaserConfig { range_sigma_m: 0.01 }, &Streams::new(5));
        laser.distances_m = vec![2.0; 20_000];
        laser.distances_m[7] = f64::INFINITY;
        let ranges = laser.measure(&Troubles::default());
        assert_eq!(ranges[7], f32::INFINITY);
        let errors = ranges.iter().filter(|range| range.is_finite()).map(|range| f64::from(*range) - 2.0);
        let sigma = (errors.map(|error| error * error).sum::<f64>() / 19_999.0).sqrt();
        assert!((sigma - 0.01).abs() < 2e-4, "{sigma}");
    }
}
