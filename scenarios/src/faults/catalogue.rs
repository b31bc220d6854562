//! The kinds of faults there are.

mod battery;
mod behavior;
mod channels;
mod lasers;
mod motion;
mod software;
mod world;

use super::{ArgumentDefault, ArgumentDomain, Arguments, Effect, Parameter};

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

/// All kinds, by place.
pub const KINDS: &[&FaultKind] = &[
    &battery::LEVEL,
    &battery::DRAIN,
    &battery::FADE,
    &battery::SENSOR_STUCK,
    &battery::SENSOR_OFFSET,
    &battery::SENSOR_NOISE,
    &battery::SENSOR_DROPOUT,
    &battery::CHARGING_STATUS,
    &battery::STATION_DEAD,
    &battery::STATION_SLOW,
    &lasers::DEAD,
    &lasers::DROPOUT,
    &lasers::STUCK,
    &lasers::NOISE,
    &lasers::RANGE_LIMIT,
    &lasers::MOUNT,
    &lasers::GHOST,
    &motion::WHEEL_SLIP,
    &motion::ODOMETRY_BIAS,
    &motion::ODOMETRY_FREEZE,
    &motion::JOYPAD,
    &motion::WEAK_WHEEL,
    &motion::SPEED_LIMIT,
    &motion::EMERGENCY_STOP,
    &motion::COMMAND_DELAY,
    &software::KIDNAP,
    &software::WRONG_POSE,
    &software::WRONG_MAP,
    &software::FROZEN,
    &software::CRASH,
    &software::SLOW,
    &software::WRONG_REPLY,
    &software::NO_REPLY,
    &channels::LOST,
    &channels::DELAYED,
    &channels::DUPLICATED,
    &channels::CORRUPTED,
    &channels::TICK_MISSED,
    &channels::TICK_LATE,
    &channels::TICK_JITTER,
    &behavior::MACHINE_REPLACED,
    &behavior::DATA_CHANGED,
    &behavior::GUARD_NEGATED,
    &behavior::TARGET_SWAPPED,
    &behavior::TRANSITION_DROPPED,
    &behavior::STATE_STUCK,
    &behavior::MUTATED,
    &behavior::LEAF_INVERTED,
    &behavior::HALT_LOST,
    &world::DOOR,
    &world::OBSTACLE,
    &world::MOVING_OBSTACLE,
    &world::PEOPLE,
    &world::STATION_OCCUPIED,
    &world::STATION_MOVED,
];

/// The kind of that name.
#[must_use]
pub fn kind(name: &str) -> Option<&'static FaultKind> {
    KINDS.iter().find(|kind| kind.name == name).copied()
}

/// A parameter that has to be given.
const fn required(name: &'static str, about: &'static str, domain: ArgumentDomain) -> Parameter {
    Parameter { name, about, domain, default: ArgumentDefault::Required }
}

/// A number that need not be given.
const fn number(name: &'static str, about: &'static str, least: f64, most: f64, default: f64) -> Parameter {
    Parameter { name, about, domain: ArgumentDomain::Numbers(least, most), default: ArgumentDefault::Number(default) }
}

/// A whole number that need not be given.
const fn whole(name: &'static str, about: &'static str, least: u64, most: u64, default: u64) -> Parameter {
    Parameter { name, about, domain: ArgumentDomain::Whole(least, most), default: ArgumentDefault::Whole(default) }
}
