//! Interface definitions of ROS 2 as parsed: the contents of `.msg`, `.srv` and `.action` files.

mod annotations;
mod bundle;
mod generated;
mod idl;
mod line;
mod literal;
mod names;
mod parse;
mod print;
mod span_parts;
mod types;

pub use bundle::Bundle;
pub use names::is_name;
pub use types::{Base, Count, Primitive, Type, TypeName};

use crate::value::Value;

/// A message: the content of a `.msg` file, or a part of another definition.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Message {
    /// Named values; they are not sent.
    pub constants: Vec<Constant>,
    /// The fields that are sent, in this order. In the IDL that ROS generates, a message without fields has one, a
    /// `uint8` named `structure_needs_at_least_one_member`, and so has its CDR.
    pub fields: Vec<Field>,
}

/// A service: what a `.srv` file defines.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Service {
    /// The request.
    pub request: Message,
    /// The response.
    pub response: Message,
}

/// An action: what an `.action` file defines.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Action {
    /// The goal.
    pub goal: Message,
    /// How it ended.
    pub result: Message,
    /// How it goes.
    pub feedback: Message,
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Field<M = TypeName> {
    /// Its name.
    pub name: String,
    /// What it holds.
    pub kind: Type<M>,
    /// Its initial value, if the definition gives one. It fits the type.
    pub default: Option<Value>,
    /// `@optional`: it may be missing.
    pub is_optional: bool,
    /// `@key`: it identifies the thing that a message is about.
    pub is_key: bool,
}

impl<M> Field<M> {
    /// A field without a default value and annotations.
    #[must_use]
    pub fn new(name: &str, kind: Type<M>) -> Self {
        Self { name: name.to_owned(), kind, default: None, is_optional: false, is_key: false }
    }
}

/// A constant of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Its name.
    pub name: String,
    /// The type of its value, without a bound.
    pub kind: Primitive,
    /// Its value, which fits the type.
    pub value: Value,
}
