//! The particle filter: predict, weight, resample.

use std::sync::Arc;

use maps::Pose;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::normal;

use super::challengers::{Challengers, Trial};
use super::clusters::Clusters;
use super::kld::particles_needed;
use super::motion_model::DifferentialMotion;
use super::recovery::Recovery;
use super::resampling::{effective_number, systematic};
use super::search::{Advantage, Search, Sighting};
use crate::atlas::likelihood_field::{Endpoints, log_likelihood};
use crate::particle::{Gaussian, Particle};
use crate::{Atlas, LocalizationParameters};

/// One in this many particles is placed where the scan was matched.
const MATCHED_EVERY: usize = 20;

/// A pose that may challenge the particles is the most likely of this many random ones.
const CANDIDATES: usize = 64;

/// One in this many beams is used to choose among them.
const CANDIDATE_STRIDE: usize = 4;

/// The maximum number of challengers searched for in an update: each takes about 10 µs.
const MOST_SOUGHT: usize = 10;

/// A robot counts as lost only if the scan, seen from somewhere else, is as likely as scans usually are, or less likely
/// by at most this many nats per beam: people may stand there as well. A scan that fits nowhere is a bad scan.
const FITS_ELSEWHERE_NATS: f64 = 0.2;

/// Fewer beams are not informative.
const FEWEST_BEAMS: usize = 8;

/// The particles, with the operations that move, weight and resample them. Poses are in the grid's frame.
#[derive(Clone, Debug)]
pub(crate) struct ParticleFilter {
    atlas: Arc<Atlas>,
    particles: Vec<Particle>,
    /// The particles of the last generation, kept to reuse the memory.
    spare: Vec<Particle>,
    penalties: Vec<u32>,
    drawn: Vec<u32>,
    is_drawn: Vec<bool>,
    sparse: Endpoints,
    challengers: Challengers,
    clusters: Clusters,
    recovery: Recovery,
    rng: ChaCha8Rng,
}

impl ParticleFilter {
    /// A filter without particles yet.
    pub(crate) fn new(atlas: &Arc<Atlas>, rng: ChaCha8Rng) -> Self {
        let parameters = atlas.parameters();
        Self {
            particles: Vec::with_capacity(parameters.min_particles),
            spare: Vec::with_capacity(parameters.min_particles),
            penalties: Vec::new(),
            drawn: Vec::new(),
            is_drawn: Vec::new(),
            sparse: Endpoints::default(),
            challengers: Challengers::default(),
            clusters: Clusters::default(),
            recovery: Recovery::new(parameters.recovery_alpha_slow, parameters.recovery_alpha_fast),
            atlas: Arc::clone(atlas),
            rng,
        }
    }

    pub(crate) fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// Places as many particles around a pose as its covariance requires.
    pub(crate) fn place_around(&mut self, guess: &Gaussian) {
        let spread = spread_of(&guess.covariance);
        let mut count = self.parameters().min_particles;
        loop {
            self.particles.clear();
            for _ in 0..count {
                let off = spread * Vector3::from_fn(|_, _| normal(&mut self.rng));
                let heading_rad = maps::wrap_angle(guess.heading_rad + off.z);
                self.particles.push(Particle::new(guess.x_m + off.x, guess.y_m + off.y, heading_rad));
            }
            self.clusters.assign(&self.particles);
            let needed = self.needed(self.clusters.bins());
            if count >= needed {
                break;
            }
            count = needed.min(2 * count);
        }
        self.start_anew();
    }

    /// Places the maximum number of particles anywhere in free space.
    pub(crate) fn place_anywhere(&mut self) {
        self.particles.clear();
        for _ in 0..self.parameters().max_particles {
            self.particles.push(self.atlas.free.draw(&mut self.rng));
        }
        self.start_anew();
    }

    fn start_anew(&mut self) {
        let weight = 1.0 / self.particles.len() as f64;
        self.particles.iter_mut().for_each(|particle| particle.weight = weight);
        self.recovery.reset();
        self.challengers.clear();
    }

    /// Moves all particles by the odometry, with its noise.
    pub(crate) fn predict(&mut self, motion: &DifferentialMotion) {
        for particle in &mut self.particles {
            motion.sample(particle, &mut self.rng);
        }
    }

    /// The weight of a scan with this many beams: neighboring beams see the same objects, so they are less informative
    /// than independent ones. Without this, the particles collapse after a few scans.
    fn scan_weight(&self, beams: usize) -> f64 {
        (self.parameters().independent_beams / beams as f64).min(1.0)
    }

    /// Weights all particles by the ends of their beams. Too few beams change nothing.
    pub(crate) fn weigh(&mut self, ends: &Endpoints) {
        if ends.len() < FEWEST_BEAMS {
            return;
        }
        self.penalties.clear();
        let field = &self.atlas.likelihoods;
        self.penalties.extend(self.particles.iter().map(|particle| field.penalty(particle, ends)));
        let least = self.penalties.iter().copied().min().unwrap_or(0);
        let nats_per_unit = field.nats_per_unit;
        let scan_weight = self.scan_weight(ends.len());
        let mut total = 0.0;
        let mut penalty = 0.0;
        for (particle, units) in self.particles.iter_mut().zip(&self.penalties) {
            particle.weight *= libm::exp(-f64::from(units - least) * nats_per_unit * scan_weight);
            total += particle.weight;
            penalty += particle.weight * f64::from(*units);
        }
        if total > 0.0 {
            self.particles.iter_mut().for_each(|particle| particle.weight /= total);
            self.recovery.observe(libm::exp(-penalty / total * nats_per_unit / ends.len() as f64));
        } else {
            // The only particles that fit had lost all their weight before.
            let weight = 1.0 / self.particles.len() as f64;
            self.particles.iter_mut().for_each(|particle| particle.weight = weight);
        }
    }

    /// Mean and covariance of the heaviest cluster of particles.
    pub(crate) fn estimate(&mut self) -> Gaussian {
        self.clusters.assign(&self.particles);
        self.clusters.heaviest(&self.particles)
    }

    /// Draws a new generation if the weights have become too unequal. Relies on the clusters of the last
    /// [`estimate`](Self::estimate).
    ///
    /// A few particles are placed where the scan was `matched`: the best available guess, even if no particle was near.
    pub(crate) fn resample_if_needed(&mut self, matched: &Gaussian) {
        let count = self.particles.len();
        let effective = effective_number(self.particles.iter().map(|particle| particle.weight));
        if effective >= self.parameters().resample_threshold * count as f64 {
            return;
        }
        let bins = self.bins_after_resampling();
        let needed = self.needed(bins);
        let weight = 1.0 / needed as f64;
        self.spare.clear();
        let weights = self.particles.iter().map(|particle| particle.weight);
        let offset = self.rng.random();
        systematic(weights, needed, offset, |index| self.spare.push(Particle { weight, ..self.particles[index] }));
        let matched = Particle { weight, ..Particle::new(matched.x_m, matched.y_m, matched.heading_rad) };
        self.spare.iter_mut().step_by(MATCHED_EVERY).for_each(|particle| *particle = matched);
        std::mem::swap(&mut self.particles, &mut self.spare);
    }

    /// Judges the poses that challenge the particles' `belief` after a motion, and searches for more of them, as many
    /// as the decrease of the scans' likelihood suggests. Returns the pose of a winning one that `may_win`: the robot
    /// was lost and is there.
    pub(crate) fn challenge(
        &mut self,
        belief: &Gaussian,
        moved: &Pose,
        ends: &Endpoints,
        may_win: &dyn Fn(&Gaussian) -> bool,
    ) -> Option<Gaussian> {
        let usual_nats = self.recovery.usual_nats()?;
        if ends.len() < FEWEST_BEAMS {
            return None;
        }
        let beams = (ends.len() as f64).min(self.parameters().independent_beams);
        let mut challengers = std::mem::take(&mut self.challengers);
        self.sparse.copy_every(CANDIDATE_STRIDE, ends);
        // Augmented MCL (Probabilistic Robotics, table 8.3) would make this share of the particles random ones. Clutter
        // misled those, so they must prove themselves as challengers first.
        let sought = (self.recovery.random_share() * self.particles.len() as f64) as usize;
        let sought: Vec<Particle> = (0..sought.min(MOST_SOUGHT)).map(|_| self.likeliest_anywhere()).collect();
        let trial = Trial {
            ends,
            field: &self.atlas.likelihoods,
            surfaces: &self.atlas.surfaces,
            usual_nats,
            incumbent: belief,
            beams,
            may_win,
        };
        let winner = challengers.judge(moved, &trial);
        sought.iter().for_each(|candidate| challengers.add(candidate, &trial));
        self.challengers = challengers;
        winner
    }

    pub(crate) fn dismiss_challengers(&mut self) {
        self.challengers.clear();
    }

    /// Whether there are challengers.
    pub(crate) fn is_challenged(&self) -> bool {
        !self.challengers.is_empty()
    }

    /// Searches for a robot that may be anywhere. The particles are those that have `tracked` its believed pose, if
    /// there still is one; otherwise the hypotheses of the search, or a set around the winning one. Returns the belief,
    /// and whether the search is over.
    pub(crate) fn seek(
        &mut self,
        search: &mut Search,
        moved: &Pose,
        ends: &Endpoints,
        tracked: Option<Gaussian>,
    ) -> Option<(Gaussian, bool)> {
        if ends.len() < FEWEST_BEAMS {
            search.carry(moved, tracked);
            return Some((self.follow(search)?, false));
        }
        let sighting = Sighting { atlas: &self.atlas, moved, ends, advantage: None, tracked };
        match (search.update(&sighting, &mut self.rng), tracked) {
            (Some(_), Some(tracked)) if search.has_incumbent() => Some((tracked, true)),
            (Some(found), _) => {
                self.place_around(&found);
                Some((found, true))
            }
            (None, _) => Some((self.follow(search)?, false)),
        }
    }

    /// Searches for a robot whose believed pose the scans contradict: returns the search, if this scan fits some other
    /// place, and the belief.
    pub(crate) fn seek_elsewhere(
        &mut self,
        believed: &Gaussian,
        ends: &Endpoints,
        is_at_rest: bool,
    ) -> Option<(Search, Gaussian)> {
        let usual_nats = self.recovery.usual_nats().filter(|_| ends.len() >= FEWEST_BEAMS)?;
        let mut search = Search::for_lost(believed, is_at_rest);
        let sighting = Sighting { atlas: &self.atlas, moved: &Pose::identity(), ends, advantage: None, tracked: None };
        search.update(&sighting, &mut self.rng);
        let fits = log_likelihood(&self.atlas.likelihoods, &search.best()?, ends) >= usual_nats - FITS_ELSEWHERE_NATS;
        let belief = if fits { self.follow(&search) } else { None }?;
        Some((search, belief))
    }

    /// Begins or continues a search in parallel to tracking. The particles stay. Returns the pose of the winning
    /// hypothesis, if there is one.
    pub(crate) fn seek_beside(
        &mut self,
        search: &mut Search,
        moved: &Pose,
        ends: &Endpoints,
        advantage: Advantage<'_>,
    ) -> Option<Gaussian> {
        if ends.len() < FEWEST_BEAMS {
            search.carry(moved, None);
            return None;
        }
        let sighting = Sighting { atlas: &self.atlas, moved, ends, advantage: Some(advantage), tracked: None };
        search.update(&sighting, &mut self.rng)
    }

    /// The belief of a search. Its hypotheses become the particles, unless these track the robot's believed pose.
    pub(crate) fn follow(&mut self, search: &Search) -> Option<Gaussian> {
        let belief = search.belief()?;
        if !search.has_incumbent() {
            self.particles.clear();
            self.particles.extend(search.particles());
        }
        Some(belief)
    }

    /// How much less likely recent scans have been than usual, from 0 to 1.
    pub(crate) fn doubt(&self) -> f64 {
        self.recovery.random_share()
    }

    /// The number of bins that would still be occupied after drawing the same number of particles again.
    fn bins_after_resampling(&mut self) -> usize {
        let offset = self.rng.random();
        self.drawn.clear();
        let weights = self.particles.iter().map(|particle| particle.weight);
        systematic(weights, self.particles.len(), offset, |index| self.drawn.push(index as u32));
        self.is_drawn.clear();
        self.is_drawn.resize(self.clusters.bins(), false);
        for index in &self.drawn {
            self.is_drawn[self.clusters.bin_of(*index as usize)] = true;
        }
        self.is_drawn.iter().filter(|drawn| **drawn).count()
    }

    fn parameters(&self) -> &LocalizationParameters {
        self.atlas.parameters()
    }

    fn needed(&self, bins: usize) -> usize {
        particles_needed(bins, self.parameters().pf_err, self.parameters().pf_z)
            .clamp(self.parameters().min_particles, self.parameters().max_particles)
    }

    fn likeliest_anywhere(&mut self) -> Particle {
        let mut best = self.atlas.free.draw(&mut self.rng);
        let mut least = self.atlas.likelihoods.penalty(&best, &self.sparse);
        for _ in 1..CANDIDATES {
            let candidate = self.atlas.free.draw(&mut self.rng);
            let penalty = self.atlas.likelihoods.penalty(&candidate, &self.sparse);
            if penalty < least {
                (best, least) = (candidate, penalty);
            }
        }
        best
    }
}

/// A matrix that transforms independent standard normal numbers to this covariance. For an invalid covariance (not
/// positive, even with a small correction), only the diagonal is used.
fn spread_of(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    match (covariance + Matrix3::identity() * 1e-12).cholesky() {
        Some(cholesky) => cholesky.unpack(),
        None => Matrix3::from_diagonal(&covariance.diagonal().map(|variance| variance.max(0.0).sqrt())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn singular_covariances_are_sampled_correctly() {
        let covariance = Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.0);
        let spread = spread_of(&covariance);
        assert!((spread * spread.transpose() - covariance).abs().max() < 1e-9);
        let impossible = Matrix3::new(0.04, 1.0, 0.0, 1.0, -0.09, 0.0, 0.0, 0.0, 0.0);
        assert!(spread_of(&impossible).iter().all(|entry| entry.is_finite()));
    }
}
