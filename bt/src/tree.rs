//! Trees: nodes in a flat array, in the order in which they stand in the file.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use diagnostics::{Problem, Source};
use miette::SourceSpan;

use crate::program::Program;
use crate::xml::{Library, Loader};
use crate::{Kind, TreeError};

/// A node of a tree: its place in document order (depth first, the root is 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    /// The root of every tree.
    pub const ROOT: Self = Self(0);

    /// Position in document order.
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

/// What a node is and where it stands.
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
    /// Of a leaf; empty for the others.
    pub(crate) process: String,
}

impl Node {
    /// The node's own number.
    #[must_use]
    pub fn id(&self) -> NodeId {
        self.number
    }

    /// What kind of node it is.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// BehaviorTree.CPP's ID: of a leaf, the name under which it is registered, which says what it does; of a
    /// [`Kind::SubTree`], the tree that it stands for; of all others, the kind's name. Several nodes may have the same.
    #[must_use]
    pub fn type_id(&self) -> &str {
        &self.type_id
    }

    /// The `name` that the file gives this one node, if it does.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.attribute("name")
    }

    /// What people read: the name, else the ID.
    #[must_use]
    pub fn label(&self) -> &str {
        self.name().filter(|name| !name.is_empty()).unwrap_or(&self.type_id)
    }

    /// The name of the process that carries a leaf out, which is no other leaf's: the leaf's [label](Self::label). Where
    /// several leaves have the same label, the first in document order is called so, and the others get a number behind
    /// it: `GoTo`, `GoTo_2`, `GoTo_3`; a number that makes the label of some other leaf is left out. Of nodes that are no
    /// leaves, the label.
    #[must_use]
    pub fn process(&self) -> &str {
        if self.process.is_empty() { self.label() } else { &self.process }
    }

    /// All attributes in the order of the file, with those that mean nothing here.
    #[must_use]
    pub fn attributes(&self) -> &[(String, String)] {
        &self.attributes
    }

    /// The value of an attribute.
    #[must_use]
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// Where the node's start tag stands in its file, in bytes.
    #[must_use]
    pub fn span(&self) -> SourceSpan {
        self.span
    }

    /// Which file that is: 0 is the main file, and those that it includes come after it.
    #[must_use]
    pub fn file(&self) -> usize {
        self.file
    }

    /// The node above; none for the root.
    #[must_use]
    pub fn parent(&self) -> Option<NodeId> {
        self.parent
    }

    /// How many nodes are above.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }
}

/// Gives every leaf the name of its process.
pub(crate) fn name_processes(nodes: &mut [Node]) {
    let leaves = || nodes.iter().filter(|node| node.kind.is_leaf());
    let labels: BTreeSet<&str> = leaves().map(Node::label).collect();
    let mut last: BTreeMap<&str, usize> = BTreeMap::new();
    let name = |leaf| {
        let label = Node::label(leaf);
        let number = last.entry(label).and_modify(|number| *number += 1).or_insert(1);
        while *number > 1 && labels.contains(format!("{label}_{number}").as_str()) {
            *number += 1;
        }
        if *number == 1 { label.to_owned() } else { format!("{label}_{number}") }
    };
    let names: Vec<String> = leaves().map(name).collect();
    for (leaf, name) in nodes.iter_mut().filter(|node| node.kind.is_leaf()).zip(names) {
        leaf.process = name;
    }
}

/// A behavior tree, checked and ready to run: the main tree of a file with its subtrees in their places.
///
/// ```
/// let tree = bt::Tree::from_xml("door.xml", r#"
///     <root BTCPP_format="4">
///         <BehaviorTree ID="Door">
///             <Fallback name="open the door">
///                 <Condition ID="IsOpen"/>
///                 <Action ID="Push"/>
///             </Fallback>
///         </BehaviorTree>
///     </root>"#)?;
/// assert_eq!(tree.to_string(), "?* open the door\n  IsOpen\n  Push\n");
/// # Ok::<(), bt::TreeError>(())
/// ```
#[derive(Debug)]
pub struct Tree {
    pub(crate) name: String,
    pub(crate) nodes: Vec<Node>,
    pub(crate) program: Program,
    /// The main file, and those that it includes.
    pub(crate) sources: Vec<Source>,
    /// All that the files say, to be written back.
    pub(crate) library: Arc<Library>,
    /// The place of the main tree among the definitions.
    pub(crate) main: usize,
    pub(crate) concerns: Option<TreeError>,
}

impl Tree {
    /// Loads the main tree of a file in BehaviorTree.CPP's XML, format 3 or 4. See [`Loader`] for choices.
    ///
    /// # Errors
    /// A [`TreeError`] with everything that is wrong with the file, each with its place.
    pub fn from_xml(file: impl AsRef<Path>, text: &str) -> Result<Self, TreeError> {
        Loader::default().load(file, text)
    }

    /// The ID of the tree; the file's name without its ending where the only tree of a file has no ID.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All nodes in document order.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// A node.
    ///
    /// # Panics
    /// If the number is of another, larger tree.
    #[must_use]
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// The children of a node in their order.
    ///
    /// # Panics
    /// If the number is of another, larger tree.
    pub fn children(&self, id: NodeId) -> impl Iterator<Item = &Node> {
        let end = self.node(id).subtree_end as usize;
        let first = self.nodes[..end].get(id.index() + 1);
        std::iter::successors(first, move |child| self.nodes[..end].get(child.subtree_end as usize))
    }

    /// The leaves that the tree calls, in document order: conditions and actions, several of them perhaps of one ID.
    pub fn leaves(&self) -> impl Iterator<Item = &Node> {
        self.nodes.iter().filter(|node| node.kind.is_leaf())
    }

    /// Opens a file and loads the main tree from it, with all files that it includes. See [`Loader`] for choices.
    ///
    /// # Errors
    /// A [`TreeError`] with everything that is wrong with the files, each with its place; also if the file itself cannot
    /// be read.
    pub fn from_file(file: impl AsRef<Path>) -> Result<Self, TreeError> {
        Loader::default().load_file(file)
    }

    /// The main file that the tree was loaded from, whole.
    #[must_use]
    pub fn source(&self) -> &Source {
        &self.sources[0]
    }

    /// All files that the tree was loaded from: the main file, and those that it includes.
    #[must_use]
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// What looks odd in the files without making them unusable, to be rendered; none if there is nothing.
    #[must_use]
    pub fn concerns(&self) -> Option<&TreeError> {
        self.concerns.as_ref()
    }

    /// A problem with a node that only the surroundings know of (there is no skill for a leaf), with its place.
    /// [`error`](Self::error) makes a diagnostic of several.
    #[must_use]
    pub fn problem_at(
        &self,
        node: NodeId,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Problem {
        let &Node { span, file, .. } = self.node(node);
        Problem::new(message).of(&self.sources[file]).at(span, label).with_help(help)
    }

    /// The diagnostic of these problems, with the files that they are in.
    #[must_use]
    pub fn error(&self, problems: &[Problem]) -> TreeError {
        let of = |source| problems.iter().filter(move |problem| problem.is_of(source)).cloned().collect();
        let mut errors = self.sources.iter().map(|source| TreeError::new(source.clone(), of(source)));
        let main = errors.next().expect("the main file is there");
        main.with_included(errors.filter(|error| !error.problems().is_empty()).collect())
    }
}

/// Nodes alike and in the same places; the files may differ.
impl PartialEq for Tree {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.nodes == other.nodes && self.program == other.program
    }
}

impl Eq for Tree {}

/// The tree as an indented outline, one node per line: leaves by the names of their processes, and in parentheses their
/// IDs where those differ.
impl fmt::Display for Tree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.nodes.iter().try_for_each(|node| writeln!(f, "{}", node.outline()))
    }
}

impl Node {
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

/// A text as it can stand on a line: control characters are escaped, `\n`.
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
