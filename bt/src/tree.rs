//! Trees: nodes in a flat array, in the order in which they stand in the file.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use miette::{NamedSource, SourceSpan};

use crate::xml::Loader;
use crate::{Kind, Problem, TreeError};

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
    pub(crate) parent: Option<NodeId>,
    pub(crate) depth: usize,
    pub(crate) subtree_end: u32,
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

    /// BehaviorTree.CPP's ID: of a leaf, the name under which it is registered and which its process has; of a
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

    /// Where the node's start tag stands in the file, in bytes.
    #[must_use]
    pub fn span(&self) -> SourceSpan {
        self.span
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

/// What the engine needs of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Op {
    pub(crate) kind: Kind,
    pub(crate) parent: u32,
    /// The first node in document order that is not below this one: its next sibling, if it has one.
    pub(crate) end: u32,
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
#[derive(Clone, Debug)]
pub struct Tree {
    pub(crate) name: String,
    pub(crate) nodes: Vec<Node>,
    pub(crate) ops: Vec<Op>,
    pub(crate) source: NamedSource<Arc<str>>,
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

    /// The file that the tree was loaded from, whole.
    #[must_use]
    pub fn source(&self) -> &NamedSource<Arc<str>> {
        &self.source
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
        let span = self.node(node).span;
        Problem::Surroundings { message: message.into(), label: label.into(), span, help: Some(help.into()) }
    }

    /// The diagnostic of these problems, with the file that they are in.
    #[must_use]
    pub fn error(&self, problems: Vec<Problem>) -> TreeError {
        TreeError::new(self.source.clone(), problems)
    }
}

/// Nodes alike and in the same places; the files may differ.
impl PartialEq for Tree {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.nodes == other.nodes
    }
}

impl Eq for Tree {}

/// The tree as an indented outline with a node a line.
impl fmt::Display for Tree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for node in &self.nodes {
            write!(f, "{:indent$}", "", indent = 2 * node.depth)?;
            match (node.kind.symbol(), node.kind) {
                (Some(symbol), Kind::SubTree) => writeln!(f, "{symbol} {}", node.label())?,
                (Some(symbol), _) => match node.name() {
                    Some(name) => writeln!(f, "{symbol} {name}")?,
                    None => writeln!(f, "{symbol}")?,
                },
                (None, _) => writeln!(f, "{}", node.label())?,
            }
        }
        Ok(())
    }
}
