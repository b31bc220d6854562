//! The entries of blackboards in a reply. Not all are kept, since blackboards may contain maps, images and paths.

use rmpv::Value;

/// The maximum length of a value that is kept, in bytes. Of a longer value, only the length is kept.
const MOST_OF_VALUE: usize = 4 << 10;
/// The maximum size of all entries of a reply that are kept, in bytes, and the overhead of each entry.
const MOST_KEPT: usize = 1 << 20;
const PER_ENTRY: usize = 64;
/// The maximum nesting depth of values.
const MOST_DEPTH: usize = 64;

/// The entries of blackboards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blackboards {
    /// The entries, by the names of the blackboards.
    pub boards: Vec<(String, Vec<(String, BoardValue)>)>,
    /// The number of entries that are left out because there are too many.
    pub left_out: u64,
}

/// The value of an entry.
#[derive(Clone, Debug, PartialEq)]
pub enum BoardValue {
    /// The value.
    Whole(Value),
    /// The length of a value that is too long to be kept, in bytes.
    Long(usize),
}

impl Blackboards {
    /// Reads a reply: a map of maps, or nil. None if it is not MessagePack, or is nested too deep.
    pub(crate) fn read(reply: &[u8]) -> Option<Self> {
        let (mut rest, mut kept, mut all) = (reply, 0, Self::default());
        // If the reply is not a map, the program has none of the requested blackboards.
        let Some(count) = map(&mut rest) else { return extent(reply).map(|_| all) };
        for _ in 0..count {
            let name = name(take(&mut rest)?)?;
            kept += name.len() + PER_ENTRY;
            let (is_left_out, mut entries) = (kept > MOST_KEPT, Vec::new());
            let Some(count) = map(&mut rest) else {
                take(&mut rest)?;
                continue;
            };
            for _ in 0..count {
                let (key, value) = (take(&mut rest)?, take(&mut rest)?);
                let is_long = value.len() > MOST_OF_VALUE;
                let size = key.len() + PER_ENTRY + if is_long { 0 } else { value.len() };
                if is_left_out || kept + size > MOST_KEPT {
                    all.left_out += 1;
                    continue;
                }
                kept += size;
                let value = if is_long { BoardValue::Long(value.len()) } else { BoardValue::Whole(decoded(value)?) };
                entries.push((self::name(key)?, value));
            }
            if !is_left_out {
                all.boards.push((name, entries));
            }
        }
        Some(all)
    }
}

fn decoded(mut bytes: &[u8]) -> Option<Value> {
    rmpv::decode::read_value_with_max_depth(&mut bytes, MOST_DEPTH).ok()
}

/// A name. A value that is not text is formatted as text.
fn name(bytes: &[u8]) -> Option<String> {
    let value = decoded(bytes.get(..bytes.len().min(MOST_KEPT))?)?;
    Some(value.as_str().map_or_else(|| value.to_string(), str::to_owned))
}

/// The number of entries of the map at the beginning of the bytes, if there is one.
fn map(rest: &mut &[u8]) -> Option<u64> {
    let (&marker, after) = rest.split_first()?;
    let (count, after) = match marker {
        0x80..=0x8f => (u64::from(marker & 0x0f), after),
        0xde => number::<2>(after)?,
        0xdf => number::<4>(after)?,
        _ => return None,
    };
    *rest = after;
    Some(count)
}

/// The bytes of the value at the beginning, which are removed from `rest`.
fn take<'b>(rest: &mut &'b [u8]) -> Option<&'b [u8]> {
    let (value, after) = rest.split_at_checked(extent(rest)?)?;
    *rest = after;
    Some(value)
}

/// The number of bytes of the value at the beginning, including nested values. The value is not decoded: a list of a
/// million numbers would take thirty times as much memory.
fn extent(bytes: &[u8]) -> Option<usize> {
    let (mut rest, mut values) = (bytes, 1_u64);
    while values > 0 {
        values -= 1;
        let (&marker, after) = rest.split_first()?;
        let items = |of: (u64, _)| (0, of.0, of.1);
        let pairs = |of: (u64, _)| (0, of.0 * 2, of.1);
        let bytes = |of: (u64, _)| (of.0, 0, of.1);
        let (length, more, after) = match marker {
            0x00..=0x7f | 0xc0 | 0xc2 | 0xc3 | 0xe0..=0xff => (0, 0, after),
            0x80..=0x8f => (0, u64::from(marker & 0x0f) * 2, after),
            0x90..=0x9f => (0, u64::from(marker & 0x0f), after),
            0xa0..=0xbf => (u64::from(marker & 0x1f), 0, after),
            0xc4 | 0xd9 => bytes(number::<1>(after)?),
            0xc5 | 0xda => bytes(number::<2>(after)?),
            0xc6 | 0xdb => bytes(number::<4>(after)?),
            // A type precedes the bytes of an extension.
            0xc7 => number::<1>(after).map(|(length, after)| (length + 1, 0, after))?,
            0xc8 => number::<2>(after).map(|(length, after)| (length + 1, 0, after))?,
            0xc9 => number::<4>(after).map(|(length, after)| (length + 1, 0, after))?,
            0xcc | 0xd0 => (1, 0, after),
            0xcd | 0xd1 | 0xd4 => (2, 0, after),
            0xd5 => (3, 0, after),
            0xca | 0xce | 0xd2 => (4, 0, after),
            0xd6 => (5, 0, after),
            0xcb | 0xcf | 0xd3 => (8, 0, after),
            0xd7 => (9, 0, after),
            0xd8 => (17, 0, after),
            0xdc => items(number::<2>(after)?),
            0xdd => items(number::<4>(after)?),
            0xde => pairs(number::<2>(after)?),
            0xdf => pairs(number::<4>(after)?),
            0xc1 => return None,
        };
        rest = after.get(usize::try_from(length).ok()?..)?;
        // Each value takes at least one byte.
        values = values.saturating_add(more);
        if values > rest.len() as u64 {
            return None;
        }
    }
    Some(bytes.len() - rest.len())
}

/// A big-endian number of `BYTES` bytes, and the bytes after it.
fn number<const BYTES: usize>(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (number, rest) = bytes.split_first_chunk::<BYTES>()?;
    Some((number.iter().fold(0, |number, byte| number << 8 | u64::from(*byte)), rest))
}
