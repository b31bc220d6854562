//! A behavior tree as a separate picture.

use super::canvas::Canvas;
use super::tree_folding::FoldedTree;
use super::tree_layout::TreeLayout;
use super::tree_panel::{draw_nodes, draw_signs, signs_height};

/// The margin around a tree, in pixels.
const MARGIN: f64 = 24.0;

/// The tree as a standalone SVG picture, as large as necessary: no label is shortened.
///
/// ```
/// use drawing::{FoldedTree, NodeStatus, TreeNode, tree_svg};
///
/// let node = |parent, label: &str, status| TreeNode { parent, label: label.to_owned(), status };
/// let tree = [
///     node(None, "→", NodeStatus::Running),
///     node(Some(0), "BatteryLevel", NodeStatus::Success),
///     node(Some(0), "GotoGoal", NodeStatus::Running),
/// ];
/// assert!(tree_svg(&FoldedTree::whole(&tree)).contains(">GotoGoal<"));
/// ```
#[must_use]
pub fn tree_svg(tree: &FoldedTree) -> String {
    let nodes = &tree.nodes;
    let (height, _) = TreeLayout::wanted_height(nodes);
    let layout = TreeLayout::new(nodes, f64::INFINITY, height);
    let mut canvas = Canvas::for_browsers();
    draw_nodes(&mut canvas, &layout, tree, (MARGIN, MARGIN));
    let (width, below) = (layout.width.max(260.0), MARGIN + layout.height + 10.0);
    draw_signs(&mut canvas, (MARGIN, below), nodes, width);
    canvas.finish(width + 2.0 * MARGIN, below + signs_height(nodes, width) + 14.0)
}
