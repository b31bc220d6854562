//! CDR, as ROS 2 encodes messages: version 1, big- or little-endian.

use std::collections::BTreeMap;
use std::sync::Arc;

use interfaces::ros::{Base, Count, TypeName};

use crate::layout::{Item, Layout};

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

/// Decodes the messages of a type: the wanted parts are stored, the rest is skipped.
#[derive(Clone, Debug)]
pub struct Decoder(Arc<Plan>);

/// The parts of a message, in order.
#[derive(Debug)]
struct Plan {
    /// How many fields the message has.
    fields: usize,
    steps: Vec<Step>,
}

#[derive(Debug)]
enum Step {
    /// Skips numbers of `size` bytes.
    Skip { size: usize, count: usize },
    /// A field, with its index if it is wanted.
    Field { wanted: Option<usize>, part: Part, count: Count },
}

/// The type of one item.
#[derive(Debug)]
enum Part {
    Plain(Base),
    Message(Arc<Plan>),
}

impl Decoder {
    /// A decoder for the wanted parts of messages of that type.
    #[must_use]
    pub fn new(layout: &Layout, want: &Want) -> Self {
        Self(plan(layout, want, &mut BTreeMap::new()))
    }

    /// Decodes a message.
    ///
    /// # Errors
    /// [`Mismatch`] if the bytes are not a message of that type, even in the unwanted parts.
    pub fn decode(&self, bytes: &[u8]) -> Result<Value, Mismatch> {
        let mut value = Value::Passed;
        self.decode_into(bytes, &mut value).map(|()| value)
    }

    /// The same, but reuses the memory of `value` if it has a message of that type.
    pub(crate) fn decode_into(&self, bytes: &[u8], value: &mut Value) -> Result<(), Mismatch> {
        let [0, order @ (0 | 1), _, _, body @ ..] = bytes else { return Err(Mismatch::Encoding) };
        let mut cdr = Cdr { bytes: body, at: 0, is_big: *order == 0 };
        cdr.message(&self.0, Some(value))?;
        // Some writers pad the message to a multiple of eight bytes.
        if cdr.bytes.len() - cdr.at < 8 { Ok(()) } else { Err(Mismatch::Long) }
    }
}

/// The plan for a message. A type that is decoded or skipped as a whole has one plan, wherever it is used.
fn plan<'l>(layout: &'l Layout, want: &Want, made: &mut BTreeMap<(&'l TypeName, bool), Arc<Plan>>) -> Arc<Plan> {
    let key = match want {
        Want::Nothing => Some((&layout.name, false)),
        Want::All => Some((&layout.name, true)),
        Want::Fields(_) => None,
    };
    if let Some(plan) = key.and_then(|key| made.get(&key)) {
        return Arc::clone(plan);
    }
    let mut new = Plan { fields: layout.fields.len(), steps: Vec::new() };
    // In IDL, an empty struct gets a dummy member of one byte.
    if layout.fields.is_empty() {
        new.skip(1, 1);
    }
    for (index, slot) in layout.fields.iter().enumerate() {
        let want = want.field(index);
        let wanted = (*want != Want::Nothing).then_some(index);
        let part = match &slot.item {
            Item::Plain(base) => Part::Plain(base.clone()),
            Item::Message(layout) => Part::Message(plan(layout, want, made)),
        };
        match (part.numbers(), slot.count, wanted) {
            (Some((size, count)), Count::One, None) => new.skip(size, count),
            (Some((size, count)), Count::Exactly(times), None) => new.skip(size, count.saturating_mul(times)),
            (_, count, wanted) => new.steps.push(Step::Field { wanted, part, count }),
        }
    }
    let new = Arc::new(new);
    made.extend(key.map(|key| (key, Arc::clone(&new))));
    new
}

impl Plan {
    /// Adds numbers to skip, together with those before them if they have the same size.
    fn skip(&mut self, size: usize, count: usize) {
        match self.steps.last_mut() {
            Some(Step::Skip { size: before, count: so_far }) if *before == size => {
                *so_far = so_far.saturating_add(count);
            }
            _ => self.steps.push(Step::Skip { size, count }),
        }
    }
}

impl Part {
    /// The size and the count of its numbers, if it has nothing but numbers of one size to skip.
    fn numbers(&self) -> Option<(usize, usize)> {
        match self {
            Self::Plain(base) => size(base).map(|size| (size, 1)),
            Self::Message(plan) => match plan.steps.as_slice() {
                [Step::Skip { size, count }] => Some((*size, *count)),
                _ => None,
            },
        }
    }
}

impl Want {
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

    /// Moves on to the next multiple of a power of two.
    fn align(&mut self, size: usize) {
        self.at = self.at.saturating_add(size - 1) & !(size - 1);
    }

    fn aligned<const N: usize>(&mut self) -> Result<&'b [u8; N], Mismatch> {
        self.align(N);
        self.take(N)?.try_into().map_err(|_| Mismatch::Short)
    }

    fn message(&mut self, plan: &Plan, value: Option<&mut Value>) -> Result<(), Mismatch> {
        let fields = value.map_or(&mut [][..], |value| value.fields(plan.fields));
        plan.steps.iter().try_for_each(|step| match step {
            Step::Skip { size, count } => self.skip(*size, *count),
            Step::Field { wanted, part, count } => {
                self.field(part, *count, wanted.and_then(|index| fields.get_mut(index)))
            }
        })
    }

    fn field(&mut self, part: &Part, count: Count, value: Option<&mut Value>) -> Result<(), Mismatch> {
        let count = match count {
            Count::One => return self.item(part, value),
            Count::Exactly(count) => count,
            Count::UpTo(bound) => self.length(bound)?,
            Count::Any => self.length(usize::MAX)?,
        };
        // Each item has at least one byte, so a wrong length is detected before anything is allocated.
        if count > self.bytes.len().saturating_sub(self.at) {
            return Err(Mismatch::Short);
        }
        match (value, part.numbers()) {
            (Some(value), _) => value.items(count).iter_mut().try_for_each(|value| self.item(part, Some(value))),
            (None, Some((size, each))) => self.skip(size, count.saturating_mul(each)),
            (None, None) => (0..count).try_for_each(|_| self.item(part, None)),
        }
    }

    /// Skips numbers.
    fn skip(&mut self, size: usize, count: usize) -> Result<(), Mismatch> {
        if count > 0 {
            self.align(size);
            self.take(count.saturating_mul(size))?;
        }
        Ok(())
    }

    fn length(&mut self, bound: usize) -> Result<usize, Mismatch> {
        let length = number!(self, u32) as usize;
        if length > bound { Err(Mismatch::Bound) } else { Ok(length) }
    }

    fn item(&mut self, part: &Part, value: Option<&mut Value>) -> Result<(), Mismatch> {
        match part {
            Part::Message(plan) => self.message(plan, value),
            Part::Plain(base) => self.plain(base, value),
        }
    }

    fn plain(&mut self, base: &Base, value: Option<&mut Value>) -> Result<(), Mismatch> {
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
                if let Some(value) = value {
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
        if let Some(value) = value {
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
