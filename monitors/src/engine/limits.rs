//! How much is computed about a formula before a run.

/// Where the computation about a formula ends. Beyond a limit, verdicts come later; none is different.
///
/// The defaults are chosen, not measured, except for two that follow from how sets are kept: `rules` are the bits of a
/// 16-bit number, and `delays` those of a 128-bit number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Visits to parts of conditions, for finding out which conditions on a channel can hold together.
    pub combinations: usize,
    /// The letters of an automaton or a graph.
    pub symbols: usize,
    /// The clauses of a formula that are monitored as rules; at most 16.
    pub rules: usize,
    /// The states of a graph.
    pub graph_states: usize,
    /// The states of an automaton; at most 65,534.
    pub automaton_states: usize,
    /// The clauses of an automaton's state.
    pub clauses: usize,
    /// The sets of obligations that continuations lead to.
    pub nodes: usize,
    /// The steps between them.
    pub edges: usize,
    /// The ways to meet a set of obligations.
    pub ways: usize,
    /// The different obligations that a continuation can postpone; at most 128.
    pub delays: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            combinations: 2_000_000,
            symbols: 1 << 10,
            rules: 16,
            graph_states: 4_096,
            automaton_states: 10_000,
            clauses: 500,
            nodes: 20_000,
            edges: 400_000,
            ways: 200,
            delays: 128,
        }
    }
}
