//! Checks the settings of a simulation.

use std::time::Duration;

use maps::{Point, Pose, Shape};
use robot::{LaserSpec, RobotModel};

use crate::config::{
    BatteryConfig, DockingConfig, Door, DriftNoise, DriveConfig, Follow, ObstacleConfig, ObstacleMotion,
    OdometryConfig, SimConfig, Walk,
};
use crate::error::BadSetting;

impl SimConfig {
    /// Every setting with an invalid value.
    #[must_use]
    pub fn bad_settings(&self) -> Vec<BadSetting> {
        let mut check = Check::default();
        check.model(&self.model);
        check.duration("dt", self.dt);
        check.positive("body.mass_kg", self.body.mass_kg);
        check.not_negative("body.friction", self.body.friction);
        check.drive(&self.drive);
        check.odometry(&self.odometry);
        check.not_negative("lasers.range_sigma_m", self.lasers.range_sigma_m);
        check.battery(&self.battery);
        check.docking(&self.docking);
        for (index, obstacle) in self.obstacles.iter().enumerate() {
            check.obstacle(&format!("obstacles[{index}]"), obstacle);
        }
        check.bad
    }
}

/// Whether a body can be placed in the world.
pub(crate) fn is_sound(obstacle: &ObstacleConfig) -> bool {
    let mut check = Check::default();
    check.obstacle("", obstacle);
    check.bad.is_empty()
}

/// Collects problems.
#[derive(Default)]
pub(crate) struct Check {
    pub(crate) bad: Vec<BadSetting>,
}

impl Check {
    pub(crate) fn that(
        &mut self,
        holds: bool,
        setting: impl Into<String>,
        value: impl ToString,
        accepted: &'static str,
    ) {
        if !holds {
            self.bad.push(BadSetting { setting: setting.into(), value: value.to_string(), accepted });
        }
    }

    pub(crate) fn positive(&mut self, setting: impl Into<String>, value: f64) {
        self.that(value > 0.0 && value.is_finite(), setting, value, "greater than 0");
    }

    pub(crate) fn not_negative(&mut self, setting: impl Into<String>, value: f64) {
        self.that(value >= 0.0 && value.is_finite(), setting, value, "at least 0");
    }

    pub(crate) fn finite(&mut self, setting: impl Into<String>, value: f64) {
        self.that(value.is_finite(), setting, value, "a finite number");
    }

    fn percent(&mut self, setting: impl Into<String>, value: f64) {
        self.that((0.0..=100.0).contains(&value), setting, value, "from 0 to 100");
    }

    fn duration(&mut self, setting: impl Into<String>, value: Duration) {
        self.that(!value.is_zero(), setting, value.as_secs_f64(), "longer than 0 s");
    }

    pub(crate) fn pose(&mut self, setting: &str, pose: &Pose) {
        self.finite(format!("{setting}.x"), pose.translation.x);
        self.finite(format!("{setting}.y"), pose.translation.y);
        self.finite(format!("{setting}.heading"), pose.rotation.angle());
    }

    fn model(&mut self, model: &RobotModel) {
        self.positive("model.radius_m", model.radius_m);
        self.positive("model.max_linear_mps", model.max_linear_mps);
        self.positive("model.max_angular_radps", model.max_angular_radps);
        self.positive("model.max_linear_acceleration_mps2", model.max_linear_acceleration_mps2);
        self.positive("model.max_angular_acceleration_radps2", model.max_angular_acceleration_radps2);
        model.lasers.iter().enumerate().for_each(|(index, laser)| self.laser(index, laser));
    }

    fn laser(&mut self, index: usize, laser: &LaserSpec) {
        let at = |field: &str| format!("model.lasers[{index}].{field}");
        self.pose(&at("mount"), &laser.mount);
        self.finite(at("angle_min_rad"), laser.angle_min_rad);
        self.positive(at("angle_increment_rad"), laser.angle_increment_rad);
        self.that(laser.beams > 0, at("beams"), laser.beams as f64, "at least 1");
        self.duration(at("period"), laser.period);
        self.not_negative(at("range_min_m"), laser.range_min_m);
        let longer = laser.range_max_m > laser.range_min_m && laser.range_max_m.is_finite();
        self.that(longer, at("range_max_m"), laser.range_max_m, "greater than range_min_m");
    }

    fn drive(&mut self, drive: &DriveConfig) {
        self.positive("drive.wheel_separation_m", drive.wheel_separation_m);
        self.positive("drive.max_wheel_mps", drive.max_wheel_mps);
        self.noise("drive.noise", &drive.noise);
    }

    fn noise(&mut self, setting: &str, noise: &DriftNoise) {
        self.not_negative(format!("{setting}.angle_per_sqrt_rad"), noise.angle_per_sqrt_rad);
        self.not_negative(format!("{setting}.angle_per_sqrt_m"), noise.angle_per_sqrt_m);
        self.not_negative(format!("{setting}.distance_per_sqrt_m"), noise.distance_per_sqrt_m);
        self.not_negative(format!("{setting}.distance_per_sqrt_rad"), noise.distance_per_sqrt_rad);
    }

    fn odometry(&mut self, odometry: &OdometryConfig) {
        self.duration("odometry.period", odometry.period);
        self.noise("odometry.noise", &odometry.noise);
        self.finite("odometry.distance_bias", odometry.distance_bias);
        self.finite("odometry.angle_bias", odometry.angle_bias);
        self.finite("odometry.angle_bias_rad_per_m", odometry.angle_bias_rad_per_m);
    }

    fn battery(&mut self, battery: &BatteryConfig) {
        self.percent("battery.initial_pct", battery.initial_pct);
        self.not_negative("battery.drain_pct_per_s", battery.drain_pct_per_s);
        self.not_negative("battery.standstill_drain_pct_per_s", battery.standstill_drain_pct_per_s);
        self.not_negative("battery.charge_pct_per_s", battery.charge_pct_per_s);
        self.percent("battery.full_pct", battery.full_pct);
        let again = (0.0..=battery.full_pct).contains(&battery.recharge_below_pct);
        self.that(again, "battery.recharge_below_pct", battery.recharge_below_pct, "from 0 to battery.full_pct");
        self.duration("battery.period", battery.period);
    }

    fn docking(&mut self, docking: &DockingConfig) {
        self.positive("docking.distance_m", docking.distance_m);
        self.positive("docking.angle_rad", docking.angle_rad);
    }

    /// Checks the obstacle whose settings have this path.
    pub(crate) fn obstacle(&mut self, path: &str, obstacle: &ObstacleConfig) {
        let at = |field: &str| format!("{path}.{field}");
        match obstacle.shape {
            Shape::Disc { radius_m } => self.positive(at("shape.radius_m"), radius_m),
            Shape::Box { length_m, width_m } => {
                self.positive(at("shape.length_m"), length_m);
                self.positive(at("shape.width_m"), width_m);
            }
        }
        self.pose(&at("pose"), &obstacle.pose);
        match &obstacle.motion {
            ObstacleMotion::Fixed => {}
            ObstacleMotion::Movable { mass_kg } => self.positive(at("motion.mass_kg"), *mass_kg),
            ObstacleMotion::Person(walk) => self.walk(&at("motion"), walk),
            ObstacleMotion::Follower(follow) => self.follow(&at("motion"), follow),
            ObstacleMotion::Door(door) => self.door(&at("motion"), door),
            ObstacleMotion::Route { waypoints, speed_mps, .. } => {
                self.positive(at("motion.speed_mps"), *speed_mps);
                self.that(!waypoints.is_empty(), at("motion.waypoints"), waypoints.len() as f64, "at least one point");
                self.waypoints(&at("motion.waypoints"), waypoints);
            }
        }
    }

    /// People without waypoints stand still.
    fn walk(&mut self, path: &str, walk: &Walk) {
        self.positive(format!("{path}.speed_mps"), walk.speed_mps);
        self.waypoints(&format!("{path}.waypoints"), &walk.waypoints);
        if let Some(manners) = &walk.manners {
            self.not_negative(format!("{path}.manners.stop_within_m"), manners.stop_within_m);
            let slows = manners.slow_within_m > manners.stop_within_m;
            self.that(
                slows,
                format!("{path}.manners.slow_within_m"),
                manners.slow_within_m,
                "greater than stop_within_m",
            );
        }
    }

    fn follow(&mut self, path: &str, follow: &Follow) {
        self.positive(format!("{path}.distance_m"), follow.distance_m);
        self.positive(format!("{path}.meets_within_m"), follow.meets_within_m);
        self.positive(format!("{path}.speed_mps"), follow.speed_mps);
        for (number, (from, to)) in follow.stands.iter().enumerate() {
            let setting = format!("{path}.stands[{number}]");
            self.that(from < to, setting, to.as_secs_f64(), "later than when the person begins to stand");
        }
    }

    fn waypoints(&mut self, path: &str, waypoints: &[Point]) {
        for (number, waypoint) in waypoints.iter().enumerate() {
            self.finite(format!("{path}[{number}].x"), waypoint.x);
            self.finite(format!("{path}[{number}].y"), waypoint.y);
        }
    }

    fn door(&mut self, path: &str, door: &Door) {
        for (number, (from, to)) in door.closed.iter().enumerate() {
            let setting = format!("{path}.closed[{number}]");
            self.that(from < to, setting, to.as_secs_f64(), "later than when the door begins to close");
        }
        if let Some(every) = door.every {
            self.duration(format!("{path}.every"), every);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_valid() {
        assert_eq!(SimConfig::default().bad_settings(), []);
    }

    #[test]
    fn every_invalid_setting_is_named_with_its_value() {
        let mut config = SimConfig { dt: Duration::ZERO, ..SimConfig::default() };
        config.model.lasers[1].range_max_m = 0.05;
        config.battery.initial_pct = 120.0;
        config.drive.noise.angle_per_sqrt_m = f64::NAN;
        let bad: Vec<String> = config.bad_settings().iter().map(ToString::to_string).collect();
        assert_eq!(
            bad,
            [
                "model.lasers[1].range_max_m is 0.05, must be greater than range_min_m",
                "dt is 0, must be longer than 0 s",
                "drive.noise.angle_per_sqrt_m is NaN, must be at least 0",
                "battery.initial_pct is 120, must be from 0 to 100",
            ]
        );
    }

    #[test]
    fn a_route_needs_a_waypoint_and_a_speed() {
        let motion = ObstacleMotion::Route { waypoints: Vec::new(), speed_mps: 0.0, end: crate::RouteEnd::Loop };
        let obstacle = ObstacleConfig {
            name: "person".to_owned(),
            shape: Shape::Disc { radius_m: 0.2 },
            pose: Pose::identity(),
            motion,
        };
        let config = SimConfig { obstacles: vec![obstacle], ..SimConfig::default() };
        let bad: Vec<String> = config.bad_settings().into_iter().map(|bad| bad.setting).collect();
        assert_eq!(bad, ["obstacles[0].motion.speed_mps", "obstacles[0].motion.waypoints"]);
    }

    #[test]
    fn a_follower_needs_distances_and_intervals() {
        let stands = vec![(Duration::from_secs(9), Duration::from_secs(3))];
        let follow = Follow { distance_m: 0.0, meets_within_m: f64::NAN, speed_mps: -1.0, stands };
        let obstacle = ObstacleConfig {
            name: "person".to_owned(),
            shape: Shape::Disc { radius_m: 0.2 },
            pose: Pose::identity(),
            motion: ObstacleMotion::Follower(follow),
        };
        let config = SimConfig { obstacles: vec![obstacle], ..SimConfig::default() };
        let bad: Vec<String> = config.bad_settings().into_iter().map(|bad| bad.to_string()).collect();
        assert_eq!(
            bad,
            [
                "obstacles[0].motion.distance_m is 0, must be greater than 0",
                "obstacles[0].motion.meets_within_m is NaN, must be greater than 0",
                "obstacles[0].motion.speed_mps is -1, must be greater than 0",
                "obstacles[0].motion.stands[0] is 3, must be later than when the person begins to stand",
            ]
        );
    }
}
