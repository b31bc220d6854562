//! Adaptive Monte Carlo localization.
//!
//! There is one algorithm per file: the [likelihood field](crate::atlas::likelihood_field), the
//! [motion model](motion_model), [resampling], [KLD sampling](kld), [recovery] by [challengers], [clusters],
//! [scan matching](scan_matching), [rays](crate::atlas::rays), the [search] for a robot that may be anywhere, the
//! [contradiction] that detects a robot that may be lost, and the [reconsideration] that decides what to do about it.
//! The [filter] combines them, and [`Localization`] connects it with odometry, scans and frames.

mod challengers;
mod clusters;
mod contradiction;
mod filter;
mod kld;
mod laser_memory;
mod motion_model;
mod odometry_history;
mod odometry_trust;
mod reconsideration;
mod recovery;
mod resampling;
mod scan_matching;
mod search;

use std::sync::Arc;
use std::time::Duration;

use maps::{OccupancyGrid, Pose, heading, pose};
use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;
use robot::{LaserScan, Odometry, RobotModel};

use crate::atlas::likelihood_field::Endpoints;
use crate::atlas::rays::Ray;
use crate::particle::{Gaussian, Particle, after};
use crate::{Atlas, Error, LocalizationParameters};
use clusters::Clusters;
use contradiction::{Contradiction, Look, Silent};
use filter::ParticleFilter;
use laser_memory::LaserMemory;
use motion_model::DifferentialMotion;
use odometry_history::OdometryHistory;
use odometry_trust::OdometryTrust;
use search::Search;

/// Scans of the other lasers join an update if they are at most this old.
const OLDEST_SCAN: Duration = Duration::from_millis(250);

/// Beams of each scan that are matched to the map, as a multiple of those that weight the particles.
const MATCHED_BEAMS: usize = 3;

/// An estimate of the robot's pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// The time of the estimate: that of the latest odometry.
    pub time: Duration,
    /// The pose of `base_link` in the `map` frame.
    pub pose: Pose,
    /// Covariance of x, y (meters, `map` frame) and heading (radians).
    ///
    /// It covers the uncertainty that the scan leaves, judged by how well it fits, and the drift of odometry since
    /// then, judged by how far recent scans have corrected it. On simulated drives, the normalized squared error (NEES,
    /// 3 if it were exact) is about 4, so deviations are 15 % too small. Among much unmapped furniture it is about 8,
    /// because beams are misled consistently for meters. Errors of the map itself are not covered.
    pub covariance: Matrix3<f64>,
}

/// A possible pose of the robot: a cluster of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// The mean pose of `base_link` in the `map` frame.
    pub pose: Pose,
    /// Covariance of x, y (meters, `map` frame) and heading (radians).
    pub covariance: Matrix3<f64>,
    /// Its probability: the share of the particles' weight, from 0 to 1.
    pub weight: f64,
}

/// What is known about the pose before the first scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InitialPose {
    /// Near a pose in the `map` frame.
    Near {
        /// The pose.
        pose: Pose,
        /// Covariance of x, y (meters) and heading (radians).
        covariance: Matrix3<f64>,
    },
    /// Anywhere in the map's free space.
    Anywhere,
}

impl InitialPose {
    /// Near a pose in the `map` frame, with the covariance of x, y (meters) and heading (radians).
    #[must_use]
    pub fn near(pose: Pose, covariance: [[f64; 3]; 3]) -> Self {
        Self::Near { pose, covariance: covariance.into() }
    }

    /// A pose known to within 5 cm and 3° (standard deviations).
    #[must_use]
    pub fn at(pose: Pose) -> Self {
        Self::Near { pose, covariance: Matrix3::from_diagonal(&nalgebra::Vector3::new(2.5e-3, 2.5e-3, 2.7e-3)) }
    }
}

/// Adaptive Monte Carlo localization on an occupancy grid.
///
/// A particle filter with a likelihood field as its sensor model, an odometry motion model, an adaptive number of
/// particles (KLD sampling), selective systematic resampling and recovery from a lost pose. The estimate is the mean of
/// the heaviest cluster of particles, matched to the scan, and updated by odometry between scans.
///
/// A robot that may be [anywhere](InitialPose::Anywhere) is located with hypotheses, each matched to every scan, until
/// one is far ahead of all others. Until then the estimate is the best of them, its covariance is that of all, and the
/// particles are the hypotheses.
///
/// Updates happen with the first scan, and then with the first scan after the robot has driven or turned far enough, as
/// soon as each laser that is not silent has delivered one. A robot at rest needs almost no computation, and its
/// estimate stays constant. In steady state no memory is allocated.
///
/// A kidnapped robot is found again in three ways: while it drives, by poses elsewhere that fit the scans better over
/// some distance; if beams persistently pass through walls of the map, even at rest, by a global search; and if nearly
/// all beams are too short, by such a search as well. These searches run in parallel to tracking, because beams also
/// pass through walls that have been removed, and are too short when people surround the robot or a door closes in
/// front of it. So the estimate stays, with a high doubt, unless another place explains the scans far better over some
/// distance or, if beams are short, explains nearly every beam for ten seconds. Even then, the estimate returns if it
/// turns out to have been right.
///
/// Randomness comes only from the stream given to [`new`](Self::new); no clock is read.
///
/// ```
/// use std::time::Duration;
/// use maps::{Cell, OccupancyGrid, pose};
/// use nav::{InitialPose, Localization, LocalizationParameters};
/// use robot::{Odometry, RobotModel, Streams};
///
/// let map = OccupancyGrid::from_cells(100, 100, 0.05, pose(0.0, 0.0, 0.0), vec![Cell::Free; 10_000]);
/// let start = InitialPose::at(pose(1.0, 2.0, 0.0));
/// let rng = Streams::new(1).stream("localization");
/// let mut localization =
///     Localization::new(&map, &RobotModel::default(), LocalizationParameters::default(), &start, rng)?;
///
/// // According to the wheels, the robot has driven half a meter; a scan would correct them.
/// let odometry = |time_s, x_m| Odometry {
///     time: Duration::from_secs(time_s), pose: pose(x_m, 0.0, 0.0), linear_mps: 0.5, angular_radps: 0.0,
/// };
/// localization.odometry(&odometry(0, 7.0));
/// localization.odometry(&odometry(1, 7.5));
/// assert!((localization.estimate().pose.translation.x - 1.5).abs() < 1e-9);
/// # Ok::<(), nav::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Localization {
    atlas: Arc<Atlas>,
    filter: ParticleFilter,
    lasers: Vec<LaserMemory>,
    odometry: OdometryHistory,
    /// The search for a robot that may be anywhere, until it is found.
    search: Option<Box<Search>>,
    /// The search for a robot that may be elsewhere, in parallel to tracking its believed pose.
    suspicion: Option<Box<Search>>,
    /// The pose believed before a suspicion was confirmed, in the grid's frame at the last update.
    remembered: Option<Gaussian>,
    /// Whether only odometry has moved the belief since the last informative scan.
    is_blind: bool,
    contradiction: Contradiction,
    trust: OdometryTrust,
    /// The estimate at the last update, in the grid's frame.
    belief: Gaussian,
    /// Odometry at the last update; before the first update, the first odometry.
    anchor: Option<Pose>,
    updates: u64,
    /// When the first scan was taken.
    first_scan: Option<Duration>,
    /// Ends of the beams that weight particles, and of those that are matched; kept to reuse the memory.
    weighed: Endpoints,
    matched: Endpoints,
    /// The beams that may contradict poses.
    rays: Vec<Ray>,
}

/// The result of reconsidering the believed pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reconsidered {
    Stays,
    /// The robot is now believed to be elsewhere.
    Moves,
    /// An update is needed to decide, even for a robot at rest.
    Unsettled,
}

impl Reconsidered {
    fn moves(does: bool) -> Self {
        if does { Self::Moves } else { Self::Stays }
    }
}

impl Localization {
    /// A localization of a robot on a map, with its stream of random numbers. For several on one map, make an [`Atlas`]
    /// of it and use [`on`](Self::on).
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter is invalid; [`Error::NoFreeSpace`] if the map has no free cell.
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
            suspicion: None,
            remembered: None,
            is_blind: false,
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

    /// Forgets the pose and restarts with this knowledge of it.
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
        (self.suspicion, self.remembered, self.is_blind) = (None, None, false);
        self.contradiction.forget();
        self.trust = OdometryTrust::new();
    }

    /// Processes odometry. Readings must be in chronological order. A reading from before the last one means that the
    /// clock was set back, and earlier readings and scans are forgotten. A reading that is not finite is ignored.
    pub fn odometry(&mut self, odometry: &Odometry) {
        if !is_finite(odometry) {
            return;
        }
        if self.odometry.latest().is_some_and(|latest| odometry.time < latest.time) {
            self.lasers.iter_mut().for_each(LaserMemory::forget);
            self.first_scan = None;
        }
        self.odometry.push(*odometry);
        self.anchor.get_or_insert(odometry.pose);
    }

    /// Processes a scan, after the odometry of its time if there is any, and updates the estimate if the robot has
    /// moved far enough. Returns whether it did.
    ///
    /// Scans of lasers that the model does not have are ignored; so are beams that are not finite, outside the laser's
    /// range, or beyond the laser's number of beams. The pose of a scan is interpolated from the odometry of the last
    /// two seconds, or extrapolated by up to a quarter of a second. Older and later scans are ignored, because their
    /// pose is unknown.
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
        let is_unsettled = match self.reconsider(scan.time, &now, &moved, !far) {
            Reconsidered::Moves => return true,
            Reconsidered::Unsettled => true,
            Reconsidered::Stays => self.updates == 0 || self.search.as_ref().is_some_and(|search| search.begins()),
        };
        if !far && !is_unsettled {
            return false;
        }
        self.collect_ends(scan.time, &now);
        // A suspicion or a search that has just begun may have moved the anchor.
        self.update(&self.anchor.unwrap_or(anchor), now);
        true
    }

    /// The latest estimate of the pose, updated by the odometry since then. Before any scan, the initial pose.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let believed = pose(self.belief.x_m, self.belief.y_m, self.belief.heading_rad);
        let (Some(latest), Some(anchor)) = (self.odometry.latest(), self.anchor) else {
            return self.in_map_frame(Duration::ZERO, &believed, &self.belief.covariance);
        };
        let motion = DifferentialMotion::between(&anchor, &latest.pose, self.alphas());
        let covariance = self.carried_covariance(&motion);
        self.in_map_frame(latest.time, &(believed * anchor.inv_mul(&latest.pose)), &covariance)
    }

    /// The covariance of the belief after a motion.
    fn carried_covariance(&self, motion: &DifferentialMotion) -> Matrix3<f64> {
        let noise = motion.propagate(self.belief.heading_rad, &Matrix3::zeros());
        let all = motion.propagate(self.belief.heading_rad, &self.belief.covariance);
        all + noise * (self.trust.share() - 1.0)
    }

    /// The particles as poses in the `map` frame with their normalized weights.
    pub fn particles(&self) -> impl ExactSizeIterator<Item = (Pose, f64)> {
        let origin = self.origin();
        let in_map = move |particle: &Particle| origin * pose(particle.x_m, particle.y_m, particle.heading_rad);
        self.filter.particles().iter().map(move |particle| (in_map(particle), particle.weight))
    }

    /// The possible poses of the robot, most likely first: the clusters of the particles. There are several during a
    /// search, or if two places look alike.
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

    /// The evidence against the estimate, from 0 (none) to 1: how much less likely recent scans have been than usual. 1
    /// while a robot that may be anywhere has not been found, and while hardly anything of the map is visible.
    ///
    /// It rises if the robot has been kidnapped, before it is found elsewhere, and also if the map is out of date or a
    /// crowd surrounds the robot.
    #[must_use]
    pub fn doubt(&self) -> f64 {
        if self.search.is_some() || self.suspicion.is_some() { 1.0 } else { self.filter.doubt() }
    }

    /// The number of updates since the start or the last [`restart`](Self::restart).
    #[must_use]
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Collects the ends of the latest scans' beams from the robot's present pose: some of each scan to weight
    /// particles, more to match.
    fn collect_ends(&mut self, time: Duration, now: &Pose) {
        self.weighed.clear();
        self.matched.clear();
        self.rays.clear();
        let casts = self.filter.is_challenged() || self.suspicion.is_some();
        for laser in self.lasers.iter_mut().filter(|laser| laser.is_fresh(time.saturating_sub(OLDEST_SCAN))) {
            let stride = laser.stride(self.atlas.parameters().max_beams);
            // Different beams each time, so that all of them contribute.
            laser.append_ends(now, self.updates as usize % stride, stride, &mut self.weighed);
            if casts {
                laser.append_rays(now, self.updates as usize % stride, stride, &mut self.rays);
            }
            let stride = laser.stride(MATCHED_BEAMS * self.atlas.parameters().max_beams);
            laser.append_ends(now, self.updates as usize % stride, stride, &mut self.matched);
            laser.mark_used();
        }
    }

    /// Collects the latest scans from the robot's present pose for a look: rays, and more ends to match.
    fn see(&mut self, time: Duration, now: &Pose) {
        self.matched.clear();
        self.rays.clear();
        for laser in self.lasers.iter().filter(|laser| laser.is_fresh(time.saturating_sub(OLDEST_SCAN))) {
            let max_beams = self.atlas.parameters().max_beams;
            laser.append_rays(now, 0, laser.stride(max_beams), &mut self.rays);
            laser.append_ends(now, 0, laser.stride(MATCHED_BEAMS * max_beams), &mut self.matched);
        }
    }

    fn update(&mut self, anchor: &Pose, now: Pose) {
        let moved = anchor.inv_mul(&now);
        self.carry_remembered(&DifferentialMotion::between(anchor, &now, self.alphas()), &moved);
        match self.search.take() {
            Some(search) => self.seek(search, anchor, &now),
            None => self.track(anchor, &now),
        }
        self.anchor = Some(now);
        self.updates += 1;
    }

    /// An update for a robot that may be anywhere. Its believed pose, if there still is one, is tracked meanwhile.
    fn seek(&mut self, mut search: Box<Search>, anchor: &Pose, now: &Pose) {
        let tracked = search.has_incumbent().then(|| {
            let matched = self.follow(&DifferentialMotion::between(anchor, now, self.alphas()));
            self.filter.resample_if_needed(&matched);
            matched
        });
        // Every beam counts for finding the places that fit at all; fewer are enough to compare them.
        let ends = if search.begins() { &self.matched } else { &self.weighed };
        let sought = self.filter.seek(&mut search, &anchor.inv_mul(now), ends, tracked);
        let is_over = sought.is_some_and(|(_, is_over)| is_over);
        if let Some((belief, _)) = sought {
            self.belief = belief;
        }
        if is_over {
            self.contradiction.forget();
        } else {
            self.search = Some(search);
        }
    }

    /// Moves and weights the particles. Returns where they match the scan.
    fn follow(&mut self, motion: &DifferentialMotion) -> Gaussian {
        self.filter.predict(motion);
        self.filter.weigh(&self.weighed);
        let mean = self.filter.estimate();
        let matched = scan_matching::matched(&mean, &self.matched, &self.atlas.surfaces);
        let independent = self.parameters().independent_beams;
        let surfaces = &self.atlas.surfaces;
        let covariance = scan_matching::remaining_covariance(&mean, &matched, &self.matched, surfaces, independent);
        Gaussian { covariance, ..matched }
    }

    /// An update for a robot whose pose is known.
    fn track(&mut self, anchor: &Pose, now: &Pose) {
        let motion = DifferentialMotion::between(anchor, now, self.alphas());
        if self.contradiction.is_map_hidden() {
            self.track_blindly(anchor, now, &motion);
            return;
        }
        self.is_blind = false;
        let matched = self.follow(&motion);
        let before = std::mem::replace(&mut self.belief, matched);
        self.judge_odometry(&before, &motion, &anchor.inv_mul(now));
        let moved = anchor.inv_mul(now);
        if self.go_on_suspecting(&moved) {
            return;
        }
        let (map, rays) = (self.atlas.map(), self.rays.as_slice());
        let is_contradicted = |at: &Gaussian, silent| Look::from(map, at, rays, silent).contradicts();
        // If lasers fail, the belief gets the benefit of the doubt.
        let may_win =
            |at: &Gaussian| is_contradicted(&self.belief, Silent::TellNothing) && !is_contradicted(at, Silent::AreFree);
        match self.filter.challenge(&self.belief, &moved, &self.weighed, &may_win) {
            None => self.filter.resample_if_needed(&self.belief),
            Some(found) => {
                self.filter.place_around(&found);
                self.belief = found;
            }
        }
    }

    /// Learns from the difference between the belief after the update and the prediction by odometry.
    fn judge_odometry(&mut self, before: &Gaussian, motion: &DifferentialMotion, moved: &Pose) {
        let carried = after(before, moved);
        let turn_rad = maps::wrap_angle(self.belief.heading_rad - carried.heading_rad);
        let off = Vector3::new(self.belief.x_m - carried.x_m, self.belief.y_m - carried.y_m, turn_rad);
        let noise = motion.propagate(before.heading_rad, &Matrix3::zeros());
        let poses = motion.propagate(before.heading_rad, &before.covariance) - noise + self.belief.covariance;
        self.trust.observe(&off, &noise, &poses);
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

    /// Origin of the map: the pose of the grid's frame, in which the filter computes.
    fn origin(&self) -> Pose {
        self.atlas.map().origin()
    }
}

fn is_finite(odometry: &Odometry) -> bool {
    let Odometry { pose, linear_mps, angular_radps, .. } = odometry;
    let numbers = [pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im];
    numbers.iter().chain([linear_mps, angular_radps]).all(|number| number.is_finite())
}

fn gaussian(at: &Pose, covariance: Matrix3<f64>) -> Gaussian {
    Gaussian { x_m: at.translation.x, y_m: at.translation.y, heading_rad: heading(at), covariance }
}

/// The covariance of x, y and heading in a frame rotated by `-angle_rad`.
fn turned(covariance: &Matrix3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let rotation = nalgebra::Rotation2::new(angle_rad).to_homogeneous();
    rotation * covariance * rotation.transpose()
}
