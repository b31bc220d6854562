//! Driving to goals: the state machine that plans, follows, waits, retries and gives up.
//!
//! ```text
//!  idle --start--> thinking --path--> preparing_before_move --> moving --arrived--> goal_reached
//!                    |  ^                    ^                  |    ^
//!              no way|  |patience over       '----new path------'    |gone
//!                    v  |                                       v    |
//!  aborted <--- failing '------------------------------- waiting_obstacle
//! ```
//!
//! While it is failing, it performs recovery behaviors one after another ([`Recovery`]) and keeps searching for a path.
//! From every state, `stop` leads to idle; an unknown pose leads to error, as does a silent laser if no other looks
//! ahead.

mod machine;
mod now;
mod parameters;
mod recovering;
mod recovery;
mod status;
mod trip;
mod zone_rules;

use std::time::Duration;

use maps::{OccupancyGrid, Point, Pose};
use robot::{LaserScan, Odometry, RobotModel, VelocityCommand};

use crate::beams::Beams;
use crate::error::{check, positive};
use crate::following::{Surroundings, VelocitySmoother, braking_m, farthest_look_m};
use crate::{Atlas, Costmap, Error, Goal, PoseEstimate};
use now::Now;
use trip::Trip;
use zone_rules::ZoneRules;

pub use parameters::NavigationParameters;
pub use recovery::Recovery;
pub use status::{GiveUpReason, NavigationStatus};

/// The longest time between two updates that counts in full, in seconds. After a longer one, the robot starts from
/// rest.
const LONGEST_STEP_S: f64 = 0.1;

/// The estimate has jumped if it is this far from that at the last scan, in meters: the robot was believed to be
/// elsewhere.
const JUMP_M: f64 = 1.0;

/// Drives a robot to goals.
///
/// Pass scans to [`scan`](Self::scan), and call [`update`](Self::update) in every control step; it returns the velocity
/// to drive at. It uses only the map, scans, odometry and the estimate of the pose. It reads no clock and draws no
/// random numbers.
#[derive(Clone, Debug)]
pub struct Navigator {
    parameters: NavigationParameters,
    model: RobotModel,
    lasers: Vec<Beams>,
    costmap: Costmap,
    zones: Option<ZoneRules>,
    surroundings: Surroundings,
    smoother: VelocitySmoother,
    status: NavigationStatus,
    reason: Option<GiveUpReason>,
    restarts: u64,
    trips_started: u64,
    trips_given_up: u64,
    trip: Option<Trip>,
    last_update: Option<Duration>,
    /// The believed pose at the last scan.
    scanned_at: Option<Pose>,
}

impl Navigator {
    /// A navigator on a map, idle.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter, or one of the robot, is invalid.
    pub fn new(map: &OccupancyGrid, model: &RobotModel, parameters: NavigationParameters) -> Result<Self, Error> {
        check_robot(model)?;
        parameters.check()?;
        let costmap = Costmap::new(map, parameters.costmap.clone())?;
        Ok(Self::with(costmap, model, parameters))
    }

    /// A navigator of the atlas's robot on its map and in its zones, idle.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter, or one of the robot, is invalid.
    pub fn on(atlas: &Atlas, parameters: NavigationParameters) -> Result<Self, Error> {
        check_robot(atlas.model())?;
        parameters.check()?;
        let costmap = Costmap::on(atlas, parameters.costmap.clone())?;
        let zones = atlas.zones.as_ref().map(ZoneRules::new);
        Ok(Self { zones, ..Self::with(costmap, atlas.model(), parameters) })
    }

    fn with(costmap: Costmap, model: &RobotModel, parameters: NavigationParameters) -> Self {
        Self {
            surroundings: Surroundings::new(model, farthest_look_m(model, &parameters.following)),
            costmap,
            zones: None,
            parameters,
            model: model.clone(),
            lasers: model.lasers.iter().map(Beams::new).collect(),
            smoother: VelocitySmoother::new(model),
            status: NavigationStatus::Idle,
            reason: None,
            restarts: 0,
            trips_started: 0,
            trips_given_up: 0,
            trip: None,
            last_update: None,
            scanned_at: None,
        }
    }

    /// Ignores the zones with these names, and respects all others: a malfunction.
    pub fn ignore_zones(&mut self, is_ignored: impl Fn(&str) -> bool) {
        if let Some(zones) = &mut self.zones {
            zones.ignore(is_ignored);
        }
    }

    /// Starts a trip to a goal and abandons any other trip. The next update searches for a path.
    pub fn start(&mut self, goal: Goal) {
        self.trips_started += 1;
        self.reason = None;
        if goal.is_valid() {
            self.trip = Some(Trip::new(goal));
            self.status = NavigationStatus::Thinking;
        } else {
            self.give_up(NavigationStatus::Error, GiveUpReason::BadGoal);
        }
    }

    /// Forgets the goal and the outcome of the last trip; the navigator is idle afterwards.
    pub fn stop(&mut self) {
        self.status = NavigationStatus::Idle;
        self.reason = None;
        self.trip = None;
    }

    /// Returns to the initial state: forgets the goal and everything that the lasers have seen.
    pub fn restart(&mut self) {
        self.restarts += 1;
        self.stop();
        self.costmap.forget_marks();
        let horizon_m = farthest_look_m(&self.model, &self.parameters.following);
        self.surroundings = Surroundings::new(&self.model, horizon_m);
        self.smoother = VelocitySmoother::new(&self.model);
        (self.last_update, self.scanned_at) = (None, None);
    }

    /// The navigator's status.
    #[must_use]
    pub fn status(&self) -> NavigationStatus {
        self.status
    }

    /// Why it gave up, in [`Aborted`](NavigationStatus::Aborted) or [`Error`](NavigationStatus::Error), or why it is
    /// [`Failing`](NavigationStatus::Failing).
    #[must_use]
    pub fn reason(&self) -> Option<GiveUpReason> {
        self.reason
    }

    /// How often it has returned to the initial state.
    #[must_use]
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// How many trips it has started.
    #[must_use]
    pub fn trips_started(&self) -> u64 {
        self.trips_started
    }

    /// How many trips it has given up.
    #[must_use]
    pub fn trips_given_up(&self) -> u64 {
        self.trips_given_up
    }

    /// The current recovery behavior, in [`Failing`](NavigationStatus::Failing).
    #[must_use]
    pub fn recovery(&self) -> Option<Recovery> {
        let attempt = self.trip.as_ref().and_then(|trip| trip.attempt.as_ref());
        attempt.filter(|_| self.status == NavigationStatus::Failing).map(|attempt| attempt.recovery)
    }

    /// The goal of the current trip.
    #[must_use]
    pub fn goal(&self) -> Option<&Goal> {
        self.trip.as_ref().map(|trip| &trip.goal)
    }

    /// The current path, in the `map` frame, from where it was planned to its end; empty if there is none.
    #[must_use]
    pub fn path(&self) -> &[Point] {
        let follower = self.trip.as_ref().and_then(|trip| trip.follower.as_ref());
        follower.map_or(&[], |follower| follower.route.points())
    }

    /// The remaining length of the path, in meters, if there is one.
    #[must_use]
    pub fn remaining_m(&self) -> Option<f64> {
        let follower = self.trip.as_ref().and_then(|trip| trip.follower.as_ref());
        follower.map(|follower| follower.route.remaining_m())
    }

    /// The map, with all obstacles that the lasers have seen.
    #[must_use]
    pub fn costmap(&self) -> &Costmap {
        &self.costmap
    }

    /// Processes a scan and the estimate of the pose at its time. Scans of lasers that the model does not have, and
    /// scans at a pose that is not finite, are ignored.
    pub fn scan(&mut self, scan: &LaserScan, estimate: &PoseEstimate) {
        let Some(beams) = self.lasers.get(scan.laser).filter(|_| is_finite(&estimate.pose)) else { return };
        let jumped = |before: Pose| (before.translation.vector - estimate.pose.translation.vector).norm() > JUMP_M;
        if self.scanned_at.replace(estimate.pose).is_some_and(jumped) {
            // Obstacles marked from a wrong pose are in the wrong place.
            self.costmap.forget_marks();
        }
        self.costmap.take_in(scan, beams, &estimate.pose);
        self.costmap.clear_footprint(&estimate.pose.translation.vector.into());
        self.surroundings.take_in(scan, beams, &estimate.pose);
    }

    /// One control step at time `now`. Returns the velocity to drive at until the next step.
    pub fn update(&mut self, now: Duration, estimate: &PoseEstimate, odometry: &Odometry) -> VelocityCommand {
        let passed_s = self.last_update.map_or(0.0, |last| now.saturating_sub(last).as_secs_f64());
        self.last_update = Some(now);
        if passed_s > LONGEST_STEP_S {
            self.smoother = VelocitySmoother::new(&self.model);
        }
        self.surroundings.update(now, self.parameters.scan_patience);
        let now = Now { time: now, at: &estimate.pose, odometry };
        self.close_zones(&now.position());
        let wanted = self.wanted(&now);
        let wanted = self.slowed(wanted, &now.position());
        self.smoother.step(wanted, odometry, passed_s.min(LONGEST_STEP_S))
    }

    /// Closes the areas to keep out of for a robot at this point, and searches for another path if they have changed.
    fn close_zones(&mut self, at: &Point) {
        let Some(fixed) = self.zones.as_mut().and_then(|zones| zones.changed(at)) else { return };
        self.costmap.put_on(fixed);
        if self.status.is_under_way() {
            self.status = NavigationStatus::Thinking;
        }
    }

    /// A velocity that keeps the speeds of zones: of those here, and of those ahead from which the robot could no
    /// longer slow down in time. It stays on its arc.
    fn slowed(&self, wanted: VelocityCommand, at: &Point) -> VelocityCommand {
        let Some(zones) = &self.zones else { return wanted };
        let braking_mps2 = self.parameters.following.braking_share * self.model.max_linear_acceleration_mps2;
        let farthest_m = braking_m(&self.model, &self.parameters.following, self.model.max_linear_mps);
        let route = self.trip.as_ref().and_then(|trip| trip.follower.as_ref()).map(|follower| &follower.route);
        let ahead = route.into_iter().flat_map(|route| route.points_ahead(farthest_m));
        let limits = ahead.chain([(0.0, *at)]).map(|(way_m, point)| zones.speed_mps(&point, way_m, braking_mps2));
        let limit_mps = limits.fold(f64::INFINITY, f64::min);
        let share = (limit_mps / wanted.linear_mps.abs()).min(1.0);
        VelocityCommand { linear_mps: wanted.linear_mps * share, angular_radps: wanted.angular_radps * share }
    }

    /// Continues the current activity and returns the desired velocity.
    fn wanted(&mut self, now: &Now<'_>) -> VelocityCommand {
        let Some(mut trip) = self.trip.take() else { return VelocityCommand::STOP };
        let started = *trip.started.get_or_insert(now.time);
        if let Some(reason) = self.cannot_navigate(now, started) {
            self.give_up(NavigationStatus::Error, reason);
            return VelocityCommand::STOP;
        }
        if !self.surroundings.sees_ahead(now.time, self.parameters.scan_patience) {
            // Nothing has been seen yet, or not recently.
            self.trip = Some(trip);
            return VelocityCommand::STOP;
        }
        let wanted = match self.status {
            NavigationStatus::Thinking => self.think(&mut trip, now),
            NavigationStatus::PreparingBeforeMove | NavigationStatus::Moving => self.follow(&mut trip, now),
            NavigationStatus::WaitingObstacle => self.wait(&mut trip, now),
            NavigationStatus::Failing => self.try_again(&mut trip, now),
            _ => VelocityCommand::STOP,
        };
        if self.status.is_under_way() {
            self.trip = Some(trip);
        }
        wanted
    }
}

fn check_robot(model: &RobotModel) -> Result<(), Error> {
    check(&[
        positive("radius_m", model.radius_m),
        positive("max_linear_mps", model.max_linear_mps),
        positive("max_angular_radps", model.max_angular_radps),
        positive("max_linear_acceleration_mps2", model.max_linear_acceleration_mps2),
        positive("max_angular_acceleration_radps2", model.max_angular_acceleration_radps2),
    ])
}

fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().all(|coordinate| coordinate.is_finite()) && pose.rotation.angle().is_finite()
}
