//! The places where faults take hold.

mod base;
mod battery;
mod check;
mod lasers;

use bevy_ecs::prelude::Resource;
use maps::Pose;

use crate::config::ObstacleConfig;

pub use base::{BaseFaults, OdometryFaults};
pub use battery::{BatteryFaults, BatteryReport};
pub use lasers::{LaserFault, LaserTrouble};

/// What is wrong with the simulated world at the moment.
///
/// Whoever runs an experiment sets fields of [`Simulation::faults_mut`](crate::Simulation::faults_mut) when a fault begins
/// and sets them back when it ends. Each field is read at one place of a step; the places, in the order of a step:
///
/// | field | read by | acts |
/// |---|---|---|
/// | `bodies` | `place_bodies` | before anything moves |
/// | `base.command_delay` | `drive_robot` | between the software's commands and the base |
/// | `base.velocity_override` | `drive_robot` | instead of the command that has arrived |
/// | `base.emergency_stop` | `drive_robot` | after command and joypad: the motors are off |
/// | `base.speed_limit_mps` | `drive_robot` | among the limits of the motors |
/// | `base.left_wheel_factor`, `base.right_wheel_factor` | `drive_robot` | between motors and encoders |
/// | `base.slip` | `drive_robot` | between wheels and floor |
/// | `station` | `update_battery` | where docking happens |
/// | `battery.drain_factor`, `capacity_factor`, `charger_factor` | `update_battery` | between current and charge |
/// | `odometry` | `measure_odometry` | between the wheels' motion and the reading |
/// | `lasers`: `Mount`, `Ghost` | `scan` | on what there is to be seen |
/// | `lasers`: `Noise`, `RangeLimit`, `Dropout`, `Stuck`, `Dead`, in this order | `scan` | on what was seen |
/// | `battery.reported` | `report_battery` | between the charge and the reading |
///
/// [`Faults::default`] is a world in order, and a field at its default leaves every bit of a run as it would be without
/// it. A fault that needs randomness draws it from a stream of its own (`fault/battery`, `fault/laser_<name>_noise`,
/// `fault/laser_<name>_dropout`), and only while it lasts. Sensors that are faulty go on drawing their own noise, so that
/// after a fault they measure what they would have measured without it.
///
/// What happens at one instant is a method of the simulation:
/// [`set_battery_charge`](crate::Simulation::set_battery_charge), [`kidnap`](crate::Simulation::kidnap).
///
/// Values that make no sense are named by [`problems`](Self::problems), which is for whoever reads them from a file: a
/// step does not look for them. It does not panic over them either, but what they do to a run is not said here.
///
/// # Example
/// ```
/// use maps::pose;
/// use sim::{Faults, LaserFault, LaserTrouble, ObstacleConfig, ObstacleMotion, Shape, SimConfig};
///
/// let mut faults = Faults::default();
/// faults.base.slip = 0.3;
/// let trouble = LaserTrouble::Dropout { probability: 0.2 };
/// faults.lasers.push(LaserFault { laser: Some("front".to_owned()), trouble });
/// faults.bodies.push(ObstacleConfig {
///     name: "kitchen door".to_owned(),
///     shape: Shape::Box { length_m: 0.9, width_m: 0.05 },
///     pose: pose(4.0, 2.0, 0.0),
///     motion: ObstacleMotion::Fixed,
/// });
/// assert_eq!(faults.problems(&SimConfig::default()), []);
/// ```
#[derive(Resource, Clone, Debug, PartialEq, Default)]
pub struct Faults {
    /// The battery, its electronics and the charger.
    pub battery: BatteryFaults,
    /// The laser scanners. Faults of one scanner add up, whatever their order. Default none.
    pub lasers: Vec<LaserFault>,
    /// The wheels' encoders.
    pub odometry: OdometryFaults,
    /// The base: motors and wheels.
    pub base: BaseFaults,
    /// Bodies beside those of the configuration, there as long as they are in this list: a closed door, people, an
    /// obstacle that appears. Each is known by its name; one whose description changes is taken away and put down anew.
    /// One that stays in the list as it is goes on from where it is, whatever happens to the others.
    ///
    /// A body that would appear on top of the robot waits until there is room: it is put down at the first step at which
    /// the robot does not overlap it. Walls and other bodies are no hindrance. Default none.
    pub bodies: Vec<ObstacleConfig>,
    /// Where the charging station has been moved to, in the `map` frame: where docking happens, which the robot's
    /// software does not know. Default none: it is where it was built.
    pub station: Option<Pose>,
}
