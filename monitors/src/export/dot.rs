//! A program graph for Graphviz.

use std::fmt::Write as _;

use channels::{Label, LocationId, ProgramGraph, Topology};

/// The graph in the DOT language.
pub(crate) fn dot(graph: &ProgramGraph, failures: &[LocationId], topology: &Topology) -> String {
    let mut text = format!("digraph {} {{\n  rankdir=LR;\n  node [shape=circle];\n", quoted(graph.name()));
    for (index, location) in graph.locations().iter().enumerate() {
        let failed = failures.iter().any(|failure| failure.index() == index);
        let look = if failed { " [shape=doublecircle, color=red]" } else { "" };
        let _ = writeln!(text, "  {}{look};", quoted(location));
    }
    for initial in graph.initial_locations() {
        let name = &graph.locations()[initial.index()];
        let _ = writeln!(text, "  {} [shape=point];\n  {} -> {};", quoted("(start)"), quoted("(start)"), quoted(name));
    }
    for transition in graph.transitions() {
        let [from, to] = [transition.from, transition.to].map(|place| quoted(&graph.locations()[place.index()]));
        let label = quoted(&graph.caption(transition, topology));
        let style = if matches!(transition.label, Label::Internal(_)) { ", style=dashed" } else { "" };
        let _ = writeln!(text, "  {from} -> {to} [label={label}{style}];");
    }
    text.push_str("}\n");
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
