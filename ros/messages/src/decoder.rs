//! Decodes messages: the wanted parts are stored, the rest is skipped.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::definition::{Base, Count, Primitive, Type, TypeName};
use crate::layout::Layout;
use crate::reader::CdrReader;
use crate::rust::RosType as _;
use crate::value::{Mismatch, Value, WideWidth};

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

impl Want {
    /// The wanted parts of a field of the message.
    fn field(&self, index: usize) -> &Self {
        match self {
            Self::Fields(wants) => &wants[index],
            whole => whole,
        }
    }
}

/// Decodes the messages of a type: the wanted parts are stored, the rest is skipped.
///
/// How wide strings are encoded [depends on the program](WideWidth) that wrote a message. The width is the one with
/// which the bytes are a message of the type. If they are with both, it is that of the program; if this is unknown, it
/// is the one with which no character is 0; if this does not decide, and the wanted parts differ, they are no message.
#[derive(Clone, Debug)]
pub struct Decoder {
    plan: Arc<Plan>,
    /// Whether messages have wide strings.
    is_wide: bool,
    width: Option<WideWidth>,
}

impl Decoder {
    /// A decoder for the wanted parts of messages of that type.
    #[must_use]
    pub fn new(layout: &Layout, want: &Want) -> Self {
        Self { plan: plan(layout, want, &mut BTreeMap::new()), is_wide: layout.has_wide_strings(), width: None }
    }

    /// The same for messages of a program whose wide strings have this width; `None` if it is unknown.
    #[must_use]
    pub fn with_width(self, width: Option<WideWidth>) -> Self {
        Self { width, ..self }
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
    ///
    /// # Errors
    /// As [`decode`](Self::decode); `value` may then have parts of the message.
    pub fn decode_into(&self, bytes: &[u8], value: &mut Value) -> Result<(), Mismatch> {
        let likely = self.width.unwrap_or_default();
        let found = self.decode_with(likely, bytes, value);
        if !self.is_wide || found.is_ok() && self.width.is_some() {
            return found.map(drop);
        }
        let other = if likely == WideWidth::Four { WideWidth::Two } else { WideWidth::Four };
        let mut second = Value::Passed;
        match (found, self.decode_with(other, bytes, &mut second)) {
            (found, Err(_)) => found.map(drop),
            (Ok(_), Ok(_)) if value.is_same(&second) => Ok(()),
            (Ok(false), Ok(true)) => Ok(()),
            (Ok(true), Ok(false)) | (Err(_), Ok(_)) => {
                *value = second;
                Ok(())
            }
            (Ok(_), Ok(_)) => Err(Mismatch::Wide),
        }
    }

    /// Returns whether a wide string has a zero.
    fn decode_with(&self, width: WideWidth, bytes: &[u8], value: &mut Value) -> Result<bool, Mismatch> {
        let mut cdr = CdrReader::new(bytes)?;
        self.plan.read(&mut cdr, width, Some(value))?;
        // Some writers pad the message to a multiple of eight bytes.
        if cdr.left() < 8 { Ok(cdr.has_wide_zero) } else { Err(Mismatch::Long) }
    }
}

/// The parts of a message, in order.
#[derive(Debug)]
struct Plan {
    /// How many fields the message has.
    fields: usize,
    steps: Vec<DecodingStep>,
}

#[derive(Debug)]
enum DecodingStep {
    /// Skips numbers of `size` bytes.
    Skip { size: usize, count: usize },
    /// A field, with its index if it is wanted.
    Field { wanted: Option<usize>, kind: Type<Arc<Plan>> },
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
    // Unwanted numbers are skipped at once, even through nested messages: a message of which little is wanted takes few
    // steps. An item with strings or sequences has no fixed size, and is walked through.
    for (index, field) in layout.fields.iter().enumerate() {
        let want = want.field(index);
        let wanted = (*want != Want::Nothing).then_some(index);
        let base = match &field.kind.base {
            Base::Primitive(primitive) => Base::Primitive(*primitive),
            Base::Message(layout) => Base::Message(plan(layout, want, made)),
        };
        match (numbers(&base), field.kind.count, wanted) {
            (Some((size, count)), Count::One, None) => new.skip(size, count),
            (Some((size, count)), Count::Exactly(times), None) => new.skip(size, count.saturating_mul(times)),
            (_, count, wanted) => new.steps.push(DecodingStep::Field { wanted, kind: Type { base, count } }),
        }
    }
    let new = Arc::new(new);
    made.extend(key.map(|key| (key, Arc::clone(&new))));
    new
}

/// The size and the count of an item's numbers, if it has nothing but numbers of one size to skip.
fn numbers(base: &Base<Arc<Plan>>) -> Option<(usize, usize)> {
    match base {
        Base::Primitive(primitive) => size(*primitive).map(|size| (size, 1)),
        Base::Message(plan) => match plan.steps.as_slice() {
            [DecodingStep::Skip { size, count }] => Some((*size, *count)),
            _ => None,
        },
    }
}

/// The size and the alignment of a number in bytes. A Boolean has no size here: it is checked even if it is unwanted.
fn size(primitive: Primitive) -> Option<usize> {
    match primitive {
        Primitive::Byte | Primitive::Char | Primitive::Int8 | Primitive::Uint8 => Some(1),
        Primitive::Int16 | Primitive::Uint16 => Some(2),
        Primitive::Int32 | Primitive::Uint32 | Primitive::Float32 => Some(4),
        Primitive::Int64 | Primitive::Uint64 | Primitive::Float64 => Some(8),
        Primitive::Bool | Primitive::String(_) | Primitive::WString(_) => None,
    }
}

impl Plan {
    /// Adds numbers to skip, together with those before them if they have the same size.
    fn skip(&mut self, size: usize, count: usize) {
        match self.steps.last_mut() {
            Some(DecodingStep::Skip { size: before, count: so_far }) if *before == size => {
                *so_far = so_far.saturating_add(count);
            }
            _ => self.steps.push(DecodingStep::Skip { size, count }),
        }
    }

    fn read(&self, cdr: &mut CdrReader<'_>, width: WideWidth, value: Option<&mut Value>) -> Result<(), Mismatch> {
        let fields = value.map_or(&mut [][..], |value| value.fields(self.fields));
        self.steps.iter().try_for_each(|step| match step {
            DecodingStep::Skip { size, count } => cdr.skip(*size, *count),
            DecodingStep::Field { wanted, kind } => {
                read_field(cdr, width, kind, wanted.and_then(|index| fields.get_mut(index)))
            }
        })
    }
}

fn read_field(
    cdr: &mut CdrReader<'_>,
    width: WideWidth,
    kind: &Type<Arc<Plan>>,
    value: Option<&mut Value>,
) -> Result<(), Mismatch> {
    let count = match kind.count {
        Count::One => return read_item(cdr, width, &kind.base, value),
        Count::Exactly(count) if count > cdr.left() => return Err(Mismatch::Short),
        Count::Exactly(count) => count,
        Count::UpTo(bound) => cdr.length(bound)?,
        Count::Any => cdr.length(usize::MAX)?,
    };
    match (value, numbers(&kind.base)) {
        (Some(value), _) => {
            value.items(count).iter_mut().try_for_each(|value| read_item(cdr, width, &kind.base, Some(value)))
        }
        (None, Some((size, each))) => cdr.skip(size, count.saturating_mul(each)),
        (None, None) => (0..count).try_for_each(|_| read_item(cdr, width, &kind.base, None)),
    }
}

fn read_item(
    cdr: &mut CdrReader<'_>,
    width: WideWidth,
    base: &Base<Arc<Plan>>,
    value: Option<&mut Value>,
) -> Result<(), Mismatch> {
    match base {
        Base::Message(plan) => plan.read(cdr, width, value),
        Base::Primitive(primitive) => read_primitive(cdr, width, *primitive, value),
    }
}

fn read_primitive(
    cdr: &mut CdrReader<'_>,
    width: WideWidth,
    kind: Primitive,
    value: Option<&mut Value>,
) -> Result<(), Mismatch> {
    let found = match kind {
        Primitive::Bool => Value::Bool(bool::read(cdr)?),
        Primitive::Byte | Primitive::Char | Primitive::Uint8 => Value::Int(u8::read(cdr)?.into()),
        Primitive::Int8 => Value::Int(i8::read(cdr)?.into()),
        Primitive::Int16 => Value::Int(i16::read(cdr)?.into()),
        Primitive::Uint16 => Value::Int(u16::read(cdr)?.into()),
        Primitive::Int32 => Value::Int(i32::read(cdr)?.into()),
        Primitive::Uint32 => Value::Int(u32::read(cdr)?.into()),
        Primitive::Int64 => Value::Int(i64::read(cdr)?.into()),
        Primitive::Uint64 => Value::Int(u64::read(cdr)?.into()),
        Primitive::Float32 => Value::Real(f32::read(cdr)?.into()),
        Primitive::Float64 => Value::Real(f64::read(cdr)?),
        // The most common values that need memory: that of the previous message is reused.
        Primitive::String(bound) => {
            let text = cdr.string(bound)?;
            if let Some(value) = value {
                value.set_text(&String::from_utf8_lossy(text));
            }
            return Ok(());
        }
        Primitive::WString(bound) => Value::Text(String::from_utf16_lossy(&cdr.wide_string(bound, width)?)),
    };
    if let Some(value) = value {
        *value = found;
    }
    Ok(())
}
