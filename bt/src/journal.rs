//! The changes of status in a running tree, as the loggers of BehaviorTree.CPP receive them.

use channels::Unobserved;

use crate::{NodeId, Status};

/// A node got another status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeTransition {
    /// The node.
    pub node: NodeId,
    /// The status; `None` is `IDLE`.
    pub status: Option<Status>,
}

/// Notes the changes of status once they are needed. It only reports: it is not part of a state that is compared or
/// hashed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Journal(Unobserved<Option<Notes>>);

#[derive(Clone, Debug)]
struct Notes {
    /// The status that each node had when it was last noted.
    statuses: Box<[Option<Status>]>,
    transitions: Vec<NodeTransition>,
}

impl Journal {
    /// From now on, changes are noted, if they are not yet; the nodes have these statuses.
    pub(crate) fn begin(&mut self, statuses: impl Iterator<Item = Option<Status>>) {
        self.0.get_or_insert_with(|| Notes { statuses: statuses.collect(), transitions: Vec::new() });
    }

    /// The changes since the last call.
    pub(crate) fn take(&mut self) -> Vec<NodeTransition> {
        self.0.as_mut().map_or_else(Vec::new, |notes| std::mem::take(&mut notes.transitions))
    }

    #[inline]
    pub(crate) fn note(&mut self, node: u32, status: Option<Status>) {
        if let Some(notes) = &mut *self.0 {
            notes.add(node, status);
        }
    }
}

impl Notes {
    fn add(&mut self, node: u32, status: Option<Status>) {
        if std::mem::replace(&mut self.statuses[node as usize], status) != status {
            self.transitions.push(NodeTransition { node: NodeId(node), status });
        }
    }
}
