//! What determines how a running machine continues.

use crate::engine::obligations::Obligations;

/// The part of a running machine that determines how it continues, apart from τ. Two machines of one formula in the
/// same situation give the same verdicts from now on, if both count τ from the same moment.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(crate) enum Situation<'a> {
    /// The state of rules, and a tick for each rule.
    Compact(u16, &'a [u64]),
    /// The state of an automaton.
    Automaton(u16),
    /// The obligations, and the remembered events that the last messages satisfy.
    Progression(Option<&'a Obligations>, u64),
}
