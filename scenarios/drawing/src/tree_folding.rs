//! The part of a large tree that is drawn: what is going on stays open, everything else is folded.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use super::frame::{NodeStatus, TreeNode};
use super::tree_layout::Family;

/// The part of a tree that is drawn. A folded node stands for everything below it, and a row of dots for neighbors that
/// are left out; both have the number of these nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct FoldedTree {
    /// What is drawn, parents before their children.
    pub nodes: Vec<TreeNode>,
    /// The index of each of them in the whole tree: for a row of dots, that of the parent.
    pub numbers: Vec<usize>,
}

impl FoldedTree {
    /// A tree with nothing folded.
    #[must_use]
    pub fn whole(tree: &[TreeNode]) -> Self {
        Self { nodes: tree.to_vec(), numbers: (0..tree.len()).collect() }
    }

    /// A tree in at most `rows` rows, if the way to what is running, or to why the tree has failed, needs no more. Of
    /// the `opened` nodes, by their index, all children are shown in any case.
    ///
    /// ```
    /// use std::collections::BTreeSet;
    /// use drawing::{FoldedTree, NodeStatus, TreeNode};
    ///
    /// let node = |parent, label: &str, status| TreeNode { parent, label: label.to_owned(), status };
    /// let mut tree = vec![node(None, "→", NodeStatus::Running)];
    /// for room in 0..100 {
    ///     let status = if room == 70 { NodeStatus::Running } else { NodeStatus::NotTicked };
    ///     tree.push(node(Some(0), &format!("Clean{room}"), status));
    /// }
    /// let folded = FoldedTree::new(&tree, 5, &BTreeSet::new());
    /// let labels: Vec<&str> = folded.nodes.iter().map(|node| node.label.as_str()).collect();
    /// assert_eq!(labels, ["→", "Clean0", "Clean1", "… 68 nodes", "Clean70", "… 29 nodes"]);
    /// ```
    #[must_use]
    pub fn new(tree: &[TreeNode], rows: usize, opened: &BTreeSet<usize>) -> Self {
        let folded = Self::around(tree, rows, opened);
        let excess = folded.rows().saturating_sub(rows);
        // The way to what is active needs rows that others have taken. An opened node does not fold the rest.
        if excess == 0 || !opened.is_empty() { folded } else { Self::around(tree, rows.saturating_sub(excess), opened) }
    }

    /// How many rows it takes.
    fn rows(&self) -> usize {
        Family::of(&self.nodes).children.iter().filter(|children| children.is_empty()).count()
    }

    /// The same, but without room for what must be opened although all rows are taken.
    fn around(tree: &[TreeNode], rows: usize, opened: &BTreeSet<usize>) -> Self {
        let tree = Tree::of(tree, opened);
        let mut shown: Vec<Option<BTreeSet<usize>>> = vec![None; tree.nodes.len()];
        let mut free = rows.saturating_sub(tree.roots.len());
        // Nodes are opened one after another, the most interesting first: so what is active gets the room, and of the
        // rest what is near the root.
        let entry = |node: usize| (Reverse(tree.interest[node]), tree.depths[node], node);
        let mut closed: BTreeSet<_> = tree.roots.iter().map(|&root| entry(root)).collect();
        while let Some((Reverse(interest), _, node)) = closed.pop_first() {
            // The first child takes the row of its parent.
            let (children, room) = (&tree.children[node], free + 1);
            let fits = children.len() <= room || opened.contains(&node);
            if children.is_empty() || (!fits && interest < tree.least) {
                continue;
            }
            let some = if fits { children.iter().copied().collect() } else { tree.most_interesting(children, room) };
            free = room.saturating_sub(runs(children, &some));
            closed.extend(some.iter().map(|&child| entry(child)));
            shown[node] = Some(some);
        }
        tree.drawn(&shown)
    }

    fn push(&mut self, node: TreeNode, number: usize) {
        self.nodes.push(node);
        self.numbers.push(number);
    }
}

/// How important it is to show what is below a node.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Interest {
    Idle,
    Done,
    Failed,
    Running,
    Opened,
}

impl Interest {
    fn of(status: NodeStatus) -> Self {
        match status {
            NodeStatus::NotTicked => Self::Idle,
            NodeStatus::Success => Self::Done,
            NodeStatus::Failure => Self::Failed,
            NodeStatus::Running => Self::Running,
        }
    }
}

/// A whole tree, and what decides about folding it.
struct Tree<'t> {
    nodes: &'t [TreeNode],
    roots: Vec<usize>,
    parents: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
    depths: Vec<usize>,
    /// The number of nodes of each subtree, its root included.
    sizes: Vec<usize>,
    interest: Vec<Interest>,
    /// The least interest for which there are more rows than wanted: the way to what is running; in a tree that has
    /// failed, to why. While it is running, what failed before has been dealt with.
    least: Interest,
}

impl<'t> Tree<'t> {
    fn of(nodes: &'t [TreeNode], opened: &BTreeSet<usize>) -> Self {
        let Family { parents, children, depths } = Family::of(nodes);
        let mut sizes = vec![1; nodes.len()];
        let mut interest: Vec<Interest> = nodes.iter().map(|node| Interest::of(node.status)).collect();
        for i in (0..nodes.len()).rev() {
            if opened.contains(&i) {
                interest[i] = Interest::Opened;
            }
            if let Some(parent) = parents[i] {
                sizes[parent] += sizes[i];
                // An opened node must not be hidden in a folded one.
                if interest[i] == Interest::Opened {
                    interest[parent] = Interest::Opened;
                }
            }
        }
        let roots: Vec<usize> = (0..nodes.len()).filter(|&i| parents[i].is_none()).collect();
        let is_running = roots.iter().any(|&root| nodes[root].status == NodeStatus::Running);
        let least = if is_running { Interest::Running } else { Interest::Failed };
        Self { nodes, roots, parents, children, depths, sizes, interest, least }
    }

    /// The children to show where not all fit into this many rows: the most interesting ones, at least one, and all
    /// on the way to opened nodes.
    fn most_interesting(&self, children: &[usize], rows: usize) -> BTreeSet<usize> {
        let mut order = children.to_vec();
        order.sort_by_key(|&child| Reverse(self.interest[child]));
        let mut shown = BTreeSet::new();
        for child in order {
            shown.insert(child);
            let is_wanted = self.interest[child] == Interest::Opened || shown.len() == 1;
            if !is_wanted && runs(children, &shown) > rows {
                shown.remove(&child);
                break;
            }
        }
        // One that is left out alone takes no less room than it would itself.
        let is_known = |at: Option<usize>| at.and_then(|at| children.get(at)).is_none_or(|child| shown.contains(child));
        let alone = |&at: &usize| !is_known(Some(at)) && is_known(at.checked_sub(1)) && is_known(Some(at + 1));
        let alone: Vec<usize> = (0..children.len()).filter(alone).map(|at| children[at]).collect();
        shown.extend(alone);
        shown
    }

    /// What is drawn if open nodes show these children.
    fn drawn(&self, shown: &[Option<BTreeSet<usize>>]) -> FoldedTree {
        let mut folded = FoldedTree { nodes: Vec::new(), numbers: Vec::new() };
        let mut places: Vec<Option<usize>> = vec![None; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            let (mut label, mut status) = (node.label.clone(), node.status);
            let mut place = None;
            if let Some(parent) = self.parents[i] {
                place = places[parent];
                // Nothing is drawn below a folded node, or below one that is left out.
                let (Some(_), Some(shown)) = (place, &shown[parent]) else { continue };
                if !shown.contains(&i) {
                    let Some(left_out) = left_out_from(i, &self.children[parent], shown) else { continue };
                    let most = left_out.iter().max_by_key(|&&node| self.interest[node]);
                    label = in_words("", left_out.iter().map(|&node| self.sizes[node]).sum());
                    status = most.map_or(status, |&node| self.nodes[node].status);
                    folded.push(TreeNode { parent: place, label, status }, parent);
                    continue;
                }
            }
            if shown[i].is_none() && self.sizes[i] > 1 {
                label = in_words(&label, self.sizes[i] - 1);
            }
            places[i] = Some(folded.nodes.len());
            folded.push(TreeNode { parent: place, label, status }, i);
        }
        folded
    }
}

/// The rows of these children if only some are shown, the others as dots between them.
fn runs(children: &[usize], shown: &BTreeSet<usize>) -> usize {
    let is_new_run =
        |(at, child): (usize, &usize)| !shown.contains(child) && (at == 0 || shown.contains(&children[at - 1]));
    shown.len() + children.iter().enumerate().filter(|&row| is_new_run(row)).count()
}

/// The neighbors that are left out together, if `child` is the first of them.
fn left_out_from<'c>(child: usize, children: &'c [usize], shown: &BTreeSet<usize>) -> Option<&'c [usize]> {
    let at = children.binary_search(&child).ok()?;
    if at > 0 && !shown.contains(&children[at - 1]) {
        return None;
    }
    let after = &children[at..];
    Some(&after[..after.iter().position(|next| shown.contains(next)).unwrap_or(after.len())])
}

/// What stands for nodes that are not drawn, below this one or beside others.
fn in_words(label: &str, count: usize) -> String {
    let words = if count == 1 { "1 node".to_owned() } else { format!("{count} nodes") };
    format!("{label} … {words}").trim_start().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Chance, paper_tree};

    /// A tree of this many nodes with random parents and statuses.
    fn random(chance: &mut Chance, nodes: usize) -> Vec<TreeNode> {
        let statuses = [NodeStatus::NotTicked, NodeStatus::Success, NodeStatus::Failure, NodeStatus::Running];
        let node = |i: usize| TreeNode {
            parent: (i > 0).then(|| i - 1 - chance.below(i.min(1 + i / 2))),
            label: format!("n{i}"),
            status: statuses[chance.below(4)],
        };
        (0..nodes).map(node).collect()
    }

    fn rows(tree: &[TreeNode]) -> usize {
        let Family { children, .. } = Family::of(tree);
        children.iter().filter(|children| children.is_empty()).count()
    }

    #[test]
    fn a_tree_that_fits_is_drawn_whole() {
        let tree = paper_tree();
        let folded = FoldedTree::new(&tree, rows(&tree), &BTreeSet::new());
        assert_eq!(folded.nodes, tree);
        assert_eq!(folded.numbers, Vec::from_iter(0..tree.len()));
        assert_eq!(FoldedTree::new(&[], 0, &BTreeSet::new()).nodes, []);
    }

    #[test]
    fn every_node_is_drawn_or_counted_once() {
        let mut chance = Chance::new(3);
        for case in 0..500 {
            let size = 1 + chance.below(200);
            let tree = random(&mut chance, size);
            let opened: BTreeSet<usize> = (0..chance.below(3)).map(|_| chance.below(tree.len())).collect();
            let folded = FoldedTree::new(&tree, chance.below(60), &opened);
            let counted = |node: &TreeNode| {
                node.label.rsplit_once("… ").map(|(before, words)| {
                    let count: usize = words.split(' ').next().unwrap().parse().unwrap();
                    count + usize::from(!before.is_empty())
                })
            };
            let all: usize = folded.nodes.iter().map(|node| counted(node).unwrap_or(1)).sum();
            assert_eq!(all, tree.len(), "{case}: {folded:?}");
            for (number, node) in tree.iter().enumerate() {
                let is_opened = |node: &usize| opened.contains(node);
                let is_shown = is_opened(&number) || node.parent.as_ref().is_some_and(is_opened);
                assert!(!is_shown || folded.numbers.contains(&number), "{case}: {number}");
            }
        }
    }

    #[test]
    fn there_are_no_more_rows_than_wanted_where_nothing_is_active() {
        let mut chance = Chance::new(4);
        for _ in 0..300 {
            let mut tree = random(&mut chance, 300);
            tree.iter_mut().for_each(|node| node.status = NodeStatus::NotTicked);
            let most = 1 + chance.below(50);
            assert!(rows(&FoldedTree::new(&tree, most, &BTreeSet::new()).nodes) <= most);
        }
    }

    #[test]
    fn what_failed_before_takes_no_more_rows_than_there_are_while_the_tree_is_running() {
        let node = |parent, status| TreeNode { parent, label: String::new(), status };
        let mut tree = vec![node(None, NodeStatus::Running)];
        for room in 0..40 {
            let status = if room == 30 { NodeStatus::Running } else { NodeStatus::Failure };
            let parent = tree.len();
            tree.push(node(Some(0), status));
            tree.extend((0..20).map(|step| node(Some(parent), if step == 7 { status } else { NodeStatus::Failure })));
        }
        let folded = FoldedTree::new(&tree, 16, &BTreeSet::new());
        assert!(rows(&folded.nodes) <= 16);
        assert!(folded.numbers.contains(&(30 * 21 + 2 + 7)));
    }

    #[test]
    fn the_way_to_what_is_running_is_open() {
        let mut tree = random(&mut Chance::new(5), 1000);
        tree.iter_mut().for_each(|node| node.status = NodeStatus::NotTicked);
        let mut running = Some(999);
        while let Some(node) = running {
            tree[node].status = NodeStatus::Running;
            running = tree[node].parent;
        }
        let folded = FoldedTree::new(&tree, 12, &BTreeSet::new());
        let active = |(node, &number): (&TreeNode, &usize)| {
            node.label == tree[number].label && node.status == NodeStatus::Running
        };
        let drawn = folded.nodes.iter().zip(&folded.numbers).filter(|&row| active(row)).count();
        assert_eq!(drawn, tree.iter().filter(|node| node.status == NodeStatus::Running).count());
    }
}
