//! The states found, each stored once in a few bytes, in the order in which they were found.
//!
//! A state is a vector of small numbers. Each slot of the vector is as wide as its largest number so far requires; for
//! a larger one, all states are repacked.

use std::ops::Range;
use std::{hint, mem};

/// A slot of a vector, and its new number.
pub(crate) type Assignment = (u32, u32);

/// The position of a slot's bits.
#[derive(Clone, Copy, Debug)]
struct BitField {
    word: usize,
    shift: u32,
    /// The largest number that fits: all bits are ones.
    mask: u64,
}

impl BitField {
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
    fields: Vec<BitField>,
    /// The number of words in a vector.
    words: usize,
    /// Which bit of the last word is the first that no slot has used.
    free: u32,
}

impl Layout {
    /// Slots of these widths in bits, one after the other; none extends over two words.
    fn new(widths: &[u32]) -> Self {
        let (mut word, mut shift) = (0, 0);
        let fields = widths.iter().map(|&width| {
            if shift + width > u64::BITS {
                (word, shift) = (word + 1, 0);
            }
            let begin = if width == 0 { 0 } else { shift };
            shift += width;
            BitField { word, shift: begin, mask: (1 << width) - 1 }
        });
        Self { fields: fields.collect(), words: word + 1, free: shift }
    }

    /// A bit field behind all slots, if so many bits are free there.
    fn reserve(&mut self, width: u32) -> Option<BitField> {
        let field = BitField { word: self.words - 1, shift: self.free, mask: (1 << width) - 1 };
        self.free += width;
        (self.free <= u64::BITS).then_some(field)
    }
}

/// All states found.
#[derive(Debug)]
pub(crate) struct Store {
    layout: Layout,
    /// How often a slot was widened.
    widenings: u32,
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
        layout.fields.iter().zip(first).for_each(|(field, value)| field.set(&mut words, *value));
        let mut store = Self { layout, widenings: 0, words, len: 1, index: Index::default() };
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
        slots.extend(self.layout.fields.iter().map(|field| field.get(words)));
    }

    /// Packs the state that differs in these slots from the state with the number `from`.
    ///
    /// # Errors
    /// A change with a number that is too large for its slot.
    pub(crate) fn pack(&self, from: u32, changes: &[Assignment], packed: &mut Packed) -> Result<(), Assignment> {
        let begin = packed.words.len();
        packed.words.extend_from_slice(self.vector(from));
        let words = &mut packed.words[begin..];
        for &(slot, value) in changes {
            let field = self.layout.fields[slot as usize];
            if u64::from(value) > field.mask {
                packed.words.truncate(begin);
                return Err((slot, value));
            }
            field.set(words, value);
        }
        packed.hashes.push(hash(words));
        Ok(())
    }

    /// Empties the list, which then takes states in the present layout.
    pub(crate) fn clear(&self, packed: &mut Packed) {
        packed.words.clear();
        packed.hashes.clear();
        (packed.width, packed.widenings) = (self.layout.words, self.widenings);
    }

    /// Whether the states were packed in the present layout.
    pub(crate) fn is_current(&self, packed: &Packed) -> bool {
        packed.widenings == self.widenings
    }

    /// The number of a packed state, if it is stored.
    #[inline]
    pub(crate) fn find(&self, packed: &Packed, index: usize) -> Option<u32> {
        let words = packed.vector(index);
        self.index.find(packed.hashes[index], |number| same(self.vector(number), words))
    }

    /// Stores those of the packed states that are new.
    pub(crate) fn insert(&mut self, packed: &Packed, range: Range<usize>) {
        for index in range {
            if index % AHEAD == 0 {
                self.read_ahead(packed, index);
            }
            if self.find(packed, index).is_none() {
                self.add(packed.hashes[index], packed.vector(index));
            }
        }
    }

    /// Reads the entries with which the next [`AHEAD`] searches begin, so that the processor fetches them from memory
    /// side by side.
    pub(crate) fn read_ahead(&self, packed: &Packed, begin: usize) {
        let hashes = packed.hashes[begin..].iter().take(AHEAD);
        hint::black_box(hashes.fold(0, |all, hash| all ^ self.index.entries[self.index.home(*hash)]));
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

    /// Widens a slot so that a number fits: it moves behind the others or, if there is no room there, all states are
    /// repacked.
    #[cold]
    pub(crate) fn widen(&mut self, (slot, value): Assignment) {
        let width = u32::BITS - value.leading_zeros();
        match self.layout.reserve(width) {
            Some(field) => self.move_slot(slot, field),
            None => self.repack(slot, width),
        }
        self.widenings += 1;
        self.build_index();
    }

    fn move_slot(&mut self, slot: u32, field: BitField) {
        let old = mem::replace(&mut self.layout.fields[slot as usize], field);
        for vector in self.words.chunks_exact_mut(self.layout.words) {
            let value = old.get(vector);
            old.set(vector, 0);
            field.set(vector, value);
        }
    }

    fn repack(&mut self, slot: u32, width: u32) {
        let mut widths: Vec<u32> = self.layout.fields.iter().map(|field| field.mask.count_ones()).collect();
        widths[slot as usize] = width;
        let old = mem::replace(&mut self.layout, Layout::new(&widths));
        let packed = mem::take(&mut self.words);
        self.words.reserve_exact(packed.len() / old.words * self.layout.words);
        let mut words = vec![0; self.layout.words];
        for vector in packed.chunks_exact(old.words) {
            words.fill(0);
            old.fields.iter().zip(&self.layout.fields).for_each(|(from, to)| to.set(&mut words, from.get(vector)));
            self.words.extend_from_slice(&words);
        }
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

    fn add(&mut self, hash: u64, number: u32) {
        let mut place = self.home(hash);
        while self.entries[place] != 0 {
            place = (place + 1) & self.mask as usize;
        }
        self.entries[place] = hash as u32 & !self.mask | (number + 1);
    }

    /// Whether more than five in eight entries are taken. The share is chosen, not measured: fuller tables have longer
    /// runs of entries, and this is usual for linear probing.
    fn is_full(&self, count: u32) -> bool {
        u64::from(count) * 8 > self.entries.len() as u64 * 5
    }
}

/// How many searches begin together: chosen, not measured. It must be larger than the number of cache lines that a
/// processor fetches at a time, and so small that they are still in its cache when the searches read them.
pub(crate) const AHEAD: usize = 64;

/// Packed states that may be new, with their hashes.
#[derive(Debug, Default)]
pub(crate) struct Packed {
    words: Vec<u64>,
    hashes: Vec<u64>,
    /// The number of words in a vector.
    width: usize,
    widenings: u32,
}

impl Packed {
    pub(crate) fn len(&self) -> usize {
        self.hashes.len()
    }

    pub(crate) fn truncate(&mut self, len: usize) {
        self.words.truncate(len * self.width);
        self.hashes.truncate(len);
    }

    /// Moves a state to an earlier place.
    #[inline]
    pub(crate) fn shift(&mut self, from: usize, to: usize) {
        self.hashes[to] = self.hashes[from];
        for word in 0..self.width {
            self.words[to * self.width + word] = self.words[from * self.width + word];
        }
    }

    fn vector(&self, index: usize) -> &[u64] {
        &self.words[index * self.width..][..self.width]
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
