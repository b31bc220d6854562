//! The types that ports declare.

use std::fmt;

use super::value::{Value, ValueError, leading_int, leading_real, parse_bool};
use crate::Status;

/// The type of a port or of an entry.
///
/// BehaviorTree.CPP uses the types of C++. Here all its integers are one type with a range. Any other type is known
/// only by its name; its values are strings.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// The type of the first value written.
    Any,
    /// A Boolean.
    Bool,
    /// A whole number from `min` to `max`.
    Int {
        /// The minimum.
        min: i64,
        /// The maximum.
        max: i64,
    },
    /// A real number: C++'s `double`.
    Real,
    /// C++'s `float`. Its values are kept as those of `double` are, but an entry of the one type is not of the other.
    Float,
    /// A string.
    Text,
    /// The answer of a node, in capitals: `SUCCESS`.
    Status,
    /// A queue or vector, written with semicolons: `1;2;3`.
    List(Box<Type>),
    /// A custom type.
    Other(String),
}

/// The maximum nesting of lists: more is not needed, and a type with a million levels would exhaust the stack.
const MAX_LISTS: usize = 8;

impl Type {
    /// C++'s `int`.
    pub(crate) const INT: Self = Self::Int { min: i32::MIN as i64, max: i32::MAX as i64 };
    /// C++'s `int64_t`.
    pub(crate) const INT64: Self = Self::Int { min: i64::MIN, max: i64::MAX };
    /// C++'s `unsigned`.
    pub(crate) const UNSIGNED: Self = Self::Int { min: 0, max: u32::MAX as i64 };
    /// C++'s `uint64_t`. Values are kept in 64 bits with a sign.
    pub(crate) const UNSIGNED64: Self = Self::Int { min: 0, max: i64::MAX };

    /// The type for a name in a `<TreeNodesModel>`.
    #[must_use]
    pub fn named(name: &str) -> Self {
        let int = |min, max| Self::Int { min, max };
        let name = name.trim();
        let name = name.strip_prefix("BT::").or_else(|| name.strip_prefix("std::")).unwrap_or(name);
        match name {
            "" | "AnyTypeAllowed" | "Any" => Self::Any,
            "bool" => Self::Bool,
            "int" | "int32_t" => Self::INT,
            "unsigned int" | "unsigned" | "uint32_t" | "uint" => Self::UNSIGNED,
            "int8_t" | "char" => int(i8::MIN.into(), i8::MAX.into()),
            "int16_t" | "short" => int(i16::MIN.into(), i16::MAX.into()),
            "uint8_t" | "unsigned char" => int(0, u8::MAX.into()),
            "uint16_t" | "unsigned short" => int(0, u16::MAX.into()),
            "int64_t" | "long" | "long long" => int(i64::MIN, i64::MAX),
            "uint64_t" | "unsigned long" | "unsigned long long" | "size_t" => Self::UNSIGNED64,
            "double" => Self::Real,
            "float" => Self::Float,
            "string" | "basic_string<char>" => Self::Text,
            "NodeStatus" => Self::Status,
            _ => match name.split_once('<').filter(|(list, _)| list.ends_with("vector") || list.ends_with("Queue")) {
                Some((_, item)) if item.matches('<').count() < MAX_LISTS => {
                    Self::List(Box::new(Self::named(item.trim_end_matches('>'))))
                }
                _ => Self::Other(name.to_owned()),
            },
        }
    }

    /// Whether an entry of this type keeps that type permanently.
    #[must_use]
    pub fn is_strong(&self) -> bool {
        *self != Self::Any
    }

    /// Whether a port of the other type may use an entry that was first named by a port of this type. As in
    /// BehaviorTree.CPP, the types must be equal, or one is any type, or the entry is a string, which is read as the
    /// port's type.
    #[must_use]
    pub fn agrees_with(&self, other: &Self) -> bool {
        matches!(self, Self::Any | Self::Text) || *other == Self::Any || self == other
    }

    /// Whether a constant of this type, passed to a subtree, can be read by a port of the other type: a string can be
    /// read as any type, a number as a number, Boolean or string.
    pub(crate) fn is_read_as(&self, other: &Self) -> bool {
        self.agrees_with(other) || (self.is_number() && (other.is_number() || *other == Self::Text))
    }

    pub(crate) fn is_number(&self) -> bool {
        matches!(self, Self::Bool | Self::Int { .. }) || self.is_real()
    }

    pub(crate) fn is_real(&self) -> bool {
        matches!(self, Self::Real | Self::Float)
    }

    /// Parses a string as a value of this type.
    ///
    /// # Errors
    /// If the string is not such a value.
    pub fn parse(&self, text: &str) -> Result<Value, ValueError> {
        let wrong = || ValueError::new(text, self.description());
        match self {
            Self::Any | Self::Text | Self::Other(_) => Ok(text.into()),
            Self::Bool => parse_bool(text).map(Value::from).ok_or_else(wrong),
            Self::Int { min, max } => {
                let number = leading_int(text).filter(|number| (min..=max).contains(&number));
                number.map(Value::Int).ok_or_else(wrong)
            }
            Self::Real | Self::Float => leading_real(text).map(Value::Real).ok_or_else(wrong),
            Self::Status => status_named(text).map(|_| text.into()).ok_or_else(wrong),
            Self::List(item) => {
                let items = text.strip_suffix(';').unwrap_or(text);
                let items = (!items.is_empty()).then(|| items.split(';'));
                items.into_iter().flatten().map(|part| item.parse(part)).collect()
            }
        }
    }

    /// A number in a text of this type that is not a number as a whole, and the number that is read.
    pub(crate) fn reads_only_part(&self, text: &str) -> Option<(String, String)> {
        let whole = |read: &Value| match read {
            Value::Int(number) => text.trim().parse() == Ok(*number),
            Value::Real(_) => text.trim().parse::<f64>().is_ok(),
            Value::Text(_) | Value::List(_) => true,
        };
        match self {
            Self::Int { .. } | Self::Real | Self::Float => {
                let read = self.parse(text).ok().filter(|read| !whole(read))?;
                let number = if let Value::Real(number) = read { number.to_string() } else { read.to_string() };
                Some((text.to_owned(), number))
            }
            Self::List(item) => text.split(';').find_map(|part| item.reads_only_part(part)),
            _ => None,
        }
    }

    /// The type of a value that a program gives without a type: that of a literal of its kind in C++.
    pub(crate) fn of_value(value: &Value) -> Self {
        match value {
            Value::Int(number) if i32::try_from(*number).is_ok() => Self::INT,
            Value::Int(_) => Self::INT64,
            Value::Real(_) => Self::Real,
            Value::Text(_) => Self::Text,
            Value::List(_) => Self::Any,
        }
    }

    /// Whether a value of the other type may be written to an entry of this type: if both are numbers, if it keeps its
    /// value. A Boolean is 0 or 1 here, whatever its type in the robot's program.
    fn takes(&self, other: &Self, value: &Value) -> bool {
        match (self, other) {
            (Self::Any, _) | (_, Self::Any) => true,
            (Self::Int { .. }, Self::Int { .. }) => self.is_wider(other) && self.convert(value).is_ok(),
            (Self::Float, Self::Real) => matches!(value, Value::Real(number) if is_single(*number)),
            (Self::Int { .. } | Self::Real | Self::Float, of) if of.is_number() => self.convert(value).is_ok(),
            (Self::Bool, Self::Int { .. }) => self.convert(value).is_ok(),
            _ => self == other,
        }
    }

    /// Whether BehaviorTree.CPP converts integers of the other type at all. It compares limits of both types as values
    /// of the source's type: a signed integer has to be wider than an unsigned one that it gets its value from, and an
    /// unsigned one narrower than its signed source.
    fn is_wider(&self, source: &Self) -> bool {
        let width = |of: &Self| match of {
            Self::Int { min: 0, max } => (true, (max.ilog2() + 1).next_multiple_of(8)),
            Self::Int { max, .. } => (false, max.ilog2() + 2),
            _ => (false, 0),
        };
        match (width(self), width(source)) {
            ((true, this), (false, source)) => this < source,
            ((false, this), (true, source)) => this > source,
            _ => true,
        }
    }

    /// A value of the other type, as an entry of this type gets it: a string is parsed. `None` if the entry does not
    /// take it.
    pub(crate) fn receive(&self, other: &Self, value: Value) -> Result<Option<Value>, ValueError> {
        match value {
            // BehaviorTree.CPP reads no string as a status here, though its ports do.
            Value::Text(_) if *other == Self::Text && *self == Self::Status => Ok(None),
            Value::Text(_) if *other == Self::Text && *self != Self::Text => self.convert(&value).map(Some),
            value => Ok(self.takes(other, &value).then_some(value)),
        }
    }

    /// Converts a value to this type.
    ///
    /// # Errors
    /// If the value does not fit this type.
    pub fn convert(&self, value: &Value) -> Result<Value, ValueError> {
        let wrong = || ValueError::new(value, self.description());
        match (self, value) {
            (Self::Any, _) => Ok(value.clone()),
            (_, Value::Text(text)) => self.parse(text),
            (Self::Bool, _) => value.to_bool().map(Value::from),
            (Self::Int { min, max }, _) => {
                value.to_int().ok().filter(|number| (min..=max).contains(&number)).map(Value::Int).ok_or_else(wrong)
            }
            (Self::Real | Self::Float, _) => value.to_real().map(Value::Real),
            (Self::List(item), Value::List(items)) => items.iter().map(|one| item.convert(one)).collect(),
            _ => Err(wrong()),
        }
    }

    fn description(&self) -> &'static str {
        match self {
            Self::Any => "a value",
            Self::Bool => "true or false",
            Self::Int { min: 0, .. } => "a non-negative whole number",
            Self::Int { .. } => "a whole number in range",
            Self::Real | Self::Float => "a number",
            Self::Text => "a string",
            Self::Status => "SUCCESS, FAILURE, RUNNING or SKIPPED",
            Self::List(_) => "a list of such values",
            Self::Other(_) => "a value of this type",
        }
    }
}

/// Whether a `float` has this value exactly.
#[expect(clippy::cast_possible_truncation, clippy::float_cmp, reason = "it is asked whether the value stays the same")]
fn is_single(number: f64) -> bool {
    f64::from(number as f32) == number
}

/// The status with this name in capitals.
pub(crate) fn status_named(name: &str) -> Option<Status> {
    Some(match name {
        "SUCCESS" => Status::Success,
        "FAILURE" => Status::Failure,
        "RUNNING" => Status::Running,
        "SKIPPED" => Status::Skipped,
        _ => return None,
    })
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("BT::AnyTypeAllowed"),
            Self::Bool => f.write_str("bool"),
            Self::Int { min: 0, .. } => f.write_str("unsigned int"),
            Self::Int { min, max } if (*min, *max) == (i64::MIN, i64::MAX) => f.write_str("int64_t"),
            Self::Int { .. } => f.write_str("int"),
            Self::Real => f.write_str("double"),
            Self::Float => f.write_str("float"),
            Self::Text => f.write_str("std::string"),
            Self::Status => f.write_str("BT::NodeStatus"),
            Self::List(item) => write!(f, "std::vector<{item}>"),
            Self::Other(name) => f.write_str(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_may_hold_lists_but_only_to_a_limited_depth() {
        let matrix = Type::List(Box::new(Type::List(Box::new(Type::Real))));
        assert_eq!(Type::named("std::vector<std::vector<double>>"), matrix);
        let endless = "vector<".repeat(100_000) + "int" + &">".repeat(100_000);
        assert!(matches!(Type::named(&endless), Type::Other(_)), "and the stack does not overflow");
    }
}
