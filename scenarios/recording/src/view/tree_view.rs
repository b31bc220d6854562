//! The behavior tree of a run as its readers see it.

use std::collections::BTreeMap;
use std::time::Duration;

use bt::Outcome;
use channels::EventKind;

use crate::inconsistent::{Inconsistent, check};
use crate::tree_failure::{Failures, cause};
use crate::{Details, EntryValue, Header, Node, Step};

/// An error in a node of the tree, and when it first occurred.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeError {
    /// The node's index in the header.
    pub node: usize,
    /// The error, in words.
    pub message: String,
    /// The tick.
    pub tick: u64,
    /// Since the start of the run.
    pub time: Duration,
}

/// What the nodes of the tree have done, and what is on its blackboards.
#[derive(Clone, Debug)]
pub(super) struct TreeView {
    pub(super) outcomes: Vec<Option<Outcome>>,
    /// For each tick of the last step, the outcomes before it.
    pub(super) before_ticks: Vec<Vec<Option<Outcome>>>,
    /// By the index of the blackboard in the header, and the key.
    pub(super) entries: BTreeMap<(usize, String), EntryValue>,
    pub(super) errors: Vec<TreeError>,
    pub(super) failures: Failures,
}

impl TreeView {
    pub(super) fn new(header: &Header) -> Self {
        Self {
            outcomes: vec![None; header.tree.len()],
            before_ticks: Vec::new(),
            entries: BTreeMap::new(),
            errors: Vec::new(),
            failures: Failures::new(header),
        }
    }

    pub(super) fn take(&mut self, details: &Details, header: &Header, step: &Step) -> Result<(), Inconsistent> {
        let mut before_ticks = details.before_ticks.iter();
        for event in &details.events {
            if let (EventKind::Tick, Some(outcomes)) = (&event.kind, before_ticks.next()) {
                self.set_outcomes(outcomes, header, event.tick.saturating_sub(1), step.time)?;
                self.before_ticks.push(self.outcomes.clone());
            }
            self.failures.note(event);
        }
        self.set_outcomes(&details.outcomes, header, step.ticks.saturating_sub(1), step.time)?;
        check(details.transitions.iter().all(|(node, _)| *node < header.tree.len()))?;
        for (board, key, value) in &details.entries {
            check(*board < header.blackboards.len())?;
            let entry = (*board, key.clone());
            match value {
                Some(value) => drop(self.entries.insert(entry, value.clone())),
                None => drop(self.entries.remove(&entry)),
            }
        }
        Ok(())
    }

    /// Sets these outcomes, which the nodes have after this tick.
    fn set_outcomes(
        &mut self,
        outcomes: &[(usize, Option<Outcome>)],
        header: &Header,
        tick: u64,
        now: Duration,
    ) -> Result<(), Inconsistent> {
        for (node, outcome) in outcomes {
            *self.outcomes.get_mut(*node).ok_or(Inconsistent)? = *outcome;
        }
        if !outcomes.is_empty() {
            self.failures.judge(header, &self.outcomes, tick, now);
        }
        Ok(())
    }

    /// The leaves that are running, by name.
    pub(super) fn running<'v>(&'v self, tree: &'v [Node]) -> impl Iterator<Item = &'v str> {
        // The first child of a node comes right after it.
        let is_leaf = |node: usize| tree.get(node + 1).is_none_or(|next| next.parent != Some(node));
        let is_running = |&node: &usize| self.outcomes[node] == Some(Outcome::Answered(bt::Status::Running));
        (0..tree.len()).filter(is_running).filter(move |&node| is_leaf(node)).map(|node| tree[node].process.as_str())
    }

    pub(super) fn doing(&self, tree: &[Node]) -> String {
        let names: Vec<&str> = self.running(tree).collect();
        match cause(tree, &self.outcomes) {
            _ if !names.is_empty() => format!("{} is running", names.join(", ")),
            Some(node) => format!("the tree failed, because {} failed", tree[node].process),
            None if tree.is_empty() => String::new(),
            None => "no leaf is running".to_owned(),
        }
    }
}
