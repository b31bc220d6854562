//! The adapter between a machine and its channels.

use std::any::Any;
use std::fmt::Debug;
use std::hash::{Hash, Hasher};

use channels::{ChannelId, Envelope, NoNormalForm, NormalForm, Offer, RequestNumber, TransitionId, Use};

use crate::Datum;
use crate::event::Event;
use crate::machine::{Machine, Undelivered};

/// Turns the messages of a machine's channels into events, and what the machine sends into messages.
///
/// Like that of a process, its state is a value ([`AdapterState`] follows from `Clone + Eq + Hash`).
pub trait Adapter: AdapterState + Debug + Send + Sync {
    /// Appends the transitions that the process can take.
    fn offers(&self, offers: &mut Vec<Offer>);

    /// Takes one of the transitions. Returns the event that the machine must process, if the message received is one;
    /// what comes with it may be stored in the machine's data.
    fn take(&mut self, transition: TransitionId, received: Option<&Envelope>, machine: &mut Machine) -> Option<Event>;

    /// An event that had to wait until the machine has processed the last one.
    fn waiting(&mut self) -> Option<Event> {
        None
    }

    /// Sends a message that begins with the symbol `head` and has these fields by name: to the process `target`, or
    /// without a target to all that have subscribed to the topic.
    ///
    /// # Errors
    /// [`Undelivered`] if there is no such channel or topic, if the channel does not carry the message, if it answers
    /// nothing or cancels nothing, or if too many messages are already waiting.
    fn send(&mut self, target: Option<&str>, head: &str, data: &Datum) -> Result<(), Undelivered>;

    /// Adds an event to those of which the machine will get one: its transitions are offered next, and no others.
    ///
    /// # Errors
    /// [`Undelivered`] if there are no choices here.
    fn choose(&mut self, event: Event) -> Result<(), Undelivered> {
        Err(Undelivered::Unfit(format!("there are no choices here, so `{}` cannot be chosen", event.name)))
    }

    /// The event that the machine gets if it takes this transition, if that is a choice.
    fn choice(&self, transition: TransitionId) -> Option<&Event> {
        let _ = transition;
        None
    }

    /// Completes what the machine has sent, now that it has come to rest.
    fn complete(&mut self, machine: &mut Machine) {
        let _ = machine;
    }

    /// The adapter of a process that replaces this one.
    fn succeeding(&self) -> Box<dyn Adapter>;

    /// Every communication that the process may ever perform with this machine.
    fn uses(&self, machine: &Machine) -> Vec<Use>;

    /// Appends the requests whose answers would still matter, as [`Process::awaits`](channels::Process::awaits) does.
    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        let _ = requests;
    }

    /// Brings the state into [normal form](NormalForm).
    ///
    /// # Errors
    /// [`NoNormalForm`] if there is none.
    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm>;
}

/// An adapter's state as a value, whatever its type. Implemented for every `Clone + Eq + Hash` type.
pub trait AdapterState: Any {
    /// A copy.
    fn clone_adapter(&self) -> Box<dyn Adapter>;

    /// Whether the other adapter is of the same type and in the same state.
    fn same_state(&self, other: &dyn Adapter) -> bool;

    /// Feeds the state to a hasher.
    fn hash_state(&self, hasher: &mut dyn Hasher);
}

impl<A: Adapter + Clone + Eq + Hash> AdapterState for A {
    fn clone_adapter(&self) -> Box<dyn Adapter> {
        Box::new(self.clone())
    }

    fn same_state(&self, other: &dyn Adapter) -> bool {
        (other as &dyn Any).downcast_ref::<A>() == Some(self)
    }

    fn hash_state(&self, mut hasher: &mut dyn Hasher) {
        self.hash(&mut hasher);
    }
}

impl Clone for Box<dyn Adapter> {
    fn clone(&self) -> Self {
        self.clone_adapter()
    }
}

impl PartialEq for dyn Adapter {
    fn eq(&self, other: &Self) -> bool {
        self.same_state(other)
    }
}

impl Hash for dyn Adapter {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.hash_state(state);
    }
}
