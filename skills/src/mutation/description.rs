//! The description of a mutation: what it changes, and where.

use std::fmt;

/// One change of a machine.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Mutation {
    /// A datum starts with another value, for example a moved threshold.
    Data {
        /// The datum's id.
        id: String,
        /// The expression of its new value.
        expr: String,
    },
    /// The condition of a transition is negated.
    NegateGuard {
        /// A transition that has a condition.
        transition: TransitionPlace,
    },
    /// The condition of a transition is ignored.
    DropGuard {
        /// A transition that has a condition.
        transition: TransitionPlace,
    },
    /// A transition leads to another state.
    SwapTarget {
        /// A transition that has a target.
        transition: TransitionPlace,
        /// The id of its new target.
        target: String,
    },
    /// A transition is removed.
    DropTransition {
        /// The transition.
        transition: TransitionPlace,
    },
    /// No transition leaves the state once it is active.
    StuckState {
        /// The state's id.
        state: String,
    },
    /// Another message or event is sent: a success instead of a failure.
    SwapSend {
        /// The original message or event.
        send: SendPlace,
        /// The new one.
        event: String,
    },
    /// A message or an event is not sent.
    DropSend {
        /// The message or event.
        send: SendPlace,
    },
}

/// A transition, as described by its file: "the second in `ask` on `Navigation.ok`".
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TransitionPlace {
    /// The id of its source state.
    pub state: String,
    /// Its `event`, or one word of it; empty for a transition without events.
    pub event: String,
    /// The number among such transitions of the state, counted from 1.
    pub nth: usize,
}

/// A `<send>` with a literal `event`, in the entry, exit or transition content of a state.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SendPlace {
    /// The id of the state.
    pub state: String,
    /// The `event` that is sent.
    pub event: String,
    /// The number among such `<send>`s of the state, counted from 1.
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
            Self::Data { id, expr } => write!(f, "the datum `{id}` starts with {expr}"),
            Self::NegateGuard { transition } => write!(f, "{transition} is taken if its condition does not hold"),
            Self::DropGuard { transition } => write!(f, "{transition} ignores its condition"),
            Self::SwapTarget { transition, target } => write!(f, "{transition} leads to `{target}`"),
            Self::DropTransition { transition } => write!(f, "{transition} is removed"),
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
