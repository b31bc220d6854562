//! Monitors as program graphs, and program graphs as text, Graphviz and SCXML.

mod automaton_graph;
mod dot;
mod picture;
mod rule_graph;
mod scxml;
mod shape;
mod text;

pub(crate) use picture::Picture;

use crate::monitor::ScopeMonitor;

/// A format for exported monitors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// The program graph as text.
    Text,
    /// Graphviz.
    Dot,
    /// An SCXML machine with the ECMAScript data model: a message from P to Q is the event `message.P.Q` with the
    /// message as an array in its data, symbols as `{ sym: "ok" }`; a tick is the event `tick` with its number as data.
    Scxml,
}

impl ScopeMonitor {
    /// The monitor's program graph in the given format; `None` for a monitor by progression, which has no graph.
    ///
    /// An automaton as a graph treats a tick with number 0 as the first of the run, and any other as one that follows
    /// another tick. It is correct on runs whose ticks are numbered from 0 without gaps.
    #[must_use]
    pub fn export(&self, format: Format) -> Option<String> {
        let picture = self.picture_of_any_size()?;
        let (graph, failures) = (&picture.graph, &picture.failures);
        Some(match format {
            Format::Text => text::text(graph, failures, self.topology()),
            Format::Dot => dot::dot(graph, failures, self.topology()),
            Format::Scxml => scxml::scxml(graph, failures, self.topology()),
        })
    }
}
