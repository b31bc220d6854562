//! Choices for reading a tree.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::settings::Constants;

/// Reads tree files.
///
/// Both spellings of nodes are read: `<Action ID="GoTo"/>` and `<GoTo/>`, `<Control ID="Sequence">` and `<Sequence>`.
/// The short spelling of a leaf needs to be told what the leaf is: by the file's `<TreeNodesModel>`, or by
/// [`leaves`](Self::leaves). What means nothing here (a description, what Groot notes down) is kept. What
/// BehaviorTree.CPP 4 refuses when it loads a tree is refused: IDs with a space or another forbidden character, two subtrees
/// of one name in a tree, ports that no model declares, ports of two types that name one entry. In files of version 3, whose
/// models are notes of Groot's, a port that they do not declare is a warning, as is an attribute that is no script
/// ([`Tree::concerns`](crate::Tree::concerns)).
///
/// All trees of a file are checked, also those that the main tree does not use.
///
/// ```
/// use bt::Loader;
///
/// let text = r#"<root BTCPP_format="4"> <BehaviorTree ID="Greet">
///     <Sequence> <SomebodyThere/> <SayHello/> </Sequence>
/// </BehaviorTree> </root>"#;
/// let tree = Loader::default().leaves(["SomebodyThere", "SayHello"]).load("greet.xml", text)?;
/// assert_eq!(tree.to_string(), "→*\n  SomebodyThere\n  SayHello\n");
/// # Ok::<(), bt::TreeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Loader {
    pub(super) leaves: BTreeSet<String>,
    pub(super) constants: Arc<Constants>,
    pub(super) main_tree: Option<String>,
    pub(super) max_depth: usize,
    pub(super) max_nodes: usize,
}

impl Default for Loader {
    fn default() -> Self {
        let (leaves, constants) = (BTreeSet::new(), Arc::default());
        Self { leaves, constants, main_tree: None, max_depth: 256, max_nodes: 100_000 }
    }
}

impl Loader {
    /// Knows leaves of these IDs, so that `<ID/>` is an action where the file itself does not say what it is.
    #[must_use]
    pub fn leaves(mut self, ids: impl IntoIterator<Item: Into<String>>) -> Self {
        self.leaves.extend(ids.into_iter().map(Into::into));
        self
    }

    /// Knows these names for numbers in scripts and switches, as BehaviorTree.CPP knows the enumerators that a program
    /// registers.
    #[must_use]
    pub fn constants(mut self, constants: impl IntoIterator<Item = (impl Into<String>, i64)>) -> Self {
        let constants = constants.into_iter().map(|(name, number)| (name.into(), number));
        Arc::make_mut(&mut self.constants).extend(constants);
        self
    }

    /// Takes this tree for the main tree, whatever the file says.
    #[must_use]
    pub fn main_tree(mut self, id: impl Into<String>) -> Self {
        self.main_tree = Some(id.into());
        self
    }

    /// Refuses trees that are deeper than this, subtrees included. 256 if not set, as in BehaviorTree.CPP.
    #[must_use]
    pub fn max_depth(mut self, nodes: usize) -> Self {
        self.max_depth = nodes;
        self
    }

    /// Refuses trees of more nodes than this, subtrees included. 100 000 if not set.
    #[must_use]
    pub fn max_nodes(mut self, nodes: usize) -> Self {
        self.max_nodes = nodes;
        self
    }
}
