//! The settings of a simulation, with their units and defaults.

mod door;
mod follow;
mod walk;

use std::time::Duration;

use maps::{Point, Pose, Shape};
use robot::RobotModel;

pub use door::{Door, Opening};
pub use follow::Follow;
pub use walk::{Manners, Pauses, RouteEnd, Walk};

/// All settings of the simulated robot and its world, except the map, the poses of start and station, and the seed.
///
/// The default is the robot of the paper's experiments, without noise and without obstacles.
///
/// ```
/// use maps::{Shape, pose};
/// use sim::{ObstacleConfig, ObstacleMotion, SimConfig};
///
/// // A faster robot with noisy lasers, and a box in the room.
/// let mut config = SimConfig::default();
/// config.model.max_linear_mps = 0.8;
/// config.lasers.range_sigma_m = 0.02;
/// config.obstacles.push(ObstacleConfig {
///     name: "box".to_owned(),
///     shape: Shape::Box { length_m: 0.6, width_m: 0.4 },
///     pose: pose(3.0, 1.0, 0.0),
///     motion: ObstacleMotion::Fixed,
/// });
/// assert_eq!(config.dt.as_millis(), 20);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SimConfig {
    /// Size, limits and lasers of the robot, which its software has as well.
    pub model: RobotModel,
    /// Duration of a step. Default 20 ms.
    pub dt: Duration,
    /// The robot's body.
    pub body: BodyConfig,
    /// The robot's wheels.
    pub drive: DriveConfig,
    /// The readings of the wheels' encoders.
    pub odometry: OdometryConfig,
    /// The accuracy of the lasers.
    pub lasers: LaserConfig,
    /// The battery.
    pub battery: BatteryConfig,
    /// When the robot counts as docked.
    pub docking: DockingConfig,
    /// Other bodies in the world. Default: none.
    pub obstacles: Vec<ObstacleConfig>,
}

impl Default for SimConfig {
    fn default() -> Self {
        Self {
            model: RobotModel::default(),
            dt: Duration::from_millis(20),
            body: BodyConfig::default(),
            drive: DriveConfig::default(),
            odometry: OdometryConfig::default(),
            lasers: LaserConfig::default(),
            battery: BatteryConfig::default(),
            docking: DockingConfig::default(),
            obstacles: Vec::new(),
        }
    }
}

/// The robot's body, a disc of [`RobotModel::radius_m`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyConfig {
    /// Mass, in kg. Default 30.
    pub mass_kg: f64,
    /// Coefficient of friction between the body's side and other bodies. Default 0.3.
    pub friction: f64,
}

impl Default for BodyConfig {
    fn default() -> Self {
        Self { mass_kg: 30.0, friction: 0.3 }
    }
}

/// The two driven wheels. The limits of the whole body are in [`RobotModel`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveConfig {
    /// Distance between the wheels, in meters. Default 0.40: two thirds of the default model's diameter.
    pub wheel_separation_m: f64,
    /// Largest speed of a wheel's rim, in m/s. Default 0.65: just enough for the default model's largest forward speed
    /// and turning rate at once.
    pub max_wheel_mps: f64,
    /// How imprecisely the wheels follow the motors' commands. The encoders measure the resulting motion. Default none.
    pub noise: DriftNoise,
}

impl Default for DriveConfig {
    fn default() -> Self {
        Self::of(&RobotModel::default())
    }
}

impl DriveConfig {
    /// Wheels for a robot: in proportion to its size, and just strong enough for its largest forward speed and turning
    /// rate at once.
    #[must_use]
    pub fn of(model: &RobotModel) -> Self {
        let wheel_separation_m = 0.40 * (model.radius_m / 0.30);
        let max_wheel_mps = model.max_linear_mps + 0.5 * wheel_separation_m * model.max_angular_radps;
        Self { wheel_separation_m, max_wheel_mps, noise: DriftNoise::default() }
    }
}

/// Errors of a motion that accumulate, like the four alphas of the odometry motion model (Thrun, Burgard, Fox,
/// *Probabilistic Robotics*, section 5.4), but independent of the length of a step: variances are proportional to the
/// distance and the angle, so standard deviations are proportional to their square roots. By default, there are none.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct DriftNoise {
    /// Standard deviation of the angle after turning by 1 rad, in rad (alpha 1). Default 0.
    pub angle_per_sqrt_rad: f64,
    /// Standard deviation of the angle after driving 1 m, in rad (alpha 2). Default 0.
    pub angle_per_sqrt_m: f64,
    /// Standard deviation of the distance after driving 1 m, in m (alpha 3). Default 0.
    pub distance_per_sqrt_m: f64,
    /// Standard deviation of the distance after turning by 1 rad, in m (alpha 4). Default 0.
    pub distance_per_sqrt_rad: f64,
}

/// The readings of the wheels' encoders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryConfig {
    /// Time between readings. Default 20 ms.
    pub period: Duration,
    /// Random errors. Default none.
    pub noise: DriftNoise,
    /// Systematic error of the distance, as a fraction of it: 0.01 reports 1 % too much. Default 0.
    pub distance_bias: f64,
    /// Systematic error of the angle, as a fraction of it. Default 0.
    pub angle_bias: f64,
    /// Excess angle reported per meter driven (wheels of unequal diameter), in rad/m. Default 0.
    pub angle_bias_rad_per_m: f64,
}

impl Default for OdometryConfig {
    fn default() -> Self {
        Self {
            period: Duration::from_millis(20),
            noise: DriftNoise::default(),
            distance_bias: 0.0,
            angle_bias: 0.0,
            angle_bias_rad_per_m: 0.0,
        }
    }
}

/// The accuracy of the lasers; the lasers themselves are in [`RobotModel::lasers`].
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct LaserConfig {
    /// Standard deviation of a range, in meters. Default 0.
    pub range_sigma_m: f64,
}

/// The battery and its charger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryConfig {
    /// Initial charge, in percent. Default 100.
    pub initial_pct: f64,
    /// Consumption when driving, in percent per second. Default 0.05.
    pub drain_pct_per_s: f64,
    /// Consumption when standing still, in percent per second. Default 0.
    pub standstill_drain_pct_per_s: f64,
    /// Charging rate at the station, in percent per second. Default 0.05.
    pub charge_pct_per_s: f64,
    /// Charge at which charging ends, in percent. Default 99.7.
    pub full_pct: f64,
    /// Charge below which a fully charged robot that has stayed at the dock is charged again, in percent. Default 95.
    pub recharge_below_pct: f64,
    /// Time between readings. Default 100 ms.
    pub period: Duration,
}

impl Default for BatteryConfig {
    fn default() -> Self {
        Self {
            initial_pct: 100.0,
            drain_pct_per_s: 0.05,
            standstill_drain_pct_per_s: 0.0,
            charge_pct_per_s: 0.05,
            full_pct: 99.7,
            recharge_below_pct: 95.0,
            period: Duration::from_millis(100),
        }
    }
}

/// When the robot counts as docked: near enough to the station's pose, with its heading, and at rest for a while, so
/// that it does not dock in passing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockingConfig {
    /// Maximum distance from the station, in meters. Default 0.5.
    pub distance_m: f64,
    /// Largest difference of heading from the station's, in radians. Default 10°.
    pub angle_rad: f64,
    /// How long the robot must be at rest. Default 1 s.
    pub rest: Duration,
}

impl Default for DockingConfig {
    fn default() -> Self {
        Self { distance_m: 0.5, angle_rad: 10_f64.to_radians(), rest: Duration::from_secs(1) }
    }
}

/// Something other than a wall that the robot can see and collide with.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleConfig {
    /// Name, for messages and pictures.
    pub name: String,
    /// Outline.
    pub shape: Shape,
    /// Initial pose of its center, in the `map` frame.
    pub pose: Pose,
    /// How it moves.
    pub motion: ObstacleMotion,
}

/// How an obstacle moves.
#[derive(Clone, Debug, PartialEq)]
pub enum ObstacleMotion {
    /// Not at all; it cannot be pushed.
    Fixed,
    /// Along a polyline from its first pose, facing forward. Nothing stops it: it passes through walls and pushes the
    /// robot away.
    Route {
        /// Corners of the polyline after the first pose, in the `map` frame.
        waypoints: Vec<Point>,
        /// Speed, in m/s.
        speed_mps: f64,
        /// The behavior at the last waypoint.
        end: RouteEnd,
    },
    /// A walking person.
    Person(Walk),
    /// A person who follows the robot.
    Follower(Follow),
    /// A door's leaf.
    Door(Door),
    /// It stays in place until it is pushed.
    Movable {
        /// Mass, in kg.
        mass_kg: f64,
    },
}
