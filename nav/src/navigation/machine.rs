//! The activities of a navigator in each status, and the transitions between them.
//!
//! Its distances and times were chosen; those for obstacles on the path were lowered when trips among people were
//! measured (`steward navigate --goals 100 --people 10`). None was measured alone.

use std::time::Duration;

use maps::Point;
use robot::VelocityCommand;

use super::recovery::Recovery;
use super::trip::Trip;
use super::{GiveUpReason, NavigationStatus, Navigator, Now, is_finite};
use crate::Costmap;
use crate::following::{Arrival, Follower, Phase, Progress, Route, Situation};
use crate::planning::{PlanError, plan, plan_into};

/// The path is blocked if there is an obstacle on it up to this distance ahead, in meters.
const LOOK_AHEAD_M: f64 = 2.5;

/// The path is checked again when the robot has advanced by this distance, in meters.
const LOOK_AGAIN_M: f64 = 0.1;

/// The robot stops and waits if the path is blocked nearer than this, in meters.
const STOP_BEFORE_M: f64 = 0.6;

/// A waiting robot accepts a detour that is longer by this multiple of the distance that it could have driven
/// meanwhile.
const DETOUR_FOR_WAITING: f64 = 3.0;

/// The robot is stuck when it cannot move for this long.
const STUCK: Duration = Duration::from_millis(400);

/// The robot continues after waiting when the path has been free for this long.
const FREE_AGAIN: Duration = Duration::from_millis(300);

/// Time between two attempts to find a path.
const TRY_AGAIN: Duration = Duration::from_secs(1);

/// Coming nearer to the goal by this much is progress, in meters.
const PROGRESS_M: f64 = 0.1;

impl Navigator {
    pub(super) fn cannot_navigate(&self, now: &Now<'_>, started: Duration) -> Option<GiveUpReason> {
        if !is_finite(now.at) {
            return Some(GiveUpReason::BadEstimate);
        }
        let blind = self.surroundings.blind_ahead_for(now.time, started);
        blind.filter(|blind| *blind > self.parameters.scan_patience).map(GiveUpReason::NoScans)
    }

    pub(super) fn give_up(&mut self, status: NavigationStatus, reason: GiveUpReason) {
        self.status = status;
        self.reason = Some(reason);
        self.trips_given_up += 1;
        self.trip = None;
    }

    /// Why there is no path. What closes the goal may be an area to keep out of: to the costmap, that is an obstacle.
    fn no_path(&self, trip: &Trip, error: PlanError) -> GiveUpReason {
        let PlanError::GoalInObstacle { clearance_m, .. } = error else { return error.into() };
        let closed = self.zones.as_ref().is_some_and(|zones| zones.closes(&trip.goal.position, clearance_m));
        if closed { GiveUpReason::GoalInZone } else { error.into() }
    }

    fn enter(&mut self, trip: &mut Trip, status: NavigationStatus, now: &Now<'_>) {
        self.status = status;
        trip.since = now.time;
    }

    /// Searches for a path of any length.
    pub(super) fn think(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        match find_path(&self.costmap, trip, now) {
            Ok(path) => self.take_path(trip, path, now),
            Err(_) if trip.goal.area.as_ref().is_some_and(|area| area.contains(now.at)) => {
                self.status = NavigationStatus::GoalReached;
            }
            Err(error) => {
                trip.follower = None;
                if self.is_hopeless(trip, now) {
                    self.give_up(NavigationStatus::Aborted, self.no_path(trip, error));
                } else {
                    self.fail(trip, self.no_path(trip, error), now);
                }
            }
        }
        VelocityCommand::STOP
    }

    /// There is currently no path.
    fn fail(&mut self, trip: &mut Trip, reason: GiveUpReason, now: &Now<'_>) {
        self.reason = Some(reason);
        trip.next_plan = now.time + TRY_AGAIN;
        (trip.attempt, trip.recoveries) = (None, 0);
        self.enter(trip, NavigationStatus::Failing, now);
    }

    /// Whether there is no path on the map alone, regardless of what the lasers have seen. A robot that seems to be in
    /// a wall may be elsewhere.
    fn is_hopeless(&self, trip: &Trip, now: &Now<'_>) -> bool {
        let mut unmarked = self.costmap.clone();
        unmarked.forget_marks();
        let on_the_map = find_path(&unmarked, trip, now);
        on_the_map.is_err_and(|error| !matches!(error, PlanError::StartOutside | PlanError::StartInObstacle))
    }

    fn take_path(&mut self, trip: &mut Trip, path: Vec<Point>, now: &Now<'_>) {
        // An end beside the goal leaves less tolerance; in an area any end is acceptable.
        let beside_m = path.last().map_or(0.0, |end| (end - trip.goal.position).norm());
        let missed_m = if trip.goal.area.is_some() { 0.0 } else { beside_m };
        let arrival = Arrival {
            heading_rad: trip.goal.heading_rad,
            position_tolerance_m: trip.goal.position_tolerance_m - missed_m,
            heading_tolerance_rad: trip.goal.heading_tolerance_rad,
        };
        let (route, commanded_mps) = (Route::new(path), self.smoother.command().linear_mps);
        trip.follower =
            Some(Follower::new(&self.parameters.following, &self.model, route, arrival, now.at, commanded_mps));
        trip.least_left_m = f64::INFINITY;
        trip.progress_at = now.time;
        trip.next_plan = now.time + self.parameters.planning_period;
        (trip.stuck_since, trip.obstacle, trip.looked, trip.blocked_m) = (None, None, None, None);
        trip.attempt = None;
        self.reason = None;
        self.enter(trip, NavigationStatus::PreparingBeforeMove, now);
    }

    /// Follows the path, and checks whether it is free.
    pub(super) fn follow(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        self.look_ahead(trip);
        if let Some(blocked_m) = trip.blocked_m {
            if now.time >= trip.next_plan {
                self.find_detour(trip, now);
            }
            if !self.status.is_under_way() {
                return VelocityCommand::STOP;
            }
            if trip.blocked_m.is_some() && blocked_m < STOP_BEFORE_M {
                return self.stand(trip, now);
            }
        }
        let progress = self.step_follower(trip, now);
        if self.status == NavigationStatus::GoalReached {
            return VelocityCommand::STOP;
        }
        if progress.off_path_m > self.parameters.off_path_m {
            self.enter(trip, NavigationStatus::Thinking, now);
            return VelocityCommand::STOP;
        }
        self.note_progress(trip, &progress, now);
        progress.wanted
    }

    fn step_follower(&mut self, trip: &mut Trip, now: &Now<'_>) -> Progress {
        let situation = Situation {
            at: now.at,
            odometry: now.odometry,
            speed_mps: self.smoother.speed_mps(),
            costmap: &self.costmap,
            surroundings: &self.surroundings,
        };
        let follower = trip.follower.as_mut().expect("a moving robot has a path");
        let progress = follower.step(&situation);
        match follower.phase {
            Phase::Arrived => self.status = NavigationStatus::GoalReached,
            Phase::Aligning | Phase::Aiming if self.status == NavigationStatus::PreparingBeforeMove => {}
            _ => self.status = NavigationStatus::Moving,
        }
        progress
    }

    /// Checks the path for obstacles marked by lasers, if anything has changed or the robot has advanced.
    fn look_ahead(&self, trip: &mut Trip) {
        let Some(follower) = &trip.follower else { return };
        let left_m = follower.route.remaining_m();
        let nothing_new = trip.looked.is_some_and(|(generation, before_m)| {
            generation == self.costmap.generation() && before_m - left_m < LOOK_AGAIN_M
        });
        if nothing_new && trip.blocked_m.is_none() {
            return;
        }
        trip.looked = Some((self.costmap.generation(), left_m));
        let ahead = follower.route.points_ahead(LOOK_AHEAD_M);
        let blocked = ahead
            .map(|(way_m, point)| (way_m, self.costmap.is_blocked_by_marks(&point)))
            // A path that begins too near to an obstacle leads away from it.
            .skip_while(|(_, blocked)| *blocked)
            .find(|(_, blocked)| *blocked);
        trip.blocked_m = blocked.map(|(way_m, _)| way_m);
    }

    /// Takes another path if it is not much longer.
    fn find_detour(&mut self, trip: &mut Trip, now: &Now<'_>) {
        trip.next_plan = now.time + self.parameters.planning_period;
        let left_m = trip.follower.as_ref().map_or(0.0, |follower| follower.route.remaining_m());
        let Ok(path) = find_path(&self.costmap, trip, now) else { return };
        if length_m(&path) <= left_m + self.parameters.detour_m && self.count_blockage(trip) {
            self.take_path(trip, path, now);
        }
    }

    /// Counts a blockage. Returns false, and gives up, if there have been too many.
    fn count_blockage(&mut self, trip: &mut Trip) -> bool {
        trip.blockages += 1;
        let few = trip.blockages <= self.parameters.blockages;
        if !few {
            self.give_up(NavigationStatus::Aborted, GiveUpReason::BlockedTooOften(trip.blockages));
        }
        few
    }

    /// Stops and waits for the obstacle to go away.
    fn stand(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        trip.free_since = None;
        self.enter(trip, NavigationStatus::WaitingObstacle, now);
        VelocityCommand::STOP
    }

    /// Prevents a robot that does not move, or does not get nearer, from staying there forever.
    fn note_progress(&mut self, trip: &mut Trip, progress: &Progress, now: &Now<'_>) {
        let left_m = trip.follower.as_ref().map_or(0.0, |follower| follower.route.remaining_m());
        if left_m < trip.least_left_m - PROGRESS_M {
            if trip.least_left_m.is_finite() {
                trip.stalls = 0;
            }
            (trip.least_left_m, trip.progress_at) = (left_m, now.time);
        }
        trip.obstacle = progress.obstacle;
        let Some(obstacle) = progress.obstacle else {
            trip.stuck_since = None;
            if now.time.saturating_sub(trip.progress_at) > self.parameters.progress_patience {
                self.stall(trip, now);
            }
            return;
        };
        if now.time.saturating_sub(*trip.stuck_since.get_or_insert(now.time)) >= STUCK {
            // The object that the map seemed to explain is real after all.
            self.costmap.mark(&obstacle);
            self.stand(trip, now);
        }
    }

    fn stall(&mut self, trip: &mut Trip, now: &Now<'_>) {
        trip.stalls += 1;
        if trip.stalls > self.parameters.stalls {
            let patience = self.parameters.progress_patience * trip.stalls;
            self.give_up(NavigationStatus::Aborted, GiveUpReason::NoProgress(patience));
        } else if trip.stalls == 1 {
            self.enter(trip, NavigationStatus::Thinking, now);
        } else {
            self.get_away(trip, GiveUpReason::NoProgress(self.parameters.progress_patience * trip.stalls), now);
        }
    }

    /// There is a path, but it does not work: begins with the recovery behaviors that move the robot.
    fn get_away(&mut self, trip: &mut Trip, reason: GiveUpReason, now: &Now<'_>) {
        self.fail(trip, reason, now);
        trip.recoveries = Recovery::FIRST_THAT_MOVES;
        trip.next_plan = Duration::MAX;
    }

    /// Waits for the obstacle to go away; continues when it is gone, searches for another path when patience has run
    /// out.
    pub(super) fn wait(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        self.look_ahead(trip);
        let is_free = trip.blocked_m.is_none_or(|blocked_m| blocked_m >= STOP_BEFORE_M)
            && trip.obstacle.is_none_or(|obstacle| !self.surroundings.is_near(&obstacle));
        let patience_over = now.time.saturating_sub(trip.since) >= self.parameters.obstacle_patience;
        if !is_free {
            trip.free_since = None;
            if !patience_over && trip.obstacle.is_none() && now.time >= trip.next_plan {
                self.find_detour(trip, now);
            }
        } else if now.time.saturating_sub(*trip.free_since.get_or_insert(now.time)) >= FREE_AGAIN {
            trip.progress_at = now.time;
            trip.stuck_since = None;
            self.enter(trip, NavigationStatus::Moving, now);
        }
        // Judged after the check above, so that a robot whose path has just become free does not plan again.
        let waits = self.status == NavigationStatus::WaitingObstacle && patience_over;
        if waits && !self.is_better_to_wait(trip, now) && self.count_blockage(trip) {
            if trip.wait_in_vain(&now.position()) {
                self.get_away(trip, GiveUpReason::BlockedTooOften(trip.blockages), now);
            } else {
                self.enter(trip, NavigationStatus::Thinking, now);
            }
        }
        VelocityCommand::STOP
    }

    /// Whether the only other path is so long that the obstacle on this one will probably be gone sooner. The longer
    /// the robot has waited, the longer the detour that it accepts.
    fn is_better_to_wait(&self, trip: &mut Trip, now: &Now<'_>) -> bool {
        if now.time < trip.next_plan {
            return true;
        }
        trip.next_plan = now.time + self.parameters.planning_period;
        let left_m = trip.follower.as_ref().map_or(0.0, |follower| follower.route.remaining_m());
        let waited_s = now.time.saturating_sub(trip.since).as_secs_f64();
        let worth_m = self.parameters.detour_m + DETOUR_FOR_WAITING * self.model.max_linear_mps * waited_s;
        find_path(&self.costmap, trip, now).is_ok_and(|path| length_m(&path) > left_m + worth_m)
    }

    /// Recovers: performs one behavior after another and searches for a path after each one and every second, as long
    /// as obstacles seen by lasers may be the reason why there is none.
    pub(super) fn try_again(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        let reason = self.reason.unwrap_or(GiveUpReason::NoPlan(PlanError::NoPath));
        let failed_for = now.time.saturating_sub(trip.since);
        if failed_for >= self.parameters.failing_patience {
            self.give_up(NavigationStatus::Aborted, reason);
            return VelocityCommand::STOP;
        }
        let (command, done) = self.recover(trip, now);
        if done || now.time >= trip.next_plan {
            trip.next_plan = now.time + TRY_AGAIN;
            match find_path(&self.costmap, trip, now) {
                Ok(path) => {
                    self.take_path(trip, path, now);
                    return VelocityCommand::STOP;
                }
                Err(error) => self.reason = Some(self.no_path(trip, error)),
            }
        }
        command
    }
}

fn find_path(costmap: &Costmap, trip: &Trip, now: &Now<'_>) -> Result<Vec<Point>, PlanError> {
    let goal = &trip.goal;
    let path = plan(costmap, &now.position(), &goal.position, goal.plan_tolerance_m());
    match (&goal.area, path) {
        (Some(area), Err(_)) => plan_into(costmap, &now.position(), area),
        (_, path) => path,
    }
}

fn length_m(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}
