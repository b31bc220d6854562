//! The model to explore: a system at its start, its ticks, its environment, and what may happen to messages.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, ChannelSystem, Process, ProcessId};
use smallvec::SmallVec;

/// A system to be explored.
#[derive(Debug)]
pub struct Model {
    pub(crate) start: ChannelSystem,
    pub(crate) ticks: Option<Ticks>,
    pub(crate) environment: Arc<dyn Environment>,
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

/// Drives a system from outside: the world around it changes between its steps.
///
/// Its state is encoded in numbers, as is what its moves tell the processes that it drives. The moves depend only on
/// this state and on these processes.
pub trait Environment: fmt::Debug + Send + Sync {
    /// The processes that it reads and changes.
    fn driven(&self) -> &[ProcessId];

    /// Its state at the start.
    fn start(&self) -> EnvironmentState;

    /// The possible moves before a tick or at any other moment, in an order that depends only on the arguments. Without
    /// a move, time stands still. `driven` are the processes that it drives, in their normal form.
    fn moves(&self, state: &[i64], driven: &[&dyn Process], instant: Instant) -> Vec<Move>;

    /// Changes a driven process, in normal form or not, as a move does that tells it this number.
    fn tell(&self, id: ProcessId, told: u32, process: &mut dyn Process, now: Duration);

    /// The same moves in words: `the level falls below 30 %`. Empty where nothing worth mentioning changes.
    fn words(&self, state: &[i64], driven: &[&dyn Process], instant: Instant) -> Vec<String>;

    /// Whether a move may enable a process that could not move. If not, the search leaves out the moves that are
    /// possible while time stands still.
    fn may_stir(&self, _state: &[i64], _driven: &[&dyn Process]) -> bool {
        true
    }
}

/// When an environment moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Instant {
    /// Before the next tick.
    Tick,
    /// Before a timer fires, or at any other moment between two ticks.
    Between,
}

/// The state of an environment.
pub type EnvironmentState = SmallVec<[i64; 8]>;

/// Something that may happen in the environment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Move {
    /// The state of the environment after the move.
    pub state: EnvironmentState,
    /// What each driven process is [told](Environment::tell): small numbers.
    pub told: SmallVec<[u32; 4]>,
}

/// The environment of a system that nothing drives.
#[derive(Clone, Copy, Debug, Default)]
pub struct Closed;

impl Environment for Closed {
    fn driven(&self) -> &[ProcessId] {
        &[]
    }

    fn start(&self) -> EnvironmentState {
        EnvironmentState::new()
    }

    fn moves(&self, _state: &[i64], _driven: &[&dyn Process], _instant: Instant) -> Vec<Move> {
        vec![Move { state: EnvironmentState::new(), told: SmallVec::new() }]
    }

    fn tell(&self, _id: ProcessId, _told: u32, _process: &mut dyn Process, _now: Duration) {}

    fn words(&self, _state: &[i64], _driven: &[&dyn Process], _instant: Instant) -> Vec<String> {
        vec![String::new()]
    }
}

impl Model {
    /// The system in its present state, in this environment. Without ticks, it is explored until nothing more can
    /// happen. The system's own monitors and disturbances are ignored.
    #[must_use]
    pub fn new(system: &ChannelSystem, ticks: Option<Ticks>, environment: Arc<dyn Environment>) -> Self {
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
