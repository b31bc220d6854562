//! Global localization: a robot that may be anywhere is located with several hypotheses at a time.
//!
//! Particles spread over a whole map are far too few: the one nearest to the truth is off by half a meter and half a
//! right angle, and loses against another that happens to fit. So here random poses are only candidates. Those that fit
//! a scan best are matched to it and become hypotheses: they move with the odometry, are matched to every scan, and
//! gather evidence, until one is far ahead of all others. New candidates may join at any time, since the first scan may
//! have been taken where the map is wrong.
//!
//! A robot whose surroundings hide the map is searched for in the same way, in parallel to tracking its believed pose.
//! Then the best hypothesis must also be far ahead of that pose, with beams that are cut short costing either of them
//! little.
//!
//! Among many poses, one always happens to fit a scan better than the truth does if there are people or the place has
//! changed. So the scan for which a later candidate was chosen does not count as evidence, and the believed pose is
//! kept until another place has been far ahead for several scans.
//!
//! # The numbers
//! They were chosen together, and none was measured alone. What they achieve together is measured: `steward localize
//! --global --starts 100` finds the robot 100 times within 15 m on the log of the Intel Research Lab, with 5 % drift
//! and noise. `nav/tests/drives/rebuilt.rs` holds that a pose survives walls that were removed, `hemmed_in.rs` that it
//! survives crowds and doors.

use maps::{Pose, heading, wrap_angle};
use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::scan_matching;
use crate::Atlas;
use crate::atlas::likelihood_field::{Endpoints, log_likelihood};
use crate::particle::{Gaussian, Particle, after, are_same};

/// Number of poses drawn for the first scan per square meter of free floor, with its minimum and maximum: a few of them
/// lie within a quarter of a meter and 10° of the truth.
const DRAWN_PER_M2: f64 = 400.0;
const FEWEST_DRAWN: usize = 20_000;
const MOST_DRAWN: usize = 600_000;

/// Later scans draw this many times fewer poses, and fewer with each scan, because they seldom find what the first
/// scans have not found.
const DRAWN_LATER: usize = 10;

/// The maximum number of drawn poses that are matched to the scan, for the first scan and later.
const MATCHED_FIRST: usize = 600;
const MATCHED_LATER: usize = 50;

/// Beams for choosing among drawn poses.
const CHOOSING_BEAMS: usize = 30;

/// Most hypotheses at a time.
const MOST: usize = 300;

/// A scan is worth this many independent beams: moved furniture misleads many beams, for many scans.
const INDEPENDENT_BEAMS: f64 = 20.0;

/// A hypothesis this much less likely than the best is dropped, in nats.
const GIVEN_UP_NATS: f64 = 40.0;

/// A later one begins this much behind the best, in nats.
const HANDICAP_NATS: f64 = 5.0;

/// The believed pose is kept unless the best has been ahead of it by this much, in nats, in this many scans in a row,
/// over this distance, in meters; a radian counts as this many meters.
const DOUBTED_NATS: f64 = 15.0;
const DOUBTED_SCANS: u32 = 5;
const DOUBTED_M: f64 = 1.0;
const METERS_A_RADIAN: f64 = 0.5;

/// The pose believed before the robot was lost is this much more likely initially, in nats: robots are seldom
/// kidnapped.
const HEAD_START_NATS: f64 = 10.0;

/// The best wins once it has been ahead of all others by this much, in nats, over this distance, in meters, and this
/// many scans.
const AHEAD_NATS: f64 = 15.0;
const AHEAD_M: f64 = 2.0;
const AHEAD_SCANS: u32 = 6;

/// Places less than this far behind the best, in nats, look like it.
const ALIKE_NATS: f64 = 10.0;

/// How far a hypothesis may be from its best match: the squared deviations of the first guess, in meters and radians.
const GUESS_VARIANCE: [f64; 3] = [0.04, 0.04, 0.02];

/// A search for a robot that may be anywhere. Poses are in the grid's frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    hypotheses: Vec<Hypothesis>,
    candidates: Vec<Candidate>,
    choosing: Endpoints,
    scans: u32,
    ahead_scans: u32,
    ahead_m: f64,
    /// How much more likely, in nats, the scans have been from the best than from the tracked pose while the best was
    /// ahead.
    advantage_nats: f64,
    /// The number of scans in a row, and the distance, for which the best has been far ahead of the incumbent.
    doubted_scans: u32,
    doubted_m: f64,
    /// Whether the robot was at rest when it was found to be lost.
    is_at_rest: bool,
}

/// A possible pose, and the log-likelihood of the scans seen from it.
#[derive(Clone, Copy, Debug)]
struct Hypothesis {
    at: Gaussian,
    nats: f64,
    /// Whether this is the pose believed before the robot was lost, which is still possible.
    is_incumbent: bool,
}

#[derive(Clone, Copy, Debug)]
struct Candidate {
    penalty: u32,
    at: Particle,
}

/// How much more likely, in nats, a beam is from one pose than from another.
pub(crate) type Advantage<'a> = &'a dyn Fn(&Gaussian) -> f64;

/// A scan, and the robot's motion to where it was taken.
pub(crate) struct Sighting<'a> {
    pub(crate) atlas: &'a Atlas,
    pub(crate) moved: &'a Pose,
    /// Ends of the scan's beams.
    pub(crate) ends: &'a Endpoints,
    /// How much more likely, in nats, a beam of the scan is from a pose than from the tracked pose, if there is one.
    pub(crate) advantage: Option<Advantage<'a>>,
    /// The current pose of the incumbent, if it is tracked: particles track better than a matched guess.
    pub(crate) tracked: Option<Gaussian>,
}

impl Sighting<'_> {
    fn matched(&self, at: &Gaussian) -> Gaussian {
        scan_matching::matched(at, self.ends, &self.atlas.surfaces)
    }

    fn nats(&self, at: &Gaussian) -> f64 {
        log_likelihood(&self.atlas.likelihoods, at, self.ends) * self.beams()
    }

    /// The number of independent beams that the scan is worth.
    fn beams(&self) -> f64 {
        (self.ends.len() as f64).min(INDEPENDENT_BEAMS)
    }
}

impl Search {
    /// A search for a robot that is lost, but may still be where it was believed to be. For a robot at rest, the first
    /// scan decides whether that is still believed: walls are removed in its absence, but hardly in its view.
    pub(crate) fn for_lost(believed: &Gaussian, is_at_rest: bool) -> Self {
        let incumbent = Hypothesis { at: *believed, nats: HEAD_START_NATS, is_incumbent: true };
        Self { hypotheses: vec![incumbent], is_at_rest, ..Self::default() }
    }

    /// Whether the robot is still believed to be where it was before it was lost.
    pub(crate) fn has_incumbent(&self) -> bool {
        self.incumbent().is_some()
    }

    fn incumbent(&self) -> Option<&Hypothesis> {
        self.hypotheses.iter().find(|hypothesis| hypothesis.is_incumbent)
    }

    /// The most likely pose so far.
    pub(crate) fn best(&self) -> Option<Gaussian> {
        self.hypotheses.first().map(|best| best.at)
    }

    /// Whether no scan has been processed yet.
    pub(crate) fn begins(&self) -> bool {
        self.scans == 0
    }

    /// Moves the hypotheses with the odometry if a scan is too uninformative to judge them; the incumbent moves to its
    /// tracked pose.
    pub(crate) fn carry(&mut self, moved: &Pose, tracked: Option<Gaussian>) {
        for hypothesis in &mut self.hypotheses {
            let tracked = tracked.filter(|_| hypothesis.is_incumbent);
            hypothesis.at = tracked.unwrap_or_else(|| driven(&hypothesis.at, moved));
        }
    }

    /// Processes a scan. Returns the pose of the winning hypothesis, if there is one.
    pub(crate) fn update(&mut self, sighting: &Sighting<'_>, rng: &mut ChaCha8Rng) -> Option<Gaussian> {
        let leader = self.hypotheses.first().copied();
        let expected = leader.filter(|_| !self.begins()).map_or(0.0, |leader| leader.nats);
        self.carry(sighting.moved, sighting.tracked);
        for hypothesis in &mut self.hypotheses {
            if sighting.tracked.is_none() || !hypothesis.is_incumbent {
                hypothesis.at = sighting.matched(&hypothesis.at);
            }
            hypothesis.nats += sighting.nats(&hypothesis.at);
        }
        self.merge_and_give_up();
        self.admit(expected - HANDICAP_NATS, sighting, rng);
        self.scans += 1;
        let turned_m = METERS_A_RADIAN * heading(sighting.moved).abs();
        self.doubt_incumbent(sighting.moved.translation.vector.norm() + turned_m);
        let leads_still = match (leader, self.hypotheses.first()) {
            (Some(before), Some(now)) => are_same(&driven(&before.at, sighting.moved), &now.at),
            _ => false,
        };
        self.judge(leads_still, sighting)
    }

    /// Drops the belief in the incumbent once the best has been far ahead for long enough.
    fn doubt_incumbent(&mut self, moved_m: f64) {
        let Some(best) = self.hypotheses.first().map(|best| best.nats) else { return };
        let Some(incumbent) = self.hypotheses.iter_mut().find(|hypothesis| hypothesis.is_incumbent) else { return };
        if best - incumbent.nats < DOUBTED_NATS {
            (self.doubted_scans, self.doubted_m) = (0, 0.0);
            return;
        }
        (self.doubted_scans, self.doubted_m) = (self.doubted_scans + 1, self.doubted_m + moved_m);
        let for_long = self.doubted_scans >= DOUBTED_SCANS && self.doubted_m >= DOUBTED_M;
        let at_once = self.is_at_rest && self.scans == 1;
        incumbent.is_incumbent = !(for_long || at_once);
    }

    /// Sorts hypotheses by evidence and drops those that are far behind or have moved to the place of a better one. One
    /// bad scan does not drop the incumbent.
    fn merge_and_give_up(&mut self) {
        self.hypotheses.sort_by(|a, b| b.nats.total_cmp(&a.nats));
        let Some(best) = self.hypotheses.first().map(|best| best.nats) else { return };
        let mut kept = 0;
        for index in 0..self.hypotheses.len() {
            let hypothesis = self.hypotheses[index];
            let is_likely = index < MOST && hypothesis.nats >= best - GIVEN_UP_NATS;
            let known = self.hypotheses[..kept].iter_mut().find(|other| are_same(&other.at, &hypothesis.at));
            if let Some(known) = known {
                known.is_incumbent |= hypothesis.is_incumbent;
            } else if is_likely || hypothesis.is_incumbent {
                self.hypotheses[kept] = hypothesis;
                kept += 1;
            }
        }
        self.hypotheses.truncate(kept);
    }

    /// Draws poses and adds those that fit best as hypotheses. They begin with this evidence and that of the scan;
    /// later ones begin behind the best.
    fn admit(&mut self, nats: f64, sighting: &Sighting<'_>, rng: &mut ChaCha8Rng) {
        let most = if self.begins() { MATCHED_FIRST } else { MATCHED_LATER };
        let best = self.hypotheses.first().filter(|_| !self.begins()).map_or(f64::INFINITY, |best| best.nats);
        self.choose(most, sighting, rng);
        let candidates = std::mem::take(&mut self.candidates);
        for candidate in &candidates {
            let Particle { x_m, y_m, heading_rad, .. } = candidate.at;
            let covariance = Matrix3::from_diagonal(&Vector3::from(GUESS_VARIANCE));
            let at = sighting.matched(&Gaussian { x_m, y_m, heading_rad, covariance });
            if !self.hypotheses.iter().any(|other| are_same(&other.at, &at)) {
                let nats = (nats + sighting.nats(&at)).min(best - HANDICAP_NATS);
                self.hypotheses.push(Hypothesis { at, nats, is_incumbent: false });
            }
        }
        self.candidates = candidates;
        self.merge_and_give_up();
    }

    /// Draws random poses and keeps those that fit a few beams best.
    fn choose(&mut self, most: usize, sighting: &Sighting<'_>, rng: &mut ChaCha8Rng) {
        let Sighting { atlas, ends, .. } = sighting;
        self.choosing.copy_every(ends.len().div_ceil(CHOOSING_BEAMS).max(1), ends);
        let drawn = ((atlas.free.area_m2() * DRAWN_PER_M2) as usize).clamp(FEWEST_DRAWN, MOST_DRAWN);
        let drawn = if self.scans == 0 { drawn } else { drawn / (DRAWN_LATER + self.scans as usize) };
        let mut least = u32::MAX;
        self.candidates.clear();
        for _ in 0..drawn {
            let at = atlas.free.draw(rng);
            let penalty = atlas.likelihoods.penalty(&at, &self.choosing);
            if penalty < least {
                self.candidates.push(Candidate { penalty, at });
            }
            if self.candidates.len() == 4 * most {
                least = self.keep_best(most);
            }
        }
        self.keep_best(most);
    }

    /// Keeps this many candidates, best first. Returns the penalty of the last.
    fn keep_best(&mut self, most: usize) -> u32 {
        // Stable: which of two equally good ones is kept depends only on the order of drawing.
        self.candidates.sort_by_key(|candidate| candidate.penalty);
        self.candidates.truncate(most);
        self.candidates.last().map_or(u32::MAX, |last| last.penalty)
    }

    /// The leader, if it has been far enough ahead for long enough.
    fn judge(&mut self, leads_still: bool, sighting: &Sighting<'_>) -> Option<Gaussian> {
        let best = self.best()?;
        if self.ahead_nats() < AHEAD_NATS || !leads_still {
            (self.ahead_scans, self.ahead_m, self.advantage_nats) = (0, 0.0, 0.0);
            return None;
        }
        self.ahead_scans += 1;
        self.ahead_m += sighting.moved.translation.vector.norm();
        self.advantage_nats += sighting.advantage.map_or(AHEAD_NATS, |advantage| advantage(&best) * sighting.beams());
        let is_far_ahead = self.ahead_scans >= AHEAD_SCANS && self.ahead_m >= AHEAD_M;
        (is_far_ahead && self.advantage_nats >= AHEAD_NATS).then_some(best)
    }

    /// The best hypothesis, if it is far enough ahead of all others to exclude places that merely look alike.
    pub(crate) fn only_place(&self) -> Option<Gaussian> {
        self.best().filter(|_| self.ahead_nats() >= ALIKE_NATS)
    }

    /// How far the best hypothesis is ahead of all others, in nats.
    fn ahead_nats(&self) -> f64 {
        match self.hypotheses.as_slice() {
            [best, second, ..] => best.nats - second.nats,
            _ => f64::INFINITY,
        }
    }

    /// The incumbent, or else the best hypothesis; its covariance covers all of them.
    pub(crate) fn belief(&self) -> Option<Gaussian> {
        let believed = self.incumbent().or(self.hypotheses.first())?.at;
        let mut covariance = Matrix3::zeros();
        for (hypothesis, weight) in self.weighted() {
            let Gaussian { x_m, y_m, heading_rad, .. } = hypothesis.at;
            let turn_rad = wrap_angle(heading_rad - believed.heading_rad);
            let off = Vector3::new(x_m - believed.x_m, y_m - believed.y_m, turn_rad);
            covariance += (hypothesis.at.covariance + off * off.transpose()) * weight;
        }
        Some(Gaussian { covariance, ..believed })
    }

    /// The hypotheses as particles with normalized weights.
    pub(crate) fn particles(&self) -> impl Iterator<Item = Particle> {
        self.weighted().map(|(hypothesis, weight)| {
            let Gaussian { x_m, y_m, heading_rad, .. } = hypothesis.at;
            Particle { weight, ..Particle::new(x_m, y_m, heading_rad) }
        })
    }

    fn weighted(&self) -> impl Iterator<Item = (&Hypothesis, f64)> {
        let best = self.hypotheses.first().map_or(0.0, |best| best.nats);
        let likelihood = move |hypothesis: &Hypothesis| libm::exp(hypothesis.nats - best);
        let total: f64 = self.hypotheses.iter().map(likelihood).sum();
        self.hypotheses.iter().map(move |hypothesis| (hypothesis, likelihood(hypothesis) / total))
    }
}

/// A guess after a motion, before matching.
fn driven(from: &Gaussian, moved: &Pose) -> Gaussian {
    Gaussian { covariance: Matrix3::from_diagonal(&Vector3::from(GUESS_VARIANCE)), ..after(from, moved) }
}
