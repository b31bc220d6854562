//! The components: BatteryReader, Localization and Navigation.
//!
//! A component is a process of the channel system that answers skills' requests, and a driver outside the system that
//! connects it with the robot. [`Software`] holds the drivers and what they drive: it reads the robot's sensors, keeps
//! the pose estimate and the navigation going, exchanges data with the three processes between steps, and commands the
//! base. It sees nothing but the [`robot::Robot`] that it is given.
//!
//! [`operations`] lists what the components can be asked. [`Blackboard`] and [`StopRule::AnyTrip`] are those of the paper's
//! published system, for skills that follow its protocol.

mod battery_reader;
mod blackboard;
mod localization;
mod navigation;
mod operations;
mod outages;
mod service;
mod software;

pub use battery_reader::BatteryReader;
pub use blackboard::Blackboard;
pub use localization::Localization;
pub use navigation::{Navigation, Order, StopRule, TripStatus};
pub use operations::{BATTERY_READER, BLACKBOARD, LOCALIZATION, NAVIGATION, Operation, operations};
pub use outages::{Component, Outages};
pub use software::{Processes, Software};
