//! Messages: tuples of values.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::Value;
use crate::value::write_items;

/// A message: a tuple of values `m[1]`, `m[2]`, …
///
/// Copies share their values, so copying a message is cheap.
#[derive(Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Message(Arc<[Value]>);

impl Message {
    /// The message with these fields.
    #[must_use]
    pub fn new(fields: impl IntoIterator<Item = Value>) -> Self {
        Self(fields.into_iter().collect())
    }

    /// The message whose fields are these symbols: `Message::symbols(["ok", "running"])` is `[<ok>, <running>]`.
    #[must_use]
    pub fn symbols<const N: usize>(names: [&str; N]) -> Self {
        Self::new(names.map(Value::symbol))
    }

    /// Field `m[number]`, counted from 1 as in the paper; `None` if the message has no such field.
    #[must_use]
    pub fn field(&self, number: usize) -> Option<&Value> {
        self.0.get(number.checked_sub(1)?)
    }

    /// All fields in order; the first is `m[1]`.
    #[must_use]
    pub fn fields(&self) -> &[Value] {
        &self.0
    }

    /// The name of `m[1]` if it is a symbol: the kind of the message.
    #[must_use]
    pub fn head(&self) -> Option<&str> {
        match self.0.first() {
            Some(Value::Symbol(symbol)) => Some(symbol.name()),
            _ => None,
        }
    }
}

/// As the paper writes it: `[<ok>, 83.2]`. The alternate form is for readers, as that of a [`Value`].
impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_items(&self.0, f)
    }
}

impl fmt::Debug for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// The number in a request's envelope, which its reply repeats. It is not part of the message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct RequestNumber(pub u64);

/// A message in transit, with the number of its request.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Envelope {
    /// The message; properties and monitors see nothing else.
    pub message: Message,
    /// The number of the request that this message is or answers; zero if requests are not numbered.
    pub request: RequestNumber,
}

impl From<Message> for Envelope {
    fn from(message: Message) -> Self {
        Self { message, request: RequestNumber::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_print_as_in_the_paper() {
        let message = Message::new([Value::symbol("ok"), 83.2.into(), true.into(), 3.into(), "why".into()]);
        assert_eq!(message.to_string(), r#"[<ok>, 83.2, true, 3, "why"]"#);
    }

    #[test]
    fn readers_can_tell_a_number_from_one_with_fewer_digits() {
        let f32 = f64::from(0.1_f32);
        let large = (1_u64 << 60) as f64;
        let reals = [10.0, 19.999_999_9, 20.000_000_01, 9.975_000_000_000_014, 0.1, f32, -0.0, large, 1e308, 5e-324];
        let reals = Message::new(reals.map(Value::from));
        let expected = "[10, 19.999999…, 20…, 9.975…, 0.1, 0.1…, 0, 1152921504606846976, 1e308, 5e-324]";
        assert_eq!(format!("{reals:#}"), expected);
    }

    #[test]
    fn fields_are_counted_from_one() {
        let message = Message::symbols(["ok", "running"]);
        assert_eq!(message.field(0), None);
        assert_eq!(message.field(2), Some(&Value::symbol("running")));
        assert_eq!(message.field(3), None);
    }
}
