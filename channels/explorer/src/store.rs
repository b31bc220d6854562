//! The states found, each stored once in a few bytes, in the order in which they were found.
//!
//! A state is a vector of small numbers. Each slot of the vector is as wide as its largest number so far requires; for
//! a larger one, all states are repacked.

use std::mem;

use hashbrown::HashTable;

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

    fn apply(&self, words: &mut [u64], changes: &[Change]) {
        changes.iter().for_each(|(slot, value)| self.places[*slot as usize].set(words, *value));
    }
}

/// All states found.
#[derive(Debug)]
pub(crate) struct Store {
    layout: Layout,
    /// The packed vectors, one after the other.
    words: Vec<u64>,
    /// The numbers of the states, by the hash of their words.
    numbers: HashTable<u32>,
}

/// A state that was read from the store, packed and unpacked.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unpacked {
    slots: Vec<u32>,
    words: Vec<u64>,
    /// Working memory for its successors.
    changed: Vec<u64>,
}

impl Unpacked {
    /// The vector of numbers.
    pub(crate) fn slots(&self) -> &[u32] {
        &self.slots
    }
}

impl Store {
    /// A store with one vector.
    pub(crate) fn new(first: &[u32]) -> Self {
        let width = |value: &u32| u32::BITS - value.leading_zeros();
        let layout = Layout::new(&first.iter().map(width).collect::<Vec<_>>());
        let mut words = vec![0; layout.words];
        layout.places.iter().zip(first).for_each(|(place, value)| place.set(&mut words, *value));
        let mut store = Self { layout, words: Vec::new(), numbers: HashTable::new() };
        store.add(hash(&words), &words);
        store
    }

    pub(crate) fn len(&self) -> u32 {
        self.numbers.len() as u32
    }

    /// How much memory it uses.
    pub(crate) fn bytes(&self) -> usize {
        self.words.capacity() * size_of::<u64>() + self.numbers.allocation_size()
    }

    /// Reads the state with this number.
    pub(crate) fn unpack(&self, number: u32, state: &mut Unpacked) {
        let words = self.vector(number);
        state.words.clear();
        state.words.extend_from_slice(words);
        state.slots.clear();
        state.slots.extend(self.layout.places.iter().map(|place| place.get(words)));
    }

    /// The number of the state that differs from `from` in these slots, if it is stored.
    pub(crate) fn find(&self, from: &mut Unpacked, changes: &[Change]) -> Option<u32> {
        if self.layout.misfit(changes).is_some() {
            return None;
        }
        let Unpacked { words, changed, .. } = from;
        changed.clear();
        changed.extend_from_slice(words);
        self.layout.apply(changed, changes);
        self.numbers.find(hash(changed), |number| same(self.vector(*number), changed)).copied()
    }

    /// Stores the state that differs in these slots from the state with the number `from`, if it is new.
    pub(crate) fn insert(&mut self, from: u32, changes: &[Change], changed: &mut Vec<u64>) {
        while let Some((slot, value)) = self.layout.misfit(changes) {
            self.widen(slot as usize, value);
        }
        changed.clear();
        changed.extend_from_slice(self.vector(from));
        self.layout.apply(changed, changes);
        let hash = hash(changed);
        if self.numbers.find(hash, |number| same(self.vector(*number), changed)).is_none() {
            self.add(hash, changed);
        }
    }

    fn vector(&self, number: u32) -> &[u64] {
        vector(&self.words, self.layout.words, number)
    }

    fn add(&mut self, hash: u64, words: &[u64]) {
        let number = self.len();
        if self.words.len() + words.len() > self.words.capacity() {
            self.words.reserve_exact((self.words.len() / 4).max(64 * words.len()));
        }
        self.words.extend_from_slice(words);
        let (all, width) = (&self.words, self.layout.words);
        self.numbers.insert_unique(hash, number, |number| self::hash(vector(all, width, *number)));
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
        let count = self.len();
        self.numbers.clear();
        for number in 0..count {
            let (all, width) = (&self.words, self.layout.words);
            let hash = |number: &u32| hash(vector(all, width, *number));
            self.numbers.insert_unique(hash(&number), number, hash);
        }
    }
}

fn vector(words: &[u64], width: usize, number: u32) -> &[u64] {
    let begin = number as usize * width;
    &words[begin..begin + width]
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
        let mut words = Vec::new();
        let changes = |number: u32| (0..).zip(vector(number)).collect::<Vec<Change>>();
        for number in 0..100_000 {
            store.insert(number / 2, &changes(number), &mut words);
            store.insert(number / 3, &changes(number / 2), &mut words);
        }
        assert_eq!(store.len(), 100_000);
        let mut state = Unpacked::default();
        for number in (0..100_000).rev() {
            store.unpack(number, &mut state);
            assert_eq!(state.slots(), vector(number));
            assert_eq!(store.find(&mut state, &changes(number / 2)), Some(number / 2));
            assert_eq!(store.find(&mut state, &[(2, 6)]), None);
            assert_eq!(store.find(&mut state, &[(2, 9)]), None, "it does not fit");
        }
    }
}
