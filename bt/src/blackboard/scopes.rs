//! Scopes of the blackboard: which entry a key refers to in which tree.

use std::collections::{BTreeMap, BTreeSet};
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
    /// The keys that a subtree gets from outside and that its nodes name, with its scope.
    used: BTreeSet<(ScopeId, String)>,
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

    /// Notes that a node of this scope names a key: the subtrees around it use what they get under that name.
    pub(crate) fn mention(&mut self, mut scope: ScopeId, key: &str) {
        let mut key = key.to_owned();
        while !key.starts_with('@') {
            let Scope { parent, remapped, constants, autoremap } = &self.scopes[scope.0 as usize];
            let Some(parent) = *parent else { return };
            let above = match remapped.get(&key) {
                Some(above) => above.clone(),
                None if constants.contains_key(&key) || !autoremap || key.starts_with('_') => key.clone(),
                None => {
                    scope = parent;
                    continue;
                }
            };
            let is_shared = remapped.contains_key(&key);
            if !self.used.insert((scope, key)) || !is_shared {
                return;
            }
            (scope, key) = (parent, above);
        }
    }

    /// Whether a node of this scope names a key that the scope gets from outside.
    pub(crate) fn is_mentioned(&self, scope: ScopeId, key: &str) -> bool {
        self.used.contains(&(scope, key.to_owned()))
    }

    /// The entry of a key that a node names, created if necessary.
    pub(crate) fn named_slot(&mut self, scope: ScopeId, key: &str) -> Slot {
        self.mention(scope, key);
        self.slot(scope, key)
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

    /// The keys of the entries that belong to this scope.
    pub(crate) fn own_keys(&self, scope: ScopeId) -> impl Iterator<Item = &str> {
        self.names.iter().filter(move |(of, _)| *of == scope).map(|(_, key)| &**key)
    }

    /// The names of all entries, by their numbers.
    pub(crate) fn names(&self) -> &[(ScopeId, Arc<str>)] {
        &self.names
    }
}
