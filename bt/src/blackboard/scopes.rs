//! Names on the blackboard: which entry a key means in which tree.

use std::collections::BTreeMap;
use std::sync::Arc;

/// A tree or subtree, which has names of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct ScopeId(pub(crate) u32);

/// An entry of the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Slot(pub(crate) u32);

/// What a subtree's own blackboard passes on to the tree that it is in.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Scope {
    pub(crate) parent: Option<ScopeId>,
    /// Own keys, and what they are called above.
    pub(crate) remapped: BTreeMap<String, String>,
    /// Keys that have a value of their own here, whatever is called so above.
    pub(crate) constants: BTreeMap<String, ()>,
    /// All keys that are not private (`_x`) mean the same above.
    pub(crate) autoremap: bool,
}

/// All scopes of a tree, and the entries that it names.
///
/// A key means the entry of its own scope, unless the subtree remaps it; `@key` means the entry `key` of the main tree.
/// So every key that is written in a file stands for an entry that is known when the file is loaded.
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

    /// The scope that a key ends up in, and its name there.
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

    /// The entry that a key means, if it is one that the file names.
    pub(crate) fn find(&self, scope: ScopeId, key: &str) -> Option<Slot> {
        let (scope, key) = self.resolve(scope, key);
        self.slots.get(&(scope, Arc::from(key))).copied()
    }

    /// The entry that a key means; new if need be.
    pub(crate) fn slot(&mut self, scope: ScopeId, key: &str) -> Slot {
        let (scope, key) = self.resolve(scope, key);
        let name = (scope, Arc::from(key));
        let next = Slot(u32::try_from(self.names.len()).expect("there are fewer names than characters in a file"));
        *self.slots.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            next
        })
    }

    /// The names of all entries, by their numbers.
    pub(crate) fn names(&self) -> &[(ScopeId, Arc<str>)] {
        &self.names
    }
}
