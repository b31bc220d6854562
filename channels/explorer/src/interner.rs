//! Values that are stored once and identified by number.

use std::hash::{BuildHasher, Hash, Hasher};

use foldhash::fast::FixedState;
use hashbrown::HashTable;

/// Values by number, in the order in which they were first seen.
#[derive(Debug)]
pub(crate) struct Interner<T> {
    values: Vec<T>,
    /// The numbers of the values, by their hashes.
    numbers: HashTable<(u64, u32)>,
}

impl<T> Default for Interner<T> {
    fn default() -> Self {
        Self { values: Vec::new(), numbers: HashTable::new() }
    }
}

impl<T> Interner<T> {
    pub(crate) fn len(&self) -> usize {
        self.values.len()
    }

    pub(crate) fn get(&self, number: u32) -> &T {
        &self.values[number as usize]
    }

    pub(crate) fn get_mut(&mut self, number: u32) -> &mut T {
        &mut self.values[number as usize]
    }

    /// Forgets all values from this number on.
    pub(crate) fn truncate(&mut self, len: usize) {
        self.values.truncate(len);
        self.numbers.retain(|(_, number)| (*number as usize) < len);
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.values.iter()
    }

    /// The number of the value with this hash that is the `same`.
    pub(crate) fn find(&self, hash: u64, same: impl Fn(&T) -> bool) -> Option<u32> {
        let is_same = |(of, known): &(u64, u32)| *of == hash && same(&self.values[*known as usize]);
        self.numbers.find(hash, is_same).map(|(_, number)| *number)
    }

    /// Adds a value with this hash, which must be new, and returns its number.
    pub(crate) fn add(&mut self, hash: u64, value: T) -> u32 {
        let number = u32::try_from(self.values.len()).expect("memory runs out before numbers do");
        self.numbers.insert_unique(hash, (hash, number), |(hash, _)| *hash);
        self.values.push(value);
        number
    }
}

impl<T: Hash + Eq> Interner<T> {
    /// The number of a value.
    pub(crate) fn intern(&mut self, value: T) -> u32 {
        let hash = hash_of(&value);
        self.find(hash, |known| *known == value).unwrap_or_else(|| self.add(hash, value))
    }

    /// The number of a value that is already known.
    pub(crate) fn find_value(&self, value: &T) -> Option<u32> {
        self.find(hash_of(value), |known| known == value)
    }
}

fn hash_of(value: &impl Hash) -> u64 {
    FixedState::default().hash_one(value)
}

/// The hash of what is fed to a hasher.
pub(crate) fn hash_by(feed: impl FnOnce(&mut dyn Hasher)) -> u64 {
    let mut hasher = FixedState::default().build_hasher();
    feed(&mut hasher);
    hasher.finish()
}
