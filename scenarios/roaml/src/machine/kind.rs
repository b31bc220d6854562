//! The kinds of values in messages.

use channels::{FieldKind, Value};
use skills::Datum;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum DataKind {
    /// `true` or `false`.
    Bool,
    /// A whole number.
    Int,
    /// A number.
    Real,
    /// A text.
    Text,
    /// Any value: an array, a structure, or one whose type is not known. Channels carry it as JSON.
    Any,
}

const TYPES: [(&str, DataKind); 12] = [
    ("bool", DataKind::Bool),
    ("float32", DataKind::Real),
    ("float64", DataKind::Real),
    ("int8", DataKind::Int),
    ("int16", DataKind::Int),
    ("int32", DataKind::Int),
    ("int64", DataKind::Int),
    ("string", DataKind::Text),
    ("uint8", DataKind::Int),
    ("uint16", DataKind::Int),
    ("uint32", DataKind::Int),
    ("uint64", DataKind::Int),
];

impl DataKind {
    /// The kind of a type in a model: `int32`, `float64[3]`, or one of its own structures.
    pub(crate) fn of_type(name: &str, structures: &[String]) -> Option<Self> {
        let element = name.split('[').next().unwrap_or_default().trim();
        let base = TYPES.iter().find(|(known, _)| *known == element).map(|(_, kind)| *kind);
        let known = base.or_else(|| structures.iter().any(|known| known == element).then_some(Self::Any))?;
        Some(if name.contains('[') { Self::Any } else { known })
    }

    pub(crate) fn type_names() -> impl Iterator<Item = &'static str> {
        TYPES.iter().map(|(name, _)| *name)
    }

    /// The kind of a field of a message, if the message is one of ROS's own.
    pub(crate) fn of_ros(of: &str, field: &str) -> Option<Self> {
        let name = of.strip_prefix("std_msgs/").filter(|_| field == "data")?;
        Some(match name {
            "Bool" => Self::Bool,
            "String" => Self::Text,
            "Float32" | "Float64" => Self::Real,
            name if name.starts_with("Int") || name.starts_with("UInt") => Self::Int,
            _ => return None,
        })
        .filter(|_| !name.ends_with("Array"))
    }

    /// The kind that includes both kinds.
    pub(crate) fn or(self, other: Self) -> Self {
        match (self, other) {
            (one, same) if one == same => one,
            (Self::Int, Self::Real) | (Self::Real, Self::Int) => Self::Real,
            _ => Self::Any,
        }
    }

    /// What a channel carries.
    pub(crate) fn field(self) -> FieldKind {
        match self {
            Self::Bool => FieldKind::Bool,
            Self::Int => FieldKind::Int,
            Self::Real => FieldKind::Real,
            Self::Text | Self::Any => FieldKind::Text,
        }
    }

    /// The value of a field, if the datum is of this kind.
    pub(crate) fn value(self, datum: &Datum) -> Option<Value> {
        match (self, datum) {
            (Self::Bool, Datum::Bool(truth)) => Some(Value::Bool(*truth)),
            (Self::Int, Datum::Number(number)) if number.fract() == 0.0 && number.abs() <= MAX_EXACT => {
                Some(Value::Int(*number as i64))
            }
            (Self::Real, Datum::Number(number)) if !number.is_nan() => Some(Value::Real(*number)),
            (Self::Text, Datum::Text(text)) => Some(Value::Text(std::sync::Arc::clone(text))),
            (Self::Any, datum) => Some(Value::Text(datum.to_json().into())),
            _ => None,
        }
    }

    /// Why a datum is not of this kind, in words.
    pub(crate) fn unfit(self, datum: &Datum) -> String {
        match (self, datum) {
            (Self::Int, Datum::Number(number)) if number.fract() == 0.0 => {
                format!("int, and {datum} is beyond {MAX_EXACT}, up to which integers in machines are exact")
            }
            _ => format!("{}, and {datum} is not", self.field()),
        }
    }

    /// The value of an unset field, as in ROS.
    pub(crate) fn default(self) -> Value {
        match self {
            Self::Bool => Value::Bool(false),
            Self::Int => Value::Int(0),
            Self::Real => Value::Real(0.0),
            Self::Text => Value::Text("".into()),
            Self::Any => Value::Text("null".into()),
        }
    }

    pub(crate) fn datum(self, value: &Value) -> Datum {
        match value {
            Value::Bool(truth) => (*truth).into(),
            Value::Int(number) => exact(*number).map_or(Datum::Undefined, Datum::from),
            Value::Real(number) => (*number).into(),
            Value::Text(text) if self == Self::Any => serde_json::from_str(text).map(from_json).unwrap_or_default(),
            Value::Text(text) => Datum::Text(std::sync::Arc::clone(text)),
            // No message of a model has one.
            Value::Symbol(_) | Value::List(_) => Datum::Undefined,
        }
    }

    /// The datum that a text in a tree's file stands for.
    pub(crate) fn parse(self, text: &str) -> Option<Datum> {
        Some(match self {
            Self::Bool => match text.trim() {
                "true" | "1" => true.into(),
                "false" | "0" => false.into(),
                _ => return None,
            },
            Self::Int => exact(text.trim().parse().ok()?)?.into(),
            Self::Real => text.trim().parse::<f64>().ok()?.into(),
            Self::Text => Datum::text(text),
            Self::Any => from_json(serde_json::from_str(text).ok()?),
        })
    }
}

/// The greatest integer that no other one becomes as a double.
const MAX_EXACT: f64 = 9_007_199_254_740_991.0;

/// The double that is equal to an integer, if there is one: a machine must not see another integer.
fn exact(integer: i64) -> Option<f64> {
    let real = integer as f64;
    (real as i128 == i128::from(integer)).then_some(real)
}

fn from_json(json: serde_json::Value) -> Datum {
    use serde_json::Value as Json;
    match json {
        Json::Null => Datum::Undefined,
        Json::Bool(truth) => truth.into(),
        Json::Number(number) => match number.as_i64() {
            Some(integer) => exact(integer).map_or(Datum::Undefined, Datum::from),
            None => number.as_f64().map_or(Datum::Undefined, Datum::from),
        },
        Json::String(text) => Datum::text(&text),
        Json::Array(items) => Datum::array(items.into_iter().map(from_json)).unwrap_or_default(),
        Json::Object(members) => {
            Datum::object(members.into_iter().map(|(name, value)| (name, from_json(value)))).unwrap_or_default()
        }
    }
}

/// Fields whose names have dots, as objects in objects: `pose.x` is the member `x` of `pose`.
pub(crate) fn nested(fields: Vec<(String, Datum)>) -> Datum {
    let mut members: Vec<(String, Datum)> = Vec::new();
    let mut inner: Vec<(String, Vec<(String, Datum)>)> = Vec::new();
    for (name, value) in fields {
        match name.split_once('.') {
            None => members.push((name, value)),
            Some((outer, rest)) => match inner.iter_mut().find(|(known, _)| known == outer) {
                Some((_, fields)) => fields.push((rest.to_owned(), value)),
                None => inner.push((outer.to_owned(), vec![(rest.to_owned(), value)])),
            },
        }
    }
    members.extend(inner.into_iter().map(|(name, fields)| (name, nested(fields))));
    Datum::object(members).unwrap_or_default()
}
