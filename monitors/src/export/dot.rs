//! A program graph for Graphviz.

use channels::{Label, LocationId, ProgramGraph, Topology};

pub(crate) fn dot(graph: &ProgramGraph, failures: &[LocationId], topology: &Topology) -> String {
    let mut text = format!("digraph {} {{\n  rankdir=LR;\n  node [shape=circle];\n", quoted(graph.name()));
    for (index, location) in graph.locations().iter().enumerate() {
        let failed = failures.iter().any(|failure| failure.index() == index);
        let look = if failed { " [shape=doublecircle, color=red]" } else { "" };
        text += &format!("  {}{look};\n", quoted(location));
    }
    for initial in graph.initial_locations() {
        let name = &graph.locations()[initial.index()];
        text += &format!("  {} [shape=point];\n  {} -> {};\n", quoted("(start)"), quoted("(start)"), quoted(name));
    }
    for transition in graph.transitions() {
        let [from, to] = [transition.from, transition.to].map(|place| quoted(&graph.locations()[place.index()]));
        let label = quoted(&graph.caption(transition, topology));
        let style = if matches!(transition.label, Label::Internal(_)) { ", style=dashed" } else { "" };
        text += &format!("  {from} -> {to} [label={label}{style}];\n");
    }
    text.push_str("}\n");
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
