//! Nodes of a tree, and the processes of its leaves.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use miette::SourceSpan;

use crate::Kind;

/// A node of a tree, as an index in document order (depth first, the root is 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    /// The root of every tree.
    pub const ROOT: Self = Self(0);

    /// Index in document order.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A node's kind and its place in the tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    pub(crate) number: NodeId,
    pub(crate) kind: Kind,
    pub(crate) type_id: String,
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) span: SourceSpan,
    pub(crate) file: usize,
    pub(crate) parent: Option<NodeId>,
    pub(crate) depth: usize,
    pub(crate) subtree_end: u32,
    /// Only for leaves whose label a leaf before them has; empty for other nodes.
    pub(crate) process: String,
}

impl Node {
    /// The node's own number.
    #[must_use]
    pub fn id(&self) -> NodeId {
        self.number
    }

    /// The node's kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// BehaviorTree.CPP's ID. For a leaf, the name under which it is registered, which determines what it does. For a
    /// [`Kind::SubTree`], the ID of its tree. For others, the name of the kind. Several nodes may have the same ID.
    #[must_use]
    pub fn type_id(&self) -> &str {
        &self.type_id
    }

    /// The `name` that the file gives this node, if any.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.attribute("name")
    }

    /// The label for people: the name, or else the ID.
    #[must_use]
    pub fn label(&self) -> &str {
        self.name().filter(|name| !name.is_empty()).unwrap_or(&self.type_id)
    }

    /// The unique name of the process that executes a leaf: the leaf's [label](Self::label). If several leaves have the
    /// same label, the first in document order has this name, and the others get a number: `GoTo`, `GoTo_2`, `GoTo_3`.
    /// Numbers that would give the label of another leaf are skipped. For nodes that are not leaves, the label.
    #[must_use]
    pub fn process(&self) -> &str {
        if self.process.is_empty() { self.label() } else { &self.process }
    }

    /// All attributes in the order of the file, including those that have no meaning here.
    #[must_use]
    pub fn attributes(&self) -> &[(String, String)] {
        &self.attributes
    }

    /// The value of an attribute.
    #[must_use]
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// The position of the node's start tag in its file, in bytes.
    #[must_use]
    pub fn span(&self) -> SourceSpan {
        self.span
    }

    /// The index of this file: 0 is the main file, followed by the files that it includes.
    #[must_use]
    pub fn file(&self) -> usize {
        self.file
    }

    /// The parent; none for the root.
    #[must_use]
    pub fn parent(&self) -> Option<NodeId> {
        self.parent
    }

    /// The node's line in the tree's outline.
    pub(crate) fn outline(&self) -> String {
        let text = match (self.kind.symbol(), self.kind) {
            (Some(symbol), Kind::SubTree) => format!("{symbol} {}", self.label()),
            (None, Kind::Condition | Kind::Action) if self.process() == self.type_id => self.type_id.clone(),
            (None, Kind::Condition | Kind::Action) => format!("{} ({})", self.process(), self.type_id),
            (symbol, kind) => {
                let symbol = symbol.unwrap_or_else(|| kind.name());
                self.name().map_or(symbol.to_owned(), |name| format!("{symbol} {name}"))
            }
        };
        " ".repeat(2 * self.depth) + &one_line(&text)
    }
}

/// Gives every leaf the name of its process.
pub(crate) fn name_processes(nodes: &mut [Node]) {
    let labels: Vec<&str> = nodes.iter().filter(|node| node.kind.is_leaf()).map(Node::label).collect();
    let names = process_names(&labels);
    for (leaf, name) in nodes.iter_mut().filter(|node| node.kind.is_leaf()).zip(names) {
        leaf.process = if name == leaf.label() { String::new() } else { name };
    }
}

/// The names of the processes of nodes with these labels, as [`Node::process`] has them: each is different.
#[must_use]
pub fn process_names<'l>(labels: &[&'l str]) -> Vec<String> {
    let all: BTreeSet<&str> = labels.iter().copied().collect();
    let mut last: BTreeMap<&'l str, usize> = BTreeMap::new();
    let name = |&label: &&'l str| {
        let number = last.entry(label).and_modify(|number| *number += 1).or_insert(1);
        while *number > 1 && all.contains(format!("{label}_{number}").as_str()) {
            *number += 1;
        }
        if *number == 1 { label.to_owned() } else { format!("{label}_{number}") }
    };
    labels.iter().map(name).collect()
}

/// A string that fits on one line: control characters are escaped, such as `\n`.
#[must_use]
pub fn one_line(text: &str) -> Cow<'_, str> {
    if !text.contains(char::is_control) {
        return Cow::Borrowed(text);
    }
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { line.extend(c.escape_default()) } else { line.push(c) }
    }
    Cow::Owned(line)
}
