//! Trees: nodes in a flat array, in the order of the file.

use std::fmt;
use std::sync::Arc;

use diagnostics::{Problem, Source};

use crate::blackboard::Scopes;
use crate::library::{Library, Model};
use crate::program::Program;
use crate::{Node, NodeId, TreeError};

/// A behavior tree, checked and ready to run: the main tree of a file with its subtrees inserted.
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
    /// The full contents of the files, for writing them back.
    pub(crate) library: Arc<Library>,
    /// The index of the main tree among the definitions.
    pub(crate) main: usize,
    pub(crate) concerns: Option<TreeError>,
}

impl Tree {
    /// The ID of the tree. If the only tree of a file has no ID, the file's name without its extension.
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
    /// If the id belongs to another, larger tree.
    #[must_use]
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// The children of a node, in order.
    ///
    /// # Panics
    /// If the id belongs to another, larger tree.
    pub fn children(&self, id: NodeId) -> impl Iterator<Item = &Node> {
        let end = self.node(id).subtree_end as usize;
        let first = self.nodes[..end].get(id.index() + 1);
        std::iter::successors(first, move |child| self.nodes[..end].get(child.subtree_end as usize))
    }

    /// The leaves that the tree calls, in document order: conditions and actions. Several may have the same ID.
    pub fn leaves(&self) -> impl Iterator<Item = &Node> {
        self.nodes.iter().filter(|node| node.kind.is_leaf())
    }

    /// The leaves that only Nav2's model declares: no file does, and neither does the [`Loader`](crate::Loader).
    pub fn leaves_of_nav2(&self) -> impl Iterator<Item = &Node> {
        self.leaves().filter(|leaf| self.library.model(&leaf.type_id).is_some_and(Model::is_of_nav2))
    }

    /// Whether a node of the tree, or a script, names this entry of the main tree. Nav2's nodes name `robot_pose` and
    /// `robot_speed`.
    #[must_use]
    pub fn names_entry(&self, key: &str) -> bool {
        self.program.scopes.find(Scopes::ROOT, key).is_some()
    }

    /// The whole main file from which the tree was loaded.
    #[must_use]
    pub fn source(&self) -> &Source {
        &self.sources[0]
    }

    /// All files from which the tree was loaded: the main file, and those that it includes.
    #[must_use]
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// The warnings about the files, to be rendered; `None` if there are none.
    #[must_use]
    pub fn concerns(&self) -> Option<&TreeError> {
        self.concerns.as_ref()
    }

    /// A problem of a node that depends on its environment (such as a leaf without a skill), with its location.
    /// [`error`](Self::error) combines several into a diagnostic.
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

    /// The diagnostic of these problems, with their files.
    #[must_use]
    pub fn error(&self, problems: &[Problem]) -> TreeError {
        let of = |source| problems.iter().filter(move |problem| problem.is_of(source)).cloned().collect();
        let mut errors = self.sources.iter().map(|source| TreeError::new(source.clone(), of(source)));
        let main = errors.next().expect("there is a main file");
        main.with_included(errors.filter(|error| !error.problems().is_empty()).collect())
    }
}

/// Two trees are equal if they have equal nodes in the same positions; the files may differ.
impl PartialEq for Tree {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.nodes == other.nodes && self.program == other.program
    }
}

impl Eq for Tree {}

/// The tree as an indented outline, one node per line: leaves with the names of their processes, followed by their IDs
/// in parentheses if they differ.
impl fmt::Display for Tree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.nodes.iter().try_for_each(|node| writeln!(f, "{}", node.outline()))
    }
}
