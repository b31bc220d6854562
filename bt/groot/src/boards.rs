//! The entries of blackboards in a reply, as far as they are kept: a program may have maps, images and paths there.

use rmpv::Value;

/// The most bytes of a value that are kept; of a longer one, only its length is.
const MOST_OF_VALUE: usize = 4 << 10;
/// The most bytes of all entries of a reply that are kept, each with what it takes besides.
const MOST_KEPT: usize = 1 << 20;
const PER_ENTRY: usize = 64;
/// How deep values may go.
const MOST_DEPTH: usize = 64;

/// The entries of blackboards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blackboards {
    /// By the name of the blackboard.
    pub boards: Vec<(String, Vec<(String, BoardValue)>)>,
    /// How many entries are left out, because there are too many.
    pub left_out: u64,
}

/// The value of an entry.
#[derive(Clone, Debug, PartialEq)]
pub enum BoardValue {
    /// The value.
    Whole(Value),
    /// Its length in bytes: it is too long to be kept.
    Long(usize),
}

impl Blackboards {
    /// Those in a reply: a map of maps, or nil. None if it is no MessagePack, or its values are too deep.
    pub(crate) fn read(reply: &[u8]) -> Option<Self> {
        let (mut rest, mut kept, mut all) = (reply, 0, Self::default());
        // Without a map, none of the blackboards is known.
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

/// A name, which is a text; what else it is, is written as one.
fn name(bytes: &[u8]) -> Option<String> {
    let value = decoded(bytes.get(..bytes.len().min(MOST_KEPT))?)?;
    Some(value.as_str().map_or_else(|| value.to_string(), str::to_owned))
}

/// The number of entries of the map that begins here, if one does.
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

/// The bytes of the value that begins here.
fn take<'b>(rest: &mut &'b [u8]) -> Option<&'b [u8]> {
    let (value, after) = rest.split_at_checked(extent(rest)?)?;
    *rest = after;
    Some(value)
}

/// How many bytes the value that begins here has, with all that is in it. It is not read: a list of a million numbers
/// would take thirty times as much memory.
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
            // Their types come before their bytes.
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
        // Each takes at least a byte.
        values = values.saturating_add(more);
        if values > rest.len() as u64 {
            return None;
        }
    }
    Some(bytes.len() - rest.len())
}

/// A number of so many bytes, the most significant first, and what follows.
fn number<const BYTES: usize>(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (number, rest) = bytes.split_first_chunk::<BYTES>()?;
    Some((number.iter().fold(0, |number, byte| number << 8 | u64::from(*byte)), rest))
}
