//! The behavior tree with the status of each node.

use std::collections::BTreeSet;

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::frame::{NodeStatus, TreeNode};
use super::geometry::{Area, Spot};
use super::icons::Look;
use super::panel;
use super::path::Path;
use super::text::Font;
use super::theme;
use super::tree_folding::FoldedTree;
use super::tree_layout::{Link, PlacedNode, READABLE_ROW, TreeLayout, WRAPPED_ROW, lines_font, symbol_font};

/// Height of a line that explains signs, in pixels.
const SIGNS: f64 = 20.0;
const SMALL: Font = Font::regular(13.0);

const FONT: Font = Font::regular(14.0);

/// Draws the tree's panel. Of a tree that has no room there, the part that is going on. `knows_ticks` is whether it
/// is known when the tree was ticked.
pub(super) fn draw(canvas: &mut Canvas, area: Area, tree: &[TreeNode], knows_ticks: bool) {
    let inner = panel::titled(canvas, area, "Behavior tree");
    legend(canvas, area, if knows_ticks { Look::of_status(NodeStatus::NotTicked).words } else { "halted or unknown" });
    let (folded, layout, below) = fitted(tree, inner);
    let tree = &folded.nodes;
    let room = Area { height: (inner.height - below).max(0.0), ..inner };
    let (dx, dy) = (room.x, room.y + (room.height - layout.height).max(0.0) / 2.0);
    draw_nodes(canvas, &layout, &folded, (dx, dy));
    draw_signs(canvas, (room.x, inner.bottom() - below + 4.0), tree, room.width);
}

/// As much of a tree as is legible there, and the height of the signs below it. Where names have no room, fewer rows
/// are high enough for two lines.
fn fitted(tree: &[TreeNode], area: Area) -> (FoldedTree, TreeLayout, f64) {
    let fitted = |row: f64| {
        let folded = FoldedTree::new(tree, ((area.height - SIGNS) / row) as usize, &BTreeSet::new());
        let below = signs_height(&folded.nodes, area.width);
        let layout = TreeLayout::new(&folded.nodes, area.width, (area.height - below).max(0.0));
        (folded, layout, below)
    };
    let cut = |layout: &TreeLayout| layout.nodes.iter().filter(|node| node.is_cut).count();
    let most = fitted(READABLE_ROW);
    if cut(&most.1) == 0 {
        return most;
    }
    // Names that have no room in two lines either are no reason to fold more.
    let wrapped = fitted(WRAPPED_ROW);
    if 2 * cut(&wrapped.1) <= cut(&most.1) { wrapped } else { most }
}

/// The signs of inner nodes, with their meaning.
pub const SYMBOLS: [(&str, &str); 13] = [
    ("→", "sequence"),
    ("→*", "sequence with memory"),
    ("→**", "sequence with full memory"),
    ("?", "fallback"),
    ("?*", "fallback with memory"),
    ("⇉", "parallel"),
    ("¬", "inverter"),
    ("+", "always success"),
    ("−", "always failure"),
    ("▸", "subtree"),
    ("↻", "retry until successful"),
    ("∞", "keep running until failure"),
    ("1×", "run once"),
];

/// The sign that pictures show instead of a decorator's long name.
#[must_use]
pub fn short_name(name: &str) -> &str {
    match name {
        "RetryUntilSuccessful" => "↻",
        "KeepRunningUntilFailure" => "∞",
        "RunOnce" => "1×",
        _ => name,
    }
}

/// The meaning of the signs in a tree, in lines of at most this many pixels.
fn signs(tree: &[TreeNode], room: f64) -> Vec<String> {
    let is_there = |sign: &str| tree.iter().any(|node| node.label.split(' ').next() == Some(sign));
    let known = SYMBOLS.iter().filter(|(sign, _)| is_there(sign));
    let words: Vec<String> = known.map(|(sign, words)| format!("{sign} {words}")).collect();
    SMALL.wrap_items(&words, "   ", room)
}

/// The height of the lines that explain the signs in a tree, in pixels.
#[must_use]
pub fn signs_height(tree: &[TreeNode], room: f64) -> f64 {
    SIGNS * signs(tree, room).len().max(1) as f64
}

/// Explains the signs in a tree, in lines below this spot.
pub fn draw_signs(canvas: &mut Canvas, (x, y): (f64, f64), tree: &[TreeNode], room: f64) {
    for (number, line) in signs(tree, room).iter().enumerate() {
        canvas.centered_text((x, y + (number as f64 + 0.5) * SIGNS), line, TextStyle::new(SMALL, theme::MUTED));
    }
}

/// Draws the nodes and their links, moved by this offset.
pub fn draw_nodes(canvas: &mut Canvas, layout: &TreeLayout, tree: &FoldedTree, (dx, dy): (f64, f64)) {
    for link in &layout.links {
        draw_link(canvas, link, (dx, dy), tree.nodes[link.child].status);
    }
    for ((placed, node), &number) in layout.nodes.iter().zip(&tree.nodes).zip(&tree.numbers) {
        canvas.part("node", number, |canvas| {
            let font = if placed.lines.len() > 1 { lines_font(layout.row_px) } else { Font::regular(layout.font_px) };
            draw_node(canvas, placed, placed.area.shifted(dx, dy), node.status, font);
            if placed.is_cut {
                canvas.title(&node.label);
            }
        });
    }
}

/// The meaning of the signs of statuses; `nothing` is that of a node without an answer.
fn legend(canvas: &mut Canvas, area: Area, nothing: &str) {
    const BOX: f64 = 17.0;
    const STATUSES: [NodeStatus; 4] =
        [NodeStatus::Success, NodeStatus::Failure, NodeStatus::Running, NodeStatus::NotTicked];
    let y = panel::title_y(area);
    let free = area.right() - panel::MARGIN - (area.x + panel::MARGIN + panel::TITLE.width("Behavior tree") + 12.0);
    let meaning = |status| if status == NodeStatus::NotTicked { nothing } else { Look::of_status(status).words };
    let words: f64 = STATUSES.iter().map(|&status| BOX + 6.0 + FONT.width(meaning(status))).sum();
    let gap = ((free - words) / STATUSES.len() as f64).clamp(4.0, 26.0);
    let mut x = area.right() - panel::MARGIN - words - gap * (STATUSES.len() - 1) as f64;
    for status in STATUSES {
        let look = Look::of_status(status);
        let sign = Area::around((x + BOX / 2.0, y), BOX, BOX);
        canvas.rounded(sign, 4.0, Paint::fill(look.ground).outlined(look.front, 1.4));
        look.icon.draw(canvas, sign.center(), 11.0, look.front);
        canvas.centered_text((x + BOX + 6.0, y), meaning(status), TextStyle::new(FONT, theme::MUTED));
        x += BOX + 6.0 + FONT.width(meaning(status)) + gap;
    }
}

/// Draws an S from the parent to the child's height, then a straight line. Links to ticked nodes stand out.
fn draw_link(canvas: &mut Canvas, link: &Link, (dx, dy): (f64, f64), status: NodeStatus) {
    let at = |(x, y): (f64, f64)| (x + dx, y + dy);
    let (from, bend, to) = (at(link.from), at(link.bend), at(link.to));
    let middle = ((from.0 + bend.0) / 2.0, (from.1 + bend.1) / 2.0);
    let quarter = (bend.0 - from.0) / 4.0;
    let path = Path::new()
        .move_to(from)
        .curve_to((from.0 + quarter, from.1), middle)
        .curve_to((bend.0 - quarter, bend.1), bend)
        .line_to(to);
    let paint = match status {
        NodeStatus::NotTicked => Paint::stroke(theme::IDLE, 1.3),
        _ => Paint::stroke(theme::MUTED, 1.8),
    };
    canvas.path(&path, paint);
}

fn draw_node(canvas: &mut Canvas, node: &PlacedNode, area: Area, status: NodeStatus, font: Font) {
    let look = Look::of_status(status);
    let ink = if status == NodeStatus::NotTicked { theme::MUTED } else { theme::INK };
    let paint = Paint::fill(look.ground).outlined(look.front, if status == NodeStatus::Running { 2.4 } else { 1.6 });
    if node.leaf {
        canvas.rounded(area, area.height / 2.0, paint);
        let sign = area.x + area.height * 0.52;
        look.icon.draw(canvas, (sign, area.center().1), font.size * 0.8, look.front);
        draw_lines(canvas, (sign + font.size * 0.75, area.center().1), &node.lines, TextStyle::new(font, ink));
        return;
    }
    canvas.rounded(area, area.height * 0.22, paint);
    let font = if node.lines.len() > 1 { font } else { symbol_font(font) };
    draw_lines(canvas, area.center(), &node.lines, TextStyle::new(font, ink).anchored(Anchor::Middle));
    let (badge, radius) = ((area.right() - 1.0, area.bottom() - 1.0), area.height * 0.22);
    canvas.circle(badge, radius, Paint::fill(look.front).outlined(theme::PAPER, radius * 0.2));
    look.icon.draw(canvas, badge, radius * 1.35, theme::PAPER);
}

/// Writes lines around this height.
fn draw_lines(canvas: &mut Canvas, (x, y): Spot, lines: &[String], style: TextStyle) {
    let middle = (lines.len() as f64 - 1.0) / 2.0;
    for (number, line) in lines.iter().enumerate() {
        canvas.centered_text((x, y + (number as f64 - middle) * style.font.line_height()), line, style);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three rooms of eight steps with long names.
    #[test]
    fn names_of_a_tree_of_25_leaves_are_not_cut() {
        let node = |parent, label: String| TreeNode { parent, label, status: NodeStatus::Success };
        let mut tree = vec![node(None, "→ CleanAllRooms".to_owned())];
        for room in 0..3 {
            let parent = tree.len();
            tree.push(node(Some(0), format!("? CleanTheRoom{room}AndReportBack")));
            tree.extend((0..8).map(|step| node(Some(parent), format!("NavigateToThePoseInRoom{room}AtStep{step}"))));
        }
        tree.push(node(Some(0), "ReturnToTheChargingStationAndWait".to_owned()));
        for (width, height) in [(580.0, 640.0), (516.0, 420.0), (516.0, 250.0)] {
            let (folded, layout, below) = fitted(&tree, Area::new(0.0, 0.0, width, height));
            assert!(layout.height <= height - below);
            for (placed, node) in layout.nodes.iter().zip(&folded.nodes) {
                assert!(!placed.is_cut, "{node:?} in {width} × {height}");
                assert_eq!(placed.lines.concat().replace(' ', ""), node.label.replace(' ', ""));
            }
        }
    }
}
