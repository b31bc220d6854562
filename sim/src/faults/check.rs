//! Checks the values of faults.

use std::f64::consts::TAU;

use crate::check::Check;
use crate::config::{ObstacleMotion, SimConfig};
use crate::error::BadSetting;
use crate::faults::{BaseFaults, BatteryFaults, Faults, LaserFault, LaserTrouble, OdometryFaults};

impl Faults {
    /// Every value that is invalid in a simulation with these settings, in the order of the fields. Paths are those of
    /// [`Faults`]: `battery.drain_factor`, `lasers[0].trouble.probability`, `bodies[1].shape.radius_m`.
    #[must_use]
    pub fn problems(&self, config: &SimConfig) -> Vec<BadSetting> {
        let mut check = Check::default();
        check.battery_faults(&self.battery);
        for (index, fault) in self.lasers.iter().enumerate() {
            check.laser_fault(&format!("lasers[{index}]"), fault, config);
        }
        check.odometry_faults(&self.odometry);
        check.base_faults(&self.base);
        check.bodies(self, config);
        check.stuck_doors(self, config);
        if let Some(station) = &self.station {
            check.pose("station", station);
        }
        check.bad
    }
}

impl Check {
    fn battery_faults(&mut self, battery: &BatteryFaults) {
        self.not_negative("battery.drain_factor", battery.drain_factor);
        self.positive("battery.capacity_factor", battery.capacity_factor);
        self.not_negative("battery.charger_factor", battery.charger_factor);
        self.finite("battery.reported.offset_pct", battery.reported.offset_pct);
        self.not_negative("battery.reported.sigma_pct", battery.reported.sigma_pct);
    }

    fn laser_fault(&mut self, path: &str, fault: &LaserFault, config: &SimConfig) {
        if let Some(name) = &fault.laser {
            let known = config.model.lasers.iter().any(|laser| laser.name == *name);
            self.that(known, format!("{path}.laser"), name, "the name of one of the robot's lasers");
        }
        let at = |field: &str| format!("{path}.trouble.{field}");
        match fault.trouble {
            LaserTrouble::Dead | LaserTrouble::Stuck => {}
            LaserTrouble::Dropout { probability } => self.share(at("probability"), probability),
            LaserTrouble::Noise { sigma_m } => self.not_negative(at("sigma_m"), sigma_m),
            LaserTrouble::RangeLimit { max_m } => self.positive(at("max_m"), max_m),
            LaserTrouble::Mount { x_m, y_m, yaw_rad } => {
                self.finite(at("x_m"), x_m);
                self.finite(at("y_m"), y_m);
                self.finite(at("yaw_rad"), yaw_rad);
            }
            LaserTrouble::Ghost { distance_m, bearing_rad, width_rad } => {
                self.not_negative(at("distance_m"), distance_m);
                self.finite(at("bearing_rad"), bearing_rad);
                let sector = width_rad > 0.0 && width_rad <= TAU;
                self.that(sector, at("width_rad"), width_rad, "greater than 0 and at most a full circle");
            }
        }
    }

    fn odometry_faults(&mut self, odometry: &OdometryFaults) {
        self.finite("odometry.distance_bias", odometry.distance_bias);
        self.finite("odometry.angle_bias", odometry.angle_bias);
        self.finite("odometry.angle_bias_rad_per_m", odometry.angle_bias_rad_per_m);
    }

    fn base_faults(&mut self, base: &BaseFaults) {
        if let Some(command) = &base.velocity_override {
            self.finite("base.velocity_override.linear_mps", command.linear_mps);
            self.finite("base.velocity_override.angular_radps", command.angular_radps);
        }
        self.share("base.slip", base.slip);
        for (setting, factor) in
            [("base.left_wheel_factor", base.left_wheel_factor), ("base.right_wheel_factor", base.right_wheel_factor)]
        {
            self.that((0.0..=2.0).contains(&factor), setting, factor, "from 0 to 2");
        }
        if let Some(limit_mps) = base.speed_limit_mps {
            self.not_negative("base.speed_limit_mps", limit_mps);
        }
    }

    fn bodies(&mut self, faults: &Faults, config: &SimConfig) {
        for (index, body) in faults.bodies.iter().enumerate() {
            let path = format!("bodies[{index}]");
            let mut others = config.obstacles.iter().chain(&faults.bodies[..index]);
            let alone = others.all(|other| other.name != body.name);
            self.that(alone, format!("{path}.name"), &body.name, "a name that no other body has");
            self.obstacle(&path, body);
        }
    }

    fn stuck_doors(&mut self, faults: &Faults, config: &SimConfig) {
        for (index, name) in faults.stuck_doors.iter().enumerate() {
            let mut doors = config.obstacles.iter().chain(&faults.bodies);
            let known = doors.any(|door| door.name == *name && matches!(door.motion, ObstacleMotion::Door(_)));
            self.that(known, format!("stuck_doors[{index}]"), name, "the name of a door");
        }
    }

    fn share(&mut self, setting: impl Into<String>, value: f64) {
        self.that((0.0..=1.0).contains(&value), setting, value, "from 0 to 1");
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use maps::{Shape, pose};
    use robot::VelocityCommand;

    use super::*;
    use crate::config::{Door, ObstacleConfig, Opening};

    fn problems(faults: &Faults) -> Vec<String> {
        faults.problems(&SimConfig::default()).iter().map(ToString::to_string).collect()
    }

    fn person(name: &str, radius_m: f64) -> ObstacleConfig {
        ObstacleConfig {
            name: name.to_owned(),
            shape: Shape::Disc { radius_m },
            pose: pose(1.0, 2.0, 0.0),
            motion: ObstacleMotion::Fixed,
        }
    }

    #[test]
    fn a_world_without_faults_has_no_problems() {
        assert!(problems(&Faults::default()).is_empty());
    }

    #[test]
    fn every_value_of_battery_and_base_is_checked() {
        let mut faults = Faults { station: Some(pose(f64::NAN, 0.0, 0.0)), ..Faults::default() };
        faults.battery = BatteryFaults { drain_factor: -1.0, capacity_factor: 0.0, ..faults.battery };
        faults.battery.charger_factor = f64::INFINITY;
        faults.battery.reported.offset_pct = f64::NAN;
        faults.battery.reported.sigma_pct = -0.5;
        faults.odometry.distance_bias = f64::NAN;
        faults.odometry.angle_bias = f64::INFINITY;
        faults.odometry.angle_bias_rad_per_m = f64::NEG_INFINITY;
        faults.base.velocity_override = Some(VelocityCommand { linear_mps: f64::NAN, angular_radps: f64::NAN });
        faults.base.slip = 1.1;
        faults.base.left_wheel_factor = -0.1;
        faults.base.right_wheel_factor = 2.5;
        faults.base.speed_limit_mps = Some(-0.2);
        let expected = [
            "battery.drain_factor is -1, must be at least 0",
            "battery.capacity_factor is 0, must be greater than 0",
            "battery.charger_factor is inf, must be at least 0",
            "battery.reported.offset_pct is NaN, must be a finite number",
            "battery.reported.sigma_pct is -0.5, must be at least 0",
            "odometry.distance_bias is NaN, must be a finite number",
            "odometry.angle_bias is inf, must be a finite number",
            "odometry.angle_bias_rad_per_m is -inf, must be a finite number",
            "base.velocity_override.linear_mps is NaN, must be a finite number",
            "base.velocity_override.angular_radps is NaN, must be a finite number",
            "base.slip is 1.1, must be from 0 to 1",
            "base.left_wheel_factor is -0.1, must be from 0 to 2",
            "base.right_wheel_factor is 2.5, must be from 0 to 2",
            "base.speed_limit_mps is -0.2, must be at least 0",
            "station.x is NaN, must be a finite number",
        ];
        assert_eq!(problems(&faults), expected);
    }

    #[test]
    fn lasers_are_checked_by_name_and_their_troubles_by_limits() {
        let nan = f64::NAN;
        let troubles = [
            LaserTrouble::Dropout { probability: 1.5 },
            LaserTrouble::Noise { sigma_m: nan },
            LaserTrouble::RangeLimit { max_m: 0.0 },
            LaserTrouble::Mount { x_m: nan, y_m: nan, yaw_rad: nan },
            LaserTrouble::Ghost { distance_m: -1.0, bearing_rad: nan, width_rad: 7.0 },
        ];
        let lasers = troubles.map(|trouble| LaserFault { laser: None, trouble }).to_vec();
        let mut faults = Faults { lasers, ..Faults::default() };
        faults.lasers[0].laser = Some("left".to_owned());
        let expected = [
            "lasers[0].laser is left, must be the name of one of the robot's lasers",
            "lasers[0].trouble.probability is 1.5, must be from 0 to 1",
            "lasers[1].trouble.sigma_m is NaN, must be at least 0",
            "lasers[2].trouble.max_m is 0, must be greater than 0",
            "lasers[3].trouble.x_m is NaN, must be a finite number",
            "lasers[3].trouble.y_m is NaN, must be a finite number",
            "lasers[3].trouble.yaw_rad is NaN, must be a finite number",
            "lasers[4].trouble.distance_m is -1, must be at least 0",
            "lasers[4].trouble.bearing_rad is NaN, must be a finite number",
            "lasers[4].trouble.width_rad is 7, must be greater than 0 and at most a full circle",
        ];
        assert_eq!(problems(&faults), expected);
    }

    #[test]
    fn bodies_need_unique_names_and_valid_sizes() {
        let config = SimConfig { obstacles: vec![person("table", 0.4)], ..SimConfig::default() };
        let bodies = vec![person("table", 0.4), person("Ann", 0.2), person("Ann", -0.2)];
        let found = Faults { bodies, ..Faults::default() }.problems(&config);
        assert_eq!(
            found.iter().map(ToString::to_string).collect::<Vec<_>>(),
            [
                "bodies[0].name is table, must be a name that no other body has",
                "bodies[2].name is Ann, must be a name that no other body has",
                "bodies[2].shape.radius_m is -0.2, must be greater than 0",
            ]
        );
    }

    #[test]
    fn only_doors_get_stuck() {
        let door = Door { opening: Opening::Slide, moving: Duration::ZERO, closed: Vec::new(), every: None };
        let door = ObstacleConfig { motion: ObstacleMotion::Door(door), ..person("door", 0.2) };
        let config = SimConfig { obstacles: vec![door, person("Ann", 0.2)], ..SimConfig::default() };
        let stuck_doors = ["door", "Ann"].map(str::to_owned).to_vec();
        let found = Faults { stuck_doors, ..Faults::default() }.problems(&config);
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(found, ["stuck_doors[1] is Ann, must be the name of a door"]);
    }
}
