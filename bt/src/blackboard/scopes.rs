//! Scopes of the blackboard: which entry a key refers to in which tree.

use std::collections::BTreeMap;
use std::sync::Arc;

/// A tree or subtree, which has its own names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct ScopeId(pub(crate) u32);

/// An entry of the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Slot(pub(crate) u32);

/// The names that a subtree shares with the tree that contains it.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Scope {
    pub(crate) parent: Option<ScopeId>,
    /// Its own keys, and their names in the parent scope.
    pub(crate) remapped: BTreeMap<String, String>,
    /// Keys that have their own value here, whatever the parent scope contains.
    pub(crate) constants: BTreeMap<String, ()>,
    /// All keys that are not private (`_x`) are shared with the parent scope.
    pub(crate) autoremap: bool,
}

/// All scopes of a tree, and the entries that it names.
///
/// A key refers to the entry of its own scope unless the subtree remaps it; `@key` refers to the entry `key` of the
/// main tree. So every key in a file refers to an entry that is known when the file is loaded.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Scopes {
    scopes: Vec<Scope>,
    names: Vec<(ScopeId, Arc<str>)>,
    slots: BTreeMap<(ScopeId, Arc<str>), Slot>,
}

impl Scopes {
    pub(crate) const ROOT: ScopeId = ScopeId(0);

    pub(crate) fn push(&mut self, scope: Scope) -> ScopeId {
        self.scopes.push(scope);
        ScopeId(u32::try_from(self.scopes.len() - 1).expect("there are fewer scopes than nodes"))
    }

    /// The scope to which a key finally resolves, and its name there.
    pub(crate) fn resolve<'a>(&'a self, mut scope: ScopeId, mut key: &'a str) -> (ScopeId, &'a str) {
        loop {
            if let Some(rest) = key.strip_prefix('@') {
                return (Self::ROOT, rest);
            }
            let Scope { parent, remapped, constants, autoremap } = &self.scopes[scope.0 as usize];
            let Some(parent) = *parent else { return (scope, key) };
            if constants.contains_key(key) {
                return (scope, key);
            } else if let Some(above) = remapped.get(key) {
                key = above;
            } else if !autoremap || key.starts_with('_') {
                return (scope, key);
            }
            scope = parent;
        }
    }

    /// The entry of a key, if the file names it.
    pub(crate) fn find(&self, scope: ScopeId, key: &str) -> Option<Slot> {
        let (scope, key) = self.resolve(scope, key);
        self.slots.get(&(scope, Arc::from(key))).copied()
    }

    /// The entry of a key, created if necessary.
    pub(crate) fn slot(&mut self, scope: ScopeId, key: &str) -> Slot {
        let (scope, key) = self.resolve(scope, key);
        let name = (scope, Arc::from(key));
        let next = Slot(u32::try_from(self.names.len()).expect("there are fewer names than characters in a file"));
        *self.slots.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            next
        })
    }

    /// The key of an entry in its own scope.
    pub(crate) fn name(&self, slot: Slot) -> &str {
        &self.names[slot.0 as usize].1
    }

    /// The names of all entries, by their numbers.
    pub(crate) fn names(&self) -> &[(ScopeId, Arc<str>)] {
        &self.names
    }
}
