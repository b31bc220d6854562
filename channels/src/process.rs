//! The definition of a process: it offers transitions and takes one of them.

use std::any::Any;
use std::fmt::Debug;
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use crate::{ChannelId, Envelope, Message, NoNormalForm, NormalForm, RequestNumber, Symbol};

/// A transition of a process, numbered by the process itself. The number has no meaning elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TransitionId(pub u32);

/// Which messages a receive action takes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// Any message: `?(q, p, x)`.
    Any,
    /// This message and no other: `?(q, p, <m>)`.
    Exactly(Message),
    /// Any message that does not begin with one of these symbols.
    Except(Arc<[Symbol]>),
}

impl Pattern {
    /// Whether the action accepts the message.
    #[must_use]
    pub fn accepts(&self, message: &Message) -> bool {
        match self {
            Self::Any => true,
            Self::Exactly(expected) => expected == message,
            Self::Except(heads) => !heads.iter().any(|head| Some(head.name()) == message.head()),
        }
    }
}

/// The effect of a transition, apart from the change of the process's state.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// An internal action.
    Internal,
    /// `!(p, q, …)`: sends this envelope.
    Send(ChannelId, Envelope),
    /// `?(q, p, …)`: receives a message that the pattern accepts.
    Receive(ChannelId, Pattern),
}

/// A transition whose guard holds: the process can take it if the channels permit.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Offer {
    /// The process's own number for the transition.
    pub transition: TransitionId,
    /// What it does.
    pub action: Action,
}

/// A communication that a process may perform, for the check at wiring.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Use {
    /// It may send on the channel: this message, or an unknown one if the message is only known at run time.
    Sends(ChannelId, Option<Message>),
    /// It may receive from the channel: this message only, or any.
    Receives(ChannelId, Option<Message>),
}

/// A process of a channel system.
///
/// Its state is a value: it can be copied, compared and hashed ([`ProcessState`] follows from `Clone + Eq + Hash`). Its
/// behavior is a function of that state and of the messages it receives. A driver outside the system gives it all other
/// data between steps.
pub trait Process: ProcessState + Debug + Send + Sync {
    /// Appends the transitions whose guards hold, without side effects and in an order that depends only on the state.
    ///
    /// A process takes one transition at a time, which the scheduler chooses from all enabled ones.
    fn offers(&self, offers: &mut Vec<Offer>);

    /// Takes a transition that was offered in the current state. `received` is the envelope that a receive action takes
    /// from its channel. `now` is the time of the run.
    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration);

    /// When the process's next timer is due, if it has one.
    fn next_timer(&self) -> Option<Duration> {
        None
    }

    /// Fires all timers that are due at `now`, in order of their times. Called between steps.
    fn fire_timers(&mut self, now: Duration) {
        let _ = now;
    }

    /// Every communication that the process may ever perform, for the check at wiring.
    fn uses(&self) -> Vec<Use>;

    /// Appends the requests that it has sent, or is about to send, and whose answers would still matter to it, each
    /// with its channel.
    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        let _ = requests;
    }

    /// Brings the state into normal form: afterwards, states that continue alike should be equal, and states that do
    /// not must not be. Needed only for proofs.
    ///
    /// # Errors
    /// [`NoNormalForm`] if the process has none; by default it has none.
    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        let _ = form;
        Err(NoNormalForm::Unsupported {
            reason: "it does not define which of its states are alike".to_owned(),
            help: None,
        })
    }

    /// What an internal transition that is offered now does, in words that continue the process's name. `None` if it is
    /// not worth mentioning.
    fn in_words(&self, transition: TransitionId) -> Option<String> {
        let _ = transition;
        None
    }

    /// The current location in a word or two, for reports and pictures: `idle`, `waiting for Navigation`.
    fn location(&self) -> String;
}

/// A process's state as a value, whatever its type. Implemented for every `Clone + Eq + Hash` type.
pub trait ProcessState: Any {
    /// A copy.
    fn clone_process(&self) -> Box<dyn Process>;

    /// Whether the other process is of the same type and in the same state.
    fn same_state(&self, other: &dyn Process) -> bool;

    /// Feeds the state to a hasher.
    fn hash_state(&self, hasher: &mut dyn Hasher);

    /// The process as its own type, for its driver.
    fn as_any(&self) -> &dyn Any;

    /// The process as its own type, for its driver.
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

impl<P: Process + Clone + Eq + Hash> ProcessState for P {
    fn clone_process(&self) -> Box<dyn Process> {
        Box::new(self.clone())
    }

    fn same_state(&self, other: &dyn Process) -> bool {
        other.as_any().downcast_ref::<P>() == Some(self)
    }

    fn hash_state(&self, mut hasher: &mut dyn Hasher) {
        self.hash(&mut hasher);
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}

impl Clone for Box<dyn Process> {
    fn clone(&self) -> Self {
        self.clone_process()
    }
}

impl PartialEq for dyn Process {
    fn eq(&self, other: &Self) -> bool {
        self.same_state(other)
    }
}

impl Eq for dyn Process {}

impl Hash for dyn Process {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.hash_state(state);
    }
}
