//! Reconsiders the believed pose when scans contradict it.
//!
//! Once per second the scans are [checked](super::contradiction) against the believed pose. A robot can be lost in two
//! ways, and two other situations look similar.
//!
//! - *Beams pass through walls of the map.* The robot cannot be there. After a few such looks, a search
//!   [everywhere](super::search) begins. If it drives, it may still be there, and the map may be wrong: so it is also
//!   tracked, and the belief stays until another place has explained the scans far better for some time.
//! - *Nearly all beams are short.* A robot that was moved from a large room to a small one sees this; so does a robot
//!   that people or closed doors surround, whose wheels report that it has not moved. So the belief stays, and moves
//!   with the odometry, while a *suspicion* searches for other places in parallel. The suspicion is confirmed if
//!   another place wins over many scans and some distance, with short beams costing little at the tracked pose; or if
//!   looks still see nothing of the map, and one place alone explains nearly every beam of the scan exactly, which a
//!   crowd hardly ever causes. It is dropped as soon as the map is seen again.
//!
//! When a suspicion is confirmed, the previous pose is *remembered*, and moved with the odometry until it has become
//! too vague. If the remembered pose fits again while the search continues, or when beams pass through walls at the new
//! pose, then the robot was only surrounded, and returns to the remembered pose.
//!
//! The counts of looks were chosen, not measured: few enough to detect within seconds that a robot was carried away,
//! and more for one that drives, since its particles may follow on their own.

use std::time::Duration;

use maps::Pose;

use super::contradiction::{Look, Silent, Verdict};
use super::motion_model::DifferentialMotion;
use super::scan_matching;
use super::search::Search;
use super::{Localization, Reconsidered};
use crate::atlas::likelihood_field::log_likelihood;
use crate::particle::{Gaussian, after, are_same};

/// This many looks against the pose are sufficient: for a robot at rest, and for one that drives and may recover on its
/// own.
const ENOUGH_AT_REST: u32 = 3;
const ENOUGH_DRIVING: u32 = 6;

/// This many fitting looks in a row end a suspicion.
const ENOUGH_THAT_FIT: u32 = 3;

/// After this many looks in a row that see nothing of the map, the only place that fits a scan exactly is believed.
const ENOUGH_WITHOUT_MAP: u32 = 10;

/// A pose is remembered until its deviation by odometry reaches this, in meters.
const VAGUE_M: f64 = 1.0;

/// Which of a scan's beams to use.
#[derive(Clone, Copy)]
enum Ends {
    Matched,
    Weighed,
}

impl Localization {
    /// Checks the latest scans, if a look is due, after a motion since the last update.
    pub(super) fn reconsider(&mut self, time: Duration, now: &Pose, moved: &Pose, is_at_rest: bool) -> Reconsidered {
        let is_of_interest = self.updates > 0 && (self.search.is_none() || self.remembered.is_some());
        if !is_of_interest || !self.contradiction.is_due(time) {
            return Reconsidered::Stays;
        }
        self.see(time, now);
        if self.search.is_some() {
            return Reconsidered::moves(self.look_back(time, now, moved));
        }
        let verdict = self.look_from(&after(&self.belief, moved), Silent::TellNothing).verdict();
        if self.is_blind && verdict != Verdict::Hidden {
            // Only odometry has led to this pose. First it must converge to where the scan fits.
            self.contradiction.take_in(time, Verdict::Unclear);
            return Reconsidered::Unsettled;
        }
        self.contradiction.take_in(time, verdict);
        let enough = if is_at_rest { ENOUGH_AT_REST } else { ENOUGH_DRIVING };
        if self.contradiction.looks_through() >= enough {
            return Reconsidered::moves(self.leave(now, moved, is_at_rest));
        }
        match self.suspicion.take() {
            None if self.contradiction.looks_without_map() >= enough => self.suspect(now),
            None => {}
            Some(_) if self.contradiction.looks_that_fit() >= ENOUGH_THAT_FIT => {}
            Some(suspicion) if self.comes_true(&suspicion, moved) => {
                return Reconsidered::moves(self.believe(suspicion, now));
            }
            suspicion => self.suspicion = suspicion,
        }
        Reconsidered::Stays
    }

    /// Begins to search for the robot everywhere, since beams pass through walls at the believed pose, if the scan fits
    /// somewhere else.
    fn leave(&mut self, now: &Pose, moved: &Pose, is_at_rest: bool) -> bool {
        self.contradiction.forget();
        let remembered = self.remembered.take().map(|remembered| self.matched_from(&after(&remembered, moved)));
        if let Some(at) = remembered.filter(|at| self.look_from(at, Silent::TellNothing).verdict() == Verdict::Fits) {
            return self.return_to(at, now);
        }
        self.carry_to(now);
        let sought = self.filter.seek_elsewhere(&self.belief, &self.matched, is_at_rest);
        let Some((search, belief)) = sought else { return false };
        (self.search, self.suspicion) = (Some(Box::new(search)), None);
        self.settle(belief, now)
    }

    /// Begins a suspicion.
    fn suspect(&mut self, now: &Pose) {
        self.carry_to(now);
        let mut suspicion = Box::<Search>::default();
        self.seek_beside(&mut suspicion, &Pose::identity(), Ends::Matched);
        self.suspicion = Some(suspicion);
    }

    /// Passes the latest scan to a suspicion. Returns the winning pose, if there is one.
    fn seek_beside(&mut self, suspicion: &mut Search, moved: &Pose, ends: Ends) -> Option<Gaussian> {
        let (map, rays) = (self.atlas.map(), self.rays.as_slice());
        let nats = |at: &Gaussian| Look::from(map, at, rays, Silent::TellNothing).nats_a_beam();
        let here = nats(&self.belief);
        // As in any search, every beam counts for finding the places that fit at all, and fewer are enough to compare
        // them.
        let ends = match ends {
            Ends::Matched => &self.matched,
            Ends::Weighed => &self.weighed,
        };
        self.filter.seek_beside(suspicion, moved, ends, &|at| nats(at) - here)
    }

    /// Whether a suspicion is confirmed by the view from one place, after a motion.
    fn comes_true(&self, suspicion: &Search, moved: &Pose) -> bool {
        let is_exact = |at: &Gaussian| self.look_from(&after(at, moved), Silent::AreFree).is_exact();
        self.contradiction.looks_without_map() >= ENOUGH_WITHOUT_MAP
            && suspicion.only_place().as_ref().is_some_and(is_exact)
    }

    /// Turns a suspicion into the search for the robot; the previous belief is remembered.
    fn believe(&mut self, suspicion: Box<Search>, now: &Pose) -> bool {
        self.carry_to(now);
        let Some(belief) = self.filter.follow(&suspicion) else { return false };
        self.remembered = Some(self.belief);
        self.contradiction.forget();
        self.search = Some(suspicion);
        self.settle(belief, now)
    }

    /// Continues a suspicion, after a motion to where the robot is now tracked. Returns whether it is confirmed.
    pub(super) fn go_on_suspecting(&mut self, moved: &Pose) -> bool {
        let Some(mut suspicion) = self.suspicion.take() else { return false };
        let Some(found) = self.seek_beside(&mut suspicion, moved, Ends::Weighed) else {
            self.suspicion = Some(suspicion);
            return false;
        };
        // If the search ends without another place, the suspicion was unfounded.
        let is_elsewhere = !are_same(&found, &self.belief) && !self.look_from(&found, Silent::AreFree).contradicts();
        if is_elsewhere {
            self.remembered = Some(self.belief);
            self.filter.place_around(&found);
            self.belief = found;
        }
        self.contradiction.forget();
        is_elsewhere
    }

    /// Checks the remembered pose, after a motion, and returns to it once it fits better than the best place found.
    fn look_back(&mut self, time: Duration, now: &Pose, moved: &Pose) -> bool {
        let Some(remembered) = self.remembered else { return false };
        let at = self.matched_from(&after(&remembered, moved));
        self.contradiction.take_in(time, self.look_from(&at, Silent::TellNothing).verdict());
        if self.contradiction.looks_through() >= ENOUGH_DRIVING {
            self.remembered = None;
        }
        let nats = |at: &Gaussian| log_likelihood(&self.atlas.likelihoods, at, &self.matched);
        if self.contradiction.looks_that_fit() < ENOUGH_THAT_FIT || nats(&at) < nats(&after(&self.belief, moved)) {
            return false;
        }
        self.return_to(at, now)
    }

    fn return_to(&mut self, at: Gaussian, now: &Pose) -> bool {
        (self.search, self.suspicion, self.remembered) = (None, None, None);
        self.contradiction.forget();
        self.filter.place_around(&at);
        self.settle(at, now)
    }

    fn settle(&mut self, belief: Gaussian, now: &Pose) -> bool {
        (self.belief, self.anchor) = (belief, Some(*now));
        self.updates += 1;
        true
    }

    /// An update, after a motion, for a robot that sees almost nothing of the map: scans would only mislead.
    pub(super) fn track_blindly(&mut self, anchor: &Pose, now: &Pose, motion: &DifferentialMotion) {
        let moved = anchor.inv_mul(now);
        self.filter.predict(motion);
        self.filter.dismiss_challengers();
        self.belief = Gaussian { covariance: self.carried_covariance(motion), ..after(&self.belief, &moved) };
        self.is_blind = true;
        self.go_on_suspecting(&moved);
    }

    /// Moves the belief and the particles with the odometry.
    fn carry_to(&mut self, now: &Pose) {
        let Some(anchor) = self.anchor.replace(*now) else { return };
        let motion = DifferentialMotion::between(&anchor, now, self.alphas());
        self.filter.predict(&motion);
        let covariance = self.carried_covariance(&motion);
        self.belief = Gaussian { covariance, ..after(&self.belief, &anchor.inv_mul(now)) };
    }

    /// Moves the remembered pose with the odometry, until it has become too vague.
    pub(super) fn carry_remembered(&mut self, motion: &DifferentialMotion, moved: &Pose) {
        let carried = self.remembered.map(|remembered| {
            let covariance = motion.propagate(remembered.heading_rad, &remembered.covariance);
            Gaussian { covariance, ..after(&remembered, moved) }
        });
        let is_clear = |at: &Gaussian| at.covariance[(0, 0)] + at.covariance[(1, 1)] <= VAGUE_M * VAGUE_M;
        self.remembered = carried.filter(is_clear);
    }

    fn matched_from(&self, at: &Gaussian) -> Gaussian {
        scan_matching::matched(at, &self.matched, &self.atlas.surfaces)
    }

    /// Checks the rays from a pose.
    pub(super) fn look_from(&self, at: &Gaussian, silent: Silent) -> Look {
        Look::from(self.atlas.map(), at, &self.rays, silent)
    }
}
