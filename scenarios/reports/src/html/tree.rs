//! The tree with the last answer of each node, as an outline that one unfolds: browsers search folded text, too.

use diagnostics::counted;
use drawing::{Family, NodeStatus, TreeNode};
use maud::{Markup, html};
use recording::RunView;

use super::markup::text;
use crate::pictures;

/// Browsers do not nest elements without end.
const DEEPEST: usize = 100;

/// Whether there is a tree with answers.
pub(super) fn is_known(view: &RunView) -> bool {
    view.outcomes().iter().any(Option::is_some)
}

/// The outline; empty if no answer is known.
pub(super) fn outline(view: &RunView) -> Markup {
    let nodes = pictures::tree_nodes(&view.header().tree, view.outcomes());
    let Family { children, .. } = Family::of(&nodes);
    html! {
        @if is_known(view) {
            details.tree {
                summary { "The tree at the end: " (counted(nodes.len(), "node")) }
                (Outline { nodes: &nodes, children, open: open(&nodes, view), view }.branch(0, 0))
            }
        }
    }
}

/// For each node whether what is below it is shown at first: the way to what is running, or to why the tree has failed.
fn open(nodes: &[TreeNode], view: &RunView) -> Vec<bool> {
    let mut open: Vec<bool> = nodes.iter().map(|node| node.status == NodeStatus::Running).collect();
    let failure = view.tree_failure().filter(|failure| failure.lasts);
    let mut cause = failure.map(|failure| failure.node);
    while let Some(node) = cause {
        open[node] = true;
        cause = nodes[node].parent;
    }
    open
}

/// What is needed to write a tree.
struct Outline<'t> {
    nodes: &'t [TreeNode],
    children: Vec<Vec<usize>>,
    open: Vec<bool>,
    view: &'t RunView,
}

impl Outline<'_> {
    /// A node with everything below it.
    fn branch(&self, number: usize, depth: usize) -> Markup {
        let node = &self.nodes[number];
        let (sign, class) = match node.status {
            NodeStatus::Success => ("✓", "good"),
            NodeStatus::Failure => ("✗", "bad"),
            NodeStatus::Running => ("▸", "busy"),
            NodeStatus::NotTicked => ("–", "quiet"),
        };
        let nothing = if self.view.header().knows_ticks() { "not ticked" } else { "no answer is known" };
        let words = self.view.outcomes()[number].map_or(nothing, bt::Outcome::name);
        let line = html! { span.(class) title=(words) { (sign) } " " (text(&node.label)) };
        let below = &self.children[number];
        html! {
            @if below.is_empty() { div { (line) } }
            @else if depth == DEEPEST { div { (line) " … the nodes below are too deep to be shown" } }
            @else {
                details open[self.open[number]] {
                    summary { (line) }
                    @for &child in below { (self.branch(child, depth + 1)) }
                }
            }
        }
    }
}
