//! Poses elsewhere that may fit the scans better: a way to find a lost robot.
//!
//! Augmented Monte Carlo localization mixes random particles into the set. If there are many unmapped obstacles, one of
//! these particles sooner or later fits a single scan better than the truth does, and takes over. So here a random pose
//! is on probation: it moves with the odometry and replaces the particles only when it has fitted a number of scans for
//! which it was not chosen, much better than the particles do, and when beams [contradict](super::contradiction) the
//! particles' pose. In the open, where most of the few objects that beams hit are people, many empty places fit better
//! than the truth.
//!
//! The thresholds were chosen, not measured one by one. `nav/tests/drives` has the robots that must be found, and those
//! that clutter and crowds must not mislead.

use maps::Pose;
use nalgebra::Matrix3;

use super::scan_matching;
use crate::atlas::likelihood_field::{Endpoints, LikelihoodField, log_likelihood};
use crate::atlas::surface_field::SurfaceField;
use crate::particle::{Gaussian, Particle, after, are_same};

/// Most challengers at a time.
const MOST: usize = 8;

/// The smallest number of scans on probation, and the shortest distance: from one place, a wrong pose may fit many
/// scans in a row.
const PROBATION_SCANS: u32 = 10;
const PROBATION_M: f64 = 1.5;

/// How much more likely, in nats, the scans must have been from a challenger than from the particles.
const WINS_NATS: f64 = 30.0;

/// How much less likely than usual, in nats, they may have been from it.
const LOSES_NATS: f64 = -5.0;

/// How far a challenger may be from its best match (standard deviation, in meters and radians).
const DEVIATION: f64 = 0.2;

/// The challengers, in the grid's frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Challengers {
    kept: Vec<Challenger>,
}

#[derive(Clone, Copy, Debug)]
struct Challenger {
    at: Gaussian,
    /// How much more likely the scans on probation were from it than usual, and than from the incumbent.
    against_usual_nats: f64,
    against_incumbent_nats: f64,
    scans: u32,
    way_m: f64,
}

/// The criteria for challengers. Likelihoods are logarithms of the geometric mean over a scan's beams.
pub(crate) struct Trial<'a> {
    /// The ends of the scan's beams.
    pub(crate) ends: &'a Endpoints,
    pub(crate) field: &'a LikelihoodField,
    pub(crate) surfaces: &'a SurfaceField,
    /// The usual likelihood of scans.
    pub(crate) usual_nats: f64,
    /// Where the particles are.
    pub(crate) incumbent: &'a Gaussian,
    /// The number of independent beams that the scan is worth.
    pub(crate) beams: f64,
    /// Whether a challenger may replace the incumbent, with regard to walls.
    pub(crate) may_win: &'a dyn Fn(&Gaussian) -> bool,
}

impl Trial<'_> {
    fn matched(&self, at: &Gaussian) -> Gaussian {
        let covariance = Matrix3::identity() * (DEVIATION * DEVIATION);
        scan_matching::matched(&Gaussian { covariance, ..*at }, self.ends, self.surfaces)
    }
}

impl Challengers {
    pub(crate) fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    pub(crate) fn clear(&mut self) {
        self.kept.clear();
    }

    /// Moves all challengers, judges them by a new scan, removes those that lose or have moved to the incumbent's
    /// place, and returns the first that wins.
    pub(crate) fn judge(&mut self, moved: &Pose, trial: &Trial<'_>) -> Option<Gaussian> {
        if self.kept.is_empty() {
            return None;
        }
        let incumbent_nats = log_likelihood(trial.field, trial.incumbent, trial.ends);
        for challenger in &mut self.kept {
            challenger.at = trial.matched(&after(&challenger.at, moved));
            let nats = log_likelihood(trial.field, &challenger.at, trial.ends);
            challenger.against_usual_nats += (nats - trial.usual_nats) * trial.beams;
            challenger.against_incumbent_nats += (nats - incumbent_nats) * trial.beams;
            challenger.scans += 1;
            challenger.way_m += moved.translation.vector.norm();
        }
        self.kept.retain(|challenger| {
            challenger.against_usual_nats > LOSES_NATS && !are_same(&challenger.at, trial.incumbent)
        });
        let winner = self.kept.iter().find(|challenger| challenger.has_won() && (trial.may_win)(&challenger.at));
        winner.map(|challenger| challenger.at)
    }

    /// Adds a pose if the scan, at the pose's best match, is as likely as usual, and the pose is not among the
    /// challengers yet. If there are many, the weakest is removed.
    pub(crate) fn add(&mut self, candidate: &Particle, trial: &Trial<'_>) {
        let Particle { x_m, y_m, heading_rad, .. } = *candidate;
        let at = trial.matched(&Gaussian { x_m, y_m, heading_rad, covariance: Matrix3::zeros() });
        let is_known = are_same(&at, trial.incumbent) || self.kept.iter().any(|other| are_same(&at, &other.at));
        if is_known || log_likelihood(trial.field, &at, trial.ends) <= trial.usual_nats {
            return;
        }
        if self.kept.len() == MOST {
            let evidence = |index: &usize| self.kept[*index].against_usual_nats;
            let weakest = (0..MOST).min_by(|a, b| evidence(a).total_cmp(&evidence(b)));
            if let Some(weakest) = weakest {
                self.kept.remove(weakest);
            }
        }
        // The scan for which it was chosen does not count in its favor.
        self.kept.push(Challenger { at, against_usual_nats: 0.0, against_incumbent_nats: 0.0, scans: 0, way_m: 0.0 });
    }
}

impl Challenger {
    fn has_won(&self) -> bool {
        self.scans >= PROBATION_SCANS
            && self.way_m >= PROBATION_M
            && self.against_usual_nats >= 0.0
            && self.against_incumbent_nats >= WINS_NATS
    }
}
