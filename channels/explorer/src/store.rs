//! The states found, each stored once in a few bytes, in the order in which they were found.
//!
//! A state is a vector of small numbers. Each slot of the vector is as wide as its largest number so far requires; for
//! a larger one, all states are repacked.

use std::{hint, mem};

/// A slot of a vector, and its new number.
pub(crate) type Change = (u32, u32);

/// The position of a slot's bits.
#[derive(Clone, Copy, Debug)]
struct Place {
    word: usize,
    shift: u32,
    /// The largest number that fits: all bits are ones.
    mask: u64,
}

impl Place {
    #[inline]
    fn get(self, words: &[u64]) -> u32 {
        (words[self.word] >> self.shift & self.mask) as u32
    }

    #[inline]
    fn set(self, words: &mut [u64], value: u32) {
        let word = &mut words[self.word];
        *word = *word & !(self.mask << self.shift) | u64::from(value) << self.shift;
    }
}

/// The positions of the bits of all slots.
#[derive(Clone, Debug)]
struct Layout {
    places: Vec<Place>,
    /// The number of words in a vector.
    words: usize,
}

impl Layout {
    /// Slots of these widths in bits, one after the other; none extends over two words.
    fn new(widths: &[u32]) -> Self {
        let (mut word, mut shift) = (0, 0);
        let places = widths.iter().map(|&width| {
            if shift + width > u64::BITS {
                (word, shift) = (word + 1, 0);
            }
            let begin = if width == 0 { 0 } else { shift };
            shift += width;
            Place { word, shift: begin, mask: (1 << width) - 1 }
        });
        Self { places: places.collect(), words: word + 1 }
    }

    /// The first change with a number that is too large for its slot.
    fn misfit(&self, changes: &[Change]) -> Option<Change> {
        changes.iter().copied().find(|(slot, value)| u64::from(*value) > self.places[*slot as usize].mask)
    }

    /// Makes the changes. Returns whether all numbers fit.
    #[inline]
    fn apply(&self, words: &mut [u64], changes: &[Change]) -> bool {
        changes.iter().fold(true, |fits, (slot, value)| {
            let place = self.places[*slot as usize];
            place.set(words, *value);
            fits & (u64::from(*value) <= place.mask)
        })
    }
}

/// All states found.
#[derive(Debug)]
pub(crate) struct Store {
    layout: Layout,
    /// The packed vectors, one after the other.
    words: Vec<u64>,
    len: u32,
    index: Index,
}

impl Store {
    /// A store with one vector.
    pub(crate) fn new(first: &[u32]) -> Self {
        let width = |value: &u32| u32::BITS - value.leading_zeros();
        let layout = Layout::new(&first.iter().map(width).collect::<Vec<_>>());
        let mut words = vec![0; layout.words];
        layout.places.iter().zip(first).for_each(|(place, value)| place.set(&mut words, *value));
        let mut store = Self { layout, words, len: 1, index: Index::default() };
        store.build_index();
        store
    }

    pub(crate) fn len(&self) -> u32 {
        self.len
    }

    /// How much memory it uses.
    pub(crate) fn bytes(&self) -> usize {
        self.words.capacity() * size_of::<u64>() + self.index.entries.capacity() * size_of::<u32>()
    }

    /// Reads the vector of the state with this number.
    pub(crate) fn unpack(&self, number: u32, slots: &mut Vec<u32>) {
        let words = self.vector(number);
        slots.clear();
        slots.extend(self.layout.places.iter().map(|place| place.get(words)));
    }

    /// Adds the state that differs in these slots from the state with the number `from` to those to look up.
    pub(crate) fn look_up(&self, from: u32, changes: &[Change], lookups: &mut Lookups) {
        let begin = lookups.words.len();
        lookups.words.extend_from_slice(self.vector(from));
        let words = &mut lookups.words[begin..];
        let fits = self.layout.apply(words, changes);
        lookups.hashes.push(fits.then(|| hash(words)));
    }

    /// The numbers of the states to look up, as far as they are stored.
    pub(crate) fn find(&self, lookups: &Lookups) -> impl Iterator<Item = Option<u32>> {
        self.read_ahead(lookups);
        let vectors = lookups.words.chunks_exact(self.layout.words);
        lookups
            .hashes
            .iter()
            .zip(vectors)
            .map(|(hash, words)| hash.and_then(|hash| self.index.find(hash, |number| same(self.vector(number), words))))
    }

    /// Adds the state that differs in these slots from the state with the number `from` to those to store.
    pub(crate) fn insert_later(&mut self, from: u32, changes: &[Change], lookups: &mut Lookups) {
        while let Some((slot, value)) = self.layout.misfit(changes) {
            self.insert(lookups);
            self.widen(slot as usize, value);
        }
        self.look_up(from, changes, lookups);
    }

    /// Stores those of the states that are new.
    pub(crate) fn insert(&mut self, lookups: &mut Lookups) {
        self.read_ahead(lookups);
        for (hash, words) in lookups.hashes.iter().flatten().zip(lookups.words.chunks_exact(self.layout.words)) {
            if self.index.find(*hash, |number| same(self.vector(number), words)).is_none() {
                self.add(*hash, words);
            }
        }
        lookups.truncate(0);
    }

    /// Reads the entries with which the searches begin, so that the processor fetches them from memory side by side.
    fn read_ahead(&self, lookups: &Lookups) {
        let entries = lookups.hashes.iter().flatten().map(|hash| self.index.entries[self.index.home(*hash)]);
        hint::black_box(entries.fold(0, |all, entry| all ^ entry));
    }

    fn add(&mut self, hash: u64, words: &[u64]) {
        self.index.add(hash, self.len);
        if self.words.len() + words.len() > self.words.capacity() {
            self.words.reserve_exact((self.words.len() / 4).max(64 * words.len()));
        }
        self.words.extend_from_slice(words);
        self.len += 1;
        if self.index.is_full(self.len) {
            self.build_index();
        }
    }

    fn vector(&self, number: u32) -> &[u64] {
        let begin = number as usize * self.layout.words;
        &self.words[begin..begin + self.layout.words]
    }

    /// Makes an index of all states, with room for more.
    fn build_index(&mut self) {
        let count = (2 * self.len as usize).next_power_of_two().max(64);
        self.index = Index::default();
        let mut index = Index { entries: vec![0; count], mask: (count - 1) as u32 };
        for number in 0..self.len {
            index.add(hash(self.vector(number)), number);
        }
        self.index = index;
    }

    /// Widens a slot so that a number fits, and repacks all states.
    #[cold]
    fn widen(&mut self, slot: usize, value: u32) {
        let width = |place: &Place| place.mask.count_ones();
        let mut widths: Vec<u32> = self.layout.places.iter().map(width).collect();
        widths[slot] = u32::BITS - value.leading_zeros();
        let old = mem::replace(&mut self.layout, Layout::new(&widths));
        let packed = mem::take(&mut self.words);
        self.words.reserve_exact(packed.len() / old.words * self.layout.words);
        let mut words = vec![0; self.layout.words];
        for vector in packed.chunks_exact(old.words) {
            words.fill(0);
            old.places.iter().zip(&self.layout.places).for_each(|(from, to)| to.set(&mut words, from.get(vector)));
            self.words.extend_from_slice(&words);
        }
        self.build_index();
    }
}

/// The numbers of the states, by the hashes of their words: a hash table with linear probing.
///
/// An entry is 0, or a number plus one; the bits that no number needs hold bits of the hash. So a lookup reads a single
/// cache line of the table, and hardly ever a vector other than the one it looks for.
#[derive(Debug, Default)]
struct Index {
    /// Their count is a power of two.
    entries: Vec<u32>,
    /// The bits of an entry that hold the number: one less than the count of entries.
    mask: u32,
}

impl Index {
    /// The place where the search for a hash begins. It depends on the hash's upper bits; an entry holds lower ones.
    #[inline]
    fn home(&self, hash: u64) -> usize {
        (hash >> u32::BITS >> self.mask.leading_zeros()) as usize
    }

    /// The number with this hash that is the `same`.
    #[inline]
    fn find(&self, hash: u64, same: impl Fn(u32) -> bool) -> Option<u32> {
        let mut place = self.home(hash);
        loop {
            let entry = self.entries[place];
            let number = (entry & self.mask).checked_sub(1)?;
            if (entry ^ hash as u32) & !self.mask == 0 && same(number) {
                return Some(number);
            }
            place = (place + 1) & self.mask as usize;
        }
    }

    /// Adds a number that is new.
    fn add(&mut self, hash: u64, number: u32) {
        let mut place = self.home(hash);
        while self.entries[place] != 0 {
            place = (place + 1) & self.mask as usize;
        }
        self.entries[place] = hash as u32 & !self.mask | (number + 1);
    }

    fn is_full(&self, count: u32) -> bool {
        u64::from(count) * 8 > self.entries.len() as u64 * 5
    }
}

/// States to look up or to store together.
#[derive(Debug, Default)]
pub(crate) struct Lookups {
    words: Vec<u64>,
    /// The hash of each state; none if it does not fit.
    hashes: Vec<Option<u64>>,
}

impl Lookups {
    pub(crate) fn len(&self) -> usize {
        self.hashes.len()
    }

    pub(crate) fn truncate(&mut self, len: usize) {
        self.words.truncate(self.words.len() / self.len().max(1) * len);
        self.hashes.truncate(len);
    }
}

/// Whether two vectors of a few words are equal. A call to `memcmp` would take longer.
#[inline]
fn same(words: &[u64], others: &[u64]) -> bool {
    words.iter().eq(others)
}

/// Mixes the words of a vector.
#[inline]
fn hash(words: &[u64]) -> u64 {
    let mix = |hash: u64, word: &u64| {
        let product = u128::from(hash.rotate_left(29) ^ word) * 0x9E37_79B9_7F4A_7C15;
        (product >> 64) as u64 ^ product as u64
    };
    words.iter().fold(0x2545_F491_4F6C_DD1D, mix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_keep_their_numbers_while_slots_grow_wider() {
        let vector = |number: u32| [number % 7, number / 7 % 101, 5, number / 707, number];
        let mut store = Store::new(&vector(0));
        let mut lookups = Lookups::default();
        let changes = |number: u32| (0..).zip(vector(number)).collect::<Vec<Change>>();
        for number in 0..100_000 {
            store.insert_later(number / 4, &changes(number), &mut lookups);
            store.insert_later(number / 5, &changes(number / 2), &mut lookups);
            if number % 3 == 0 {
                store.insert(&mut lookups);
            }
        }
        store.insert(&mut lookups);
        assert_eq!(store.len(), 100_000);
        let mut slots = Vec::new();
        for number in (0..100_000).rev() {
            store.unpack(number, &mut slots);
            assert_eq!(slots, vector(number));
            lookups.truncate(0);
            store.look_up(number, &changes(number / 2), &mut lookups);
            store.look_up(number, &[(2, 6)], &mut lookups);
            store.look_up(number, &[(2, 9)], &mut lookups);
            assert_eq!(store.find(&lookups).collect::<Vec<_>>(), [Some(number / 2), None, None]);
        }
    }
}
