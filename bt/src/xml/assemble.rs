//! The main tree with its subtrees in their places.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use miette::{NamedSource, SourceSpan};

use super::scan::{Definition, Scanned};
use super::{Loader, Problems, hint};
use crate::tree::{Node, Op};
use crate::{Kind, NodeId, Problem, Tree};

/// The trees of a file by their IDs; of two with the same, the first.
pub(super) struct Index<'a>(BTreeMap<&'a str, usize>);

impl<'a> Index<'a> {
    pub(super) fn new(definitions: &'a [Definition]) -> Self {
        let ids = definitions.iter().enumerate().rev();
        Self(ids.filter_map(|(index, definition)| Some((definition.id.as_deref()?, index))).collect())
    }

    pub(super) fn find(&self, id: &str) -> Option<usize> {
        self.0.get(id).copied()
    }

    pub(super) fn ids(&self) -> impl Iterator<Item = &'a str> + Clone {
        self.0.keys().copied()
    }
}

/// Every subtree exists, and no tree contains itself.
pub(super) fn check_references(definitions: &[Definition], index: &Index<'_>, problems: &mut Problems) {
    let mut references: Vec<Vec<(usize, SourceSpan)>> = Vec::new();
    for definition in definitions {
        let mut found = Vec::new();
        for node in definition.nodes.iter().filter(|node| node.kind == Kind::SubTree) {
            let id = &node.type_id;
            match index.find(id) {
                Some(target) => found.push((target, node.span)),
                None => {
                    let help = hint(id, index.ids(), problems.len());
                    problems.push(Problem::NoSubTree { id: id.clone(), span: node.span, help });
                }
            }
        }
        references.push(found);
    }
    let done = vec![false; definitions.len()];
    let mut search = CycleSearch { definitions, references, problems, path: Vec::new(), done };
    for start in 0..definitions.len() {
        search.visit(start);
    }
}

/// A depth-first search for trees that contain themselves.
struct CycleSearch<'a> {
    definitions: &'a [Definition],
    /// By tree: the trees that it asks for, and where.
    references: Vec<Vec<(usize, SourceSpan)>>,
    problems: &'a mut Problems,
    /// The trees from the start of the search to where it is, with the number of references followed in each.
    path: Vec<(usize, usize)>,
    done: Vec<bool>,
}

impl CycleSearch<'_> {
    fn visit(&mut self, start: usize) {
        if !self.done[start] {
            self.path.push((start, 0));
        }
        while let Some((tree, followed)) = self.path.last_mut() {
            let tree = *tree;
            let Some(&(target, span)) = self.references[tree].get(*followed) else {
                self.done[tree] = true;
                self.path.pop();
                continue;
            };
            *followed += 1;
            if self.done[target] {
                continue;
            }
            match self.path.iter().position(|(above, _)| *above == target) {
                None => self.path.push((target, 0)),
                Some(first) => {
                    let circle = self.path[first..].iter().map(|(above, _)| *above).chain([target]);
                    let cycle = circle.filter_map(|tree| self.definitions[tree].id.clone()).collect();
                    self.problems.push(Problem::Recursion { cycle, span });
                }
            }
        }
    }
}

/// Puts the main tree together. All subtrees exist and none contains itself.
pub(super) fn assemble(
    loader: &Loader,
    source: &NamedSource<Arc<str>>,
    definitions: &[Definition],
    index: &Index<'_>,
    main: usize,
) -> Result<Tree, Problem> {
    let mut assembly = Assembly { loader, definitions, index, nodes: Vec::new() };
    assembly.place(main)?;
    let mut nodes = assembly.nodes;
    for index in (1..nodes.len()).rev() {
        let end = nodes[index].subtree_end;
        let parent = nodes[index].parent.expect("only the root has no parent");
        let parent_end = &mut nodes[parent.index()].subtree_end;
        *parent_end = end.max(*parent_end);
    }
    let op = |node: &Node| Op { kind: node.kind, parent: node.parent.map_or(0, |id| id.0), end: node.subtree_end };
    let file_stem = || Path::new(source.name()).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = definitions[main].id.clone().or_else(file_stem).unwrap_or_default();
    Ok(Tree { name, ops: nodes.iter().map(op).collect(), nodes, source: source.clone() })
}

struct Assembly<'a> {
    loader: &'a Loader,
    definitions: &'a [Definition],
    index: &'a Index<'a>,
    nodes: Vec<Node>,
}

/// A tree that is being placed: where its nodes have come to stand, and how many there are so far.
struct Placing {
    definition: usize,
    /// The node that stands for the tree, if it is a subtree.
    under: Option<NodeId>,
    places: Vec<NodeId>,
}

impl Assembly<'_> {
    /// Places a tree and, depth first, all its subtrees.
    fn place(&mut self, main: usize) -> Result<(), Problem> {
        let mut stack = vec![Placing { definition: main, under: None, places: Vec::new() }];
        while let Some(placing) = stack.last_mut() {
            let Some(scanned) = self.definitions[placing.definition].nodes.get(placing.places.len()) else {
                stack.pop();
                continue;
            };
            let parent = scanned.parent.map(|place| placing.places[place]).or(placing.under);
            let id = self.push(scanned, parent)?;
            placing.places.push(id);
            if scanned.kind == Kind::SubTree {
                let definition = self.index.find(&scanned.type_id).expect("all subtrees have been found before");
                stack.push(Placing { definition, under: Some(id), places: Vec::new() });
            }
        }
        Ok(())
    }

    fn push(&mut self, scanned: &Scanned, parent: Option<NodeId>) -> Result<NodeId, Problem> {
        let &Scanned { kind, span, .. } = scanned;
        let depth = parent.map_or(0, |parent| self.nodes[parent.index()].depth + 1);
        if depth >= self.loader.max_depth {
            return Err(Problem::TooDeep { limit: self.loader.max_depth, span });
        }
        let id = u32::try_from(self.nodes.len()).ok().filter(|_| self.nodes.len() < self.loader.max_nodes);
        let Some(id) = id else { return Err(Problem::TooLarge { limit: self.loader.max_nodes, span }) };
        let (type_id, attributes) = (scanned.type_id.clone(), scanned.attributes.clone());
        let subtree_end = id + 1;
        self.nodes.push(Node { number: NodeId(id), kind, type_id, attributes, span, parent, depth, subtree_end });
        Ok(NodeId(id))
    }
}
