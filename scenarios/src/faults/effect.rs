//! The effects of faults.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use devices::DeviceKind;
use diagnostics::Spanned;
use maps::Pose;
use skills::Mutation;

/// The effect of a fault. Instantaneous effects come first, then those that last as long as the fault is active.
#[derive(Clone)]
pub enum Effect {
    /// The battery's charge is set, in percent.
    Charge(f64),
    /// The robot is moved elsewhere; its wheels do not notice.
    Kidnap(Spanned<Pose>),
    /// Localization is given this pose.
    Belief(Pose),
    /// Another client sends Navigation this goal.
    Goal(Spanned<Pose>),
    /// Something is wrong with the robot or around it.
    World(Arc<dyn Fn(&mut sim::Faults) + Send + Sync>),
    /// The robot's software uses the map in this file instead of the scenario's.
    Map(Spanned<PathBuf>),
    /// Navigation ignores the zone with this name, or all of them.
    Zones(Option<Spanned<String>>),
    /// A component does nothing. If it has crashed, it restarts when the fault ends.
    Outage {
        /// The component.
        component: Spanned<String>,
        /// Whether it forgets everything.
        crashed: bool,
    },
    /// A device does not work.
    Device {
        /// The component.
        component: Spanned<String>,
        /// What is wrong with it.
        trouble: DeviceTrouble,
    },
    /// The messages on some channels are disturbed.
    Channels {
        /// The channels.
        channels: Which,
        /// The affected messages: a condition in the SCOPE language.
        condition: Spanned<String>,
        /// The damage.
        damage: Damage,
        /// The probability for each message.
        probability: f64,
    },
    /// Ticks do not come on time.
    Ticks(TickTrouble),
    /// A skill runs another machine.
    Machine {
        /// The skill.
        skill: Spanned<String>,
        /// The machine.
        change: MachineChange,
    },
}

/// What is wrong with a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceTrouble {
    /// A sensor detects nothing.
    Deaf,
    /// A speaker emits no sound.
    Mute,
    /// A tray loses its box.
    Drop,
}

impl DeviceTrouble {
    /// The devices that can have it, in words.
    pub fn befalls(self) -> &'static str {
        match self {
            Self::Deaf => "a button, a microphone or a people sensor",
            Self::Mute => "a speaker",
            Self::Drop => "a tray",
        }
    }

    /// Whether a device of this kind can have it.
    pub fn can_befall(self, kind: DeviceKind) -> bool {
        match self {
            Self::Deaf => kind.is_sensor(),
            Self::Mute => kind == DeviceKind::Speaker,
            Self::Drop => kind == DeviceKind::Tray,
        }
    }
}

/// The channels that a fault affects.
#[derive(Clone, Debug)]
pub enum Which {
    /// The channel from one process to another.
    Between(Spanned<String>, Spanned<String>),
    /// All channels from a component.
    From(Spanned<String>),
    /// All channels to a component.
    To(Spanned<String>),
}

/// The damage to a message.
#[derive(Clone, Debug)]
pub enum Damage {
    /// It is lost.
    Loss,
    /// It arrives this much later.
    Delay(Duration),
    /// It comes twice.
    Duplicate,
    /// A field has another value: the field's number, from 1, and the value in the SCOPE language.
    Corruption(Spanned<String>, usize),
    /// It is replaced with its opposite.
    Opposite,
    /// It never arrives, and its sender gets the expected answer.
    Pretence(&'static str),
}

/// A disturbance of the ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TickTrouble {
    /// This share of them is not generated.
    Missed(f64),
    /// They come later by this delay.
    Late(Duration),
    /// They come later by a normally distributed delay with this standard deviation.
    Jitter(Duration),
}

/// How a machine differs from the scenario's.
#[derive(Clone, Debug)]
pub enum MachineChange {
    /// It is the machine in this file.
    Replaced(Spanned<PathBuf>),
    /// It has this mistake.
    Mutated(Mutation),
    /// It has the mistake with this description among all [`skills::mutations`].
    MutatedAs(Spanned<String>),
}

impl Effect {
    /// Whether it acts on a robot or its surroundings.
    pub(super) fn needs_robot(&self) -> bool {
        matches!(
            self,
            Self::Charge(_)
                | Self::Kidnap(_)
                | Self::Belief(_)
                | Self::Goal(_)
                | Self::World(_)
                | Self::Map(_)
                | Self::Zones(_)
        )
    }

    /// The component that is affected, if the fault names one.
    pub fn component(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Outage { component, .. } | Self::Device { component, .. } => Some(component),
            Self::Channels { channels: Which::From(component) | Which::To(component), .. } => Some(component),
            _ => None,
        }
    }

    /// The effect of a change in the simulated world that lasts as long as the fault is active.
    pub(super) fn world(wrong: impl Fn(&mut sim::Faults) + Send + Sync + 'static) -> Self {
        Self::World(Arc::new(wrong))
    }
}

impl fmt::Debug for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Charge(_) => "Charge",
            Self::Kidnap(_) => "Kidnap",
            Self::Belief(_) => "Belief",
            Self::Goal(_) => "Goal",
            Self::World(_) => "World",
            Self::Map(_) => "Map",
            Self::Zones(_) => "Zones",
            Self::Outage { .. } => "Outage",
            Self::Device { .. } => "Device",
            Self::Channels { .. } => "Channels",
            Self::Ticks(_) => "Ticks",
            Self::Machine { .. } => "Machine",
        })
    }
}
