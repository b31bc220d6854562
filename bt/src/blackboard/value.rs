//! The values of blackboard entries.

use std::collections::VecDeque;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// The value of a blackboard entry.
///
/// As in BehaviorTree.CPP, numbers are integers or real numbers, and a Boolean is the integer 0 or 1. Two values are
/// equal if they have the same kind and the same bits.
#[derive(Clone, Debug)]
pub enum Value {
    /// A whole number.
    Int(i64),
    /// A real number.
    Real(f64),
    /// A string.
    Text(Arc<str>),
    /// A queue of values, for the loop nodes.
    List(VecDeque<Value>),
}

/// A value that cannot be read as the requested type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ValueError {
    message: String,
}

impl ValueError {
    pub(crate) fn new(value: impl fmt::Display, wanted: &'static str) -> Self {
        Self { message: format!("`{value}` is not {wanted}") }
    }

    /// A value of a type that an entry of another type does not take.
    pub(crate) fn of_type(entry: &str, is: &impl fmt::Display, value: &impl fmt::Display) -> Self {
        let theirs = "once declared, the type of a port shall not change";
        let (is, value) = (is.to_string(), value.to_string());
        // Integers of several widths have one name here.
        let what = if is == value { "one of a different width or range" } else { &format!("a value of type {value}") };
        let message = format!("the entry `{entry}` has the type {is} and cannot take {what}");
        Self { message: format!("{message} (BehaviorTree.CPP: Blackboard::set({entry}): {theirs})") }
    }

    /// An integer that cannot become a real number.
    fn of_precision(value: &Value) -> Self {
        let message = format!("the integer {value} is too large to be a real number");
        let theirs = "Loss of precision when converting a large integer number to floating point";
        Self { message: format!("{message} (BehaviorTree.CPP: {theirs})") }
    }

    /// A value that an entry of its own type does not take, because it holds a value of another kind.
    pub(crate) fn of_kind(entry: &str, old: &Value, new: &Value) -> Self {
        let message = format!("the entry `{entry}` holds `{old}` and cannot take `{new}`");
        Self { message: format!("{message} (BehaviorTree.CPP: Any::copyInto fails)") }
    }
}

impl Value {
    /// Whether it is a number.
    #[must_use]
    pub fn is_number(&self) -> bool {
        matches!(self, Self::Int(_) | Self::Real(_))
    }

    /// Whether it is an integer of more than 53 bits, which BehaviorTree.CPP does not convert to a real number.
    pub(crate) fn is_too_large(&self) -> bool {
        matches!(self, Self::Int(number) if number.unsigned_abs() >= 1 << f64::MANTISSA_DIGITS)
    }

    /// As a real number; a string is parsed.
    ///
    /// # Errors
    /// If it is a list, a string that does not begin with a number, or an integer of more than 53 bits.
    #[expect(clippy::cast_precision_loss, reason = "BehaviorTree.CPP's arithmetic is that of doubles")]
    pub fn to_real(&self) -> Result<f64, ValueError> {
        match self {
            Self::Int(_) if self.is_too_large() => Err(ValueError::of_precision(self)),
            Self::Int(number) => Ok(*number as f64),
            Self::Real(number) => Ok(*number),
            Self::Text(text) => leading_real(text).ok_or_else(|| ValueError::new(self, "a number")),
            Self::List(_) => Err(ValueError::new(self, "a number")),
        }
    }

    /// As an integer; a string is parsed, a real number must be whole.
    ///
    /// # Errors
    /// If it is not an integer.
    #[expect(clippy::cast_possible_truncation, reason = "the number is in range, which is checked")]
    pub fn to_int(&self) -> Result<i64, ValueError> {
        let not_whole = || ValueError::new(self, "a whole number");
        match self {
            Self::Int(number) => Ok(*number),
            Self::Real(number) if number.fract() == 0.0 && (-MAX_WHOLE..MAX_WHOLE).contains(number) => {
                Ok(*number as i64)
            }
            Self::Text(text) => leading_int(text).ok_or_else(not_whole),
            _ => Err(not_whole()),
        }
    }

    /// As a Boolean: 0 or 1, a real number that is not negative (only zero is false), or the strings `true` and
    /// `false`.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn to_bool(&self) -> Result<bool, ValueError> {
        let neither = || ValueError::new(self, "true or false");
        match self {
            Self::Int(0) => Ok(false),
            Self::Int(1) => Ok(true),
            Self::Real(number) if number.is_nan() || *number >= 0.0 => Ok(*number != 0.0),
            Self::Text(text) => parse_bool(text).ok_or_else(neither),
            _ => Err(neither()),
        }
    }

    /// As a string: a real number is written with six decimals, as in C.
    #[must_use]
    pub fn to_text(&self) -> Arc<str> {
        match self {
            Self::Text(text) => text.clone(),
            _ => self.to_string().into(),
        }
    }

    /// The key for comparing two values by kind and bits.
    fn key(&self) -> (u8, u64, &str, Option<&VecDeque<Self>>) {
        match self {
            Self::Int(number) => (0, number.cast_unsigned(), "", None),
            Self::Real(number) => (1, number.to_bits(), "", None),
            Self::Text(text) => (2, 0, text, None),
            Self::List(items) => (3, 0, "", Some(items)),
        }
    }
}

/// 2^63: integers range from its negative up to, but not including, this number.
const MAX_WHOLE: f64 = 9_223_372_036_854_775_808.0;

/// `true` or `false`, in three spellings, or one of these digits.
pub(crate) fn parse_bool(text: &str) -> Option<bool> {
    match text {
        "1" | "true" | "True" | "TRUE" => Some(true),
        "0" | "false" | "False" | "FALSE" => Some(false),
        _ => None,
    }
}

/// The integer at the beginning of a string; decimals after it are cut off.
pub(crate) fn leading_int(text: &str) -> Option<i64> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let length = digits.len() - digits.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    text[..text.len() - digits.len() + length].parse().ok()
}

/// The number at the beginning of a string.
pub(crate) fn leading_real(text: &str) -> Option<f64> {
    if text.starts_with('+') {
        return None;
    }
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
    let mut length = text.find(|c| !is_part(c)).unwrap_or(text.len());
    while length > 0 {
        if let Ok(number) = text[..length].parse() {
            return Some(number);
        }
        length -= 1;
    }
    None
}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Value {}

impl Hash for Value {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Int(number) => number.fmt(f),
            Self::Real(number) => write!(f, "{number:.6}"),
            Self::Text(text) => f.write_str(text),
            Self::List(items) => {
                let mut separator = "";
                for item in items {
                    write!(f, "{separator}{item}")?;
                    separator = ";";
                }
                Ok(())
            }
        }
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Self::Int(number)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

impl From<bool> for Value {
    fn from(truth: bool) -> Self {
        Self::Int(i64::from(truth))
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl FromIterator<Value> for Value {
    fn from_iter<I: IntoIterator<Item = Value>>(items: I) -> Self {
        Self::List(items.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_string_is_parsed_up_to_where_it_stops_being_a_number() {
        assert_eq!(leading_int("12"), Some(12));
        assert_eq!(leading_int("-3.9"), Some(-3));
        assert_eq!(leading_int("4 apples"), Some(4));
        assert_eq!((leading_int(""), leading_int("x"), leading_int("+1"), leading_int(" 1")), (None, None, None, None));
        assert_eq!(leading_real("-1.5e2m"), Some(-150.0));
        assert_eq!(leading_real("2e"), Some(2.0));
        assert_eq!((leading_real("e"), leading_real(" 1"), leading_real("+1")), (None, None, None));
    }

    #[test]
    fn only_whole_numbers_in_range_become_integers() {
        assert_eq!(Value::Real(3.0).to_int(), Ok(3));
        assert!(Value::Real(3.5).to_int().is_err());
        assert!(Value::Real(1e19).to_int().is_err());
        assert!(Value::Real(f64::NAN).to_int().is_err());
    }

    #[test]
    fn an_integer_is_a_boolean_only_if_it_is_0_or_1() {
        assert_eq!(Value::Int(1).to_bool(), Ok(true));
        assert!(Value::Int(2).to_bool().is_err());
        assert_eq!(Value::Real(2.0).to_bool(), Ok(true));
    }
}
