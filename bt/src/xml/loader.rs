//! Options for loading a tree.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::settings::Constants;

/// Reads tree files.
///
/// Both spellings of nodes are read: `<Action ID="GoTo"/>` and `<GoTo/>`, `<Control ID="Sequence">` and `<Sequence>`.
/// The short form of a leaf requires a declaration of the leaf, in the file's `<TreeNodesModel>` or by
/// [`leaves`](Self::leaves); Nav2's leaves (`<FollowPath/>`, `<Wait/>`, …) are declared by Nav2's model, unless the
/// file or the loader declares them. Parts that have no meaning here (descriptions, Groot's annotations) are kept.
/// Trees that BehaviorTree.CPP 4 refuses to load are refused: IDs with a space or another forbidden character, two
/// subtrees with the same name in a tree, ports that no model declares, ports of different types that use the same
/// entry. In files of version 3, whose models are only Groot's annotations, an undeclared port is a warning, as is an
/// unknown attribute that looks like a script ([`Tree::concerns`](crate::Tree::concerns)).
///
/// All trees of a file are checked, even those that the main tree does not use.
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
    /// Declares leaves with these IDs, so that `<ID/>` is an action if the file itself does not declare it.
    #[must_use]
    pub fn leaves(mut self, ids: impl IntoIterator<Item: Into<String>>) -> Self {
        self.leaves.extend(ids.into_iter().map(Into::into));
        self
    }

    /// Defines names for numbers in scripts and switches, like the enumerators that a program registers with
    /// BehaviorTree.CPP.
    #[must_use]
    pub fn constants(mut self, constants: impl IntoIterator<Item = (impl Into<String>, i64)>) -> Self {
        let constants = constants.into_iter().map(|(name, number)| (name.into(), number));
        Arc::make_mut(&mut self.constants).extend(constants);
        self
    }

    /// Uses this tree as the main tree, whatever the file declares.
    #[must_use]
    pub fn main_tree(mut self, id: impl Into<String>) -> Self {
        self.main_tree = Some(id.into());
        self
    }

    /// Refuses trees deeper than this, including subtrees. The default is 256, as in BehaviorTree.CPP.
    #[must_use]
    pub fn max_depth(mut self, nodes: usize) -> Self {
        self.max_depth = nodes;
        self
    }

    /// Refuses trees with more nodes than this, including subtrees. The default is 100,000.
    #[must_use]
    pub fn max_nodes(mut self, nodes: usize) -> Self {
        self.max_nodes = nodes;
        self
    }
}
