//! The messages of all files of a bag, in the order of their times, in bounded memory.
//!
//! A file consists of units: a chunk, or about a megabyte of records or rows. The earliest time of each is known before
//! it is read. A unit is read when no message that comes before its earliest time is left, and its messages are sorted.
//! So what is in memory are the units whose times overlap. If these are too large, only the earliest messages of each
//! are kept, and the unit is read again when the others are due: the size of the bag and the disorder in it cost time,
//! but no memory.
//!
//! Messages of one time keep the order in which they were recorded: that of the files, and within a file its own.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::survey::{Head, Topic};

/// How many bytes of messages are in memory, besides one unit.
const MOST: usize = 1 << 26;

/// About how many bytes of records or rows are read together.
pub(super) const UNIT: u64 = 1 << 20;

/// A part of a file whose messages are read together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Unit {
    /// Where it begins and ends: positions in the file, or ids of rows.
    pub(super) start: i64,
    pub(super) end: i64,
    /// The earliest time of its messages, and the latest.
    pub(super) first_ns: i64,
    pub(super) last_ns: i64,
    /// The channels of its messages, if they are known.
    pub(super) channels: Option<Box<[u16]>>,
}

impl Unit {
    /// The part of a file from this place, without messages.
    pub(super) fn empty(start: i64) -> Self {
        Self { start, end: i64::MAX, first_ns: i64::MAX, last_ns: i64::MIN, channels: None }
    }

    /// Adds the time of a message.
    pub(super) fn note(&mut self, time_ns: i64) {
        self.first_ns = self.first_ns.min(time_ns);
        self.last_ns = self.last_ns.max(time_ns);
    }

    /// Whether no message has been added.
    pub(super) fn is_empty(&self) -> bool {
        self.first_ns > self.last_ns
    }
}

/// Where the messages of a file are.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// All units, in the order of the file.
    pub(super) units: Vec<Unit>,
    /// The topics by the numbers of their channels, in a file that has such.
    pub(super) topics: BTreeMap<u16, Topic>,
    /// What was found to be damaged or missing, in words. It is found again when the messages are read.
    pub(super) lost: Vec<String>,
    /// What does not fit together, in words. It is not found again.
    pub(super) unfit: Vec<String>,
    /// How many messages each channel has, if the file states it.
    pub(super) counts: Option<BTreeMap<u16, u64>>,
}

impl Plan {
    /// Whether each unit begins when the one before it has ended.
    pub(super) fn is_ascending(&self) -> bool {
        self.units.is_sorted_by(|a, b| a.last_ns <= b.first_ns)
    }
}

/// Where a message comes: its time, its unit, and its number among the wanted messages of the unit.
type MergePlace = (i64, usize, usize);

/// A message of a block.
#[derive(Clone, Copy, Debug)]
struct Entry {
    head: Head,
    number: usize,
    /// Where its bytes are.
    at: usize,
    length: usize,
}

/// The wanted messages of a unit, or the earliest of them, while they are returned.
#[derive(Debug)]
pub(super) struct Block {
    unit: usize,
    /// Memory to which the bytes of messages are appended.
    pub(super) bytes: Vec<u8>,
    entries: Vec<Entry>,
    /// How many of them have been returned.
    returned: usize,
    /// How many messages have been found in the unit.
    found: usize,
    /// If the unit is read again, the first message that is wanted: those before it have been returned already.
    from: Option<MergePlace>,
    /// The first message that has been left out: it, and all after it, are to be read again.
    rest: Option<MergePlace>,
}

impl Block {
    fn begin(unit: usize, from: Option<MergePlace>, (bytes, entries): (Vec<u8>, Vec<Entry>)) -> Self {
        Self { unit, bytes, entries, returned: 0, found: 0, from, rest: None }
    }

    /// Whether the unit has been read before.
    pub(super) fn is_again(&self) -> bool {
        self.from.is_some()
    }

    /// Where the next message of the unit comes, if it is to be kept. Must be called once for each wanted message.
    pub(super) fn place(&mut self, time_ns: i64) -> Option<usize> {
        let place = (time_ns, self.unit, self.found);
        self.found += 1;
        (self.from.is_none_or(|from| place >= from) && self.rest.is_none_or(|rest| place < rest)).then_some(place.2)
    }

    /// Adds a message that is to be kept. Its bytes are, or will be, in this place.
    pub(super) fn add(&mut self, head: Head, number: usize, at: usize, length: usize) {
        self.entries.push(Entry { head, number, at, length });
    }

    /// The number of messages so far.
    pub(super) fn count(&self) -> usize {
        self.entries.len()
    }

    /// Moves the bytes of the messages since there were this many.
    pub(super) fn shift(&mut self, count: usize, by: usize) {
        self.entries[count..].iter_mut().for_each(|entry| entry.at += by);
    }

    /// Whether there is more in it than may be kept, with these bytes besides its own.
    pub(super) fn is_full(&self, bytes: usize) -> bool {
        self.size() + bytes > MOST
    }

    /// Keeps the earliest of the messages that have been found so far.
    pub(super) fn shorten(&mut self) {
        self.sort();
        self.cut(MOST / 2);
    }

    fn size(&self) -> usize {
        self.bytes.len() + self.entries.len() * size_of::<Entry>()
    }

    fn sort(&mut self) {
        let key = |entry: &Entry| (entry.head.log_ns, entry.number);
        if !self.entries.is_sorted_by_key(key) {
            self.entries.sort_unstable_by_key(key);
        }
    }

    fn place_of(&self, entry: &Entry) -> MergePlace {
        (entry.head.log_ns, self.unit, entry.number)
    }

    /// Where the next message comes that is to be returned.
    fn next(&self) -> Option<MergePlace> {
        self.entries.get(self.returned).map(|entry| self.place_of(entry))
    }

    /// Keeps no more than the earliest messages of this size, and at least one.
    fn cut(&mut self, size: usize) {
        if self.size() <= size {
            return;
        }
        let mut kept = 0;
        let fits = |entry: &&Entry| {
            kept += entry.length + size_of::<Entry>();
            kept <= size
        };
        let left = &self.entries[self.returned..];
        let count = left.iter().take_while(fits).count().max(1).min(left.len());
        if count == self.entries.len() && left.iter().map(|entry| entry.length).sum::<usize>() == self.bytes.len() {
            return;
        }
        let mut bytes = Vec::new();
        let entries = left[..count].iter().map(|entry| {
            let at = bytes.len();
            bytes.extend_from_slice(&self.bytes[entry.at..entry.at + entry.length]);
            Entry { at, ..*entry }
        });
        let entries = entries.collect();
        self.rest = left.get(count).map(|first| self.place_of(first)).or(self.rest);
        (self.bytes, self.entries, self.returned) = (bytes, entries, 0);
    }
}

/// Puts blocks into the order of their next messages.
struct ByNext(Block);

impl ByNext {
    fn key(&self) -> Reverse<Option<MergePlace>> {
        Reverse(self.0.next())
    }
}

impl PartialEq for ByNext {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for ByNext {}

impl PartialOrd for ByNext {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ByNext {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

/// The messages of units in order.
#[derive(Default)]
pub(super) struct Merge {
    /// The units that are to be read, by where their next messages come at the earliest.
    /// Whether they have been read before.
    due: BinaryHeap<Reverse<(MergePlace, bool)>>,
    /// What has been read of units; none is empty.
    blocks: BinaryHeap<ByNext>,
    /// How large they are.
    size: usize,
    /// The block from which messages are returned, and the place before which they may be.
    current: Option<(Block, Option<MergePlace>)>,
    /// Memory to reuse for the next block.
    spare: (Vec<u8>, Vec<Entry>),
}

impl Merge {
    /// Adds a unit, by its number: in the order in which the units were recorded.
    pub(super) fn add(&mut self, number: usize, unit: &Unit) {
        self.due.push(Reverse(((unit.first_ns, number, 0), false)));
    }

    /// Reads the next message into `body`; none at the end. `load` reads the messages of a unit into a block.
    pub(super) fn next_into(&mut self, body: &mut Vec<u8>, mut load: impl FnMut(usize, &mut Block)) -> Option<Head> {
        loop {
            if let Some((block, limit)) = &mut self.current {
                if let Some(entry) = block.entries.get(block.returned)
                    && limit.is_none_or(|limit| block.place_of(entry) < limit)
                {
                    block.returned += 1;
                    body.clear();
                    body.extend_from_slice(&block.bytes[entry.at..entry.at + entry.length]);
                    return Some(entry.head);
                }
                self.put_back();
            }
            while let Some(Reverse((place, is_again))) = self.due.peek().copied()
                && self.blocks.peek().is_none_or(|block| Some(place) < block.0.next())
            {
                self.due.pop();
                let mut block = Block::begin(place.1, is_again.then_some(place), std::mem::take(&mut self.spare));
                load(place.1, &mut block);
                block.sort();
                self.keep(block);
            }
            let ByNext(block) = self.blocks.pop()?;
            self.size -= block.size();
            let limits = [self.blocks.peek().and_then(|block| block.0.next()), self.due.peek().map(|due| due.0.0)];
            self.current = Some((block, limits.into_iter().flatten().min()));
        }
    }

    /// Puts the current block back; if its messages have been returned, what has been left out of it.
    fn put_back(&mut self) {
        let Some((block, _)) = self.current.take() else { return };
        self.keep(block);
    }

    fn keep(&mut self, block: Block) {
        if block.next().is_some() {
            self.size += block.size();
            self.blocks.push(ByNext(block));
            if self.size > MOST {
                self.make_room();
            }
            return;
        }
        self.due.extend(block.rest.map(|rest| Reverse((rest, true))));
        let Block { mut bytes, mut entries, .. } = block;
        bytes.clear();
        entries.clear();
        self.spare = (bytes, entries);
    }

    /// Leaves out the latest messages of large blocks.
    fn make_room(&mut self) {
        let most = MOST / 2 / self.blocks.len();
        let mut blocks = std::mem::take(&mut self.blocks).into_vec();
        blocks.iter_mut().for_each(|ByNext(block)| block.cut(most));
        self.size = blocks.iter().map(|ByNext(block)| block.size()).sum();
        self.blocks = blocks.into();
    }
}
