//! The state that determines how a running machine continues.

use crate::engine::obligations::Obligations;
use crate::engine::past::Memory;

/// The part of a running machine that determines how it continues, apart from τ. Two machines of one formula in the
/// same situation give the same verdicts from now on, if both count τ from the same moment.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(crate) enum Situation<'a> {
    /// The state of rules, a tick for each rule, and the memory.
    Compact(u16, &'a [u64], &'a Memory),
    /// The state of an automaton.
    Automaton(u16),
    Progression(Option<&'a Obligations>, &'a Memory),
}
