//! The particle filter: predict, weigh, resample.

use maps::OccupancyGrid;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::normal;

use super::clusters::Clusters;
use super::free_space::FreeSpace;
use super::kld::particles_needed;
use super::likelihood_field::{Endpoints, LikelihoodField};
use super::motion_model::DifferentialMotion;
use super::parameters::LocalizationParameters;
use super::particle::{Gaussian, Particle};
use super::recovery::Recovery;
use super::resampling::{effective_number, systematic};
use super::scan_matching;
use super::surface_field::SurfaceField;
use crate::Error;

/// A random particle is the likeliest of so many drawn anywhere, by a part of the beams, and then matched to them: so a few find a
/// lost robot (sensor resetting).
const CANDIDATES: usize = 64;

/// Every how many particles one is put where the scan was matched.
const MATCHED_EVERY: usize = 20;

/// Weight of a random particle, as a multiple of that of one that was drawn: being carried away is rare. A lost robot's scans make up for
/// it many times, but a place that looks just like the one where the robot is does not win by and by.
const RANDOM_WEIGHT: f64 = 1e-3;

/// Most random particles that are tried in an update: each takes about 5 µs.
const MOST_TRIES: usize = 50;

/// Every how many beams choose among them.
const CANDIDATE_STRIDE: usize = 4;

/// How far from its best match a candidate may be (standard deviations, in metres and radians).
const CANDIDATE_DEVIATION: f64 = 0.2;

/// However many beams there are, they tell no more than so many that are independent of one another: what is not on the map
/// misleads many neighbouring beams at once.
const INDEPENDENT_BEAMS: f64 = 60.0;

/// Fewer beams than this say nothing of the pose.
const FEWEST_BEAMS: usize = 8;

/// The particles and what moves, weighs and renews them. Poses are in the grid's frame.
#[derive(Clone, Debug)]
pub(crate) struct ParticleFilter {
    parameters: LocalizationParameters,
    particles: Vec<Particle>,
    /// The particles of the last generation, kept for their memory.
    spare: Vec<Particle>,
    penalties: Vec<u32>,
    drawn: Vec<u32>,
    is_drawn: Vec<bool>,
    sparse: Endpoints,
    clusters: Clusters,
    recovery: Recovery,
    field: LikelihoodField,
    free: FreeSpace,
    rng: ChaCha8Rng,
}

impl ParticleFilter {
    /// A filter without particles yet, for lasers that reach `range_max_m`.
    pub(crate) fn new(
        map: &OccupancyGrid,
        surfaces: &SurfaceField,
        parameters: LocalizationParameters,
        range_max_m: f64,
        rng: ChaCha8Rng,
    ) -> Result<Self, Error> {
        Ok(Self {
            particles: Vec::with_capacity(parameters.min_particles),
            spare: Vec::with_capacity(parameters.min_particles),
            penalties: Vec::new(),
            drawn: Vec::new(),
            is_drawn: Vec::new(),
            sparse: Endpoints::default(),
            clusters: Clusters::default(),
            recovery: Recovery::new(parameters.recovery_alpha_slow, parameters.recovery_alpha_fast),
            field: LikelihoodField::new(map, surfaces, &parameters, range_max_m),
            free: FreeSpace::new(map).ok_or(Error::NoFreeSpace)?,
            parameters,
            rng,
        })
    }

    pub(crate) fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// Places the particles around a pose, as many as its covariance needs.
    pub(crate) fn place_around(&mut self, guess: &Gaussian) {
        let spread = spread_of(&guess.covariance);
        let mut count = self.parameters.min_particles;
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

    /// Places as many particles as there may be anywhere in free space.
    pub(crate) fn place_anywhere(&mut self) {
        self.particles.clear();
        for _ in 0..self.parameters.max_particles {
            self.particles.push(self.free.draw(&mut self.rng));
        }
        self.start_anew();
    }

    fn start_anew(&mut self) {
        let weight = 1.0 / self.particles.len() as f64;
        self.particles.iter_mut().for_each(|particle| particle.weight = weight);
        self.recovery.reset();
    }

    /// Moves all particles as the odometry says, with its noise.
    pub(crate) fn predict(&mut self, motion: &DifferentialMotion) {
        for particle in &mut self.particles {
            motion.sample(particle, &mut self.rng);
        }
    }

    /// Weighs all particles by where their beams would end. Too few beams change nothing.
    pub(crate) fn weigh(&mut self, ends: &Endpoints) {
        if ends.len() < FEWEST_BEAMS {
            return;
        }
        self.penalties.clear();
        self.penalties.extend(self.particles.iter().map(|particle| self.field.penalty(particle, ends)));
        let least = self.penalties.iter().copied().min().unwrap_or(0);
        let nats_per_unit = self.field.nats_per_unit();
        let say = (INDEPENDENT_BEAMS / ends.len() as f64).min(1.0);
        let mut total = 0.0;
        let mut penalty = 0.0;
        for (particle, units) in self.particles.iter_mut().zip(&self.penalties) {
            particle.weight *= libm::exp(-f64::from(units - least) * nats_per_unit * say);
            total += particle.weight;
            penalty += particle.weight * f64::from(*units);
        }
        if total > 0.0 {
            self.particles.iter_mut().for_each(|particle| particle.weight /= total);
            self.recovery.observe(libm::exp(-penalty / total * nats_per_unit / ends.len() as f64));
        } else {
            // The only particles that fit had lost all weight before.
            let weight = 1.0 / self.particles.len() as f64;
            self.particles.iter_mut().for_each(|particle| particle.weight = weight);
        }
    }

    /// Mean and covariance of the heaviest cluster of particles.
    pub(crate) fn estimate(&mut self) -> Gaussian {
        self.clusters.assign(&self.particles);
        self.clusters.heaviest(&self.particles)
    }

    /// Draws a new generation if the weights have become too unequal or the pose seems to be lost; if so, some of it are
    /// particles that fit the beams, wherever they are. Relies on the clusters of the last [`estimate`](Self::estimate).
    ///
    /// A few particles are put where the scan was `matched`: the best guess there is, even if no particle was near.
    pub(crate) fn resample_if_needed(&mut self, ends: &Endpoints, surfaces: &SurfaceField, matched: &Gaussian) {
        let count = self.particles.len();
        let effective = effective_number(self.particles.iter().map(|particle| particle.weight));
        let random_share = self.recovery.random_share();
        if effective >= self.parameters.resample_threshold * count as f64 && random_share * (count as f64) < 1.0 {
            return;
        }
        let bins = self.bins_after_resampling();
        let needed = self.needed(bins);
        self.spare.clear();
        self.add_likely_anywhere(random_share, ends, surfaces);
        let random = self.spare.len();
        let weight = 1.0 / ((needed - random) as f64 + random as f64 * RANDOM_WEIGHT);
        self.spare.iter_mut().for_each(|particle| particle.weight = weight * RANDOM_WEIGHT);
        let weights = self.particles.iter().map(|particle| particle.weight);
        let offset = self.rng.random();
        systematic(weights, needed - random, offset, |index| {
            self.spare.push(Particle { weight, ..self.particles[index] });
        });
        let matched = Particle { weight, ..Particle::new(matched.x_m, matched.y_m, matched.heading_rad) };
        self.spare[random..].iter_mut().step_by(MATCHED_EVERY).for_each(|particle| *particle = matched);
        std::mem::swap(&mut self.particles, &mut self.spare);
    }

    /// The bins that would still be occupied if as many particles were drawn again.
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

    fn needed(&self, bins: usize) -> usize {
        particles_needed(bins, self.parameters.pf_err, self.parameters.pf_z)
            .clamp(self.parameters.min_particles, self.parameters.max_particles)
    }

    /// Looks for places anywhere from which the beams are about as likely as usual, so often as the share of all particles says, and
    /// adds particles there to the new generation. What stands about without being on the map makes beams unlikely everywhere, and
    /// adds none.
    fn add_likely_anywhere(&mut self, share: f64, ends: &Endpoints, surfaces: &SurfaceField) {
        let tries = ((share * self.particles.len() as f64) as usize).min(MOST_TRIES);
        self.sparse.copy_every(CANDIDATE_STRIDE, ends);
        for _ in 0..tries {
            let candidate = self.likeliest_anywhere();
            let particle = matched_particle(&candidate, ends, surfaces);
            let penalty = f64::from(self.field.penalty(&particle, ends)) / ends.len() as f64;
            if self.recovery.is_usual(libm::exp(-penalty * self.field.nats_per_unit())) {
                self.spare.push(particle);
            }
        }
    }

    fn likeliest_anywhere(&mut self) -> Particle {
        let mut best = self.free.draw(&mut self.rng);
        let mut least = self.field.penalty(&best, &self.sparse);
        for _ in 1..CANDIDATES {
            let candidate = self.free.draw(&mut self.rng);
            let penalty = self.field.penalty(&candidate, &self.sparse);
            if penalty < least {
                (best, least) = (candidate, penalty);
            }
        }
        best
    }
}

/// A particle moved to where the beams match nearby, if they do.
fn matched_particle(particle: &Particle, ends: &Endpoints, surfaces: &SurfaceField) -> Particle {
    let covariance = Matrix3::identity() * (CANDIDATE_DEVIATION * CANDIDATE_DEVIATION);
    let guess = Gaussian { x_m: particle.x_m, y_m: particle.y_m, heading_rad: particle.heading_rad, covariance };
    let found = scan_matching::matched(&guess, ends, surfaces);
    Particle::new(found.x_m, found.y_m, found.heading_rad)
}

/// A matrix that turns independent standard normal numbers into ones of that covariance. A covariance that is none
/// (not positive, even with a little added) spreads by its diagonal alone.
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
    fn a_covariance_spreads_as_it_says_even_if_it_is_singular() {
        let covariance = Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.0);
        let spread = spread_of(&covariance);
        assert!((spread * spread.transpose() - covariance).abs().max() < 1e-9);
        let impossible = Matrix3::new(0.04, 1.0, 0.0, 1.0, -0.09, 0.0, 0.0, 0.0, 0.0);
        assert!(spread_of(&impossible).iter().all(|entry| entry.is_finite()));
    }
}
