//! The navigator's recovery: the recovery behaviors of Nav2's trees, one after another.

use maps::{Point, pose};
use robot::VelocityCommand;

use super::recovery::{Attempt, Recovery};
use super::trip::Trip;
use super::{Navigator, Now};

/// The distance behind the robot that is checked while it backs up, in meters; it stops when less than the second is
/// free.
const LOOK_BEHIND_M: f64 = 0.25;
const FREE_BEHIND_M: f64 = 0.1;

impl Navigator {
    /// Continues the current recovery behavior, or begins the next; true in the first step after one is finished.
    pub(super) fn recover(&mut self, trip: &mut Trip, now: &Now<'_>) -> (VelocityCommand, bool) {
        let mut attempt = match trip.attempt.take() {
            Some(attempt) => attempt,
            None => self.begin_recovery(trip, now),
        };
        let command = attempt.step(now, || self.is_free_behind(now));
        match command {
            Some(command) => {
                trip.attempt = Some(attempt);
                (command, false)
            }
            None => (VelocityCommand::STOP, true),
        }
    }

    fn begin_recovery(&mut self, trip: &mut Trip, now: &Now<'_>) -> Attempt {
        let attempt = Attempt::begin(trip.recoveries, now);
        trip.recoveries += 1;
        if attempt.recovery == Recovery::ClearCostmap {
            self.costmap.forget_marks();
        }
        attempt
    }

    /// Whether the robot can back up a little: neither lasers nor the costmap have an obstacle there, and a laser looks
    /// there.
    fn is_free_behind(&self, now: &Now<'_>) -> bool {
        let needed_m = self.model.radius_m + self.parameters.following.collision_margin;
        let back = now.at * pose(0.0, 0.0, std::f64::consts::PI);
        let is_seen_free = self.surroundings.free_way(&back, 0.0, LOOK_BEHIND_M, needed_m).way_m >= FREE_BEHIND_M;
        let behind = back * Point::new(FREE_BEHIND_M, 0.0);
        let room_m = self.costmap.clearance_m(&behind);
        let is_known_free = room_m >= self.model.radius_m.min(self.costmap.clearance_m(&now.position()));
        is_seen_free && is_known_free && self.surroundings.sees_behind(now.time, self.parameters.scan_patience)
    }
}
