//! The places where faults take hold.

use bevy_ecs::prelude::Resource;
use robot::VelocityCommand;

/// What is wrong with the simulated world at the moment.
///
/// Whoever runs an experiment sets fields of [`Simulation::faults_mut`](crate::Simulation::faults_mut) when a fault begins
/// and sets them back when it ends. Each field is read at one place of a step:
///
/// | field | read by | acts |
/// |---|---|---|
/// | `battery` | `update_battery`, `report_battery` | between what is drained and the charge; between the charge and the reading |
/// | `base` | `drive_robot` | between the command and the motors' limits |
/// | (odometry) | `measure_odometry` | between the wheels' motion and the reading |
/// | (lasers) | `scan` | between true distances and the reading |
/// | (world) | `move_obstacles` | before anything else moves |
///
/// A place in parentheses has no field yet. [`Faults::default`] is a world in order, and a field at its default leaves
/// every bit of a run as it would be without it. A fault that needs randomness must draw it from a stream of its own
/// (`fault/<name>`), never from those of the noise. What happens at one instant is a method of the simulation:
/// [`set_battery_charge`](crate::Simulation::set_battery_charge).
#[derive(Resource, Clone, Debug, PartialEq, Default)]
pub struct Faults {
    /// The battery.
    pub battery: BatteryFaults,
    /// The base: motors and wheels.
    pub base: BaseFaults,
}

/// What can be wrong with the battery.
#[derive(Clone, Debug, PartialEq)]
pub struct BatteryFaults {
    /// Factor of what is drained, driving and standing. Default 1.
    pub drain_factor: f64,
}

impl Default for BatteryFaults {
    fn default() -> Self {
        Self { drain_factor: 1.0 }
    }
}

/// What can be wrong with the base.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct BaseFaults {
    /// A joypad that overrides the software's velocity commands as long as it is held. The limits of the drive and an
    /// empty battery apply to it too. Default none.
    pub velocity_override: Option<VelocityCommand>,
}
