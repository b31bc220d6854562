//! Where the robot is: adaptive Monte Carlo localization.
//!
//! One algorithm a file: the [likelihood field](likelihood_field), the [motion model](motion_model),
//! [resampling], [KLD sampling](kld), [recovery] by [challengers], [clusters], [scan matching](scan_matching), the
//! [beam model](beam_model), the [search] for a robot that may be anywhere, and the [contradiction] that says that one is
//! lost; the [filter] puts them together, and [`Localization`] connects it with odometry, scans and frames.

mod beam_model;
mod challengers;
mod clusters;
mod contradiction;
mod filter;
mod free_space;
mod kld;
mod laser_memory;
mod likelihood_field;
mod motion_model;
mod odometry_history;
mod odometry_trust;
mod parameters;
mod particle;
mod recovery;
mod resampling;
mod scan_matching;
mod search;
mod sensor_model;
mod surface_field;

use std::sync::Arc;
use std::time::Duration;

use maps::{OccupancyGrid, Pose, heading, pose};
use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;
use robot::{LaserScan, Odometry, RobotModel};

use crate::{Atlas, Error};
use beam_model::Ray;
use clusters::Clusters;
use contradiction::{Contradiction, contradict};
use filter::ParticleFilter;
use laser_memory::LaserMemory;
use likelihood_field::Endpoints;
use motion_model::DifferentialMotion;
use odometry_history::OdometryHistory;
use odometry_trust::OdometryTrust;
use particle::{Gaussian, Particle};
use search::Search;

pub(crate) use beam_model::BeamModel;
pub(crate) use free_space::FreeSpace;
pub(crate) use likelihood_field::LikelihoodField;
pub use parameters::{LaserModel, LocalizationParameters};
pub use sensor_model::SensorModel;
pub(crate) use surface_field::SurfaceField;

/// Scans of the other lasers join an update if they are at most so old.
const OLDEST_SCAN: Duration = Duration::from_millis(250);

/// A beam that hits nothing has been free for this share of the laser's range.
const SILENT_SHARE: f64 = 0.9;

/// Beams of each scan that are matched to the map, as a multiple of those that weigh the particles.
const MATCHED_BEAMS: usize = 3;

/// Where a robot is believed to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// The time of which it speaks: that of the latest odometry.
    pub time: Duration,
    /// The pose of `base_link` in the `map` frame.
    pub pose: Pose,
    /// Covariance of x, y (metres, `map` frame) and heading (radians).
    ///
    /// It says what the scan leaves open, judged by how well it fits, and what odometry has added since, judged by how
    /// far scans have of late corrected it. On simulated drives the squared error in its units (NEES, 3 if it were exact)
    /// is about 4, so that deviations are 15 % too small; among much furniture that is not on the map about 8, since what
    /// misleads beams does so for metres. Where the map itself is wrong, it knows nothing of it.
    pub covariance: Matrix3<f64>,
}

/// A place where the robot may be: a cluster of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// The mean pose of `base_link` in the `map` frame.
    pub pose: Pose,
    /// Covariance of x, y (metres, `map` frame) and heading (radians).
    pub covariance: Matrix3<f64>,
    /// How likely it is: the share of the particles' weight, from 0 to 1.
    pub weight: f64,
}

/// What is known of the pose before the first scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InitialPose {
    /// Near a pose in the `map` frame.
    Near {
        /// The pose.
        pose: Pose,
        /// Covariance of x, y (metres) and heading (radians).
        covariance: Matrix3<f64>,
    },
    /// Anywhere in the map's free space.
    Anywhere,
}

impl InitialPose {
    /// A pose that is known to within 5 cm and 3° (standard deviations).
    #[must_use]
    pub fn at(pose: Pose) -> Self {
        Self::Near { pose, covariance: Matrix3::from_diagonal(&nalgebra::Vector3::new(2.5e-3, 2.5e-3, 2.7e-3)) }
    }
}

/// Adaptive Monte Carlo localization on an occupancy grid.
///
/// A particle filter with a choice of [sensor models](LaserModel), an odometry motion model, an adaptive number of
/// particles (KLD sampling), selective systematic resampling and recovery from a lost pose. The estimate is the mean of
/// the heaviest cluster of particles, matched to the scan, and carried on by odometry between updates.
///
/// A robot that may be [anywhere](InitialPose::Anywhere) is sought with hypotheses, each matched to every scan, until one
/// is far ahead of all others. The estimate then is the best of them, its covariance that of all, and the particles are
/// the hypotheses.
///
/// Updates happen with the first scan, and then with the first scan after the robot has driven or turned far enough,
/// as soon as each laser that is not silent has delivered one. A robot at rest costs next to nothing, and its estimate
/// stays as it is. In steady state no memory is allocated.
///
/// A robot that has been carried away is found again in two ways: while it drives, by poses elsewhere that scans fit
/// better for some way; and, as soon as beams go on going through walls of the map, also at rest, by a search as for one
/// that may be anywhere.
///
/// Randomness comes from the stream given to [`new`](Self::new) alone; no clock is read.
#[derive(Clone, Debug)]
pub struct Localization {
    atlas: Arc<Atlas>,
    filter: ParticleFilter,
    lasers: Vec<LaserMemory>,
    odometry: OdometryHistory,
    /// The search for a robot that may be anywhere, until it has been found.
    search: Option<Box<Search>>,
    contradiction: Contradiction,
    trust: OdometryTrust,
    /// The estimate at the last update, in the grid's frame.
    belief: Gaussian,
    /// Odometry at the last update; before the first one, the first odometry.
    anchor: Option<Pose>,
    updates: u64,
    /// When the first scan was taken.
    first_scan: Option<Duration>,
    /// Ends of the beams that weigh particles, and of those that are matched; kept for their memory.
    weighed: Endpoints,
    matched: Endpoints,
    /// The beams that weigh particles in the beam model, and that contradict poses.
    rays: Vec<Ray>,
}

impl Localization {
    /// A localization of a robot on a map, with its stream of random numbers. Where there will be several on one map,
    /// make an [`Atlas`] of it and use [`on`](Self::on).
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter makes no sense; [`Error::NoFreeSpace`] if the map has no free cell.
    pub fn new(
        map: &OccupancyGrid,
        model: &RobotModel,
        parameters: LocalizationParameters,
        initial: &InitialPose,
        rng: ChaCha8Rng,
    ) -> Result<Self, Error> {
        let atlas = Atlas::new(Arc::new(map.clone()), model, parameters)?;
        Ok(Self::on(&Arc::new(atlas), initial, rng))
    }

    /// A localization of the atlas's robot on its map, with its stream of random numbers.
    #[must_use]
    pub fn on(atlas: &Arc<Atlas>, initial: &InitialPose, rng: ChaCha8Rng) -> Self {
        let belief = Gaussian { x_m: 0.0, y_m: 0.0, heading_rad: 0.0, covariance: Matrix3::zeros() };
        let mut localization = Self {
            atlas: Arc::clone(atlas),
            filter: ParticleFilter::new(atlas, rng),
            lasers: atlas.model().lasers.iter().map(|laser| LaserMemory::new(laser, atlas.parameters())).collect(),
            odometry: OdometryHistory::new(),
            search: None,
            contradiction: Contradiction::default(),
            trust: OdometryTrust::new(),
            belief,
            anchor: None,
            updates: 0,
            first_scan: None,
            weighed: Endpoints::default(),
            matched: Endpoints::default(),
            rays: Vec::new(),
        };
        localization.restart(initial);
        localization
    }

    /// Forgets the pose and starts again from what is said to be known of it, now.
    pub fn restart(&mut self, initial: &InitialPose) {
        let origin = self.origin();
        match initial {
            InitialPose::Near { pose, covariance } => {
                let (pose, covariance) = (origin.inv_mul(pose), turned(covariance, -heading(&origin)));
                self.belief = gaussian(&pose, covariance);
                self.filter.place_around(&self.belief);
                self.search = None;
            }
            InitialPose::Anywhere => {
                self.filter.place_anywhere();
                self.belief = self.filter.estimate();
                self.search = Some(Box::default());
            }
        }
        self.anchor = self.odometry.latest().map(|odometry| odometry.pose);
        self.updates = 0;
        self.contradiction.forget();
        self.trust = OdometryTrust::new();
    }

    /// Takes in odometry. Readings come in the order of their time.
    pub fn odometry(&mut self, odometry: &Odometry) {
        self.odometry.push(*odometry);
        self.anchor.get_or_insert(odometry.pose);
    }

    /// Takes in a scan, after the odometry of its time if there is any, and updates the estimate if the robot has
    /// moved far enough. Returns whether it did.
    ///
    /// Scans before the first odometry and scans of lasers that the model does not have are ignored; so are beams
    /// that are not finite, not within the laser's range, or more than the laser has.
    pub fn scan(&mut self, scan: &LaserScan) -> bool {
        let (Some(now), Some(anchor)) = (self.odometry.pose_at(scan.time), self.anchor) else { return false };
        let Some(laser) = self.lasers.get_mut(scan.laser) else { return false };
        laser.keep(scan, now);
        let moved = anchor.inv_mul(&now);
        let far = moved.translation.vector.norm() >= self.parameters().update_min_d
            || heading(&moved).abs() >= self.parameters().update_min_a;
        let first = *self.first_scan.get_or_insert(scan.time);
        let is_due = |(index, laser): (usize, &LaserMemory)| index != scan.laser && laser.is_due(scan.time, first);
        if self.lasers.iter().enumerate().any(is_due) {
            return false;
        }
        let is_lost = self.updates > 0 && self.search.is_none() && self.is_lost(scan.time, &moved, !far);
        if !far && self.updates > 0 && !is_lost && !self.search.as_ref().is_some_and(|search| search.begins()) {
            return false;
        }
        self.collect_ends(scan.time, &now);
        if is_lost && self.begin_search(&moved, now) {
            return true;
        }
        if is_lost && !far {
            return false;
        }
        self.update(&anchor, now);
        true
    }

    /// Begins to seek the robot everywhere, after a motion, if the scan fits somewhere else.
    fn begin_search(&mut self, moved: &Pose, now: Pose) -> bool {
        self.contradiction.forget();
        let Some((search, belief)) = self.filter.seek_elsewhere(&self.belief, moved, &self.matched) else {
            return false;
        };
        (self.search, self.belief, self.anchor) = (Some(Box::new(search)), belief, Some(now));
        self.updates += 1;
        true
    }

    /// Whether scans have for some time contradicted the belief, carried on by a motion.
    fn is_lost(&mut self, time: Duration, moved: &Pose, is_at_rest: bool) -> bool {
        if !self.contradiction.is_due(time) {
            return false;
        }
        let Some(now) = self.odometry.pose_at(time) else { return false };
        self.rays.clear();
        for laser in self.lasers.iter().filter(|laser| laser.is_fresh(time.saturating_sub(OLDEST_SCAN))) {
            laser.append_rays(&now, 0, laser.stride(self.atlas.parameters().max_beams), &mut self.rays);
        }
        let at = pose(self.belief.x_m, self.belief.y_m, self.belief.heading_rad) * moved;
        let at = Particle::new(at.translation.x, at.translation.y, heading(&at));
        self.contradiction.look(time, is_at_rest, self.atlas.map(), &at, &self.rays)
    }

    /// The latest estimate of the pose, carried on by the odometry since. Before any scan, what was given initially.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let believed = pose(self.belief.x_m, self.belief.y_m, self.belief.heading_rad);
        let (Some(latest), Some(anchor)) = (self.odometry.latest(), self.anchor) else {
            return self.in_map_frame(Duration::ZERO, &believed, &self.belief.covariance);
        };
        let motion = DifferentialMotion::between(&anchor, &latest.pose, self.alphas());
        let noise = motion.propagate(self.belief.heading_rad, &Matrix3::zeros());
        let all = motion.propagate(self.belief.heading_rad, &self.belief.covariance);
        let covariance = all + noise * (self.trust.share() - 1.0);
        self.in_map_frame(latest.time, &(believed * anchor.inv_mul(&latest.pose)), &covariance)
    }

    /// The particles as poses in the `map` frame with their normalized weights.
    pub fn particles(&self) -> impl ExactSizeIterator<Item = (Pose, f64)> {
        let origin = self.origin();
        let in_map = move |particle: &Particle| origin * pose(particle.x_m, particle.y_m, particle.heading_rad);
        self.filter.particles().iter().map(move |particle| (in_map(particle), particle.weight))
    }

    /// Where the robot may be, likeliest first: the clusters of the particles. Several while a robot is sought, or where
    /// two places look alike.
    #[must_use]
    pub fn hypotheses(&self) -> Vec<Hypothesis> {
        let mut clusters = Clusters::default();
        clusters.assign(self.filter.particles());
        let origin = self.origin();
        let in_map = |(weight, at): (f64, Gaussian)| Hypothesis {
            pose: origin * pose(at.x_m, at.y_m, at.heading_rad),
            covariance: turned(&at.covariance, heading(&origin)),
            weight,
        };
        clusters.all(self.filter.particles()).into_iter().map(in_map).collect()
    }

    /// How much speaks against the estimate, from 0 (nothing) to 1: how far scans have of late been less likely than
    /// they usually are. 1 while a robot that may be anywhere has not been found.
    ///
    /// A robot that has been carried away, or whose map is out of date, shows it here before it is found elsewhere.
    #[must_use]
    pub fn doubt(&self) -> f64 {
        if self.search.is_some() { 1.0 } else { self.filter.doubt() }
    }

    /// How many updates there have been since the start or the last [`restart`](Self::restart).
    #[must_use]
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Sees the latest scans from the robot's present pose: a few beams of each to weigh particles, more to match.
    fn collect_ends(&mut self, time: Duration, now: &Pose) {
        self.weighed.clear();
        self.matched.clear();
        self.rays.clear();
        let casts = self.parameters().laser_model_type == LaserModel::Beam || self.filter.is_challenged();
        for laser in self.lasers.iter_mut().filter(|laser| laser.is_fresh(time.saturating_sub(OLDEST_SCAN))) {
            let stride = laser.stride(self.atlas.parameters().max_beams);
            // Other beams each time, so that all have their say.
            laser.append_ends(now, self.updates as usize % stride, stride, &mut self.weighed);
            if casts {
                laser.append_rays(now, self.updates as usize % stride, stride, &mut self.rays);
            }
            let stride = laser.stride(MATCHED_BEAMS * self.atlas.parameters().max_beams);
            laser.append_ends(now, self.updates as usize % stride, stride, &mut self.matched);
            laser.mark_used();
        }
    }

    fn update(&mut self, anchor: &Pose, now: Pose) {
        match self.search.take() {
            Some(search) => self.seek(search, &anchor.inv_mul(&now)),
            None => self.track(anchor, &now),
        }
        self.anchor = Some(now);
        self.updates += 1;
    }

    /// An update of a robot that may be anywhere.
    fn seek(&mut self, mut search: Box<Search>, moved: &Pose) {
        // Every beam counts to find the places that fit at all; to tell them apart, fewer do.
        let ends = if search.begins() { &self.matched } else { &self.weighed };
        let sought = self.filter.seek(&mut search, moved, ends);
        let is_over = sought.is_some_and(|(_, is_over)| is_over);
        if let Some((belief, _)) = sought {
            self.belief = belief;
        }
        if !is_over {
            self.search = Some(search);
        }
        self.contradiction.forget();
    }

    /// An update of a robot whose place is known.
    fn track(&mut self, anchor: &Pose, now: &Pose) {
        let motion = DifferentialMotion::between(anchor, now, self.alphas());
        self.filter.predict(&motion);
        self.filter.weigh(&self.weighed, &self.rays);
        let mean = self.filter.estimate();
        let matched = scan_matching::matched(&mean, &self.matched, &self.atlas.surfaces);
        let independent = self.parameters().independent_beams;
        let surfaces = &self.atlas.surfaces;
        let covariance = scan_matching::remaining_covariance(&mean, &matched, &self.matched, surfaces, independent);
        let before = std::mem::replace(&mut self.belief, Gaussian { covariance, ..matched });
        self.judge_odometry(&before, &motion, &anchor.inv_mul(now));
        let (map, rays) = (self.atlas.map(), self.rays.as_slice());
        let silent_m = SILENT_SHARE * self.range_max_m();
        let is_contradicted = |at: &Gaussian, silent_m: Option<f64>| {
            contradict(map, &Particle::new(at.x_m, at.y_m, at.heading_rad), rays, silent_m)
        };
        // Where lasers fail, the belief has the benefit of the doubt.
        let may_win = |at: &Gaussian| is_contradicted(&self.belief, None) && !is_contradicted(at, Some(silent_m));
        match self.filter.challenge(&self.belief, &anchor.inv_mul(now), &self.weighed, &may_win) {
            None => self.filter.resample_if_needed(&self.belief),
            Some(found) => {
                self.filter.place_around(&found);
                self.belief = found;
            }
        }
    }

    /// Learns from how far the update has moved the belief from where odometry had carried the one before.
    fn judge_odometry(&mut self, before: &Gaussian, motion: &DifferentialMotion, moved: &Pose) {
        let carried = pose(before.x_m, before.y_m, before.heading_rad) * moved;
        let turn_rad = maps::wrap_angle(self.belief.heading_rad - heading(&carried));
        let off =
            Vector3::new(self.belief.x_m - carried.translation.x, self.belief.y_m - carried.translation.y, turn_rad);
        let noise = motion.propagate(before.heading_rad, &Matrix3::zeros());
        let poses = motion.propagate(before.heading_rad, &before.covariance) - noise + self.belief.covariance;
        self.trust.observe(&off, &noise, &poses);
    }

    /// The range of the laser that reaches least far, in metres.
    fn range_max_m(&self) -> f64 {
        let ranges_m = self.atlas.model().lasers.iter().map(|laser| laser.range_max_m);
        ranges_m.fold(self.parameters().laser_max_range, f64::min)
    }

    fn alphas(&self) -> [f64; 4] {
        let parameters = self.parameters();
        [parameters.alpha1, parameters.alpha2, parameters.alpha3, parameters.alpha4]
    }

    fn in_map_frame(&self, time: Duration, in_grid: &Pose, covariance: &Matrix3<f64>) -> PoseEstimate {
        let origin = self.origin();
        PoseEstimate { time, pose: origin * in_grid, covariance: turned(covariance, heading(&origin)) }
    }

    fn parameters(&self) -> &LocalizationParameters {
        self.atlas.parameters()
    }

    /// Origin of the map: the pose of the grid's frame, in which the filter works.
    fn origin(&self) -> Pose {
        self.atlas.map().origin()
    }
}

fn gaussian(at: &Pose, covariance: Matrix3<f64>) -> Gaussian {
    Gaussian { x_m: at.translation.x, y_m: at.translation.y, heading_rad: heading(at), covariance }
}

/// The covariance of x, y and heading in a frame that is turned by `-angle_rad`.
fn turned(covariance: &Matrix3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let rotation = nalgebra::Rotation2::new(angle_rad).to_homogeneous();
    rotation * covariance * rotation.transpose()
}
