//! Values.

/// A value: of a message, decoded or to be encoded, or in its definition.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A value that was not wanted.
    Passed,
    /// A Boolean.
    Bool(bool),
    /// An integer of up to 64 bits, signed or unsigned.
    Int(i128),
    /// A floating-point number of 64 or 32 bits; may be infinite or NaN.
    Real(f64),
    /// A string. Invalid UTF-8 or UTF-16 in it is replaced.
    Text(String),
    /// The items of an array.
    List(Vec<Self>),
    /// The fields of a message, in the order of its layout.
    Message(Vec<Self>),
}

/// These reuse the memory of the value before, if it has the same form.
impl Value {
    /// Turns this into a message with `count` fields.
    pub(crate) fn fields(&mut self, count: usize) -> &mut [Self] {
        if !matches!(self, Self::Message(fields) if fields.len() == count) {
            *self = Self::Message(vec![Self::Passed; count]);
        }
        let Self::Message(fields) = self else { return &mut [] };
        fields
    }

    /// Turns this into an array with `count` items.
    pub(crate) fn items(&mut self, count: usize) -> &mut [Self] {
        if !matches!(self, Self::List(_)) {
            *self = Self::List(Vec::new());
        }
        let Self::List(items) = self else { return &mut [] };
        items.resize(count, Self::Passed);
        items
    }

    /// Whether both are the same value; unlike equal values, also if they are NaN.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Real(a), Self::Real(b)) => a.to_bits() == b.to_bits(),
            (Self::List(a), Self::List(b)) | (Self::Message(a), Self::Message(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.is_same(b))
            }
            (a, b) => a == b,
        }
    }

    /// Turns this into a string.
    pub(crate) fn set_text(&mut self, text: &str) {
        match self {
            Self::Text(before) => {
                before.clear();
                before.push_str(text);
            }
            other => *other = Self::Text(text.to_owned()),
        }
    }
}

/// How many bytes a unit of a wide string has.
///
/// Source: `cdr_serialize` in `serialization_helpers.hpp` of `rosidl_typesupport_fastrtps_cpp` 3.6, and
/// `Cdr::serialize(wchar_t)` of Fast CDR 1 and 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WideWidth {
    /// In programs that use Fast CDR 2 without ROS.
    Two,
    /// In ROS, with all kinds of middleware.
    #[default]
    Four,
}

/// Why bytes or a value are not a message of that type.
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
    /// Wide strings fit with each width that ROS has used, or contain what is no character.
    #[error("it is not known how wide the characters of their wide strings are")]
    Wide,
    /// The value is of another type than its field, or out of its range.
    #[error("a value does not fit its field")]
    Value,
}
