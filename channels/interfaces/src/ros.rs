//! ROS 2 interface definitions: the contents of `.msg`, `.srv` and `.action` files.
//!
//! The whole grammar of rosidl is read, and `Display` prints it again: comments, constants, default values, bounded
//! strings and arrays, types of the same or of another package, and the annotations `@optional` and `@key`. Names are
//! checked as in ROS, values against their types. Text that ROS itself would silently misread, such as a string cut off
//! by a `#`, is an error here.
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
//! An array is a [`Type`] with a [`Count`], as CDR needs it.
//!
//! [`Bundle`] reads the definitions in recordings, in this language or in the IDL that ROS generates from it.
//! [`Service::messages`] and [`Action::messages`] are the messages that ROS sends for services and actions.

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
    /// `@key`: it identifies the thing that a message is about.
    pub is_key: bool,
}

/// A constant of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Its name.
    pub name: String,
    /// The type of its value: neither a message nor bounded.
    pub base: Base,
    /// Its value.
    pub value: Literal,
}

/// A value in a definition. It fits its type: an integer is within the range, and a string or array has a permitted
/// length.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// A truth value.
    Bool(bool),
    /// An integer of up to 64 bits, signed or unsigned.
    Int(i128),
    /// A floating-point number; may be infinite or NaN.
    Real(f64),
    /// A text.
    Text(String),
    /// The items of an array.
    Array(Vec<Self>),
}
