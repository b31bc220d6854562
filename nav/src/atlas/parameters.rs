//! The parameters of the particle filter.

use crate::Error;
use crate::error::{at_least_zero, check, positive, require, share};

/// Parameters of [`Localization`](crate::Localization).
///
/// Names and meanings are those of Nav2's AMCL where it has the parameter. Where a default differs from Nav2's, the
/// reason is given. The sensor model is Nav2's `likelihood_field_prob`, which multiplies the likelihoods of beams.
/// Nav2's default, `likelihood_field`, adds their cubes, which is less precise.
///
/// It is flat, as AMCL's parameters are: a configuration of Nav2 can be compared with it line by line.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalizationParameters {
    /// Minimum number of particles. Default 500: enough for tracking, when all of them lie within one or two bins.
    pub min_particles: usize,
    /// Maximum number of particles. Default 10 000 (Nav2: 2000): only a global localization needs this many, and an
    /// update with them takes about 7 ms.
    pub max_particles: usize,
    /// KLD sampling: the largest divergence allowed between the sampled and the true distribution. Default 0.05.
    pub pf_err: f64,
    /// KLD sampling: the upper quantile of the standard normal distribution for the desired confidence. Default 2.33
    /// (99 %). Nav2 uses 0.99 itself, which as a quantile corresponds to 84 %.
    pub pf_z: f64,
    /// Turning noise from turning: variance in rad² per rad². Default 0.01 (Nav2: 0.2): 10 % of a turn. The alphas
    /// cover odometry with errors of a few percent; larger ones spread the particles more than the lasers require.
    pub alpha1: f64,
    /// Turning noise from driving: variance in rad² per m². Default 0.01 (Nav2: 0.2): 0.1 rad per meter.
    pub alpha2: f64,
    /// Driving noise from driving: variance in m² per m². Default 0.01 (Nav2: 0.2): 10 % of the distance.
    pub alpha3: f64,
    /// Driving noise from turning: variance in m² per rad². Default 0.001 (Nav2: 0.2): 3 cm for a turn of 1 rad.
    pub alpha4: f64,
    /// Weight of beams that end on a surface of the map. Default 0.9 (Nav2: 0.5): maps and scans mostly agree.
    pub z_hit: f64,
    /// Weight of beams that end anywhere. Default 0.1 (Nav2: 0.5).
    pub z_rand: f64,
    /// Standard deviation of a hit's distance from the surface, in meters. Default 0.1 (Nav2: 0.2): map cells, laser
    /// noise and the dependence of neighboring beams, for which a wider distribution compensates.
    pub sigma_hit: f64,
    /// All distances from a surface beyond this count as equal, in meters. Default 0.5 (Nav2: 2.0): five `sigma_hit`,
    /// where a hit is already as unlikely as a stray beam.
    pub laser_likelihood_max_dist: f64,
    /// Beams longer than this are ignored, in meters, regardless of the laser's range. Default 100, as in Nav2.
    pub laser_max_range: f64,
    /// Beams shorter than this are ignored, in meters, regardless of the laser's range. Default 0: the laser's own
    /// limit applies (Nav2: −1, with the same meaning).
    pub laser_min_range: f64,
    /// How far behind the face of its cell a surface is hit, on average, in meters. Default 0: the walls of a simulated
    /// robot are the map's cells themselves. A map made from scans has a wall in every cell in which beams ended,
    /// anywhere in the cell, so half a cell's side is right for it. Nav2 has no such parameter: it measures from cell
    /// centers, which has the same effect as half a cell.
    pub surface_depth: f64,
    /// All beams together count as at most this many independent ones: unmapped objects mislead many neighboring beams
    /// at once. Default 60. Nav2 has no such parameter, and multiplies the likelihoods of all beams.
    pub independent_beams: f64,
    /// Beams of each scan that weight the particles, evenly spread. Default 60, as in Nav2.
    pub max_beams: usize,
    /// Distance until the next update, in meters. Default 0.1 (Nav2: 0.25): an update is cheap, and the estimate drifts
    /// with the odometry in between.
    pub update_min_d: f64,
    /// Turn until the next update, in radians. Default 0.1 (Nav2: 0.2).
    pub update_min_a: f64,
    /// The particles are resampled when their effective number falls below this share of them. Default 0.5. (Nav2
    /// resamples every `resample_interval` updates.)
    pub resample_threshold: f64,
    /// How fast the long-term average of the scans' likelihood adapts, per update. Default 0.005 (Nav2: 0, which
    /// switches recovery off).
    pub recovery_alpha_slow: f64,
    /// How fast the short-term average of the scans' likelihood adapts, per update. Default 0.1 (Nav2: 0).
    pub recovery_alpha_fast: f64,
}

impl Default for LocalizationParameters {
    fn default() -> Self {
        Self {
            min_particles: 500,
            max_particles: 10_000,
            pf_err: 0.05,
            pf_z: 2.33,
            alpha1: 0.01,
            alpha2: 0.01,
            alpha3: 0.01,
            alpha4: 0.001,
            z_hit: 0.9,
            z_rand: 0.1,
            sigma_hit: 0.1,
            laser_likelihood_max_dist: 0.5,
            laser_max_range: 100.0,
            laser_min_range: 0.0,
            surface_depth: 0.0,
            independent_beams: 60.0,
            max_beams: 60,
            update_min_d: 0.1,
            update_min_a: 0.1,
            resample_threshold: 0.5,
            recovery_alpha_slow: 0.005,
            recovery_alpha_fast: 0.1,
        }
    }
}

impl LocalizationParameters {
    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first invalid one.
    pub fn check(&self) -> Result<(), Error> {
        let (min_particles, max_particles) = (self.min_particles as f64, self.max_particles as f64);
        check(&[
            require("min_particles", min_particles, self.min_particles > 0, "at least 1"),
            require("max_particles", max_particles, max_particles >= min_particles, "at least min_particles"),
            positive("pf_err", self.pf_err),
            at_least_zero("pf_z", self.pf_z),
            at_least_zero("alpha1", self.alpha1),
            at_least_zero("alpha2", self.alpha2),
            at_least_zero("alpha3", self.alpha3),
            at_least_zero("alpha4", self.alpha4),
            positive("z_hit", self.z_hit),
            positive("z_rand", self.z_rand),
            positive("laser_max_range", self.laser_max_range),
            // Nav2's −1 means that the laser's own limit applies.
            require("laser_min_range", self.laser_min_range, self.laser_min_range.is_finite(), "a number"),
            at_least_zero("surface_depth", self.surface_depth),
            positive("independent_beams", self.independent_beams),
            positive("sigma_hit", self.sigma_hit),
            positive("laser_likelihood_max_dist", self.laser_likelihood_max_dist),
            require("max_beams", self.max_beams as f64, self.max_beams > 0, "at least 1"),
            at_least_zero("update_min_d", self.update_min_d),
            at_least_zero("update_min_a", self.update_min_a),
            share("resample_threshold", self.resample_threshold),
            share("recovery_alpha_slow", self.recovery_alpha_slow),
            share("recovery_alpha_fast", self.recovery_alpha_fast),
        ])
    }
}
