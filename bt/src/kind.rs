//! The kinds of nodes and what each of them means.

use std::fmt;

/// A kind of node.
///
/// The meaning is BehaviorTree.CPP's, version 4.10 (the version 3 differs where its reactive nodes leave a later child
/// running; we follow 4 for both formats). Three words used below:
///
/// - A node is *reset* when its status goes back to idle. If it is running, it is *halted* first: its running children
///   are halted in their order, each before the next is looked at, and so on down to the actions, which are told.
/// - A node that is not running is never halted, and neither is anything below it.
/// - When a node has succeeded or failed, all its children have been reset, but for [`SequenceWithMemory`]'s.
///
/// [`SequenceWithMemory`]: Kind::SequenceWithMemory
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Ticks its children in order until one fails or runs; succeeds when all have succeeded. While a child is running,
    /// the next tick goes on with that child. When a child fails, all are reset, and the next tick starts over.
    Sequence,
    /// Ticks its children in order *from the first at every tick* until one fails or runs; succeeds when all have
    /// succeeded. When a child runs, all the others are reset: one that ran before is halted, wherever it stands.
    ///
    /// The paper's sequence is this one. BehaviorTree.CPP can be told to throw an error when a second child runs; 4.10
    /// does not by default, and neither do we.
    ReactiveSequence,
    /// Like [`Sequence`](Kind::Sequence), but children that have succeeded are not ticked again, even after a later
    /// child has failed or the node has been halted: only its own success starts it over. After a failure, that child
    /// and those behind it are reset.
    ///
    /// When a child that was idle succeeds and is not the last, the node answers running, and the whole tree is
    /// ticked again at once, as part of the same tick (BehaviorTree.CPP's wake-up signal, with `tickOnce`).
    SequenceWithMemory,
    /// Ticks its children in order until one succeeds or runs; fails when all have failed. While a child is running, the
    /// next tick goes on with that child.
    Fallback,
    /// Ticks its children in order *from the first at every tick* until one succeeds or runs; fails when all have
    /// failed. When a child runs, all the others are reset. The paper's fallback is this one.
    ReactiveFallback,
    /// Succeeds when its child fails and fails when it succeeds.
    Inverter,
    /// Succeeds when its child has succeeded or failed.
    ForceSuccess,
    /// Fails when its child has succeeded or failed.
    ForceFailure,
    /// Another tree in this place. Answers what that tree answers.
    SubTree,
    /// Succeeds at once.
    AlwaysSuccess,
    /// Fails at once.
    AlwaysFailure,
    /// A leaf outside the tree that checks something. It is never told to stop: a condition that answers running (it
    /// should not) is forgotten when it is halted.
    Condition,
    /// A leaf outside the tree that does something. While it runs, it can be halted, and is told so.
    Action,
}

/// Which part nodes of a kind play in a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Category {
    /// Directs one child or more.
    Control,
    /// Changes what its only child answers.
    Decorator,
    /// Does something; has no children.
    Action,
    /// Checks something; has no children.
    Condition,
    /// Stands for another tree.
    SubTree,
}

impl Category {
    /// The element that spells nodes of this category out: `<Control ID="Sequence">`.
    #[must_use]
    pub fn element(self) -> &'static str {
        match self {
            Self::Control => "Control",
            Self::Decorator => "Decorator",
            Self::Action => "Action",
            Self::Condition => "Condition",
            Self::SubTree => "SubTree",
        }
    }

    /// How many children such a node may have in the file, in words, or none if `count` is right.
    pub(crate) fn expected_children(self, count: usize) -> Option<&'static str> {
        match self {
            Self::Control if count == 0 => Some("at least one child"),
            Self::Decorator if count != 1 => Some("exactly one child"),
            Self::Action | Self::Condition | Self::SubTree if count != 0 => Some("no children"),
            _ => None,
        }
    }
}

impl fmt::Display for Category {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.element())
    }
}

impl Kind {
    /// The name of the kind, as BehaviorTree.CPP registers it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sequence => "Sequence",
            Self::ReactiveSequence => "ReactiveSequence",
            Self::SequenceWithMemory => "SequenceWithMemory",
            Self::Fallback => "Fallback",
            Self::ReactiveFallback => "ReactiveFallback",
            Self::Inverter => "Inverter",
            Self::ForceSuccess => "ForceSuccess",
            Self::ForceFailure => "ForceFailure",
            Self::SubTree => "SubTree",
            Self::AlwaysSuccess => "AlwaysSuccess",
            Self::AlwaysFailure => "AlwaysFailure",
            Self::Condition => "Condition",
            Self::Action => "Action",
        }
    }

    /// What is drawn in the node's box: the literature's arrow and question mark for the nodes that look at all their
    /// children at every tick, with a star for those that resume and two for the one that never forgets. Leaves have no
    /// symbol: draw their label.
    #[must_use]
    pub fn symbol(self) -> Option<&'static str> {
        match self {
            Self::ReactiveSequence => Some("→"),
            Self::Sequence => Some("→*"),
            Self::SequenceWithMemory => Some("→**"),
            Self::ReactiveFallback => Some("?"),
            Self::Fallback => Some("?*"),
            Self::Inverter => Some("¬"),
            Self::ForceSuccess => Some("+"),
            Self::ForceFailure => Some("−"),
            Self::SubTree => Some("▸"),
            Self::AlwaysSuccess | Self::AlwaysFailure | Self::Condition | Self::Action => None,
        }
    }

    /// Which part nodes of this kind play.
    #[must_use]
    pub fn category(self) -> Category {
        match self {
            Self::Sequence
            | Self::ReactiveSequence
            | Self::SequenceWithMemory
            | Self::Fallback
            | Self::ReactiveFallback => Category::Control,
            Self::Inverter | Self::ForceSuccess | Self::ForceFailure => Category::Decorator,
            Self::SubTree => Category::SubTree,
            Self::AlwaysSuccess | Self::AlwaysFailure | Self::Action => Category::Action,
            Self::Condition => Category::Condition,
        }
    }

    /// Whether nodes of this kind are outside the tree: it calls them.
    #[must_use]
    pub fn is_leaf(self) -> bool {
        matches!(self, Self::Condition | Self::Action)
    }

    /// Whether a node of this kind starts over after it was halted.
    pub(crate) fn forgets(self) -> bool {
        self != Self::SequenceWithMemory
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
