//! Path following: regulated pure pursuit, with a separate phase for coming to rest at the goal.
//!
//! Far from the goal, the robot steers for a point ahead on the path, on an arc that is free according to the lasers.
//! It drives more slowly in curves, near obstacles and near the end. Near the goal, it drives straight towards it,
//! stops there and turns to the required heading. If it misses the goal, it aims again from where it stands. So it
//! never circles the goal.
//!
//! Source of the pursuit: S. Macenski, S. Singh, F. Martín, J. Ginés, "Regulated Pure Pursuit for Robot Path Tracking",
//! Autonomous Robots 47, 2023.
//!
//! The distances and shares below were chosen, not measured one by one. `steward navigate --goals 100` measures them
//! together with the rest of navigation: 500 trips on five maps, all of which arrive without touching a wall.

mod parameters;
mod route;
mod smoothing;
mod surroundings;

use maps::{Point, Pose, heading, wrap_angle};
use robot::{Odometry, RobotModel, VelocityCommand};

use crate::Costmap;
use surroundings::FreeWay;

pub use parameters::FollowingParameters;
pub(crate) use route::Route;
pub(crate) use smoothing::VelocitySmoother;
pub(crate) use surroundings::Surroundings;

/// Within this distance of the goal, the robot drives straight towards it, in meters.
const CLOSING_M: f64 = 0.3;

/// Fastest approach to the goal within that distance, in m/s.
const CLOSING_MPS: f64 = 0.25;

/// Share of a tolerance that is aimed for; the rest is for stopping and for corrections of the estimate.
const AIMED_SHARE: f64 = 0.35;

/// The robot counts as facing its direction of travel below this error, in radians.
const FACING_RAD: f64 = 0.06;

/// The robot aims again if the goal is farther to the side than this, in radians.
const AIM_AGAIN_RAD: f64 = 0.4;

/// Below these speeds the robot is at rest, in m/s and rad/s.
const AT_REST_MPS: f64 = 0.02;
const AT_REST_RADPS: f64 = 0.03;

/// Shorter paths are not driven, in meters.
const SHORTEST_WAY_M: f64 = 0.03;

/// Distance to check beyond the braking distance, in meters.
const LOOK_BEYOND_M: f64 = 0.15;

/// Shares of the lookahead distance that are tried, until the arc is free.
const LOOKAHEAD_SHARES: [f64; 3] = [1.0, 0.6, 0.35];

/// Share of the robot's maximum turning rate that is used.
const TURNING_SHARE: f64 = 0.9;

/// When the end of the path counts as reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    pub(crate) heading_rad: Option<f64>,
    pub(crate) position_tolerance_m: f64,
    pub(crate) heading_tolerance_rad: f64,
}

/// The phase of following a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Turning in place to the direction of the path.
    Aligning,
    /// Driving along the path.
    Tracking,
    /// Turning in place towards the goal.
    Aiming,
    /// Driving straight towards the goal.
    Closing,
    /// Turning in place to the required heading.
    Turning,
    /// At rest at the goal.
    Arrived,
}

/// The inputs of a follower in each step.
#[derive(Clone, Copy)]
pub(crate) struct Situation<'a> {
    pub(crate) at: &'a Pose,
    pub(crate) odometry: &'a Odometry,
    /// The robot's speed, in m/s.
    pub(crate) speed_mps: f64,
    pub(crate) costmap: &'a Costmap,
    pub(crate) surroundings: &'a Surroundings,
}

/// The result of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// The desired velocity, whether or not the robot can reach it by the next step.
    pub(crate) wanted: VelocityCommand,
    /// How far the robot is from its path, in meters.
    pub(crate) off_path_m: f64,
    /// The obstacle that keeps the robot from moving.
    pub(crate) obstacle: Option<Point>,
}

/// Follows one path to its end.
#[derive(Clone, Debug)]
pub(crate) struct Follower {
    parameters: FollowingParameters,
    model: RobotModel,
    pub(crate) route: Route,
    arrival: Arrival,
    pub(crate) phase: Phase,
}

impl Follower {
    /// For a robot with this last commanded speed, in m/s.
    pub(crate) fn new(
        parameters: &FollowingParameters,
        model: &RobotModel,
        route: Route,
        arrival: Arrival,
        at: &Pose,
        commanded_mps: f64,
    ) -> Self {
        let distance_m = (route.end() - Point::from(at.translation.vector)).norm();
        let phase = if distance_m < AIMED_SHARE * arrival.position_tolerance_m {
            Phase::Turning
        } else if distance_m < CLOSING_M && route.remaining_m() < 2.0 * CLOSING_M {
            Phase::Aiming
        } else if commanded_mps > parameters.regulated_linear_scaling_min_speed {
            // Already driving; tracking turns in place if necessary.
            Phase::Tracking
        } else {
            Phase::Aligning
        };
        Self { parameters: parameters.clone(), model: model.clone(), route, arrival, phase }
    }

    /// One control step.
    pub(crate) fn step(&mut self, now: &Situation<'_>) -> Progress {
        let off_path_m = self.route.advance(&now.at.translation.vector.into());
        let (wanted, obstacle) = match self.phase {
            Phase::Aligning => (self.align(now), None),
            Phase::Tracking => self.track(now),
            Phase::Aiming => (self.aim(now), None),
            Phase::Closing => self.close(now),
            Phase::Turning => (self.turn(now), None),
            Phase::Arrived => (VelocityCommand::STOP, None),
        };
        Progress { wanted, off_path_m, obstacle }
    }

    fn align(&mut self, now: &Situation<'_>) -> VelocityCommand {
        let turn = bearing(now.at, &self.route.ahead(self.parameters.min_lookahead_dist));
        if turn.abs() < FACING_RAD {
            self.phase = Phase::Tracking;
        }
        self.turning(turn)
    }

    fn track(&mut self, now: &Situation<'_>) -> (VelocityCommand, Option<Point>) {
        let to_goal_m = (self.route.end() - Point::from(now.at.translation.vector)).norm();
        if to_goal_m < CLOSING_M && self.route.remaining_m() < 1.5 * CLOSING_M {
            self.phase = Phase::Closing;
            return self.close(now);
        }
        let lookahead_m = (now.speed_mps * self.parameters.lookahead_time)
            .clamp(self.parameters.min_lookahead_dist, self.parameters.max_lookahead_dist);
        if bearing(now.at, &self.route.ahead(lookahead_m)).abs() > self.parameters.rotate_to_heading_min_angle {
            self.phase = Phase::Aligning;
            return (self.align(now), None);
        }
        let (curvature, way) = self.freest_arc(now, lookahead_m);
        if way.way_m < SHORTEST_WAY_M && way.obstacle.is_some() {
            let turn = bearing(now.at, &self.route.ahead(lookahead_m * LOOKAHEAD_SHARES[2]));
            let obstacle = if turn.abs() < 2.0 * FACING_RAD { way.obstacle } else { None };
            return (self.turning(turn), obstacle);
        }
        let linear_mps = self.regulated_speed(now, curvature, &way);
        (VelocityCommand { linear_mps, angular_radps: linear_mps * curvature }, None)
    }

    /// The curvature of the arc to the farthest point ahead with a free arc, and the free distance on it.
    fn freest_arc(&self, now: &Situation<'_>, lookahead_m: f64) -> (f64, FreeWay) {
        let horizon_m = self.braking_m(now.speed_mps) + LOOK_BEYOND_M;
        let needed_m = self.model.radius_m + self.parameters.collision_margin;
        let mut best: Option<(f64, FreeWay)> = None;
        for share in LOOKAHEAD_SHARES {
            let seen = now.at.inverse_transform_point(&self.route.ahead(lookahead_m * share));
            let curvature = 2.0 * seen.y / seen.coords.norm_squared().max(1e-4);
            let way = now.surroundings.free_way(now.at, curvature, horizon_m, needed_m);
            if best.is_none_or(|(_, best)| way.way_m > best.way_m) {
                best = Some((curvature, way));
            }
            if way.obstacle.is_none() {
                break;
            }
        }
        best.expect("at least one arc is tried")
    }

    /// The highest speed that the curve, the obstacles, the free distance and the end of the path permit, in m/s.
    fn regulated_speed(&self, now: &Situation<'_>, curvature: f64, way: &FreeWay) -> f64 {
        let p = &self.parameters;
        let desired = p.desired_linear_vel.min(self.model.max_linear_mps);
        let least = p.regulated_linear_scaling_min_speed.min(desired);
        let in_curve = desired / (curvature.abs() * p.regulated_linear_scaling_min_radius).max(1.0);
        let turnable = TURNING_SHARE * self.model.max_angular_radps / curvature.abs().max(1e-6);
        let clearance_m = |point: &Point| now.costmap.clearance_m(point);
        let ahead = self.route.ahead(p.min_lookahead_dist);
        let clear_m = clearance_m(&now.at.translation.vector.into()).min(clearance_m(&ahead)) - self.model.radius_m;
        let beside_obstacles = desired * clear_m / p.cost_scaling_dist;
        let to_the_end = self.stoppable(self.route.remaining_m());
        let to_the_obstacle = if way.obstacle.is_some() { self.stoppable(way.way_m - SHORTEST_WAY_M) } else { desired };
        let regulated = in_curve.min(beside_obstacles).max(least).min(desired);
        regulated.min(turnable).min(to_the_end.max(CLOSING_MPS.min(desired))).min(to_the_obstacle)
    }

    fn aim(&mut self, now: &Situation<'_>) -> VelocityCommand {
        let turn = bearing(now.at, &self.route.end());
        if turn.abs() < FACING_RAD / 2.0 {
            self.phase = Phase::Closing;
        }
        self.turning(turn)
    }

    fn close(&mut self, now: &Situation<'_>) -> (VelocityCommand, Option<Point>) {
        let seen = now.at.inverse_transform_point(&self.route.end());
        let distance_m = seen.coords.norm();
        let off = libm::atan2(seen.y, seen.x);
        let beside = off.abs() > AIM_AGAIN_RAD;
        if distance_m < AIMED_SHARE * self.arrival.position_tolerance_m
            || (beside && distance_m < 2.0 * AIMED_SHARE * self.arrival.position_tolerance_m)
        {
            self.phase = Phase::Turning;
            return (self.turn(now), None);
        }
        if beside {
            self.phase = Phase::Aiming;
            return (self.aim(now), None);
        }
        let needed_m = self.model.radius_m + self.parameters.collision_margin;
        let way = now.surroundings.free_way(now.at, 0.0, distance_m, needed_m);
        if way.obstacle.is_some() && way.way_m < SHORTEST_WAY_M {
            return (VelocityCommand::STOP, way.obstacle);
        }
        let linear_mps =
            self.stoppable(way.way_m).min(CLOSING_MPS).min(self.parameters.desired_linear_vel) * libm::cos(off);
        (VelocityCommand { linear_mps, angular_radps: self.turning(off).angular_radps * 0.5 }, None)
    }

    fn turn(&mut self, now: &Situation<'_>) -> VelocityCommand {
        let at_rest = now.odometry.linear_mps.abs() < AT_REST_MPS && now.odometry.angular_radps.abs() < AT_REST_RADPS;
        let turn = self.arrival.heading_rad.map_or(0.0, |wanted| wrap_angle(wanted - heading(now.at)));
        if turn.abs() > AIMED_SHARE * self.arrival.heading_tolerance_rad {
            return self.turning(turn);
        }
        if at_rest {
            let distance_m = (self.route.end() - Point::from(now.at.translation.vector)).norm();
            let near = distance_m <= self.arrival.position_tolerance_m;
            self.phase = if near { Phase::Arrived } else { Phase::Aiming };
        }
        VelocityCommand::STOP
    }

    /// Turning in place by an angle, as fast as possible while still stopping in time.
    fn turning(&self, turn_rad: f64) -> VelocityCommand {
        let braking = self.parameters.braking_share * self.model.max_angular_acceleration_radps2;
        let rate = (2.0 * braking * turn_rad.abs()).sqrt().min(TURNING_SHARE * self.model.max_angular_radps);
        VelocityCommand { linear_mps: 0.0, angular_radps: rate.copysign(turn_rad) }
    }

    /// The greatest speed from which the robot can stop within a distance, in m/s.
    fn stoppable(&self, way_m: f64) -> f64 {
        let braking = self.parameters.braking_share * self.model.max_linear_acceleration_mps2;
        (2.0 * braking * way_m.max(0.0)).sqrt()
    }

    /// The braking distance, in meters.
    fn braking_m(&self, speed_mps: f64) -> f64 {
        braking_m(&self.model, &self.parameters, speed_mps)
    }
}

/// The greatest distance that a follower looks ahead on its arc, in meters.
pub(crate) fn farthest_look_m(model: &RobotModel, parameters: &FollowingParameters) -> f64 {
    CLOSING_M.max(braking_m(model, parameters, model.max_linear_mps) + LOOK_BEYOND_M)
}

/// The braking distance, in meters.
pub(crate) fn braking_m(model: &RobotModel, parameters: &FollowingParameters, speed_mps: f64) -> f64 {
    speed_mps * speed_mps / (2.0 * parameters.braking_share * model.max_linear_acceleration_mps2)
}

/// The direction of a point seen from a pose, in radians.
fn bearing(from: &Pose, to: &Point) -> f64 {
    let seen = from.inverse_transform_point(to);
    libm::atan2(seen.y, seen.x)
}
