//! The compiled form of a tree for the engine.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::blackboard::{Blackboard, Entry, Scopes, Slot, Type};
use crate::hooks::Hooks;
use crate::script::Script;
use crate::settings::{Input, Setting};
use crate::{Direction, Kind, NodeId};

/// The engine's view of a node, in a few bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Op {
    pub(crate) kind: Kind,
    pub(crate) flags: Flags,
    pub(crate) parent: u32,
    /// The first node in document order that is not below this one: its next sibling, if there is one.
    pub(crate) end: u32,
    /// Its index among the nodes with memory; for leaves outside the tree, among these.
    pub(crate) place: u32,
}

/// The scripts that a node has, and whether it reads from the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Flags(u8);

impl Flags {
    pub(crate) const ENTRANCE: Self = Self(1);
    pub(crate) const EXIT: Self = Self(2);
    pub(crate) const HALTED: Self = Self(4);
    pub(crate) const READS: Self = Self(8);

    pub(crate) fn has(self, flag: Self) -> bool {
        self.0 & flag.0 != 0
    }

    pub(crate) fn add(&mut self, flag: Self, condition: bool) {
        if condition {
            self.0 |= flag.0;
        }
    }
}

/// A port of a leaf outside the tree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LeafPort {
    pub(crate) direction: Direction,
    pub(crate) of: Type,
    /// `None` if the file does not connect it.
    pub(crate) input: Option<Input>,
    /// By a model.
    pub(crate) is_declared: bool,
    /// Whether its entry, if any, is of the leaf's own tree and not remapped to one further up.
    pub(crate) is_own: bool,
}

impl LeafPort {
    /// The entry to which it is connected.
    pub(crate) fn entry(&self) -> Option<Slot> {
        self.input.as_ref().and_then(Input::entry)
    }
}

/// A tree as the engine runs it.
#[derive(Debug, PartialEq, Default)]
pub(crate) struct Program {
    pub(crate) ops: Vec<Op>,
    /// By place.
    pub(crate) settings: Vec<Setting>,
    /// By node, for those that have scripts.
    pub(crate) hooks: BTreeMap<u32, Hooks>,
    /// By place of the leaf.
    pub(crate) leaves: Vec<BTreeMap<String, LeafPort>>,
    pub(crate) scopes: Arc<Scopes>,
    /// The initial entries of the blackboard.
    pub(crate) entries: Vec<Entry>,
    /// The number of memos on the blackboard.
    pub(crate) memos: usize,
    /// The entries that nodes watch, by number.
    pub(crate) watched: Vec<Slot>,
}

impl Program {
    pub(crate) fn scripts_of(&self, node: u32) -> impl Iterator<Item = &Script> {
        let own = (!self.ops[node as usize].kind.is_leaf()).then(|| self.setting(node)).and_then(Setting::script);
        own.into_iter().chain(self.hooks.get(&node).into_iter().flat_map(Hooks::all))
    }

    /// The scripts of a node whose values decide what it does.
    pub(crate) fn conditions_of(&self, node: u32) -> impl Iterator<Item = &Script> {
        let own = (!self.ops[node as usize].kind.is_leaf()).then(|| self.setting(node)).and_then(Setting::condition);
        own.into_iter().chain(self.hooks.get(&node).into_iter().flat_map(Hooks::conditions))
    }

    /// The blackboard before the first tick.
    pub(crate) fn blackboard(&self) -> Blackboard {
        let mut entries = self.entries.clone();
        entries.resize_with(self.scopes.names().len(), Entry::default);
        Blackboard::new(self.scopes.clone(), entries, self.memos, &self.watched)
    }

    pub(crate) fn hooks(&self, node: u32) -> &Hooks {
        self.hooks.get(&node).expect("a node with the flag of a script has scripts")
    }

    pub(crate) fn setting(&self, node: u32) -> &Setting {
        &self.settings[self.ops[node as usize].place as usize]
    }

    pub(crate) fn children(&self, node: u32) -> impl Iterator<Item = u32> {
        let end = self.ops[node as usize].end;
        let first = Some(node + 1).filter(|first| *first < end);
        std::iter::successors(first, move |child| Some(self.ops[*child as usize].end).filter(|next| *next < end))
    }

    /// Whether any node can unset entries.
    pub(crate) fn can_unset(&self) -> bool {
        self.settings.iter().any(|setting| matches!(setting, Setting::UnsetBlackboard { .. }))
    }

    /// Whether any node reads from the blackboard or has scripts, or a leaf has ports connected to entries.
    pub(crate) fn uses_blackboard(&self) -> bool {
        let mut ports = self.leaves.iter().flat_map(BTreeMap::values);
        self.ops.iter().any(|op| op.flags != Flags::default()) || ports.any(|port| port.entry().is_some())
    }

    pub(crate) fn leaf_ports(&self, leaf: NodeId) -> &BTreeMap<String, LeafPort> {
        &self.leaves[self.ops[leaf.index()].place as usize]
    }
}
