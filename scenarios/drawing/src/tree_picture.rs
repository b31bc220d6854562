//! A behavior tree as a separate picture.

use super::canvas::Canvas;
use super::frame::TreeNode;
use super::tree_layout::TreeLayout;
use super::tree_panel::{draw_nodes, draw_signs, signs_height};

/// The maximum width of a tree before its labels are shortened, and the margin around it, in pixels.
const WIDEST: f64 = 1600.0;
const MARGIN: f64 = 24.0;

/// The tree as a standalone SVG picture, as large as necessary.
///
/// ```
/// use drawing::{NodeStatus, TreeNode, tree_svg};
///
/// let node = |parent, label: &str, status| TreeNode { parent, label: label.to_owned(), status };
/// let tree = [
///     node(None, "→", NodeStatus::Running),
///     node(Some(0), "BatteryLevel", NodeStatus::Success),
///     node(Some(0), "GotoGoal", NodeStatus::Running),
/// ];
/// assert!(tree_svg(&tree).contains(">GotoGoal<"));
/// ```
#[must_use]
pub fn tree_svg(tree: &[TreeNode]) -> String {
    let (height, _) = TreeLayout::wanted_height(tree);
    let layout = TreeLayout::new(tree, WIDEST, height);
    let mut canvas = Canvas::for_browsers();
    draw_nodes(&mut canvas, &layout, tree, (MARGIN, MARGIN));
    let (width, below) = (layout.width.max(260.0), MARGIN + layout.height + 10.0);
    draw_signs(&mut canvas, (MARGIN, below), tree, width);
    canvas.finish(width + 2.0 * MARGIN, below + signs_height(tree, width) + 14.0)
}
