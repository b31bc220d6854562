//! Conversion between the fields of channel messages and messages of ROS 2.

use channels::FieldKind;
use interfaces::{Field, WirePart};
use ros_messages::{Base, Count, Decoder, Mismatch, Primitive, Value, Want};
use skills::Datum;

/// Integers up to this size are exact as numbers of machines, which are doubles.
const MOST_EXACT: i128 = (1 << 53) - 1;

/// The message of ROS 2 with these fields, without the goal id or status that ROS adds.
pub(crate) fn message(part: &WirePart, fields: &[Field], data: &Datum) -> Result<Value, Mismatch> {
    let value = |field: &Field| match data.member(&field.name) {
        None | Some(Datum::Undefined) => Ok(Value::Passed),
        Some(datum) => value(datum, &field.kind),
    };
    part.message(fields.iter().map(value).collect::<Result<_, _>>()?)
}

/// The fields of an encoded message.
pub(crate) fn data(part: &WirePart, fields: &[Field], body: &[u8]) -> Result<Datum, String> {
    // A message of which no field is read need not match the definition.
    if part.is_empty() {
        return Ok(nothing());
    }
    members(part, fields, &decoded(part, body)?)
}

fn decoded(part: &WirePart, body: &[u8]) -> Result<Value, String> {
    Decoder::new(&part.layout, &Want::All).decode(body).map_err(|mismatch| mismatch.to_string())
}

fn members(part: &WirePart, fields: &[Field], message: &Value) -> Result<Datum, String> {
    let values = part.fields(message);
    let members = fields.iter().zip(values).filter(|(_, value)| *value != Value::Passed).map(|(field, value)| {
        let datum = datum(&value).ok_or_else(|| format!("`{}` has a value that a machine cannot have", field.name))?;
        Ok((field.name.as_str(), datum))
    });
    Datum::object(members.collect::<Result<Vec<_>, String>>()?).map_err(|large| large.to_string())
}

pub(crate) fn nothing() -> Datum {
    Datum::object::<&str>([]).unwrap_or_default()
}

/// Sets the first field of a message about a goal: the goal's id.
pub(crate) fn identified(mut message: Value, id: [u8; 16]) -> Value {
    let bytes = id.iter().map(|byte| Value::Int(i128::from(*byte))).collect();
    put(&mut message, Some(0), Value::Message(vec![Value::List(bytes)]));
    message
}

/// Sets the first field of a result: the goal's status.
pub(crate) fn with_status(mut message: Value, status: i8) -> Value {
    put(&mut message, Some(0), Value::Int(status.into()));
    message
}

/// The fields of a response for success and for the reason of a failure: a convention of ROS 2, which its `std_srvs`
/// follow.
const SUCCESS: &str = "success";
const MESSAGE: &str = "message";

/// The index of a field in a message, if it has this type.
fn place_of(part: &WirePart, name: &str, is_of_type: impl Fn(Primitive) -> bool) -> Option<usize> {
    part.layout.fields.iter().position(|field| {
        let is_right = matches!(field.kind.base, Base::Primitive(primitive) if is_of_type(primitive));
        field.name == name && field.kind.count == Count::One && is_right
    })
}

fn success(part: &WirePart) -> Option<usize> {
    place_of(part, SUCCESS, |primitive| primitive == Primitive::Bool)
}

fn put(message: &mut Value, place: Option<usize>, value: Value) {
    if let (Value::Message(fields), Some(place)) = (message, place)
        && let Some(field) = fields.get_mut(place)
    {
        *field = value;
    }
}

/// The outcome in an encoded response: the fields of the reply; or the reason of a failure, if the response has a field
/// `success` that is false and not part of the reply.
pub(crate) fn outcome(part: &WirePart, fields: &[Field], body: &[u8]) -> Result<Result<Datum, String>, String> {
    let Some(success) = success(part).filter(|_| !part.selects(SUCCESS)) else {
        return data(part, fields, body).map(Ok);
    };
    let response = decoded(part, body)?;
    let Value::Message(values) = &response else { return Ok(Ok(nothing())) };
    if values[success] == Value::Bool(true) {
        return members(part, fields, &response).map(Ok);
    }
    let why = place_of(part, MESSAGE, |primitive| matches!(primitive, Primitive::String(_)));
    let why = why.and_then(|place| if let Value::Text(why) = &values[place] { Some(why.clone()) } else { None });
    Ok(Err(why.unwrap_or_default()))
}

/// The response to a request that succeeded, with the fields of the reply.
pub(crate) fn response(part: &WirePart, fields: &[Field], data: &Datum) -> Result<Vec<u8>, Mismatch> {
    let mut response = message(part, fields, data)?;
    put(&mut response, success(part).filter(|_| !part.selects(SUCCESS)), Value::Bool(true));
    part.layout.encode(&response)
}

/// The response to a request that failed; `None` if its type cannot express that.
pub(crate) fn refusal(part: &WirePart, why: &str) -> Option<Vec<u8>> {
    let success = success(part)?;
    let mut response = part.message(Vec::new()).ok()?;
    put(&mut response, Some(success), Value::Bool(false));
    let text = place_of(part, MESSAGE, |primitive| primitive == Primitive::String(None));
    put(&mut response, text, Value::Text(why.to_owned()));
    part.layout.encode(&response).ok()
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
        (FieldKind::Text | FieldKind::Symbol(_), Datum::Text(text)) => Value::Text(text.to_string()),
        _ => return Err(Mismatch::Value),
    })
}

/// `None` if a machine cannot represent the value exactly.
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
