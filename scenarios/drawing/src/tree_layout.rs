//! The positions of the nodes of a behavior tree: the root on the left, the leaves in one column on the right, one per
//! row.

use super::frame::TreeNode;
use super::geometry::{Area, Spot};
use super::text::Font;

/// Height of a row if there is room, and the minimum for legible labels, in pixels.
const ROW: f64 = 36.0;
pub(super) const READABLE_ROW: f64 = 21.0;
/// Height of a row in which names may have two lines, in pixels.
pub(super) const WRAPPED_ROW: f64 = 33.0;
/// Height of a node, as a fraction of a row.
const NODE_HEIGHT: f64 = 0.82;
/// The longest label that is shown in full at all, in pixels.
const LONGEST_EVER: f64 = 700.0;
/// The longest label that is shown in full if not all have room, in pixels.
const LONGEST: f64 = 230.0;
/// The longest labels of inner nodes if room is scarce, in pixels; finally, only their signs are shown.
const LONGEST_INNER: [f64; 3] = [110.0, 70.0, 0.0];
/// A name that is cut to this many letters, with the ellipsis, is worse than none.
const MOST_STUMP: usize = 5;
/// With a gap narrower than this, in rows, links bend too sharply to be distinguished.
const LEAST_GAP: f64 = 0.55;

/// The positions of everything in a tree, in pixels from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeLayout {
    /// The nodes, in the order of the tree.
    pub nodes: Vec<PlacedNode>,
    /// The lines from parents to children.
    pub links: Vec<Link>,
    /// Extent to the right.
    pub width: f64,
    /// Extent downwards.
    pub height: f64,
    /// Height of a row.
    pub row_px: f64,
    /// Size of the font of labels in one line.
    pub font_px: f64,
}

/// A node with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedNode {
    /// Its box.
    pub area: Area,
    /// Its label in lines; if it has no room, as much of it as fits.
    pub lines: Vec<String>,
    /// Whether that is not all of it.
    pub is_cut: bool,
    /// Whether it has no children.
    pub leaf: bool,
}

/// A line from a parent to a child.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Index of the child in the tree.
    pub child: usize,
    /// Where it leaves the parent.
    pub from: Spot,
    /// Where it has reached the child's height.
    pub bend: Spot,
    /// Where it meets the child.
    pub to: Spot,
}

impl TreeLayout {
    /// Lays out a tree in at most `width` × `height` pixels.
    #[must_use]
    pub fn new(tree: &[TreeNode], width: f64, height: f64) -> Self {
        let shape = Shape::of(tree);
        let row = (height / shape.rows.max(1) as f64).min(ROW);
        let font = Font::regular((row * 0.6).min(15.0));
        let columns = Columns::fitting(tree, &shape, font, row, width);
        let nodes: Vec<PlacedNode> = (0..tree.len()).map(|i| columns.place(tree, &shape, i, row, font)).collect();
        let links = (0..tree.len()).filter_map(|i| columns.link(&shape, &nodes, i)).collect();
        let right = nodes.iter().map(|node| node.area.right()).fold(0.0, f64::max);
        Self { nodes, links, width: right, height: row * shape.rows as f64, row_px: row, font_px: font.size }
    }

    /// The height at which a tree is not squeezed, and the minimum at which it is still legible, in pixels.
    #[must_use]
    pub fn wanted_height(tree: &[TreeNode]) -> (f64, f64) {
        let rows = Shape::of(tree).rows as f64;
        (rows * ROW, rows * READABLE_ROW)
    }
}

/// How the nodes of a tree are related, by their indices.
pub struct Family {
    /// The parent of each node. Only parents that exist and come first count.
    pub parents: Vec<Option<usize>>,
    /// The children of each node, in order.
    pub children: Vec<Vec<usize>>,
    /// The number of ancestors of each node.
    pub depths: Vec<usize>,
}

impl Family {
    /// The nodes of this tree.
    #[must_use]
    pub fn of(tree: &[TreeNode]) -> Self {
        let parents: Vec<Option<usize>> =
            tree.iter().enumerate().map(|(i, node)| node.parent.filter(|&parent| parent < i)).collect();
        let mut depths: Vec<usize> = Vec::with_capacity(tree.len());
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); tree.len()];
        for (i, parent) in parents.iter().enumerate() {
            depths.push(parent.map_or(0, |parent| depths[parent] + 1));
            if let Some(parent) = parent {
                children[*parent].push(i);
            }
        }
        Self { parents, children, depths }
    }
}

/// The parent of each node, and its row and column.
struct Shape {
    parents: Vec<Option<usize>>,
    depths: Vec<usize>,
    leaf: Vec<bool>,
    /// The middle of each node, in rows from the top.
    middles: Vec<f64>,
    rows: usize,
}

impl Shape {
    fn of(tree: &[TreeNode]) -> Self {
        let Family { parents, children, depths } = Family::of(tree);
        // Leaves first, one per row; then, children before parents, every inner node beside the middle of its children.
        // Subtrees never share a row, so links cannot cross.
        let mut middles = vec![0.0; tree.len()];
        let rows = Self::number_leaves(&parents, &children, &mut middles);
        for i in (0..tree.len()).rev() {
            if let (Some(&first), Some(&last)) = (children[i].first(), children[i].last()) {
                middles[i] = (middles[first] + middles[last]) / 2.0;
            }
        }
        let leaf = children.iter().map(Vec::is_empty).collect();
        Self { parents, depths, leaf, middles, rows }
    }

    /// Gives every leaf its own row, depth first, and returns the number of leaves.
    fn number_leaves(parents: &[Option<usize>], children: &[Vec<usize>], middles: &mut [f64]) -> usize {
        let mut stack: Vec<usize> = (0..parents.len()).rev().filter(|&i| parents[i].is_none()).collect();
        let mut rows = 0;
        while let Some(i) = stack.pop() {
            if children[i].is_empty() {
                middles[i] = rows as f64 + 0.5;
                rows += 1;
            }
            stack.extend(children[i].iter().rev());
        }
        rows
    }
}

/// Where columns begin, and how wide their nodes may be.
struct Columns {
    /// Left edge and width of each column of inner nodes.
    inner: Vec<(f64, f64)>,
    leaves: (f64, f64),
}

impl Columns {
    /// The widest columns and gaps that fit. First gaps shrink, then labels are wrapped, if rows are high enough. If
    /// that is not enough, long labels are shortened, then those of inner nodes, until these show only their signs;
    /// then those of leaves, then everything.
    fn fitting(tree: &[TreeNode], shape: &Shape, font: Font, row: f64, width: f64) -> Self {
        let depth = |i: usize| shape.depths[i];
        let count = (0..tree.len()).filter(|&i| !shape.leaf[i]).map(|i| depth(i) + 1).max().unwrap_or(0);
        let mut signs = vec![0.0_f64; count];
        let wanted = |is_wrapped: bool| {
            let (mut widths, mut leaves) = (vec![0.0_f64; count], 0.0_f64);
            for (i, node) in tree.iter().enumerate() {
                let column = if shape.leaf[i] { &mut leaves } else { &mut widths[depth(i)] };
                *column = column.max(node_width(&node.label, shape.leaf[i], font, row, is_wrapped).min(LONGEST_EVER));
            }
            (widths, leaves)
        };
        for (i, node) in tree.iter().enumerate().filter(|&(i, _)| !shape.leaf[i]) {
            signs[depth(i)] = signs[depth(i)].max(inner_width(sign(&node.label), font, row).min(LONGEST_INNER[1]));
        }
        let is_too_wide = |widths: &[f64], leaves: f64, gap: f64| {
            widths.iter().sum::<f64>() + leaves + gap * row * count as f64 > width
        };
        let (mut widths, mut leaves) = wanted(false);
        if row >= WRAPPED_ROW && is_too_wide(&widths, leaves, LEAST_GAP) {
            (widths, leaves) = wanted(true);
        }
        let is_cut = is_too_wide(&widths, leaves, LEAST_GAP);
        let limits = std::iter::once(LONGEST).chain(LONGEST_INNER).zip([2.0, 2.0, LEAST_GAP, LEAST_GAP]);
        for (longest, gap) in limits {
            if is_cut && is_too_wide(&widths, leaves, gap) {
                widths.iter_mut().zip(&signs).for_each(|(width, sign)| *width = width.min(longest.max(*sign)));
                leaves = leaves.min(LONGEST);
            }
        }
        let inner: f64 = widths.iter().sum();
        // With a gap wider than two rows, a tree falls apart. A picture that may be as wide as it needs to be has no
        // room to fill.
        let widest = if width.is_finite() { (row * 2.0).max(38.0) } else { row };
        let gap = ((width - inner - leaves) / count.max(1) as f64).clamp(row * LEAST_GAP, widest);
        let leaves = leaves.min((width - inner - gap * count as f64).max(width * 0.25));
        let squeeze = (width / (inner + leaves + gap * count as f64).max(1.0)).min(1.0);
        let mut x = 0.0;
        let inner = widths
            .into_iter()
            .map(|column| {
                let left = x;
                x += (column + gap) * squeeze;
                (left, column * squeeze)
            })
            .collect();
        Self { inner, leaves: (x, leaves * squeeze) }
    }

    fn place(&self, tree: &[TreeNode], shape: &Shape, i: usize, row: f64, font: Font) -> PlacedNode {
        let label = &tree[i].label;
        let leaf = shape.leaf[i];
        let (x, room) = if leaf { self.leaves } else { self.inner[shape.depths[i]] };
        let width = node_width(label, leaf, font, row, false).min(room);
        let height = row * NODE_HEIGHT;
        let padding = if leaf { leaf_padding(row) } else { inner_padding(row) };
        let (font, room) = (if leaf { font } else { symbol_font(font) }, width - padding + 0.01);
        let area = Area::new(x, shape.middles[i] * row - height / 2.0, width, height);
        if font.width(label) > room
            && row >= WRAPPED_ROW
            && let Some(lines) = lines_font(row).halved(label, room)
        {
            return PlacedNode { area, lines: lines.into(), is_cut: false, leaf };
        }
        let fitted = font.fit_ends(label, room);
        // A sign alone is better than a sign with two letters of a name.
        let is_stump = !leaf && fitted != *label && fitted.chars().count() < MOST_STUMP + sign(label).chars().count();
        let line = if is_stump { font.fit_ends(sign(label), room) } else { fitted };
        PlacedNode { area, is_cut: line != *label, lines: vec![line], leaf }
    }

    fn link(&self, shape: &Shape, nodes: &[PlacedNode], child: usize) -> Option<Link> {
        let parent = shape.parents[child]?;
        let from = (nodes[parent].area.right(), nodes[parent].area.center().1);
        let to = (nodes[child].area.x, nodes[child].area.center().1);
        let next = self.inner.get(shape.depths[parent] + 1).map_or(self.leaves.0, |column| column.0);
        Some(Link { child, from, bend: (next.min(to.0), to.1), to })
    }
}

/// The sign at the beginning of the label of an inner node.
fn sign(label: &str) -> &str {
    label.split(' ').next().unwrap_or_default()
}

/// Room in a leaf for its round ends and its sign.
pub(super) fn leaf_padding(row: f64) -> f64 {
    row * 1.15
}

/// Room in an inner node beside its label.
fn inner_padding(row: f64) -> f64 {
    row * 0.55
}

/// The font of names in two lines.
pub(super) fn lines_font(row: f64) -> Font {
    Font::regular(row * NODE_HEIGHT / 2.0 / Font::regular(1.0).line_height())
}

/// The font of texts in inner nodes: mostly a single sign.
pub(super) fn symbol_font(font: Font) -> Font {
    font.scaled(1.12)
}

/// The width of a node that shows its whole label: in one line, or where it is long and may be wrapped, in two.
fn node_width(label: &str, leaf: bool, font: Font, row: f64, is_wrapped: bool) -> f64 {
    let whole = if leaf { font.width(label) + leaf_padding(row) } else { inner_width(label, font, row) };
    let lines_font = lines_font(row);
    let is_long = whole > LONGEST_INNER[1];
    match lines_font.halved(label, LONGEST_EVER).filter(|_| is_wrapped && is_long) {
        Some(lines) => {
            let padding = if leaf { leaf_padding(row) } else { inner_padding(row) };
            let longest = lines.iter().map(|line| lines_font.width(line)).fold(0.0, f64::max);
            whole.min(longest + padding)
        }
        None => whole,
    }
}

fn inner_width(label: &str, font: Font, row: f64) -> f64 {
    (symbol_font(font).width(label) + inner_padding(row)).max(row * 0.9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Chance, large_tree, paper_tree};

    fn check(tree: &[TreeNode], width: f64, height: f64) {
        let layout = TreeLayout::new(tree, width, height);
        let page = Area::new(0.0, 0.0, width, height);
        assert_eq!(layout.nodes.len(), tree.len());
        for (i, node) in layout.nodes.iter().enumerate() {
            assert!(page.encloses(&node.area), "{node:?} leaves {width} × {height}");
            let font = if node.lines.len() > 1 { lines_font(layout.row_px) } else { Font::regular(layout.font_px) };
            assert!(node.lines.iter().all(|line| font.width(line) <= node.area.width), "{node:?}");
            for other in &layout.nodes[..i] {
                assert!(!node.area.overlaps(&other.area), "{node:?} overlaps {other:?}");
            }
        }
        for link in &layout.links {
            assert!(link.from.0 <= link.bend.0 && link.bend.0 <= link.to.0, "{link:?}");
            for (i, node) in layout.nodes.iter().enumerate().filter(|&(i, _)| i != link.child) {
                let (y, inside) = (link.to.1, node.area.inset(0.01));
                let crossed =
                    inside.y < y && y < inside.bottom() && inside.x < link.to.0 && link.bend.0 < inside.right();
                assert!(!crossed, "the link to {} runs through {i}: {link:?}, {node:?}", link.child);
            }
        }
    }

    #[test]
    fn the_tree_of_the_paper_keeps_its_labels() {
        check(&paper_tree(), 570.0, 252.0);
        let layout = TreeLayout::new(&paper_tree(), 570.0, 252.0);
        assert!(layout.nodes.iter().zip(paper_tree()).all(|(placed, node)| placed.lines == [node.label]));
        assert_eq!(layout.links.len(), 12);
    }

    #[test]
    fn where_names_have_no_room_signs_remain() {
        let chain = |i: usize| TreeNode {
            parent: i.checked_sub(1),
            label: if i < 12 { format!("▸ Subtree{i}OfManyTrees") } else { "GoToTheChargingStation".to_owned() },
            status: Default::default(),
        };
        let tree: Vec<TreeNode> = (0..13).map(chain).collect();
        let labels = |width| {
            let layout = TreeLayout::new(&tree, width, 300.0);
            layout.nodes.into_iter().map(|node| node.lines.concat()).collect::<Vec<_>>()
        };
        assert_eq!(labels(f64::INFINITY), tree.iter().map(|node| node.label.clone()).collect::<Vec<_>>());
        let narrow = labels(830.0);
        assert!(narrow[..12].iter().all(|label| label == "▸"), "{narrow:?}");
        assert_eq!(narrow[12], "GoToTheChargingStation", "in two lines");
    }

    #[test]
    fn trees_of_all_sizes_fit() {
        check(&[], 500.0, 200.0);
        check(&paper_tree()[..1], 500.0, 200.0);
        check(&large_tree(), 500.0, 300.0);
        check(&large_tree(), 200.0, 100.0);
    }

    #[test]
    fn nodes_of_random_trees_do_not_overlap() {
        let mut chance = Chance::new(7);
        for _ in 0..300 {
            let nodes = (0..1 + chance.below(40)).map(|i| TreeNode {
                parent: (i > 0).then(|| chance.below(i + 1)),
                label: "Name".repeat(chance.below(9)),
                status: Default::default(),
            });
            check(&nodes.collect::<Vec<_>>(), 200.0 + chance.below(500) as f64, 60.0 + chance.below(400) as f64);
        }
    }
}
