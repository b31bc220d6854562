//! All kinds of faults.

mod battery;
mod behavior;
mod channels;
mod devices;
mod lasers;
mod motion;
mod software;
mod world;

use super::effect::DeviceTrouble;
use super::kind::FaultKind;

/// All kinds, sorted by subsystem.
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
    &software::GOAL,
    &software::WRONG_MAP,
    &software::ZONE_IGNORED,
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
    &devices::DOOR_STUCK,
    &devices::DEVICE_DEAF,
    &devices::SPEAKER_MUTE,
    &devices::BOX_DROPPED,
    &world::DOOR,
    &world::OBSTACLE,
    &world::MOVING_OBSTACLE,
    &world::PEOPLE,
    &world::STATION_OCCUPIED,
    &world::STATION_MOVED,
];

/// The kinds that happen at one instant.
const MOMENTARY: [&FaultKind; 5] =
    [&battery::LEVEL, &software::KIDNAP, &software::WRONG_POSE, &software::GOAL, &devices::BOX_DROPPED];

/// The kind with this name.
#[must_use]
pub fn kind(name: &str) -> Option<&'static FaultKind> {
    KINDS.iter().find(|kind| kind.name == name).copied()
}

impl FaultKind {
    /// Whether it is instantaneous, so that it cannot last.
    #[must_use]
    pub fn is_momentary(&self) -> bool {
        MOMENTARY.iter().any(|kind| kind.name == self.name)
    }

    /// Whether it can begin after the start of a run, so that a person can cause it in a session.
    #[must_use]
    pub fn can_begin_later(&self) -> bool {
        self.name != software::WRONG_MAP.name
    }

    /// What it does to a device, if it acts on one.
    pub(crate) fn trouble(&self) -> Option<DeviceTrouble> {
        let troubles = [
            (devices::DEVICE_DEAF, DeviceTrouble::Deaf),
            (devices::SPEAKER_MUTE, DeviceTrouble::Mute),
            (devices::BOX_DROPPED, DeviceTrouble::Drop),
        ];
        troubles.into_iter().find(|(kind, _)| kind.name == self.name).map(|(_, trouble)| trouble)
    }

    pub(crate) fn is_of_doors(&self) -> bool {
        self.name == devices::DOOR_STUCK.name
    }
}
