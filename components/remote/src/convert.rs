//! Fields as machines and programs see them, and as messages of ROS 2 have them.

use channels::FieldKind;
use interfaces::{Field, WirePart};
use ros_messages::{Decoder, Mismatch, Value, Want};
use skills::Datum;

/// Integers up to this size are exact as numbers of machines.
const MOST_EXACT: i128 = (1 << 53) - 1;

/// The message of ROS 2 with these fields, without what ROS adds to it.
pub(crate) fn message(part: &WirePart, fields: &[Field], data: &Datum) -> Result<Value, Mismatch> {
    let value = |field: &Field| match data.member(&field.name) {
        None | Some(Datum::Undefined) => Ok(Value::Passed),
        Some(datum) => value(datum, &field.kind),
    };
    part.message(fields.iter().map(value).collect::<Result<_, _>>()?)
}

/// The fields of an encoded message.
pub(crate) fn data(part: &WirePart, fields: &[Field], body: &[u8]) -> Result<Datum, String> {
    // What no field needs need not be as it is defined here.
    if part.is_empty() {
        return Ok(Datum::object::<&str>([]).unwrap_or_default());
    }
    let message = Decoder::new(&part.layout, &Want::All).decode(body).map_err(|mismatch| mismatch.to_string())?;
    let values = part.fields(&message);
    let members = fields.iter().zip(values).filter(|(_, value)| *value != Value::Passed).map(|(field, value)| {
        let datum = datum(&value).ok_or_else(|| format!("`{}` has a value that a machine cannot have", field.name))?;
        Ok((field.name.as_str(), datum))
    });
    Datum::object(members.collect::<Result<Vec<_>, String>>()?).map_err(|large| large.to_string())
}

fn value(datum: &Datum, kind: &FieldKind) -> Result<Value, Mismatch> {
    Ok(match (kind, datum) {
        (FieldKind::Optional(kind), datum) => value(datum, kind)?,
        (FieldKind::List(kind), Datum::Array(items)) => {
            Value::List(items.items().iter().map(|item| value(item, kind)).collect::<Result<_, _>>()?)
        }
        (FieldKind::Bool, Datum::Bool(truth)) => Value::Bool(*truth),
        (FieldKind::Int, Datum::Number(number)) => Value::Int(*number as i128),
        (FieldKind::Real, Datum::Number(number)) => Value::Real(*number),
        (FieldKind::Text, Datum::Text(text)) => Value::Text(text.to_string()),
        _ => return Err(Mismatch::Value),
    })
}

/// None if it would become another value.
fn datum(value: &Value) -> Option<Datum> {
    Some(match value {
        Value::Bool(truth) => (*truth).into(),
        Value::Int(number) => (number.abs() <= MOST_EXACT).then_some(*number as f64)?.into(),
        Value::Real(number) => Some(*number).filter(|real| !real.is_nan())?.into(),
        Value::Text(text) => Datum::text(text),
        Value::List(items) => Datum::array(items.iter().map(datum).collect::<Option<Vec<_>>>()?).ok()?,
        Value::Passed | Value::Message(_) => return None,
    })
}
