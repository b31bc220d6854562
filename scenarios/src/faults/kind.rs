//! What a kind of fault is.

use super::{Arguments, Effect, Parameter};

/// Where a fault acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
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
    /// What is around the robot.
    World,
}

impl Place {
    /// The place in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Battery => "battery",
            Self::Lasers => "lasers",
            Self::Motion => "odometry and base",
            Self::Software => "localization, navigation, components",
            Self::Channels => "channels and ticks",
            Self::Behavior => "skills and tree",
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
    pub place: Place,
    /// What it does, in a line.
    pub about: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Whether it happens at one instant, so that it cannot last.
    pub momentary: bool,
    /// An entry of `[[faults]]` without its kind.
    pub example: &'static str,
    pub(super) effect: fn(&Arguments) -> Effect,
    pub(super) words: fn(&Arguments) -> String,
}
