//! The blackboard: data that the nodes of a tree share.

mod scopes;
mod types;
mod value;

use std::collections::VecDeque;
use std::sync::Arc;

use channels::Shared;

pub(crate) use scopes::{Scope, ScopeId, Scopes, Slot};
pub use types::Type;
pub(crate) use types::status_named;
pub use value::{Value, ValueError};

/// An entry: its value, its type, and the number of times that it has been written.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Entry {
    /// `None` until it is first written.
    value: Option<Value>,
    of: Type,
    /// The type of the value in BehaviorTree.CPP: a script may give an entry a value of another type than its own.
    holds: Type,
    /// Whether SetBlackboard, or the port of a node that watches it, has given it the type `BT::Any`, as which no
    /// string can be parsed.
    is_any: bool,
    /// Whether a port of an unknown type has named it first: then it takes whatever it gets.
    is_unknown: bool,
    /// Whether a port declares it or it has been written. A script may not assign to an entry that does not exist.
    exists: bool,
    writes: u64,
}

impl Entry {
    /// Its type and its value at the start.
    pub(crate) fn initial(&self) -> (&Type, Option<&Value>) {
        (&self.of, self.value.as_ref())
    }

    pub(crate) fn has_value(&self) -> bool {
        self.value.is_some()
    }
}

impl Default for Entry {
    fn default() -> Self {
        Self {
            value: None,
            of: Type::Any,
            holds: Type::Any,
            is_any: false,
            is_unknown: false,
            exists: false,
            writes: 0,
        }
    }
}

/// The blackboard of a running tree, including its subtrees: entries with their keys.
///
/// The keys here are those of the main tree; `@key` is the same as `key`. Entries private to a subtree are visible only
/// through [`entries`](Self::entries).
///
/// ```
/// use std::sync::Arc;
/// use bt::{Execution, Tree, Value};
///
/// let tree = Tree::from_xml("count.xml", r#"<root BTCPP_format="4"> <BehaviorTree ID="Count">
///     <Script code="count := count + 1"/>
/// </BehaviorTree> </root>"#)?;
/// let mut execution = Execution::new(Arc::new(tree));
/// execution.blackboard_mut().set("count", 41)?;
/// assert_eq!(execution.blackboard().get("count"), Some(&Value::Int(41)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Blackboard {
    scopes: Shared<Scopes>,
    entries: Vec<Entry>,
    /// The keys of entries created while the tree runs; these entries follow those that the file names.
    extra: Vec<(ScopeId, Arc<str>)>,
    /// What nodes remember of the values that they have read, by number: the remaining items of a loop whose queue is
    /// not on the blackboard, and the last goal, path or position that one of Nav2's nodes has seen.
    memos: Vec<Option<VecDeque<Value>>>,
    /// For each node that watches an entry, by number: the entry, and its number of writes when the node last looked.
    watched: Vec<(Slot, u64)>,
}

impl Blackboard {
    /// The initial blackboard of a tree: these entries, room for this many memos, and a watch on each of these slots.
    pub(crate) fn new(scopes: Arc<Scopes>, entries: Vec<Entry>, memos: usize, watched: &[Slot]) -> Self {
        let watched = watched.iter().map(|slot| (*slot, 0)).collect();
        Self { scopes: scopes.into(), entries, extra: Vec::new(), memos: vec![None; memos], watched }
    }

    /// The value under this key of the main tree; `None` if it was never written.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.value(self.find(Scopes::ROOT, key)?)
    }

    /// Writes a value under this key of the main tree.
    ///
    /// # Errors
    /// If the entry has a type that the value does not fit.
    pub fn set(&mut self, key: &str, value: impl Into<Value>) -> Result<(), ValueError> {
        let (slot, value) = (self.slot(Scopes::ROOT, key), value.into());
        self.write(slot, value, &Type::Any, true)
    }

    /// All entries that exist and have a value, in the order in which the file names them: the number of the tree or
    /// subtree that holds it (the main tree is 0), the key, and the value.
    pub fn entries(&self) -> impl Iterator<Item = (usize, &str, &Value)> {
        let names = self.scopes.names().iter().chain(&self.extra);
        names.zip(&self.entries).filter_map(|((scope, key), entry)| {
            Some((scope.0 as usize, &**key, entry.value.as_ref().filter(|_| entry.exists)?))
        })
    }

    pub(crate) fn find(&self, scope: ScopeId, key: &str) -> Option<Slot> {
        self.scopes.find(scope, key).or_else(|| {
            let (scope, key) = self.scopes.resolve(scope, key);
            let place = self.extra.iter().position(|name| name.0 == scope && &*name.1 == key)?;
            u32::try_from(self.scopes.names().len() + place).ok().map(Slot)
        })
    }

    /// The entry for a key, created if necessary.
    pub(crate) fn slot(&mut self, scope: ScopeId, key: &str) -> Slot {
        self.find(scope, key).unwrap_or_else(|| {
            let (scope, key) = self.scopes.resolve(scope, key);
            self.extra.push((scope, key.into()));
            self.entries.push(Entry::default());
            Slot(u32::try_from(self.entries.len() - 1).expect("2^32 entries do not fit in memory"))
        })
    }

    pub(crate) fn value(&self, slot: Slot) -> Option<&Value> {
        self.entry(slot).value.as_ref()
    }

    /// The value, for a loop node that removes items from it. This does not count as a write.
    pub(crate) fn value_mut(&mut self, slot: Slot) -> Option<&mut Value> {
        self.entries[slot.0 as usize].value.as_mut()
    }

    pub(crate) fn exists(&self, slot: Slot) -> bool {
        self.entry(slot).exists
    }

    /// Whether the watched entry with this number exists and has been written since it was last seen to exist.
    pub(crate) fn has_new_value(&mut self, number: usize) -> bool {
        self.exists(self.watched[number].0) && self.has_changed(number)
    }

    /// Whether the watched entry with this number has been written, or unset, since the last call.
    pub(crate) fn has_changed(&mut self, number: usize) -> bool {
        let (slot, seen) = &mut self.watched[number];
        let writes = self.entries[slot.0 as usize].writes;
        std::mem::replace(seen, writes) != writes
    }

    /// Brings the numbers of writes into normal form: they only show whether an entry has been written since a node
    /// last looked. If the tree can unset entries, whose numbers then restart at 0, watched entries keep their numbers.
    pub(crate) fn normalize(&mut self, can_unset: bool) {
        let number = |watched: bool, writes: u64| match (watched, can_unset) {
            (true, true) => writes,
            (true, false) => writes.min(1),
            (false, _) => 0,
        };
        for (slot, seen) in self.watched.iter_mut().filter(|_| !can_unset) {
            let writes = self.entries[slot.0 as usize].writes;
            *seen = if *seen == writes { number(true, writes) } else { 0 };
        }
        for (slot, entry) in (0..).zip(&mut self.entries) {
            let is_watched = self.watched.iter().any(|(watched, _)| *watched == Slot(slot));
            entry.writes = number(is_watched, entry.writes);
        }
    }

    pub(crate) fn type_of(&self, slot: Slot) -> &Type {
        &self.entry(slot).of
    }

    /// The type of an entry's value in BehaviorTree.CPP.
    pub(crate) fn holds(&self, slot: Slot) -> &Type {
        &self.entry(slot).holds
    }

    fn name(&self, slot: Slot) -> &str {
        let mut names = self.scopes.names().iter().chain(&self.extra);
        names.nth(slot.0 as usize).map_or("", |(_, key)| key)
    }

    /// Writes a value of this type, as a port or a program does (`Blackboard::set`); [`Type::Any`] is the type of a
    /// literal. An entry without a type gets that of the value. One with a type keeps it, and also the kind of number
    /// that it holds. If the entry is not of the writer's `own` tree but remapped, BehaviorTree.CPP converts nothing.
    pub(crate) fn write(&mut self, slot: Slot, value: Value, of: &Type, own: bool) -> Result<(), ValueError> {
        let entry = self.entry(slot);
        let of = match (of, &entry.of, &value) {
            // A program that writes a literal gives it the right width.
            (Type::Any, Type::Int { .. }, Value::Int(_)) => entry.of.clone(),
            (Type::Any, ..) => Type::of_value(&value),
            (of, ..) => of.clone(),
        };
        if !own && entry.exists {
            if entry.of.is_strong() && of != Type::Text && entry.of != of {
                return Err(ValueError::of_type(self.name(slot), &entry.of, &of));
            }
            self.put(slot, Some(value), Some(of));
            return Ok(());
        }
        if !entry.of.is_strong() {
            // A new entry that gets a string can still become one of any type.
            let is = if entry.exists || of != Type::Text { of.clone() } else { Type::Any };
            self.declare(slot, is);
            self.put(slot, Some(value), Some(of));
            return Ok(());
        }
        let Some(value) = entry.of.receive(&of, value)? else {
            return Err(ValueError::of_type(self.name(slot), &entry.of, &of));
        };
        let (value, holds) = match (&entry.value, &value) {
            (None, _) => (entry.of.convert(&value)?, Some(entry.of.clone())),
            (Some(Value::Int(_)), Value::Int(_) | Value::Real(_)) => (Value::Int(value.to_int()?), None),
            (Some(Value::Real(_)), Value::Int(_) | Value::Real(_)) => (Value::Real(value.to_real()?), None),
            (Some(old), new) if std::mem::discriminant(old) == std::mem::discriminant(new) => (value, None),
            (Some(old), new) => return Err(ValueError::of_kind(self.name(slot), old, new)),
        };
        self.put(slot, Some(value), holds);
        Ok(())
    }

    /// Copies a value of this type from another entry, or from the file (`Blackboard::set<Any>`): an entry with a type
    /// takes that type only. One without a type gets `BT::Any` if it is of the `own` tree of the node.
    pub(crate) fn copy(&mut self, slot: Slot, value: Option<Value>, of: Type, own: bool) -> Result<(), ValueError> {
        let entry = self.entry(slot);
        if entry.of.is_strong() && entry.of != of {
            return Err(ValueError::of_type(self.name(slot), &entry.of, &of));
        }
        let is_open = !self.entry(slot).of.is_strong() && !self.entry(slot).is_unknown;
        self.entries[slot.0 as usize].is_any |= own && is_open;
        self.put(slot, value, Some(of));
        Ok(())
    }

    /// Writes without checking the type. The type of the value stays if none is given.
    pub(crate) fn put(&mut self, slot: Slot, value: Option<Value>, holds: Option<Type>) {
        let entry = &mut self.entries[slot.0 as usize];
        entry.value = value;
        entry.exists = true;
        entry.writes += 1;
        if let Some(holds) = holds {
            entry.holds = holds;
        }
    }

    /// Creates an entry without a value.
    pub(crate) fn create(&mut self, slot: Slot) {
        self.entries[slot.0 as usize].exists = true;
    }

    /// Creates an entry with a permanent type.
    pub(crate) fn declare(&mut self, slot: Slot, of: Type) {
        let entry = &mut self.entries[slot.0 as usize];
        (entry.exists, entry.of, entry.is_any, entry.is_unknown) = (true, of, false, false);
    }

    /// Creates an entry with the type of another one.
    pub(crate) fn declare_like(&mut self, slot: Slot, other: Slot) {
        let Entry { of, is_any, is_unknown, .. } = self.entry(other).clone();
        self.declare(slot, of);
        let entry = &mut self.entries[slot.0 as usize];
        (entry.is_any, entry.is_unknown) = (is_any, is_unknown);
    }

    /// Whether the type of an entry is unknown: it is in the robot's program, and not in the file.
    pub(crate) fn is_unknown(&self, slot: Slot) -> bool {
        self.entry(slot).is_unknown
    }

    /// Whether an entry has the type `BT::Any`: then no string can be parsed as its type.
    pub(crate) fn is_any(&self, slot: Slot) -> bool {
        self.entry(slot).is_any
    }

    /// Removes an entry, with its type.
    pub(crate) fn unset(&mut self, slot: Slot) {
        self.entries[slot.0 as usize] = Entry::default();
    }

    /// The keys that this scope does not remap: those that it can unset.
    pub(crate) fn is_own(&self, scope: ScopeId, key: &str) -> bool {
        !key.starts_with('@') && self.scopes.resolve(scope, key).0 == scope
    }

    pub(crate) fn memo(&mut self, number: usize) -> &mut Option<VecDeque<Value>> {
        &mut self.memos[number]
    }

    fn entry(&self, slot: Slot) -> &Entry {
        &self.entries[slot.0 as usize]
    }
}

/// A port whose type is not that of its entry.
#[derive(Debug)]
pub(crate) struct Clash {
    /// The type of the entry.
    pub(crate) is: Type,
    /// Whether the entry is a constant that is passed to a subtree and can be read with the port's type.
    pub(crate) of_constant: bool,
}

/// The initial entries of a tree that is being assembled.
#[derive(Debug, Default)]
pub(crate) struct Declared {
    pub(crate) entries: Vec<Entry>,
}

impl Declared {
    fn entry(&mut self, slot: Slot) -> &mut Entry {
        let wanted = slot.0 as usize + 1;
        if self.entries.len() < wanted {
            self.entries.resize_with(wanted, Entry::default);
        }
        &mut self.entries[slot.0 as usize]
    }

    /// Registers a port of this type for the entry: the first one determines the entry's type.
    pub(crate) fn port(&mut self, slot: Slot, of: &Type) -> Option<Clash> {
        let entry = self.entry(slot);
        if !entry.exists {
            (entry.exists, entry.of) = (true, of.clone());
        }
        let of_constant = entry.value.is_some() && entry.of.is_read_as(of);
        (!entry.of.agrees_with(of)).then(|| Clash { is: entry.of.clone(), of_constant })
    }

    /// Registers a port of the type `BT::Any` for the entry: as long as no other type follows, no string is read.
    pub(crate) fn any_port(&mut self, slot: Slot) {
        let entry = self.entry(slot);
        if !entry.exists {
            (entry.exists, entry.is_any) = (true, true);
        }
    }

    /// Registers a port of an unknown type for the entry.
    pub(crate) fn unknown_port(&mut self, slot: Slot) {
        let entry = self.entry(slot);
        if !entry.exists {
            (entry.exists, entry.is_unknown) = (true, true);
        }
    }

    /// Whether the type of the entry is unknown.
    pub(crate) fn is_unknown(&self, slot: Slot) -> bool {
        self.entries.get(slot.0 as usize).is_some_and(|entry| entry.is_unknown)
    }

    /// Whether the entry has the type `BT::Any`.
    pub(crate) fn is_any(&self, slot: Slot) -> bool {
        self.entries.get(slot.0 as usize).is_some_and(|entry| entry.is_any)
    }

    /// The constants that are integers too large to calculate with.
    pub(crate) fn large_integers(&self) -> impl Iterator<Item = Slot> {
        let entries = (0..).zip(&self.entries);
        entries.filter(|(_, entry)| entry.value.as_ref().is_some_and(Value::is_too_large)).map(|(slot, _)| Slot(slot))
    }

    pub(crate) fn type_of(&self, slot: Slot) -> Type {
        self.entries.get(slot.0 as usize).map_or(Type::Any, |entry| entry.of.clone())
    }

    pub(crate) fn exists(&self, slot: Slot) -> bool {
        self.entries.get(slot.0 as usize).is_some_and(|entry| entry.exists)
    }

    /// A value that is passed to a subtree.
    pub(crate) fn constant(&mut self, slot: Slot, text: &str) {
        let (value, of) = typed(text);
        let holds = if of == Type::Any { Type::Text } else { of.clone() };
        *self.entry(slot) = Entry { value: Some(value), of, holds, exists: true, writes: 1, ..Entry::default() };
    }
}

/// A constant in its most specific type: an integer, a real number, or a string, which can be read as any type. As in
/// BehaviorTree.CPP, an integer is an `int` if it fits.
fn typed(text: &str) -> (Value, Type) {
    if let Ok(number) = text.parse::<i64>()
        && !text.starts_with('+')
    {
        return (Value::Int(number), if i32::try_from(number).is_ok() { Type::INT } else { Type::INT64 });
    }
    match text.parse::<f64>() {
        // C++'s `from_chars` refuses digits whose number no double can hold, but accepts the name of infinity.
        Ok(number)
            if !text.starts_with('+')
                && (is_in_range(text, number) || !text.contains(|c: char| c.is_ascii_digit())) =>
        {
            (Value::Real(number), Type::Real)
        }
        _ => (text.into(), Type::Any),
    }
}

/// Whether the digits of a number were neither too large nor too small for it.
fn is_in_range(text: &str, number: f64) -> bool {
    let digits = text.split(['e', 'E']).next().unwrap_or_default();
    number.is_finite() && (number != 0.0 || !digits.contains(|c: char| matches!(c, '1'..='9')))
}

/// The key to which a port's value refers, unless the value is a constant: `{key}`, or `{=}` for the port's own name.
pub(crate) fn pointed_key<'a>(port: &'a str, value: &'a str) -> Option<&'a str> {
    if value == "{=}" || value == "=" { Some(port) } else { braced_key(value) }
}

/// The key between the braces of a value, where `{=}` is the entry `=`.
pub(crate) fn braced_key(value: &str) -> Option<&str> {
    let key = value.trim_matches(' ').strip_prefix('{')?.strip_suffix('}')?;
    (!key.is_empty()).then_some(key)
}
