//! Kinds of faults.

use super::{Arguments, Effect, Parameter};

/// The part of the system in which a fault acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subsystem {
    /// The battery, its sensor, the charging station.
    Battery,
    /// The laser scanners.
    Lasers,
    /// Odometry and the base.
    Motion,
    /// Localization, navigation and the other components.
    Software,
    /// The channels and the ticks.
    Channels,
    /// Skills and tree.
    Behavior,
    /// The devices of the world: doors, sensors, speakers, trays.
    Devices,
    /// The robot's surroundings.
    World,
}

impl Subsystem {
    /// The part, in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Battery => "battery",
            Self::Lasers => "lasers",
            Self::Motion => "odometry and base",
            Self::Software => "localization, navigation, components",
            Self::Channels => "channels and ticks",
            Self::Behavior => "skills and tree",
            Self::Devices => "devices",
            Self::World => "world",
        }
    }
}

/// A kind of fault.
#[derive(Debug)]
pub struct FaultKind {
    /// Its name: the `kind` of an entry of `[[faults]]`.
    pub name: &'static str,
    /// Where it acts.
    pub subsystem: Subsystem,
    /// Its effect, on one line.
    pub about: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// An entry of `[[faults]]` without its kind.
    pub example: &'static str,
    pub(super) effect: fn(&Arguments) -> Effect,
    pub(super) words: fn(&Arguments) -> String,
}
