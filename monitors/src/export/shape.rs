//! The shape of a monitor's program graph.

use channels::Topology;

use crate::engine::Timing;
use crate::export::automaton_graph;
use crate::export::picture::Picture;
use crate::export::rule_graph::Draft;
use crate::synthesis::Synthesis;

/// An automaton with more open states is not drawn, but it can be exported. Chosen, not measured.
pub(crate) const MAX_DRAWN_STATES: usize = 12;

impl Picture {
    /// The graph of a monitor, if it has one, and not that of an automaton with more than `limit` open states.
    pub(crate) fn of(name: &str, synthesis: &Synthesis, topology: &Topology, limit: usize) -> Option<Self> {
        let words = &synthesis.vocabulary;
        if let Some(automaton) = synthesis.automaton() {
            return automaton_graph::picture(name, automaton, (words, &synthesis.alphabet), topology, limit);
        }
        let compact = synthesis
            .compact()
            .filter(|compact| compact.is_exact() && !compact.rules.is_empty() && synthesis.has_graph())?;
        let draft = Draft::new(name, words, topology);
        match compact.rules.as_slice() {
            [rule] if rule.timing != Timing::Never => draft.timed(rule),
            _ => draft.safety(compact),
        }
    }
}
