//! What a fault does when it takes hold.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use components::Component;
use diagnostics::Spanned;
use maps::Pose;
use skills::Mutation;

/// What a fault does. What happens at one instant comes first, then what is so as long as the fault holds.
#[derive(Clone)]
pub(crate) enum Effect {
    /// The battery's charge is set, in percent.
    Charge(f64),
    /// The robot is put elsewhere; its wheels do not notice.
    Kidnap(Spanned<Pose>),
    /// Localization is told that the robot is there.
    Belief(Pose),
    /// Something is wrong with the robot or around it.
    World(Arc<dyn Fn(&mut sim::Faults) + Send + Sync>),
    /// The robot's software has the map in that file in place of the scenario's.
    Map(Spanned<PathBuf>),
    /// A component does nothing; if it crashed, it begins anew when the fault ends.
    Outage {
        /// Which.
        component: Component,
        /// Whether it forgets everything.
        crashed: bool,
    },
    /// Something becomes of the messages on some channels.
    Channels {
        /// Which channels.
        channels: Which,
        /// Which of their messages: a condition in the SCOPE language.
        condition: Spanned<String>,
        /// What becomes of them.
        damage: Damage,
        /// How likely it is for each message.
        probability: f64,
    },
    /// Ticks do not come when they should.
    Ticks(TickTrouble),
    /// A skill's machine is another one.
    Machine {
        /// Which skill.
        skill: Spanned<String>,
        /// Which machine.
        change: MachineChange,
    },
}

/// Channels that a fault concerns.
#[derive(Clone, Debug)]
pub(crate) enum Which {
    /// The one from a process to another.
    Between(Spanned<String>, Spanned<String>),
    /// All from a component.
    From(Component),
    /// All to a component.
    To(Component),
}

/// What becomes of a message.
#[derive(Clone, Debug)]
pub(crate) enum Damage {
    /// It is lost.
    Loss,
    /// It comes that much later.
    Delay(Duration),
    /// It comes twice.
    Duplicate,
    /// A field of it has another value: its number, from 1, and the value as the SCOPE language writes it.
    Corruption(Spanned<String>, usize),
    /// It says the opposite.
    Opposite,
    /// It never arrives, and its sender gets the answer that it waits for.
    Pretence(&'static str),
}

/// What is wrong with the ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TickTrouble {
    /// A share of them is not generated.
    Missed(f64),
    /// They come that much later.
    Late(Duration),
    /// They come later by the amount of a normal number with that standard deviation.
    Jitter(Duration),
}

/// How a machine differs from the scenario's.
#[derive(Clone, Debug)]
pub(crate) enum MachineChange {
    /// It is the one in that file.
    Replaced(Spanned<PathBuf>),
    /// It has that mistake.
    Mutated(Mutation),
    /// It has the mistake that is so called among all of [`skills::mutations`].
    MutatedAs(Spanned<String>),
}

impl Effect {
    /// The effect of something that is wrong in the simulated world as long as the fault holds.
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
            Self::World(_) => "World",
            Self::Map(_) => "Map",
            Self::Outage { .. } => "Outage",
            Self::Channels { .. } => "Channels",
            Self::Ticks(_) => "Ticks",
            Self::Machine { .. } => "Machine",
        })
    }
}
