//! Monitors on letters: what remains of a formula after each state, and the machines that track it.
//!
//! - [`Alphabet`] turns messages into letters: the events of the formula that a message satisfies.
//! - [`Past`] gives the values of the operators that look back in each state; [`Memory`] is what it needs for that.
//! - [`Obligations`] are what the rest of a run must do; [`Operators`] carry them from one state to the next.
//! - [`Anticipation`] determines what endless words can still do with obligations.
//! - [`Progression`] keeps the obligations themselves. An [`Automaton`] computes all their possible states before the
//!   run. [`Compact`] needs no obligations, for the paper's safety and response formulas.

mod alphabet;
mod anticipation;
mod automaton;
mod combinations;
mod compact;
mod history;
mod limits;
mod obligations;
mod operators;
mod past;
mod progression;
mod situation;
mod table;

pub(crate) use alphabet::{Alphabet, Letter, MAX_EVENTS, Symbol};
pub(crate) use anticipation::Anticipation;
pub(crate) use automaton::{Automaton, AutomatonRun};
pub(crate) use combinations::combinations;
pub use combinations::samples;
pub(crate) use compact::{Compact, CompactRun, Rule, Timing};
pub use limits::Limits;
pub(crate) use obligations::{Clause, Obligation, Obligations, order_at};
pub(crate) use operators::{Awaited, Operators, State};
pub(crate) use past::{Bits, LetterTrigger, Memory, Past};
pub(crate) use progression::Progression;
pub(crate) use situation::Situation;
