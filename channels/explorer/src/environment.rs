//! What drives a system from outside, and its states.

use std::any::Any;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Message, Process, ProcessId};
use smallvec::SmallVec;

/// Drives a system from outside: the world around it changes between its steps.
///
/// The moves depend only on its state and on the processes that it drives.
pub trait Environment: fmt::Debug + Send + Sync {
    /// Its states.
    type State: Clone + Eq + Hash + fmt::Debug + Send + Sync + 'static;

    /// The processes that it reads and changes.
    fn driven(&self) -> &[ProcessId];

    /// Its state at the start.
    fn start(&self) -> Self::State;

    /// The possible moves before a tick or at any other moment, in an order that depends only on the arguments. Without
    /// a move, time stands still. `driven` are the processes that it drives, in their normal form.
    fn moves(&self, state: &Self::State, driven: &[&dyn Process], instant: Instant) -> Vec<Move<Self::State>>;

    /// Changes a driven process, in normal form or not, as a move does that reports this number to it.
    fn report(&self, id: ProcessId, report: u32, process: &mut dyn Process, now: Duration);

    /// The same moves in words: `the level falls below 30 %`. Empty where nothing worth mentioning changes.
    fn words(&self, state: &Self::State, driven: &[&dyn Process], instant: Instant) -> Vec<String>;

    /// The message that monitors are shown when its state changes so, on a channel between processes outside the
    /// system.
    fn shown(&self, _before: &Self::State, _after: &Self::State) -> Option<(ChannelId, Message)> {
        None
    }

    /// Whether a move may enable a process that could not move, or shows monitors something. If not, the search leaves
    /// out the moves that are possible while time stands still.
    fn may_stir(&self, _state: &Self::State, _driven: &[&dyn Process]) -> bool {
        true
    }

    /// The same environment, without the type of its states.
    fn erased(self) -> Arc<AnyEnvironment>
    where
        Self: Sized + 'static,
    {
        Arc::new(Erased(self))
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

/// Something that may happen in the environment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Move<State> {
    /// The state of the environment after the move.
    pub state: State,
    /// What is [reported](Environment::report) to each driven process. The numbers are small, since the search keeps
    /// the effect of each in a table: how a process changes is computed once for all moves that report the same.
    pub reports: SmallVec<[u32; 4]>,
}

/// The environment of a system that nothing drives.
#[derive(Clone, Copy, Debug, Default)]
pub struct Closed;

impl Environment for Closed {
    type State = ();

    fn driven(&self) -> &[ProcessId] {
        &[]
    }

    fn start(&self) {}

    fn moves(&self, (): &(), _driven: &[&dyn Process], _instant: Instant) -> Vec<Move<()>> {
        vec![Move { state: (), reports: SmallVec::new() }]
    }

    fn report(&self, _id: ProcessId, _report: u32, _process: &mut dyn Process, _now: Duration) {}

    fn words(&self, (): &(), _driven: &[&dyn Process], _instant: Instant) -> Vec<String> {
        vec![String::new()]
    }
}

/// The state of some environment.
#[derive(Clone)]
pub struct EnvironmentState(Arc<dyn ErasedState>);

/// An environment of any type.
///
/// Models, tables and runs hold it in this form, so that they do not depend on the type of its states. Only their
/// hashes and equality matter to a search, and each state is hashed once, so the indirection costs nothing.
pub type AnyEnvironment = dyn Environment<State = EnvironmentState>;

impl EnvironmentState {
    /// A state of any type.
    pub fn new<S: Eq + Hash + fmt::Debug + Send + Sync + 'static>(state: S) -> Self {
        Self(Arc::new(state))
    }

    /// The state, if it has this type.
    #[must_use]
    pub fn get<S: 'static>(&self) -> Option<&S> {
        self.0.as_any().downcast_ref()
    }
}

impl fmt::Debug for EnvironmentState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl PartialEq for EnvironmentState {
    fn eq(&self, other: &Self) -> bool {
        self.0.equals(other)
    }
}

impl Eq for EnvironmentState {}

impl Hash for EnvironmentState {
    fn hash<H: Hasher>(&self, mut hasher: &mut H) {
        self.0.feed(&mut hasher);
    }
}

trait ErasedState: fmt::Debug + Send + Sync {
    fn as_any(&self) -> &dyn Any;
    fn equals(&self, other: &EnvironmentState) -> bool;
    fn feed(&self, hasher: &mut dyn Hasher);
}

impl<S: Eq + Hash + fmt::Debug + Send + Sync + 'static> ErasedState for S {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn equals(&self, other: &EnvironmentState) -> bool {
        other.get() == Some(self)
    }

    fn feed(&self, mut hasher: &mut dyn Hasher) {
        self.hash(&mut hasher);
    }
}

/// An environment without the type of its states.
#[derive(Debug)]
struct Erased<E>(E);

impl<E: Environment> Erased<E> {
    fn typed<'s>(&self, state: &'s EnvironmentState) -> &'s E::State {
        state.get().expect("an environment receives only states that it has returned")
    }
}

impl<E: Environment> Environment for Erased<E> {
    type State = EnvironmentState;

    fn driven(&self) -> &[ProcessId] {
        self.0.driven()
    }

    fn start(&self) -> EnvironmentState {
        EnvironmentState::new(self.0.start())
    }

    fn moves(
        &self,
        state: &EnvironmentState,
        driven: &[&dyn Process],
        instant: Instant,
    ) -> Vec<Move<EnvironmentState>> {
        let moves = self.0.moves(self.typed(state), driven, instant).into_iter();
        moves.map(|Move { state, reports }| Move { state: EnvironmentState::new(state), reports }).collect()
    }

    fn report(&self, id: ProcessId, report: u32, process: &mut dyn Process, now: Duration) {
        self.0.report(id, report, process, now);
    }

    fn words(&self, state: &EnvironmentState, driven: &[&dyn Process], instant: Instant) -> Vec<String> {
        self.0.words(self.typed(state), driven, instant)
    }

    fn shown(&self, before: &EnvironmentState, after: &EnvironmentState) -> Option<(ChannelId, Message)> {
        self.0.shown(self.typed(before), self.typed(after))
    }

    fn may_stir(&self, state: &EnvironmentState, driven: &[&dyn Process]) -> bool {
        self.0.may_stir(self.typed(state), driven)
    }
}
