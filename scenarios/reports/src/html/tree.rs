//! The tree with the last answer of each node, as an outline that one unfolds: browsers search folded text, too.

use drawing::icons::Look;
use drawing::{Family, NodeStatus, TreeNode};
use maud::{Markup, html};
use recording::RunView;

use super::markup::text;
use super::words;
use crate::pictures;

/// Browsers do not nest elements without end.
const DEEPEST: usize = 100;

/// The outline; empty without a tree, or if its answers are not known.
pub(super) fn outline(view: &RunView) -> Markup {
    let nodes = pictures::tree_nodes(&view.header().tree, view.outcomes());
    let Family { children, .. } = Family::of(&nodes);
    let is_known = view.outcomes().iter().any(Option::is_some);
    html! {
        @if is_known {
            details.tree {
                summary { "The tree at the end: " (words::count(nodes.len(), "node")) }
                (branch(&nodes, &children, 0, 0))
            }
        }
    }
}

/// A node with everything below it. What ran or failed last is open.
fn branch(nodes: &[TreeNode], children: &[Vec<usize>], number: usize, depth: usize) -> Markup {
    let node = &nodes[number];
    let (sign, class, is_open) = match node.status {
        NodeStatus::Success => ("✓", "good", false),
        NodeStatus::Failure => ("✗", "bad", true),
        NodeStatus::Running => ("▸", "busy", true),
        NodeStatus::NotTicked => ("–", "quiet", false),
    };
    let line = html! { span.(class) title=(Look::of_status(node.status).words) { (sign) } " " (text(&node.label)) };
    let below = &children[number];
    html! {
        @if below.is_empty() { div { (line) } }
        @else if depth == DEEPEST { div { (line) " … the nodes below are too deep to be shown" } }
        @else {
            details open[is_open] {
                summary { (line) }
                @for &child in below { (branch(nodes, children, child, depth + 1)) }
            }
        }
    }
}
