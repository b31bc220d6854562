//! Conversion between messages and events: the fields of a message are the members of an object.

use std::sync::Arc;

use channels::{FieldKind, Message, Shape, Value};

use crate::Datum;
use crate::machine::Undelivered;

/// Integers up to this size are exact as numbers.
const MAX_EXACT: f64 = 9_007_199_254_740_991.0;

/// Why a message cannot be constructed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Unsendable {
    #[error("no message begins with <{head}>")]
    Head { head: String },
    #[error("the field {field} is missing")]
    Missing { field: String },
    #[error("there is no field {field}")]
    Unknown { field: String },
    /// The value is given with why it is not of this kind: `0.5 is not`.
    #[error("the field {field} is {kind}, and {value}")]
    Value { field: String, kind: String, value: String },
}

impl Unsendable {
    /// Why a message is not delivered. `attempt` names it: `Go cannot publish <level>`.
    pub(super) fn undelivered(self, attempt: &str) -> Undelivered {
        match self {
            Self::Value { field, kind, value } => {
                Undelivered::Value { refusal: format!("{attempt}: the field {field} is {kind}"), value }
            }
            problem => Undelivered::Unfit(format!("{attempt}: {problem}")),
        }
    }
}

/// A message's fields as an object, with the names of its shape, or `m1`, `m2`, … if it has none. An optional field
/// without a value is left out.
pub(super) fn data(message: &Message, shape: Option<&Shape>) -> Datum {
    let name = |index: usize| -> Arc<str> {
        match shape.and_then(|shape| shape.fields().get(index)) {
            Some((name, _)) => name.as_str().into(),
            None => format!("m{}", index + 1).into(),
        }
    };
    let kind = |index: usize| shape.and_then(|shape| shape.fields().get(index)).map(|(_, kind)| kind);
    let is_there = |(index, value): &(usize, &Value)| {
        !(value.is_symbol(FieldKind::NONE) && matches!(kind(*index), Some(FieldKind::Optional(_))))
    };
    let fields = message.fields().iter().enumerate().filter(is_there);
    let members = fields.map(|(index, value)| (name(index), datum(value)));
    // Only a text of several megabytes is too large; the machine then sees no fields.
    Datum::object(members).unwrap_or_default()
}

fn datum(value: &Value) -> Datum {
    match value {
        Value::Symbol(symbol) => symbol.name().into(),
        Value::Bool(truth) => (*truth).into(),
        // The machine would see another integer.
        Value::Int(number) if (*number as f64) as i128 != i128::from(*number) => Datum::Undefined,
        Value::Int(number) => (*number as f64).into(),
        Value::Real(number) => (*number).into(),
        Value::Text(text) => Datum::Text(Arc::clone(text)),
        // Only several megabytes are too large.
        Value::List(items) => Datum::array(items.iter().map(datum)).unwrap_or_default(),
    }
}

/// The fields of a message that begins with `head`, in the order of the shape.
pub(super) fn message(head: &str, shape: &Shape, fields: &Datum) -> Result<Vec<Value>, Unsendable> {
    let rest = shape.fields().get(1..).unwrap_or_default();
    if let Datum::Object(given) = fields {
        let unknown = given.members().find(|(name, _)| !rest.iter().any(|(field, _)| field == name));
        if let Some((field, _)) = unknown {
            return Err(Unsendable::Unknown { field: field.to_owned() });
        }
    }
    let mut values = vec![Value::symbol(head)];
    for (field, kind) in rest {
        let given = match (fields.member(field), kind) {
            (Some(given), _) => given,
            (None, FieldKind::Optional(_)) => &Datum::Undefined,
            (None, _) => return Err(Unsendable::Missing { field: field.clone() }),
        };
        let unfit = || match given {
            Datum::Number(number) if number.fract() == 0.0 && kind.contains(&Value::Int(0)) => {
                let value = format!("{given} is beyond {MAX_EXACT}, up to which integers in machines are exact");
                Unsendable::Value { field: field.clone(), kind: FieldKind::Int.to_string(), value }
            }
            _ => Unsendable::Value { field: field.clone(), kind: kind.to_string(), value: format!("{given} is not") },
        };
        values.push(field_value(given, kind).ok_or_else(unfit)?);
    }
    Ok(values)
}

/// A datum as a value of this kind, if it can be one: conversions are never guessed.
#[must_use]
pub fn field_value(datum: &Datum, kind: &FieldKind) -> Option<Value> {
    match (kind, datum) {
        (FieldKind::Symbol(symbols), Datum::Text(name)) => {
            symbols.iter().find(|symbol| symbol.name() == &**name).map(|symbol| Value::Symbol(symbol.clone()))
        }
        (FieldKind::Bool, Datum::Bool(truth)) => Some(Value::Bool(*truth)),
        (FieldKind::Int, Datum::Number(number)) if number.fract() == 0.0 && number.abs() <= MAX_EXACT => {
            Some(Value::Int(*number as i64))
        }
        (FieldKind::Real, Datum::Number(number)) if !number.is_nan() => Some(Value::Real(*number)),
        (FieldKind::Text, Datum::Text(text)) => Some(Value::Text(Arc::clone(text))),
        (FieldKind::Optional(_), Datum::Undefined) => Some(Value::symbol(FieldKind::NONE)),
        (FieldKind::Optional(kind), datum) => field_value(datum, kind),
        (FieldKind::List(kind), Datum::Array(items)) => {
            items.items().iter().map(|item| field_value(item, kind)).collect::<Option<_>>().map(Value::List)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level() -> Shape {
        Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)])
    }

    #[test]
    fn fields_become_members_by_name() {
        let message = Message::new([Value::symbol("ok"), 83.2.into()]);
        assert_eq!(data(&message, Some(&level())).to_string(), r#"{"status": "ok", "level": 83.2}"#);
        assert_eq!(data(&message, None).to_string(), r#"{"m1": "ok", "m2": 83.2}"#);
    }

    #[test]
    fn members_become_fields_of_the_channels_kinds() {
        let shape = Shape::new([
            ("request", FieldKind::symbols(["go"])),
            ("place", FieldKind::symbols(["Dock"])),
            ("count", FieldKind::Int),
            ("speed", FieldKind::Real),
            ("why", FieldKind::Text),
        ]);
        let fields = |place: &str, count: f64| {
            let members =
                [("why", "because".into()), ("speed", 1.0.into()), ("count", count.into()), ("place", place.into())];
            Datum::object(members).unwrap()
        };
        let values = message("go", &shape, &fields("Dock", 3.0)).unwrap();
        assert_eq!(Message::new(values).to_string(), r#"[<go>, <Dock>, 3, 1.0, "because"]"#);
        let why = |fields| message("go", &shape, &fields).unwrap_err().to_string();
        assert_eq!(why(fields("Moon", 3.0)), "the field place is <Dock>, and \"Moon\" is not");
        assert_eq!(why(fields("Dock", 0.5)), "the field count is int, and 0.5 is not");
        let inexact = why(fields("Dock", MAX_EXACT + 1.0));
        assert!(
            inexact.starts_with("the field count is int, and 9007199254740992 is beyond 9007199254740991"),
            "{inexact}"
        );
        assert_eq!(why(Datum::Undefined), "the field place is missing");
        let unknown = Datum::object([("plaice", "Dock".into())]).unwrap();
        assert_eq!(why(unknown), "there is no field plaice");
    }
}
