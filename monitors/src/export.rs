//! Monitors as program graphs, and program graphs as text, Graphviz and SCXML.

mod automaton_graph;
mod dot;
mod picture;
mod rule_graph;
mod scxml;
mod shape;
mod text;

pub(crate) use picture::Picture;
pub(crate) use shape::MAX_DRAWN_STATES;

use channels::Topology;

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

impl Picture {
    /// The program graph in the given format.
    pub(crate) fn export(&self, format: Format, topology: &Topology) -> String {
        match format {
            Format::Text => text::text(&self.graph, &self.failures, topology),
            Format::Dot => dot::dot(&self.graph, &self.failures, topology),
            Format::Scxml => scxml::scxml(&self.graph, &self.failures, topology),
        }
    }
}
