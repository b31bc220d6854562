//! ECMAScript's conversions and comparisons (ECMA-262, clause 7).

use std::cmp::Ordering;
use std::sync::Arc;

use super::Datum;

/// Strings cannot grow beyond this: `s = s + s` would otherwise exhaust the memory.
pub(crate) const MAX_TEXT_BYTES: usize = 1 << 20;

impl Datum {
    /// The Boolean that `if (x)` tests (ToBoolean, 7.1.2).
    #[must_use]
    pub fn truthy(&self) -> bool {
        match self {
            Self::Undefined | Self::Null => false,
            Self::Bool(truth) => *truth,
            Self::Number(number) => *number != 0.0 && !number.is_nan(),
            Self::Text(text) => !text.is_empty(),
            Self::Array(_) | Self::Object(_) | Self::Function(_) | Self::Xml(_) => true,
        }
    }

    /// The number that arithmetic uses (ToNumber, 7.1.4).
    #[must_use]
    pub fn to_number(&self) -> f64 {
        match self {
            Self::Undefined | Self::Object(_) | Self::Function(_) | Self::Xml(_) => f64::NAN,
            Self::Null => 0.0,
            Self::Bool(truth) => f64::from(u8::from(*truth)),
            Self::Number(number) => *number,
            Self::Text(text) => numeric(text),
            Self::Array(_) => numeric(&self.to_text()),
        }
    }

    /// The string that `"" + x` yields (ToString, 7.1.17).
    #[must_use]
    pub fn to_text(&self) -> Arc<str> {
        match self {
            Self::Undefined => "undefined".into(),
            Self::Null => "null".into(),
            Self::Bool(true) => "true".into(),
            Self::Bool(false) => "false".into(),
            Self::Number(number) => number_text(*number).into(),
            Self::Text(text) | Self::Function(text) | Self::Xml(text) => Arc::clone(text),
            Self::Array(array) => {
                let items: Vec<Arc<str>> = array.items().iter().map(Self::to_joined_text).collect();
                items.join(",").into()
            }
            Self::Object(_) => "[object Object]".into(),
        }
    }

    /// An item as `Array.prototype.join` writes it.
    fn to_joined_text(&self) -> Arc<str> {
        match self {
            Self::Undefined | Self::Null => "".into(),
            other => other.to_text(),
        }
    }

    /// The result of `typeof x`.
    pub(crate) fn type_name(&self) -> &'static str {
        match self {
            Self::Undefined => "undefined",
            Self::Bool(_) => "boolean",
            Self::Number(_) => "number",
            Self::Text(_) => "string",
            Self::Null | Self::Array(_) | Self::Object(_) | Self::Xml(_) => "object",
            Self::Function(_) => "function",
        }
    }

    /// Whether the value is an object in the sense of ECMAScript, so that it has an identity.
    pub(crate) fn is_composite(&self) -> bool {
        self.identity().is_some()
    }

    /// Distinguishes an object from all others, even equal ones.
    pub(crate) fn identity(&self) -> Option<Identity> {
        Some(Identity(match self {
            Self::Array(array) => Arc::as_ptr(array).addr(),
            Self::Object(object) => Arc::as_ptr(object).addr(),
            Self::Function(text) | Self::Xml(text) => Arc::as_ptr(text).addr(),
            _ => return None,
        }))
    }

    /// An array or object as the string that operators convert it to; other values unchanged (ToPrimitive, 7.1.1).
    pub(crate) fn to_primitive(&self) -> Self {
        if self.is_composite() { Self::Text(self.to_text()) } else { self.clone() }
    }

    /// `a === b` (7.2.15). Objects are identical if they are the same object, not if they are equal.
    pub(crate) fn identical(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Undefined, Self::Undefined) | (Self::Null, Self::Null) => true,
            (Self::Bool(a), Self::Bool(b)) => a == b,
            (Self::Number(a), Self::Number(b)) => a == b,
            (Self::Text(a), Self::Text(b)) => a == b,
            (a, b) => a.is_composite() && a.identity() == b.identity(),
        }
    }

    /// `a == b` (7.2.14)
    pub(crate) fn equal(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Undefined | Self::Null, Self::Undefined | Self::Null) => true,
            (Self::Undefined | Self::Null, _) | (_, Self::Undefined | Self::Null) => false,
            (a, b) if a.is_composite() && b.is_composite() => a.identity() == b.identity(),
            (a, b) if a.is_composite() || b.is_composite() => a.to_primitive().equal(&b.to_primitive()),
            (Self::Text(a), Self::Text(b)) => a == b,
            (a, b) => a.to_number() == b.to_number(),
        }
    }

    /// How `<` and the other relations order two values (7.2.13); `None` if all of them are false.
    pub(crate) fn order(&self, other: &Self) -> Option<Ordering> {
        match (self.to_primitive(), other.to_primitive()) {
            (Self::Text(a), Self::Text(b)) => Some(a.encode_utf16().cmp(b.encode_utf16())),
            (a, b) => a.to_number().partial_cmp(&b.to_number()),
        }
    }
}

/// The identity of an object: two objects are the same only if their identities are equal. It means nothing after the
/// object is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Identity(usize);

/// The number that a string represents (StringToNumber, 7.1.4.1); NaN if it does not represent one.
pub(crate) fn numeric(text: &str) -> f64 {
    let text = text.trim();
    let radix = |digits: &str, radix| match u64::from_str_radix(digits, radix) {
        Ok(number) if !digits.starts_with('+') => number as f64,
        _ => f64::NAN,
    };
    match text.get(..2).map(str::to_ascii_lowercase).as_deref() {
        Some("0x") => return radix(&text[2..], 16),
        Some("0o") => return radix(&text[2..], 8),
        Some("0b") => return radix(&text[2..], 2),
        _ => {}
    }
    match text {
        "" => 0.0,
        "Infinity" | "+Infinity" => f64::INFINITY,
        "-Infinity" => f64::NEG_INFINITY,
        _ if text.bytes().all(|byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte)) => {
            text.parse().unwrap_or(f64::NAN)
        }
        _ => f64::NAN,
    }
}

/// A number as ECMAScript writes it (Number::toString, 6.1.6.1.20): the shortest digits that read back the same.
fn number_text(number: f64) -> String {
    if number.is_nan() {
        return "NaN".to_owned();
    }
    if number == 0.0 {
        return "0".to_owned();
    }
    let sign = if number < 0.0 { "-" } else { "" };
    if number.is_infinite() {
        return format!("{sign}Infinity");
    }
    let scientific = format!("{:e}", number.abs());
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let digits = mantissa.replace('.', "");
    // The decimal point comes after this many digits.
    let point = exponent.parse::<i32>().unwrap_or(0) + 1;
    format!("{sign}{}", place_point(&digits, point))
}

fn place_point(digits: &str, point: i32) -> String {
    let count = i32::try_from(digits.len()).unwrap_or(i32::MAX);
    let zeros = |count: i32| "0".repeat(usize::try_from(count).unwrap_or(0));
    match point {
        1..=21 if count <= point => format!("{digits}{}", zeros(point - count)),
        1..=21 => {
            let (whole, fraction) = digits.split_at(usize::try_from(point).unwrap_or(0));
            format!("{whole}.{fraction}")
        }
        -5..=0 => format!("0.{}{digits}", zeros(-point)),
        _ => {
            let (first, rest) = digits.split_at(1);
            let dot = if rest.is_empty() { "" } else { "." };
            format!("{first}{dot}{rest}e{:+}", point - 1)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_ecmascript_writes_them() {
        let written = [
            (1.0, "1"),
            (-0.0, "0"),
            (83.2, "83.2"),
            (-0.5, "-0.5"),
            (1e21, "1e+21"),
            (1e20, "100000000000000000000"),
            (0.000_001, "0.000001"),
            (1.5e-7, "1.5e-7"),
            (123_456.789, "123456.789"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-Infinity"),
        ];
        for (number, text) in written {
            assert_eq!(number_text(number), text);
        }
    }

    #[test]
    fn strings_are_read_as_ecmascript_reads_them() {
        for (text, number) in
            [("", 0.0), ("  12 ", 12.0), ("0x1F", 31.0), (".5", 0.5), ("1e3", 1000.0), ("-Infinity", f64::NEG_INFINITY)]
        {
            assert_eq!(numeric(text), number, "{text:?}");
        }
        for text in ["12px", "inf", "nan", "1_000", "e", ".", "0x", "0x+1"] {
            assert!(numeric(text).is_nan(), "{text:?}");
        }
    }

    #[test]
    fn undefined_compares_with_nothing() {
        let thirty = Datum::from(30.0);
        assert_eq!(Datum::Undefined.order(&thirty), None);
        assert_eq!(Datum::Null.order(&thirty), Some(Ordering::Less), "null is 0");
        assert_eq!(Datum::from("100").order(&thirty), Some(Ordering::Greater), "a string and a number: numbers");
        assert_eq!(Datum::from("100").order(&"30".into()), Some(Ordering::Less), "two strings: strings");
    }

    #[test]
    fn loose_equality_coerces_and_strict_equality_does_not() {
        let equal = |a: Datum, b: Datum| (a.equal(&b), a.identical(&b));
        assert_eq!(equal(Datum::Null, Datum::Undefined), (true, false));
        assert_eq!(equal("1".into(), 1.0.into()), (true, false));
        assert_eq!(equal(true.into(), 1.0.into()), (true, false));
        assert_eq!(equal(f64::NAN.into(), f64::NAN.into()), (false, false));
        assert_eq!(equal(Datum::Null, 0.0.into()), (false, false));
        let one = Datum::array([1.0.into()]).unwrap();
        assert_eq!(equal(one.clone(), 1.0.into()), (true, false));
        assert_eq!(equal(one.clone(), one.clone()), (true, true), "the same array");
        assert_eq!(equal(one, Datum::array([1.0.into()]).unwrap()), (false, false), "an array like it");
    }
}
