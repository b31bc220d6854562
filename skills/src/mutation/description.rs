//! What a mutation changes, and where.

use std::fmt;

/// One change of a machine.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Mutation {
    /// A datum begins with another value: a threshold is moved.
    Data {
        /// The datum's id.
        id: String,
        /// The expression that gives its value instead.
        expr: String,
    },
    /// A transition is taken where its condition does not hold, and is not where it does.
    NegateGuard {
        /// A transition that has a condition.
        transition: TransitionPlace,
    },
    /// A transition is taken whether its condition holds or not.
    DropGuard {
        /// A transition that has a condition.
        transition: TransitionPlace,
    },
    /// A transition leads elsewhere.
    SwapTarget {
        /// A transition that has a target.
        transition: TransitionPlace,
        /// The id of the state that it leads to instead.
        target: String,
    },
    /// A transition is not there.
    DropTransition {
        /// Which.
        transition: TransitionPlace,
    },
    /// Once the state is active, no transition leaves it.
    StuckState {
        /// The state's id.
        state: String,
    },
    /// Something else is sent: a success where there was none.
    SwapSend {
        /// The message or event that is sent now.
        send: SendPlace,
        /// The one that is sent instead.
        event: String,
    },
    /// A message or an event is not sent.
    DropSend {
        /// Which.
        send: SendPlace,
    },
}

/// A transition, as somebody says which who has the file before him: "the second in `ask` on `Navigation.ok`".
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TransitionPlace {
    /// The id of the state that it leads out of.
    pub state: String,
    /// What it reacts to: its `event`, or one word of it; empty for a transition without events.
    pub event: String,
    /// Which of several such transitions of the state, counted from 1.
    pub nth: usize,
}

/// A `<send>` with an `event` written out, in what a state does on entry, on exit or in one of its transitions.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SendPlace {
    /// The id of the state.
    pub state: String,
    /// The `event` that is sent.
    pub event: String,
    /// Which of several such `<send>`s of the state, counted from 1.
    pub nth: usize,
}

impl Mutation {
    /// The kind of mutation in a word or two: `data`, `negate_guard`, `drop_guard`, `swap_target`, `drop_transition`,
    /// `stuck_state`, `swap_send`, `drop_send`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Data { .. } => "data",
            Self::NegateGuard { .. } => "negate_guard",
            Self::DropGuard { .. } => "drop_guard",
            Self::SwapTarget { .. } => "swap_target",
            Self::DropTransition { .. } => "drop_transition",
            Self::StuckState { .. } => "stuck_state",
            Self::SwapSend { .. } => "swap_send",
            Self::DropSend { .. } => "drop_send",
        }
    }
}

/// The mutation in words, on one line.
impl fmt::Display for Mutation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Data { id, expr } => write!(f, "the datum `{id}` begins with {expr}"),
            Self::NegateGuard { transition } => write!(f, "{transition} is taken if its condition does not hold"),
            Self::DropGuard { transition } => write!(f, "{transition} is taken whatever its condition says"),
            Self::SwapTarget { transition, target } => write!(f, "{transition} leads to `{target}`"),
            Self::DropTransition { transition } => write!(f, "{transition} is not there"),
            Self::StuckState { state } => write!(f, "no transition leaves `{state}`"),
            Self::SwapSend { send, event } => write!(f, "{send} sends `{event}`"),
            Self::DropSend { send } => write!(f, "{send} sends nothing"),
        }
    }
}

impl fmt::Display for TransitionPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { state, event, nth } = self;
        write!(f, "the {}transition in `{state}` ", ordinal(*nth))?;
        if event.is_empty() { f.write_str("without an event") } else { write!(f, "on `{event}`") }
    }
}

impl fmt::Display for SendPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { state, event, nth } = self;
        write!(f, "the {}<send> of `{event}` in `{state}`", ordinal(*nth))
    }
}

/// `2nd `; nothing for the first.
fn ordinal(nth: usize) -> String {
    let ending = match (nth % 10, nth % 100) {
        (1, rest) if rest != 11 => "st",
        (2, rest) if rest != 12 => "nd",
        (3, rest) if rest != 13 => "rd",
        _ => "th",
    };
    if nth == 1 { String::new() } else { format!("{nth}{ending} ") }
}
