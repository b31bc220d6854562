//! Encodes values as messages of a type.

use crate::definition::{Base, Count, Primitive};
use crate::layout::Layout;
use crate::rust::RosType as _;
use crate::value::{Mismatch, Value, WideWidth};
use crate::writer::CdrWriter;

impl Layout {
    /// Encodes a message of this type, little-endian, as ROS 2 does.
    ///
    /// # Errors
    /// [`Mismatch::Value`] if the value or a part of it is of another type or out of range, [`Mismatch::Bound`] if an
    /// array or a string is too long.
    pub fn encode(&self, message: &Value) -> Result<Vec<u8>, Mismatch> {
        self.encode_with(WideWidth::default(), message)
    }

    /// The same for programs whose wide strings have this width.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn encode_with(&self, width: WideWidth, message: &Value) -> Result<Vec<u8>, Mismatch> {
        let mut cdr = CdrWriter::reusing(Vec::new());
        self.write(message, width, &mut cdr)?;
        Ok(cdr.bytes())
    }

    fn write(&self, message: &Value, width: WideWidth, cdr: &mut CdrWriter) -> Result<(), Mismatch> {
        let Value::Message(values) = message else { return Err(Mismatch::Value) };
        if values.len() != self.fields.len() {
            return Err(Mismatch::Value);
        }
        // In IDL, an empty struct gets a dummy member of one byte.
        if values.is_empty() {
            cdr.number([0]);
        }
        self.fields.iter().zip(values).try_for_each(|(field, value)| {
            let items = match (field.kind.count, value) {
                (Count::One, single) => std::slice::from_ref(single),
                (count, Value::List(items)) => {
                    match count {
                        Count::Exactly(count) if items.len() != count => return Err(Mismatch::Value),
                        Count::UpTo(bound) if items.len() > bound => return Err(Mismatch::Bound),
                        Count::UpTo(_) | Count::Any => cdr.length(items.len()),
                        Count::One | Count::Exactly(_) => {}
                    }
                    items
                }
                _ => return Err(Mismatch::Value),
            };
            items.iter().try_for_each(|item| match &field.kind.base {
                Base::Message(layout) => layout.write(item, width, cdr),
                Base::Primitive(primitive) => write_primitive(*primitive, item, width, cdr),
            })
        })
    }
}

fn write_primitive(kind: Primitive, value: &Value, width: WideWidth, cdr: &mut CdrWriter) -> Result<(), Mismatch> {
    match (kind, value) {
        (Primitive::Bool, Value::Bool(truth)) => truth.write(cdr),
        (Primitive::Float32, Value::Real(number)) => (*number as f32).write(cdr),
        (Primitive::Float64, Value::Real(number)) => number.write(cdr),
        (Primitive::String(bound), Value::Text(text)) => {
            within(text.len(), bound)?;
            cdr.text(text);
        }
        (Primitive::WString(bound), Value::Text(text)) => {
            let units: Vec<u16> = text.encode_utf16().collect();
            within(units.len(), bound)?;
            cdr.length(units.len());
            match width {
                WideWidth::Two => cdr.numbers(units.into_iter().map(u16::to_le_bytes)),
                WideWidth::Four => cdr.numbers(units.into_iter().map(|unit| u32::from(unit).to_le_bytes())),
            }
        }
        (kind, Value::Int(number)) => {
            let (least, greatest) = kind.range().ok_or(Mismatch::Value)?;
            if !(least..=greatest).contains(number) {
                return Err(Mismatch::Value);
            }
            // The lowest bytes of a number are those of the same number in fewer bits, whatever its sign.
            let [a, b, c, d, e, f, g, h, ..] = number.to_le_bytes();
            match kind {
                Primitive::Int16 | Primitive::Uint16 => cdr.number([a, b]),
                Primitive::Int32 | Primitive::Uint32 => cdr.number([a, b, c, d]),
                Primitive::Int64 | Primitive::Uint64 => cdr.number([a, b, c, d, e, f, g, h]),
                _ => cdr.number([a]),
            }
        }
        _ => return Err(Mismatch::Value),
    }
    Ok(())
}

fn within(length: usize, bound: Option<usize>) -> Result<(), Mismatch> {
    if bound.is_some_and(|bound| length > bound) { Err(Mismatch::Bound) } else { Ok(()) }
}
