//! ROS 2 interface definitions: what `.msg`, `.srv` and `.action` files say.
//!
//! The whole grammar of rosidl is read, and printed again by `Display`: comments, constants, default values, bounded
//! texts and arrays, types of the same or of another package, the annotations `@optional` and `@key`. A name is checked
//! as ROS checks it, a value against its type. Text that ROS itself would silently misunderstand, such as a string that
//! a `#` cuts off, is an error here.
//!
//! ```
//! use interfaces::ros::{Base, Count, Message, TypeName};
//!
//! let text = "uint8 OPEN=1  # a constant\nuint8 state 1\nfloat32[<=4] ranges\ngeometry_msgs/Pose pose\n";
//! let door = Message::parse("Door.msg", text)?;
//! assert_eq!(door.constants[0].name, "OPEN");
//! assert_eq!(door.fields[1].kind.base, Base::Float32);
//! assert_eq!(door.fields[1].kind.count, Count::UpTo(4));
//! assert_eq!(door.fields[2].kind.base, Base::Message(TypeName::new(Some("geometry_msgs"), "Pose")));
//! assert_eq!(Message::parse("printed", &door.to_string())?, door);
//! # Ok::<(), diagnostics::FileProblems>(())
//! ```
//!
//! An array of an element type, as CDR needs to know it, is a [`Type`] with its [`Count`].
//!
//! [`Bundle`] reads what recordings have, in this language or in the IDL that ROS makes of it. [`Service::messages`]
//! and [`Action::messages`] are the messages that ROS sends for services and actions.

mod bundle;
mod definition;
mod idl;
mod line;
mod literal;
mod mark;
mod print;
mod sent;
mod stretch;
mod types;

pub use bundle::Bundle;
pub use types::{Base, Count, Type, TypeName};

/// A message: what a `.msg` file defines, and each part of the others.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Message {
    /// Named values; they are not sent.
    pub constants: Vec<Constant>,
    /// The messages that are sent, in this order. The IDL that ROS makes of a message without fields has one, a `uint8`
    /// named `structure_needs_at_least_one_member`, and so has its CDR.
    pub fields: Vec<Field>,
}

/// A service: what a `.srv` file defines.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Service {
    /// What is asked.
    pub request: Message,
    /// What is answered.
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
pub struct Field {
    /// Its name.
    pub name: String,
    /// What it holds.
    pub kind: Type,
    /// Its initial value, if the definition gives one.
    pub default: Option<Literal>,
    /// `@optional`: it may be missing.
    pub is_optional: bool,
    /// `@key`: it says which of several things a message is about.
    pub is_key: bool,
}

/// A constant of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Its name.
    pub name: String,
    /// The type of its value: not a message, and not bounded.
    pub base: Base,
    /// Its value.
    pub value: Literal,
}

/// A value in a definition. It fits its type: the integer has the range, the text and the array have the length.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// A truth value.
    Bool(bool),
    /// An integer, of up to 64 bits with or without sign.
    Int(i128),
    /// A number; may be infinite or NaN.
    Real(f64),
    /// A text.
    Text(String),
    /// The items of an array.
    Array(Vec<Self>),
}
