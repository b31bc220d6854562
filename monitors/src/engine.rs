//! Monitors at work on letters: what is left of a formula after each state, and the machines that keep track of it.
//!
//! - [`Alphabet`] turns messages into letters: which of the formula's events a message satisfies.
//! - [`Obligations`] say what the rest of a run owes; [`Operators`] carry them from one state to the next.
//! - [`Anticipation`] says what endless words can still make of obligations.
//! - [`Progression`] keeps the obligations themselves; [`Automaton`] has worked out all that can become of them before
//!   the run; [`Compact`] needs no obligations at all, for the paper's safety and response formulas.

mod alphabet;
mod anticipation;
mod automaton;
mod compact;
mod obligations;
mod operators;
mod progression;
mod table;

pub use alphabet::Symbol;
pub(crate) use alphabet::{Alphabet, Letter, MAX_EVENTS};
pub(crate) use anticipation::Anticipation;
pub(crate) use automaton::{Automaton, AutomatonRun, MAX_STATES as MAX_AUTOMATON_STATES};
pub(crate) use compact::{Compact, CompactRun, Rule, Timing};
pub(crate) use obligations::{Clause, Obligation, Obligations};
pub(crate) use operators::Operators;
pub(crate) use progression::Progression;
