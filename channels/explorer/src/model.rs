//! The model to explore: a system at its start, its ticks, its environment, and what may happen to messages.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, ChannelSystem, Process, ProcessId};

use crate::environment::AnyEnvironment;

/// A system to be explored.
#[derive(Debug)]
pub struct Model {
    pub(crate) start: ChannelSystem,
    pub(crate) ticks: Option<Ticks>,
    pub(crate) environment: Arc<AnyEnvironment>,
    pub(crate) anywhere: bool,
    pub(crate) faults: MessageFaults,
    pub(crate) onlooker: Option<Arc<dyn Onlooker>>,
}

/// The ticks of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ticks {
    /// The [`TickGenerator`](channels::TickGenerator).
    pub generator: ProcessId,
    /// The time from one tick to the next.
    pub period: Duration,
    /// The time from the start to the first tick.
    pub first: Duration,
    /// The resolution of the run's clock: timers fire at multiples of it. Zero if they fire exactly when they are due.
    pub step: Duration,
}

/// Called with each process after each step that is computed for the first time, before the state that exists only for
/// reporting is forgotten.
pub trait Onlooker: fmt::Debug + Send + Sync {
    /// Sees a process.
    fn see(&self, id: ProcessId, process: &dyn Process);
}

/// How many messages may be disturbed in a run, and on which channels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MessageFaults {
    /// How many may be lost.
    pub lost: u8,
    /// How many may be delivered twice.
    pub repeated: u8,
    /// How many may be held back, and for how long.
    pub delayed: (u8, Duration),
    /// The channels whose messages may be disturbed, all of capacity 1.
    pub channels: Vec<ChannelId>,
}

/// A disturbance of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// Nothing.
    None,
    /// It is lost as soon as it is sent.
    Lost,
    /// It is held back.
    Held,
    /// It stays in the channel after it is received.
    Repeated,
}

impl Model {
    /// The system in its present state, in this environment. Without ticks, it is explored until nothing more can
    /// happen. The system's own monitors and disturbances are ignored.
    #[must_use]
    pub fn new(system: &ChannelSystem, ticks: Option<Ticks>, environment: Arc<AnyEnvironment>) -> Self {
        let faults = MessageFaults::default();
        Self { start: system.fork(), ticks, environment, anywhere: false, faults, onlooker: None }
    }

    /// The same, with an environment that also moves while processes communicate.
    #[must_use]
    pub fn with_interleaved_drivers(self) -> Self {
        Self { anywhere: true, ..self }
    }

    /// The same, with disturbed messages.
    #[must_use]
    pub fn with_message_faults(self, faults: MessageFaults) -> Self {
        Self { faults, ..self }
    }

    /// The same, with an observer that sees every state found of every process.
    #[must_use]
    pub fn with_onlooker(self, onlooker: Arc<dyn Onlooker>) -> Self {
        Self { onlooker: Some(onlooker), ..self }
    }
}
