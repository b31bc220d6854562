//! The parameters of path following.

use robot::RobotModel;

use crate::Error;
use crate::error::{check, positive, require};

/// Parameters of path following. Names are those of Nav2's regulated pure pursuit where it has the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowingParameters {
    /// Undisturbed speed, in m/s, limited to the robot's maximum. Default 0.45.
    pub desired_linear_vel: f64,
    /// The robot looks ahead as far as it drives in this time, in seconds, within the two limits below. Default 1.2
    /// (Nav2: 1.5).
    pub lookahead_time: f64,
    /// Nearest point to steer for, in meters. Default 0.25 (Nav2: 0.3).
    pub min_lookahead_dist: f64,
    /// Farthest point to steer for, in meters. Default 0.5 (Nav2: 0.9): corners are cut by about its square divided by
    /// eight times the radius of the corner.
    pub max_lookahead_dist: f64,
    /// The robot turns in place if the point to steer for is farther to the side than this, in radians. Default 0.785.
    pub rotate_to_heading_min_angle: f64,
    /// The robot slows down in curves tighter than this radius, in proportion, in meters. Default 0.9.
    pub regulated_linear_scaling_min_radius: f64,
    /// The lowest speed in curves and near obstacles, in m/s. Default 0.15 (Nav2: 0.25).
    pub regulated_linear_scaling_min_speed: f64,
    /// The robot slows down if an obstacle is nearer to the body than this, in proportion, in meters. Default 0.25.
    pub cost_scaling_dist: f64,
    /// Share of the robot's acceleration used for slowing down in time. Default 0.7: the rest compensates for the delay
    /// between a command and its effect.
    pub braking_share: f64,
    /// Distance to keep from obstacles seen by lasers, in addition to the radius, in meters. Default 0.015.
    pub collision_margin: f64,
}

impl Default for FollowingParameters {
    fn default() -> Self {
        Self {
            desired_linear_vel: 0.45,
            lookahead_time: 1.2,
            min_lookahead_dist: 0.25,
            max_lookahead_dist: 0.5,
            rotate_to_heading_min_angle: 0.785,
            regulated_linear_scaling_min_radius: 0.9,
            regulated_linear_scaling_min_speed: 0.15,
            cost_scaling_dist: 0.25,
            braking_share: 0.7,
            collision_margin: 0.015,
        }
    }
}

impl FollowingParameters {
    /// The defaults for a robot: as fast as it can drive.
    #[must_use]
    pub fn of(model: &RobotModel) -> Self {
        Self { desired_linear_vel: model.max_linear_mps, ..Self::default() }
    }

    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first invalid one.
    pub fn check(&self) -> Result<(), Error> {
        let farther = self.max_lookahead_dist >= self.min_lookahead_dist;
        let is_share = self.braking_share > 0.0 && self.braking_share <= 1.0;
        check(&[
            positive("desired_linear_vel", self.desired_linear_vel),
            positive("lookahead_time", self.lookahead_time),
            positive("min_lookahead_dist", self.min_lookahead_dist),
            require("max_lookahead_dist", self.max_lookahead_dist, farther, "at least min_lookahead_dist"),
            positive("rotate_to_heading_min_angle", self.rotate_to_heading_min_angle),
            positive("regulated_linear_scaling_min_radius", self.regulated_linear_scaling_min_radius),
            positive("regulated_linear_scaling_min_speed", self.regulated_linear_scaling_min_speed),
            positive("cost_scaling_dist", self.cost_scaling_dist),
            require("braking_share", self.braking_share, is_share, "above 0 and at most 1"),
            require("collision_margin", self.collision_margin, self.collision_margin >= 0.0, "zero or positive"),
        ])
    }
}
