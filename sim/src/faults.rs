//! The places at which faults act.

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

/// The current faults of the simulated world.
///
/// The code that runs an experiment sets fields of [`Simulation::faults_mut`](crate::Simulation::faults_mut) when a
/// fault begins and resets them when it ends. Each field acts at one place in a step. In the order of a step, these
/// are:
///
/// | field | read by | acts |
/// |---|---|---|
/// | `bodies` | `place_bodies` | before anything moves |
/// | `stuck_doors` | `move_doors` | on the leaf: it stays where it is |
/// | `base.command_delay` | `drive_robot` | between the software's commands and the base |
/// | `base.velocity_override` | `drive_robot` | instead of the command that has arrived |
/// | `base.emergency_stop` | `drive_robot` | after command and joypad: the motors are off |
/// | `base.speed_limit_mps` | `drive_robot` | as a limit on the motors |
/// | `base.left_wheel_factor`, `base.right_wheel_factor` | `drive_robot` | between motors and encoders |
/// | `base.slip` | `drive_robot` | between wheels and floor |
/// | `station` | `update_battery` | on where the robot docks |
/// | `battery.drain_factor`, `capacity_factor`, `charger_factor` | `update_battery` | between current and charge |
/// | `odometry` | `measure_odometry` | between the wheels' motion and the reading |
/// | `lasers`: `Mount`, `Ghost` | `scan` | on the visible objects |
/// | `lasers`: `Noise`, `RangeLimit`, `Dropout`, `Stuck`, `Dead`, in this order | `scan` | on the measured ranges |
/// | `battery.reported` | `report_battery` | between the charge and the reading |
///
/// [`Faults::default`] is a world without faults, and a field at its default does not change a bit of a run. A fault
/// that needs randomness draws it from its own stream (`fault/battery`, `fault/laser_<name>_noise`,
/// `fault/laser_<name>_dropout`), and only while it lasts. Faulty sensors continue to draw their own noise, so after a
/// fault they measure the same as without it.
///
/// Instantaneous faults are methods of the simulation: [`set_battery_charge`](crate::Simulation::set_battery_charge),
/// [`kidnap`](crate::Simulation::kidnap).
///
/// [`problems`](Self::problems) reports invalid values, for code that reads them from a file; a step does not check
/// them. It does not panic because of them, but their effect on a run is unspecified.
///
/// # Example
/// ```
/// use maps::{Shape, pose};
/// use sim::{Faults, LaserFault, LaserTrouble, ObstacleConfig, ObstacleMotion, SimConfig};
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
    /// The laser scanners. Faults of one scanner accumulate, in any order. Default none.
    pub lasers: Vec<LaserFault>,
    /// The wheels' encoders.
    pub odometry: OdometryFaults,
    /// The base: motors and wheels.
    pub base: BaseFaults,
    /// Additional bodies, present as long as they are in this list: a closed door, people, an obstacle that appears.
    /// They are identified by name. If a body's description changes, it is removed and placed again; otherwise it
    /// continues from its pose, whatever happens to the others.
    ///
    /// A body that would appear on top of the robot waits for room: it is placed in the first step in which it does not
    /// overlap the robot. It may overlap walls and other bodies. Default none.
    pub bodies: Vec<ObstacleConfig>,
    /// The names of the doors whose leaves do not move as long as they are in this list, regardless of their schedules
    /// and [commands](crate::Simulation::command_door). When a leaf is free again, it moves as required then. Default
    /// none.
    pub stuck_doors: Vec<String>,
    /// The new pose of the charging station, in the `map` frame, if it has been moved: docking happens there, but the
    /// robot's software does not know. Default none: it is in its original place.
    pub station: Option<Pose>,
}
