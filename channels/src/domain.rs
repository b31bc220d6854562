//! Domains: which messages a channel may carry.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{Message, Symbol, Value};

/// The possible values of a field of a message.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FieldKind {
    /// One of these symbols.
    Symbol(Vec<Symbol>),
    /// `true` or `false`.
    Bool,
    /// An integer.
    Int,
    /// A real number other than NaN.
    Real,
    /// Text.
    Text,
    /// A value of the inner kind, or [`NONE`](Self::NONE).
    Optional(Box<Self>),
    /// Any number of values of the inner kind.
    List(Box<Self>),
}

impl FieldKind {
    /// The name of the symbol that an optional field without a value holds: `<none>`.
    pub const NONE: &str = "none";

    /// One of the symbols with these names.
    #[must_use]
    pub fn symbols<const N: usize>(names: [&str; N]) -> Self {
        Self::Symbol(names.map(Symbol::new).to_vec())
    }

    /// The kind of a value if there is one: that inside an optional kind; any other kind itself.
    #[must_use]
    pub fn present(&self) -> &Self {
        if let Self::Optional(kind) = self { kind.present() } else { self }
    }

    /// Whether a field of this kind may hold the value.
    #[must_use]
    pub fn contains(&self, value: &Value) -> bool {
        match (self, value) {
            (Self::Symbol(symbols), Value::Symbol(symbol)) => symbols.contains(symbol),
            (Self::Real, Value::Real(number)) => !number.is_nan(),
            (Self::Bool, Value::Bool(_)) | (Self::Int, Value::Int(_)) | (Self::Text, Value::Text(_)) => true,
            (Self::Optional(kind), value) => value.is_symbol(Self::NONE) || kind.contains(value),
            (Self::List(kind), Value::List(items)) => items.iter().all(|item| kind.contains(item)),
            _ => false,
        }
    }

    /// The value as a field of this kind holds it: itself, or the real that is equal to an integer. `None` if it can
    /// hold neither.
    fn admit(&self, value: &Value) -> Option<Value> {
        match (self, value) {
            (Self::Optional(kind), value) if !value.is_symbol(Self::NONE) => kind.admit(value),
            (Self::Real, Value::Int(integer)) => Value::exact_real(*integer),
            (Self::List(kind), Value::List(items)) => {
                items.iter().map(|item| kind.admit(item)).collect::<Option<_>>().map(Value::List)
            }
            _ => self.contains(value).then(|| value.clone()),
        }
    }

    /// Whether a field of this kind can be equal to the value or be ordered relative to it. Integers and reals compare
    /// with each other.
    #[must_use]
    pub fn is_comparable_to(&self, value: &Value) -> bool {
        match self {
            Self::Int | Self::Real => value.as_number().is_some(),
            Self::Optional(kind) => value.is_symbol(Self::NONE) || kind.is_comparable_to(value),
            Self::Symbol(_) | Self::Bool | Self::Text => self.contains(value),
            Self::List(_) => matches!(value, Value::List(_)),
        }
    }
}

impl fmt::Display for FieldKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Symbol(symbols) => {
                let names: Vec<String> = symbols.iter().map(Symbol::to_string).collect();
                f.write_str(&names.join(" | "))
            }
            Self::Bool => f.write_str("bool"),
            Self::Int => f.write_str("int"),
            Self::Real => f.write_str("real"),
            Self::Text => f.write_str("text"),
            Self::Optional(kind) => write!(f, "{kind} | <{}>", Self::NONE),
            Self::List(kind) => match kind.to_string() {
                several if several.contains(" | ") => write!(f, "list of ({several})"),
                kind => write!(f, "list of {kind}"),
            },
        }
    }
}

/// The part that a message plays between a client and the process that serves it.
///
/// The system itself has only one rule about roles: a [topic](Self::Topic)'s waiting message gives way to a newer one.
/// The others are up to the processes, which number requests and goals, and repeat the number in every message that
/// belongs to them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Role {
    /// A client requests a [reply](Self::Reply).
    Request,
    /// The answer to a request, exactly one.
    Reply,
    /// A process publishes a message, which has no answer.
    Topic,
    /// A client requests something that takes time.
    Goal,
    /// The client cancels its goal.
    Cancel,
    /// News about a goal that is still being pursued; there may be any number of them.
    Feedback,
    /// The end of a goal, exactly one.
    Result,
}

/// One form that the messages of a channel may have: named fields with their kinds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    fields: Vec<(String, FieldKind)>,
    role: Role,
}

impl Shape {
    /// The shape with these fields, in the order `m[1]`, `m[2]`, …: that of requests.
    #[must_use]
    pub fn new(fields: impl IntoIterator<Item = (impl Into<String>, FieldKind)>) -> Self {
        Self { fields: fields.into_iter().map(|(name, kind)| (name.into(), kind)).collect(), role: Role::Request }
    }

    /// The shape of messages in another role.
    #[must_use]
    pub fn with_role(self, role: Role) -> Self {
        Self { role, ..self }
    }

    /// The role of messages of this shape.
    #[must_use]
    pub fn role(&self) -> Role {
        self.role
    }

    /// The symbols that a message of this shape may begin with; empty if its first field is of another kind.
    #[must_use]
    pub fn heads(&self) -> &[Symbol] {
        match self.fields.first() {
            Some((_, FieldKind::Symbol(symbols))) => symbols,
            _ => &[],
        }
    }

    /// The fields' names and kinds, in the order `m[1]`, `m[2]`, …
    #[must_use]
    pub fn fields(&self) -> &[(String, FieldKind)] {
        &self.fields
    }

    /// Whether the message has this shape.
    #[must_use]
    pub fn contains(&self, message: &Message) -> bool {
        let values = message.fields();
        values.len() == self.fields.len()
            && self.fields.iter().zip(values).all(|((_, kind), value)| kind.contains(value))
    }

    fn admit(&self, message: &Message) -> Option<Message> {
        let values = message.fields();
        let admitted = self.fields.iter().zip(values).map(|((_, kind), value)| kind.admit(value));
        let admitted: Option<Vec<Value>> = admitted.collect();
        admitted.filter(|admitted| admitted.len() == self.fields.len().max(values.len())).map(Message::new)
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fields: Vec<String> = self.fields.iter().map(|(name, kind)| format!("{name}: {kind}")).collect();
        write!(f, "[{}]", fields.join(", "))
    }
}

/// The messages that a channel may carry, dom((p, q)): the union of some shapes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Domain {
    shapes: Vec<Shape>,
}

impl Domain {
    /// The domain of all messages that have one of these shapes.
    #[must_use]
    pub fn new(shapes: impl IntoIterator<Item = Shape>) -> Self {
        Self { shapes: shapes.into_iter().collect() }
    }

    /// The domain with the same messages, all in this role.
    #[must_use]
    pub fn in_role(self, role: Role) -> Self {
        Self { shapes: self.shapes.into_iter().map(|shape| shape.with_role(role)).collect() }
    }

    /// The shapes, in the order they were declared.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Whether the channel may carry the message.
    #[must_use]
    pub fn contains(&self, message: &Message) -> bool {
        self.shapes.iter().any(|shape| shape.contains(message))
    }

    /// The message as the channel may carry it: where a field is real, an integer becomes the real that is equal to it.
    /// This is for messages from formats that write 30.0 as 30. `None` if there is no such message, or an integer would
    /// be rounded.
    #[must_use]
    pub fn admit(&self, message: &Message) -> Option<Message> {
        if self.contains(message) {
            return Some(message.clone());
        }
        self.shapes.iter().find_map(|shape| shape.admit(message))
    }

    /// The first shape of this domain that the message has.
    #[must_use]
    pub fn shape_of(&self, message: &Message) -> Option<&Shape> {
        self.shapes.iter().find(|shape| shape.contains(message))
    }

    /// Whether `newer` replaces `waiting` in a channel: both are messages of the same topic.
    #[must_use]
    pub fn gives_way(&self, waiting: &Message, newer: &Message) -> bool {
        let is_topic = || self.shape_of(newer).is_some_and(|shape| shape.role == Role::Topic);
        waiting.head() == newer.head() && is_topic()
    }
}

impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shapes: Vec<String> = self.shapes.iter().map(Shape::to_string).collect();
        f.write_str(&shapes.join(" or "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_domain_contains_only_messages_of_its_shapes() {
        let level = Domain::new([
            Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]),
            Shape::new([("status", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]),
        ]);
        let message = |head, value: Value| Message::new([Value::symbol(head), value]);
        assert!(level.contains(&message("ok", 83.2.into())));
        assert!(level.contains(&message("error", "no sensor".into())));
        assert!(!level.contains(&message("ok", "no sensor".into())));
        assert!(!level.contains(&message("ok", f64::NAN.into())));
        assert!(!level.contains(&message("ok", 83.into())));
        assert!(!level.contains(&Message::symbols(["ok"])));
    }

    #[test]
    fn an_integer_is_admitted_as_a_real_only_where_it_is_equal_to_one() {
        let real = FieldKind::Optional(Box::new(FieldKind::Real));
        let domain = Domain::new([
            Shape::new([("n", FieldKind::Int)]),
            Shape::new([("n", FieldKind::Int), ("x", FieldKind::Real)]),
            Shape::new([("s", FieldKind::symbols(["ok"])), ("x", real)]),
        ]);
        let none = || Value::symbol(FieldKind::NONE);
        let admitted = |values: &[Value]| domain.admit(&Message::new(values.iter().cloned()));
        let message = |values: &[Value]| Some(Message::new(values.iter().cloned()));
        const EXACT: i64 = 1 << 53;
        assert_eq!(admitted(&[3.into()]), message(&[3.into()]), "it fits as it is");
        assert_eq!(admitted(&[3.into(), EXACT.into()]), message(&[3.into(), (EXACT as f64).into()]));
        assert_eq!(admitted(&[Value::symbol("ok"), 3.into()]), message(&[Value::symbol("ok"), 3.0.into()]));
        assert_eq!(admitted(&[Value::symbol("ok"), none()]), message(&[Value::symbol("ok"), none()]));
        for outside in [&[3.into(), (EXACT + 1).into()][..], &[3.5.into()], &[], &[3.into(), 1.into(), 1.into()]] {
            assert_eq!(admitted(outside), None, "{outside:?}");
        }
    }
}
