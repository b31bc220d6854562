//! CDR, as ROS 2 encodes messages: version 1, big- or little-endian.

use interfaces::ros::{Base, Count};

use crate::layout::{Item, Layout, Slot};

/// A decoded value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A value that was not wanted.
    Passed,
    /// A Boolean.
    Bool(bool),
    /// An integer of up to 64 bits.
    Int(i128),
    /// A floating-point number of 64 or 32 bits.
    Real(f64),
    /// A string. Invalid UTF-8 or UTF-16 in it is replaced.
    Text(String),
    /// The items of an array.
    List(Vec<Self>),
    /// The fields of a message, in the order of its layout.
    Message(Vec<Self>),
}

/// Which parts of a value are wanted. The rest is skipped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Want {
    /// Nothing.
    #[default]
    Nothing,
    /// All of it.
    All,
    /// These parts of each field of the message, or of the messages in the array.
    Fields(Vec<Want>),
}

/// Why bytes are not a message of that type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum Mismatch {
    /// The bytes end too early.
    #[error("they end before their definition does")]
    Short,
    /// There are bytes left.
    #[error("they are longer than their definition")]
    Long,
    /// A Boolean is neither 0 nor 1.
    #[error("they have a Boolean that is neither true nor false")]
    Bool,
    /// An array or a string has more items than its definition allows.
    #[error("they have more items than their definition allows")]
    Bound,
    /// The bytes have another encoding.
    #[error("they are not in CDR version 1 (XCDR2 and parameter lists are not supported)")]
    Encoding,
}

/// Decodes the wanted parts of a message.
///
/// # Errors
/// [`Mismatch`] if the bytes are not a message of that type, even in the unwanted parts.
pub fn decode(bytes: &[u8], layout: &Layout, want: &Want) -> Result<Value, Mismatch> {
    let mut value = Value::Passed;
    decode_into(bytes, layout, want, &mut value).map(|()| value)
}

/// The same, but reuses the memory of `value` if it has a message of that type.
pub(crate) fn decode_into(bytes: &[u8], layout: &Layout, want: &Want, value: &mut Value) -> Result<(), Mismatch> {
    let [0, order @ (0 | 1), _, _, body @ ..] = bytes else { return Err(Mismatch::Encoding) };
    let mut cdr = Cdr { bytes: body, at: 0, is_big: *order == 0 };
    cdr.message(layout, want.of(value))?;
    // Some writers pad the message to a multiple of eight bytes.
    if cdr.bytes.len() - cdr.at < 8 { Ok(()) } else { Err(Mismatch::Long) }
}

/// The wanted parts of a value, and where they go; none if the value is skipped.
type Place<'p> = Option<(&'p Want, &'p mut Value)>;

impl Want {
    fn of<'p>(&'p self, value: &'p mut Value) -> Place<'p> {
        if *self == Self::Nothing { None } else { Some((self, value)) }
    }

    /// The wanted parts of a field of the message.
    fn field(&self, index: usize) -> &Self {
        match self {
            Self::Fields(wants) => &wants[index],
            whole => whole,
        }
    }
}

impl Value {
    /// Turns this into a message with `count` fields.
    fn fields(&mut self, count: usize) -> &mut [Self] {
        if !matches!(self, Self::Message(fields) if fields.len() == count) {
            *self = Self::Message(vec![Self::Passed; count]);
        }
        let Self::Message(fields) = self else { return &mut [] };
        fields
    }

    /// Turns this into an array with `count` items.
    fn items(&mut self, count: usize) -> &mut [Self] {
        if !matches!(self, Self::List(_)) {
            *self = Self::List(Vec::new());
        }
        let Self::List(items) = self else { return &mut [] };
        items.resize(count, Self::Passed);
        items
    }

    fn set_text(&mut self, text: &str) {
        match self {
            Self::Text(before) => {
                before.clear();
                before.push_str(text);
            }
            other => *other = Self::Text(text.to_owned()),
        }
    }
}

struct Cdr<'b> {
    bytes: &'b [u8],
    at: usize,
    is_big: bool,
}

/// Reads a number of that type.
macro_rules! number {
    ($cdr:expr, $type:ty) => {{
        let bytes = *$cdr.aligned::<{ size_of::<$type>() }>()?;
        if $cdr.is_big { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) }
    }};
}

impl<'b> Cdr<'b> {
    fn take(&mut self, count: usize) -> Result<&'b [u8], Mismatch> {
        let taken = self.at.checked_add(count).and_then(|end| self.bytes.get(self.at..end)).ok_or(Mismatch::Short)?;
        self.at += count;
        Ok(taken)
    }

    fn align(&mut self, size: usize) {
        self.at = self.at.next_multiple_of(size);
    }

    fn aligned<const N: usize>(&mut self) -> Result<&'b [u8; N], Mismatch> {
        self.align(N);
        self.take(N)?.try_into().map_err(|_| Mismatch::Short)
    }

    fn message(&mut self, layout: &Layout, place: Place<'_>) -> Result<(), Mismatch> {
        // In IDL, an empty struct gets a dummy member of one byte.
        if layout.fields.is_empty() {
            self.take(1)?;
        }
        let Some((want, value)) = place else {
            return layout.fields.iter().try_for_each(|slot| self.slot(slot, None));
        };
        let mut fields = layout.fields.iter().zip(value.fields(layout.fields.len())).enumerate();
        fields.try_for_each(|(index, (slot, value))| self.slot(slot, want.field(index).of(value)))
    }

    fn slot(&mut self, slot: &Slot, place: Place<'_>) -> Result<(), Mismatch> {
        let count = match slot.count {
            Count::One if place.is_some() => return self.item(&slot.item, place),
            Count::One => return self.pass(&slot.item, 1),
            Count::Exactly(count) => count,
            Count::UpTo(bound) => self.length(bound)?,
            Count::Any => self.length(usize::MAX)?,
        };
        // Each item has at least one byte, so a wrong length is detected before anything is allocated.
        if count > self.bytes.len().saturating_sub(self.at) {
            return Err(Mismatch::Short);
        }
        if let Some((want, value)) = place {
            return value.items(count).iter_mut().try_for_each(|value| self.item(&slot.item, want.of(value)));
        }
        self.pass(&slot.item, count)
    }

    /// Passes items.
    fn pass(&mut self, item: &Item, count: usize) -> Result<(), Mismatch> {
        let size = if let Item::Plain(base) = item { size(base) } else { None };
        match size {
            Some(size) if count > 0 => {
                self.align(size);
                self.take(count.checked_mul(size).ok_or(Mismatch::Short)?).map(drop)
            }
            _ => (0..count).try_for_each(|_| self.item(item, None)),
        }
    }

    fn length(&mut self, bound: usize) -> Result<usize, Mismatch> {
        let length = number!(self, u32) as usize;
        if length > bound { Err(Mismatch::Bound) } else { Ok(length) }
    }

    fn item(&mut self, item: &Item, place: Place<'_>) -> Result<(), Mismatch> {
        match item {
            Item::Message(layout) => self.message(layout, place),
            Item::Plain(base) => self.plain(base, place.map(|(_, value)| value)),
        }
    }

    fn plain(&mut self, base: &Base, place: Option<&mut Value>) -> Result<(), Mismatch> {
        let found = match base {
            Base::Bool => match self.take(1)?[0] {
                byte @ (0 | 1) => Value::Bool(byte == 1),
                _ => return Err(Mismatch::Bool),
            },
            Base::Byte | Base::Char | Base::Uint8 => Value::Int(self.take(1)?[0].into()),
            Base::Int8 => Value::Int(number!(self, i8).into()),
            Base::Int16 => Value::Int(number!(self, i16).into()),
            Base::Uint16 => Value::Int(number!(self, u16).into()),
            Base::Int32 => Value::Int(number!(self, i32).into()),
            Base::Uint32 => Value::Int(number!(self, u32).into()),
            Base::Int64 => Value::Int(number!(self, i64).into()),
            Base::Uint64 => Value::Int(number!(self, u64).into()),
            Base::Float32 => Value::Real(number!(self, f32).into()),
            Base::Float64 => Value::Real(number!(self, f64)),
            Base::String(bound) => {
                // The length includes a terminating zero. For an empty string, some writers leave out the zero and
                // write the length 0.
                let length = self.length(bound.map_or(usize::MAX, |bound| bound.saturating_add(1)))?;
                let text = self.take(length)?;
                if let Some(value) = place {
                    value.set_text(&String::from_utf8_lossy(text.strip_suffix(&[0]).unwrap_or(text)));
                }
                return Ok(());
            }
            Base::WString(bound) => {
                // ROS gives each unit of UTF-16 four bytes.
                let length = self.length(bound.unwrap_or(usize::MAX))?;
                if length > self.bytes.len().saturating_sub(self.at) {
                    return Err(Mismatch::Short);
                }
                let units = (0..length).map(|_| Ok(number!(self, u32) as u16)).collect::<Result<Vec<u16>, _>>()?;
                Value::Text(String::from_utf16_lossy(&units))
            }
            Base::Message(_) => Value::Passed,
        };
        if let Some(value) = place {
            *value = found;
        }
        Ok(())
    }
}

/// The size and the alignment of an item in bytes; none if it has no fixed size.
fn size(base: &Base) -> Option<usize> {
    match base {
        Base::Byte | Base::Char | Base::Int8 | Base::Uint8 => Some(1),
        Base::Int16 | Base::Uint16 => Some(2),
        Base::Int32 | Base::Uint32 | Base::Float32 => Some(4),
        Base::Int64 | Base::Uint64 | Base::Float64 => Some(8),
        Base::Bool | Base::String(_) | Base::WString(_) | Base::Message(_) => None,
    }
}
