//! Devices of the world as components: what skills can request, sense and do apart from driving.
//!
//! - [`DeviceKind`]: the kinds of devices, with their interfaces.
//! - [`DeviceSettings`]: a device of a scenario.
//! - [`DeviceProcess`]: a device that communicates over channels.
//! - [`Surroundings`]: what devices sense and move, a simulation or hardware.
//!
//! Like any other component, a device receives requests over channels. Once per step its driver lets it [sense and
//! act](DeviceProcess::act) in its surroundings.
//!
//! # Inside
//! `process` is their process in a channel system, with one file per kind; `interfaces/` has the interface of each
//! kind. The trait `Surroundings` is what they sense and move.

mod door;
mod lines;
mod people;
mod process;
mod settings;
mod signals;
mod speaker;
#[cfg(test)]
mod tests;
mod tray;

pub use process::DeviceProcess;
pub use settings::{DeviceKind, DeviceSettings};

/// The surroundings that devices sense and move.
pub trait Surroundings {
    /// How far the door with this name is open, from 0 to 1; `None` if there is no such door.
    fn door_opening(&self, door: &str) -> Option<f64>;

    /// Opens or closes a door.
    fn move_door(&mut self, door: &str, open: bool);

    /// The distances from the robot's center to the people in its view, in meters: of those with these names, or of all
    /// if there are no names.
    fn people_in_view(&self, names: &[String]) -> Vec<f64>;

    /// Takes the nearest movable box in view within `reach_m` meters of the robot's edge from the floor. Returns its
    /// name, if there is one.
    fn take_box(&mut self, reach_m: f64) -> Option<String>;

    /// Puts a box down in front of the robot; false if there is no room.
    fn put_down(&mut self, name: &str) -> bool;

    /// Lets a box fall behind the robot; false if there is no room.
    fn drop_box(&mut self, name: &str) -> bool;
}
