//! Trees: nodes in a flat array, in the order in which they stand in the file.

use std::fmt;
use std::sync::Arc;

use diagnostics::{Problem, Source};

use crate::program::Program;
use crate::xml::Library;
use crate::{Node, NodeId, TreeError};

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
