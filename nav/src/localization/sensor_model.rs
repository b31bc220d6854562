//! The sensor model alone, for tools that evaluate how well a scan fits a map.

use std::sync::Arc;

use maps::Pose;
use robot::LaserScan;

use super::laser_memory::LaserMemory;
use crate::Atlas;
use crate::atlas::likelihood_field::Endpoints;
use crate::particle::Particle;

/// The likelihood of a scan, seen from a pose: the likelihood field that weights
/// [`Localization`](crate::Localization)'s particles.
///
/// ```
/// use std::sync::Arc;
/// use std::time::Duration;
///
/// use maps::pose;
/// use nav::{Atlas, LocalizationParameters, SensorModel};
/// use robot::{LaserScan, RobotModel};
///
/// let map = Arc::new(maps::house::draw());
/// let atlas = Arc::new(Atlas::new(map, &RobotModel::default(), LocalizationParameters::default())?);
/// let mut sensor = SensorModel::new(&atlas);
/// sensor.look(&LaserScan { time: Duration::ZERO, laser: 0, ranges_m: vec![1.5; 360] });
/// assert!(sensor.nats(&pose(0.0, 0.0, 0.0)) <= 0.0);
/// # Ok::<(), nav::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct SensorModel {
    atlas: Arc<Atlas>,
    lasers: Vec<LaserMemory>,
    ends: Endpoints,
}

impl SensorModel {
    /// The sensor model of the atlas's robot on its map, without a scan.
    #[must_use]
    pub fn new(atlas: &Arc<Atlas>) -> Self {
        let memory = |laser| LaserMemory::new(laser, atlas.parameters());
        let lasers = atlas.model().lasers.iter().map(memory).collect();
        Self { atlas: Arc::clone(atlas), lasers, ends: Endpoints::default() }
    }

    /// Replaces the scan: uses `max_beams` of its beams, evenly spread. Scans of lasers that the robot does not have
    /// are ignored.
    pub fn look(&mut self, scan: &LaserScan) {
        let Some(laser) = self.lasers.get_mut(scan.laser) else { return };
        laser.keep(scan, Pose::identity());
        self.ends.clear();
        laser.append_ends(&Pose::identity(), 0, laser.stride(self.atlas.parameters().max_beams), &mut self.ends);
    }

    /// The number of effective beams of the scan: those that hit something.
    #[must_use]
    pub fn beams(&self) -> usize {
        self.ends.len()
    }

    /// The log-likelihood of the scan's beams, seen from a pose of `base_link` in the `map` frame: a sum over the beams
    /// in nats, each 0 at best. No memory is allocated.
    #[must_use]
    pub fn nats(&self, pose: &Pose) -> f64 {
        let at = self.atlas.map().origin().inv_mul(pose);
        let (position, rotation) = (at.translation, at.rotation);
        let particle = Particle {
            x_m: position.x,
            y_m: position.y,
            // The field only uses its cosine and sine.
            heading_rad: 0.0,
            cos: rotation.re,
            sin: rotation.im,
            weight: 1.0,
        };
        let field = &self.atlas.likelihoods;
        -f64::from(field.penalty(&particle, &self.ends)) * field.nats_per_unit()
    }
}
