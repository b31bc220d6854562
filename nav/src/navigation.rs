//! Driving to goals: the state machine that plans, follows, waits, tries again and gives up.
//!
//! ```text
//!  idle --start--> thinking --path--> preparing_before_move --> moving --arrived--> goal_reached
//!                    |  ^                    ^                  |    ^
//!              no way|  |patience over       '----new path------'    |gone
//!                    v  |                                       v    |
//!  aborted <--- failing '------------------------------- waiting_obstacle
//! ```
//!
//! From everywhere: `stop` leads to idle, `pause` to paused, silent lasers or a pose that is not known to error.

mod goal;
mod parameters;
mod status;

use std::time::Duration;

use maps::{OccupancyGrid, Point, Pose};
use robot::{LaserScan, Odometry, RobotModel, VelocityCommand};

use crate::beams::Beams;
use crate::following::{Arrival, Follower, Phase, Progress, Route, Situation, Surroundings};
use crate::planning::{PlanError, plan, plan_into};
use crate::{Costmap, Error, PoseEstimate};

pub use goal::Goal;
pub use parameters::NavigationParameters;
pub use status::{GiveUpReason, NavigationStatus};

/// The path is held to be blocked by what lies on it up to so far ahead, in metres.
const LOOK_AHEAD_M: f64 = 4.0;

/// Stop and wait when the path is blocked nearer than this, in metres.
const STOP_BEFORE_M: f64 = 1.0;

/// Something stands in the way when the robot cannot move for so long.
const STUCK: Duration = Duration::from_millis(400);

/// Go on after waiting when the way has been free for so long.
const FREE_AGAIN: Duration = Duration::from_millis(300);

/// Time between two tries to find a way.
const TRY_AGAIN: Duration = Duration::from_secs(2);

/// Time in which the lasers see again what is still there after all marks have been forgotten.
const SEE_AGAIN: Duration = Duration::from_millis(300);

/// How often all marks are forgotten on one trip because there is no way.
const FORGET_TIMES: u32 = 3;

/// Nearer by this much is progress, in metres.
const PROGRESS_M: f64 = 0.1;

/// The longest time between two updates that counts in full, in seconds.
const LONGEST_STEP_S: f64 = 0.1;

/// Drives a robot to goals.
///
/// Feed it scans with [`scan`](Self::scan) and call [`update`](Self::update) at every step of control; it answers with the
/// velocity to drive at. It sees nothing but the map, scans, odometry and the estimate of the pose. It reads no clock and
/// draws no random numbers.
#[derive(Clone, Debug)]
pub struct Navigator {
    parameters: NavigationParameters,
    model: RobotModel,
    lasers: Vec<Beams>,
    costmap: Costmap,
    surroundings: Surroundings,
    status: NavigationStatus,
    reason: Option<GiveUpReason>,
    trip: Option<Trip>,
    last_update: Option<Duration>,
    last_scan: Option<Duration>,
}

/// What belongs to one goal.
#[derive(Clone, Debug)]
struct Trip {
    goal: Goal,
    follower: Option<Follower>,
    started: Option<Duration>,
    /// When the present status began.
    since: Duration,
    /// When the robot last could not move, since it last could.
    stuck_since: Option<Duration>,
    /// What keeps the robot from moving.
    obstacle: Option<Point>,
    /// When the way was seen to be free again, since it last was not.
    free_since: Option<Duration>,
    next_plan: Duration,
    /// The least way left so far on this path, and when it was reached.
    least_left_m: f64,
    progress_at: Duration,
    stalls: u32,
    blockages: u32,
    forgotten: u32,
    /// The costmap's generation at the last look along the path, and what was seen: the way to what blocks it.
    looked_at: Option<u64>,
    blocked_m: Option<f64>,
}

impl Trip {
    fn new(goal: Goal) -> Self {
        Self {
            goal,
            follower: None,
            started: None,
            since: Duration::ZERO,
            stuck_since: None,
            obstacle: None,
            free_since: None,
            next_plan: Duration::ZERO,
            least_left_m: f64::INFINITY,
            progress_at: Duration::ZERO,
            stalls: 0,
            blockages: 0,
            forgotten: 0,
            looked_at: None,
            blocked_m: None,
        }
    }
}

/// What an update knows.
#[derive(Clone, Copy)]
struct Now<'a> {
    time: Duration,
    dt_s: f64,
    at: &'a Pose,
    odometry: &'a Odometry,
}

impl Now<'_> {
    fn position(&self) -> Point {
        self.at.translation.vector.into()
    }
}

impl Navigator {
    /// A navigator on a map, idle.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter makes no sense.
    pub fn new(map: &OccupancyGrid, model: &RobotModel, parameters: NavigationParameters) -> Result<Self, Error> {
        parameters.check()?;
        Ok(Self {
            costmap: Costmap::new(map, parameters.costmap.clone())?,
            parameters,
            model: model.clone(),
            lasers: model.lasers.iter().map(Beams::new).collect(),
            surroundings: Surroundings::new(model.lasers.len()),
            status: NavigationStatus::Idle,
            reason: None,
            trip: None,
            last_update: None,
            last_scan: None,
        })
    }

    /// Starts for a goal, whatever went on before. The next update looks for a path.
    pub fn start(&mut self, goal: Goal) {
        self.reason = None;
        if goal.is_valid() {
            self.trip = Some(Trip::new(goal));
            self.status = NavigationStatus::Thinking;
        } else {
            self.give_up(NavigationStatus::Error, GiveUpReason::BadGoal);
        }
    }

    /// Forgets the goal and the outcome of the last trip: idle from now on.
    pub fn stop(&mut self) {
        self.status = NavigationStatus::Idle;
        self.reason = None;
        self.trip = None;
    }

    /// Stands still until [`resume`](Self::resume), if under way.
    pub fn pause(&mut self) {
        if self.status.is_under_way() {
            self.status = NavigationStatus::Paused;
        }
    }

    /// Looks for a path again and goes on, if paused.
    pub fn resume(&mut self) {
        if self.status == NavigationStatus::Paused {
            self.status = NavigationStatus::Thinking;
        }
    }

    /// What it is doing.
    #[must_use]
    pub fn status(&self) -> NavigationStatus {
        self.status
    }

    /// Why it gave up, while [`Aborted`](NavigationStatus::Aborted) or [`Error`](NavigationStatus::Error); why it is
    /// [`Failing`](NavigationStatus::Failing).
    #[must_use]
    pub fn reason(&self) -> Option<GiveUpReason> {
        self.reason
    }

    /// The goal that it is under way to.
    #[must_use]
    pub fn goal(&self) -> Option<&Goal> {
        self.trip.as_ref().map(|trip| &trip.goal)
    }

    /// The path that it follows, in the `map` frame, from where it was planned to its end; empty while there is none.
    #[must_use]
    pub fn path(&self) -> &[Point] {
        let follower = self.trip.as_ref().and_then(|trip| trip.follower.as_ref());
        follower.map_or(&[], |follower| follower.route().points())
    }

    /// The rest of the path, in metres, while there is one.
    #[must_use]
    pub fn remaining_m(&self) -> Option<f64> {
        let follower = self.trip.as_ref().and_then(|trip| trip.follower.as_ref());
        follower.map(|follower| follower.route().remaining_m())
    }

    /// The map with all that the lasers have seen beside it.
    #[must_use]
    pub fn costmap(&self) -> &Costmap {
        &self.costmap
    }

    /// Takes in a scan and the estimate of the pose at its time. Scans of lasers that the model does not have, and
    /// scans at a pose that is not finite, are ignored.
    pub fn scan(&mut self, scan: &LaserScan, estimate: &PoseEstimate) {
        let Some(beams) = self.lasers.get(scan.laser).filter(|_| is_finite(&estimate.pose)) else { return };
        self.costmap.take_in(scan, beams, &estimate.pose);
        self.costmap.clear_footprint(&estimate.pose.translation.vector.into());
        self.surroundings.take_in(scan, beams, &estimate.pose);
        self.last_scan = Some(scan.time);
    }

    /// One step of control at time `now`: goes on with what it is doing and returns the velocity to drive at until the next.
    pub fn update(&mut self, now: Duration, estimate: &PoseEstimate, odometry: &Odometry) -> VelocityCommand {
        let dt_s = self.last_update.map_or(0.0, |last| now.saturating_sub(last).as_secs_f64().min(LONGEST_STEP_S));
        self.last_update = Some(now);
        let Some(mut trip) = self.trip.take() else { return VelocityCommand::STOP };
        let started = *trip.started.get_or_insert(now);
        let now = Now { time: now, dt_s, at: &estimate.pose, odometry };
        if let Some(reason) = self.cannot_navigate(&now, started) {
            self.give_up(NavigationStatus::Error, reason);
            return VelocityCommand::STOP;
        }
        let command = match self.status {
            NavigationStatus::Thinking => self.think(&mut trip, &now),
            NavigationStatus::PreparingBeforeMove | NavigationStatus::Moving => self.follow(&mut trip, &now),
            NavigationStatus::WaitingObstacle => self.wait(&mut trip, &now),
            NavigationStatus::Failing => self.try_again(&mut trip, &now),
            _ => VelocityCommand::STOP,
        };
        if self.status.is_under_way() {
            self.trip = Some(trip);
        }
        command
    }

    fn cannot_navigate(&self, now: &Now<'_>, started: Duration) -> Option<GiveUpReason> {
        if !is_finite(now.at) {
            return Some(GiveUpReason::BadEstimate);
        }
        let last_scan = self.last_scan.map_or(started, |last| last.max(started));
        let silent = now.time.saturating_sub(last_scan);
        (silent > self.parameters.scan_patience && !self.lasers.is_empty()).then_some(GiveUpReason::NoScans(silent))
    }

    fn give_up(&mut self, status: NavigationStatus, reason: GiveUpReason) {
        self.status = status;
        self.reason = Some(reason);
        self.trip = None;
    }

    fn enter(&mut self, trip: &mut Trip, status: NavigationStatus, now: &Now<'_>) {
        self.status = status;
        trip.since = now.time;
    }

    /// Looks for a path, whatever its length.
    fn think(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        match self.find_path(trip, now) {
            Ok(path) => self.take_path(trip, path, now),
            Err(_) if trip.goal.area.as_ref().is_some_and(|area| area.contains(now.at)) => {
                self.status = NavigationStatus::GoalReached;
            }
            Err(error) => {
                self.reason = Some(error.into());
                trip.follower = None;
                trip.next_plan = now.time;
                self.enter(trip, NavigationStatus::Failing, now);
            }
        }
        VelocityCommand::STOP
    }

    fn find_path(&self, trip: &Trip, now: &Now<'_>) -> Result<Vec<Point>, PlanError> {
        let goal = &trip.goal;
        let path = plan(&self.costmap, &now.position(), &goal.position, goal.position_tolerance_m);
        match (&goal.area, path) {
            (Some(area), Err(_)) => plan_into(&self.costmap, &now.position(), area),
            (_, path) => path,
        }
    }

    fn take_path(&mut self, trip: &mut Trip, path: Vec<Point>, now: &Now<'_>) {
        let arrival = Arrival {
            heading_rad: trip.goal.heading_rad,
            position_tolerance_m: trip.goal.position_tolerance_m,
            heading_tolerance_rad: trip.goal.heading_tolerance_rad,
        };
        let command = trip.follower.as_ref().map_or(VelocityCommand::STOP, Follower::command);
        let route = Route::new(path);
        trip.follower = Some(Follower::new(&self.parameters.following, &self.model, route, arrival, now.at, command));
        trip.least_left_m = f64::INFINITY;
        trip.progress_at = now.time;
        trip.next_plan = now.time + self.parameters.planning_period;
        (trip.stuck_since, trip.obstacle, trip.looked_at, trip.blocked_m) = (None, None, None, None);
        self.reason = None;
        self.enter(trip, NavigationStatus::PreparingBeforeMove, now);
    }

    /// Follows the path, and looks whether it is free.
    fn follow(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        self.look_ahead(trip);
        if let Some(blocked_m) = trip.blocked_m {
            if now.time >= trip.next_plan {
                self.find_detour(trip, now);
            }
            if trip.blocked_m.is_some() && blocked_m < STOP_BEFORE_M {
                return self.stand(trip, now);
            }
        }
        let progress = self.step_follower(trip, now);
        if progress.off_path_m > self.parameters.off_path_m {
            self.enter(trip, NavigationStatus::Thinking, now);
            return VelocityCommand::STOP;
        }
        self.note_progress(trip, &progress, now);
        progress.command
    }

    fn step_follower(&mut self, trip: &mut Trip, now: &Now<'_>) -> Progress {
        let situation = Situation {
            at: now.at,
            odometry: now.odometry,
            dt_s: now.dt_s,
            costmap: &self.costmap,
            surroundings: &self.surroundings,
        };
        let follower = trip.follower.as_mut().expect("whoever moves has a path");
        let progress = follower.step(&situation);
        match follower.phase() {
            Phase::Arrived => self.status = NavigationStatus::GoalReached,
            Phase::Aligning | Phase::Aiming if self.status == NavigationStatus::PreparingBeforeMove => {}
            _ => self.status = NavigationStatus::Moving,
        }
        progress
    }

    /// Looks along the path for what lasers have marked on it, if anything has changed.
    fn look_ahead(&self, trip: &mut Trip) {
        let Some(follower) = &trip.follower else { return };
        if trip.looked_at == Some(self.costmap.generation()) && trip.blocked_m.is_none() {
            return;
        }
        trip.looked_at = Some(self.costmap.generation());
        let ahead = follower.route().points_ahead(LOOK_AHEAD_M);
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
        let left_m = trip.follower.as_ref().map_or(0.0, |follower| follower.route().remaining_m());
        let Ok(path) = self.find_path(trip, now) else { return };
        if length_m(&path) <= left_m + self.parameters.detour_m && self.count_blockage(trip) {
            self.take_path(trip, path, now);
        }
    }

    /// Counts one more blockage; false, and given up, if there have been too many.
    fn count_blockage(&mut self, trip: &mut Trip) -> bool {
        trip.blockages += 1;
        let few = trip.blockages <= self.parameters.blockages;
        if !few {
            self.give_up(NavigationStatus::Aborted, GiveUpReason::BlockedTooOften(trip.blockages));
        }
        few
    }

    /// Stops and waits for what is in the way to go away.
    fn stand(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        if self.status.is_under_way() {
            trip.free_since = None;
            self.enter(trip, NavigationStatus::WaitingObstacle, now);
        }
        VelocityCommand::STOP
    }

    /// Sees to it that a robot that does not move, or not nearer, does not stay so for ever.
    fn note_progress(&mut self, trip: &mut Trip, progress: &Progress, now: &Now<'_>) {
        let left_m = trip.follower.as_ref().map_or(0.0, |follower| follower.route().remaining_m());
        if left_m < trip.least_left_m - PROGRESS_M {
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
            // What the map explained away is real after all.
            self.costmap.mark(&obstacle);
            self.stand(trip, now);
        }
    }

    fn stall(&mut self, trip: &mut Trip, now: &Now<'_>) {
        trip.stalls += 1;
        if trip.stalls > self.parameters.stalls {
            let patience = self.parameters.progress_patience * trip.stalls;
            self.give_up(NavigationStatus::Aborted, GiveUpReason::NoProgress(patience));
        } else {
            self.enter(trip, NavigationStatus::Thinking, now);
        }
    }

    /// Waits for what is in the way; goes on when it is gone, looks for another way when patience is over.
    fn wait(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        self.look_ahead(trip);
        let is_free = trip.blocked_m.is_none_or(|blocked_m| blocked_m >= STOP_BEFORE_M)
            && trip.obstacle.is_none_or(|obstacle| !self.surroundings.is_near(&obstacle));
        if !is_free {
            trip.free_since = None;
        } else if now.time.saturating_sub(*trip.free_since.get_or_insert(now.time)) >= FREE_AGAIN {
            trip.progress_at = now.time;
            trip.stuck_since = None;
            self.enter(trip, NavigationStatus::Moving, now);
        }
        let waited = now.time.saturating_sub(trip.since) >= self.parameters.obstacle_patience;
        if self.status == NavigationStatus::WaitingObstacle && waited && self.count_blockage(trip) {
            self.enter(trip, NavigationStatus::Thinking, now);
        }
        VelocityCommand::STOP
    }

    /// Tries again to find a way, as long as what the lasers have seen may be why there is none.
    fn try_again(&mut self, trip: &mut Trip, now: &Now<'_>) -> VelocityCommand {
        let reason = self.reason.unwrap_or(GiveUpReason::NoPlan(PlanError::NoPath));
        let failed_for = now.time.saturating_sub(trip.since);
        let hopeless = trip.forgotten == 0 && self.costmap.marked().len() == 0;
        if hopeless || failed_for >= self.parameters.failing_patience {
            self.give_up(NavigationStatus::Aborted, reason);
        } else if now.time >= trip.next_plan {
            trip.next_plan = now.time + TRY_AGAIN;
            match self.find_path(trip, now) {
                Ok(path) => self.take_path(trip, path, now),
                Err(error) => {
                    self.reason = Some(error.into());
                    self.forget_marks(trip, now);
                }
            }
        }
        VelocityCommand::STOP
    }

    /// Forgets what the lasers have seen, for they may have seen it long ago, and tries again when they have looked anew.
    fn forget_marks(&mut self, trip: &mut Trip, now: &Now<'_>) {
        if trip.forgotten < FORGET_TIMES {
            trip.forgotten += 1;
            self.costmap.forget_marks();
            trip.next_plan = now.time + SEE_AGAIN;
        }
    }
}

fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().all(|coordinate| coordinate.is_finite()) && pose.rotation.angle().is_finite()
}

fn length_m(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}
