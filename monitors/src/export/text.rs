//! A program graph as text: one line per location and per transition.

use channels::{LocationId, ProgramGraph, Topology};

/// The graph as text; a location that means violation has `!` after its name.
pub(crate) fn text(graph: &ProgramGraph, failures: &[LocationId], topology: &Topology) -> String {
    let mut text = format!("program graph {}\n", graph.name());
    let name = |location: LocationId| graph.locations()[location.index()].as_str();
    for (index, location) in graph.locations().iter().enumerate() {
        let initial = graph.initial_locations().iter().any(|initial| initial.index() == index);
        let failed = failures.iter().any(|failure| failure.index() == index);
        text += &format!("{} {location}{}\n", if initial { "  →" } else { "   " }, if failed { " !" } else { "" });
    }
    for transition in graph.transitions() {
        let plain = channels::GraphTransition { caption: String::new(), ..transition.clone() };
        let label = graph.caption(&plain, topology);
        let label = if label.is_empty() { "τ" } else { &label };
        text += &format!("    {} --[ {label} ]--> {}\n", name(transition.from), name(transition.to));
    }
    text
}
