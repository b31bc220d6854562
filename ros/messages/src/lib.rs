//! ROS 2 messages without ROS: their definitions, and their encoding in both directions.
//!
//! **Definitions.** [`Message`], [`Service`] and [`Action`] are the contents of `.msg`, `.srv` and `.action` files. The
//! whole grammar of rosidl is read, and `Display` prints it again: comments, constants, default values, bounded strings
//! and arrays, types of the same or of another package, and the annotations `@optional` and `@key`. Names are checked
//! as in ROS, values against their types. Text that ROS itself would silently misread, such as a string cut off by a
//! `#`, is an error here.
//!
//! ```
//! use ros_messages::{Base, Count, Message, Primitive, TypeName};
//!
//! let text = "uint8 OPEN=1  # a constant\nuint8 state 1\nfloat32[<=4] ranges\ngeometry_msgs/Pose pose\n";
//! let door = Message::parse("Door.msg", text)?;
//! assert_eq!(door.constants[0].name, "OPEN");
//! assert_eq!(door.fields[1].kind.base, Base::Primitive(Primitive::Float32));
//! assert_eq!(door.fields[1].kind.count, Count::UpTo(4));
//! assert_eq!(door.fields[2].kind.base, Base::Message(TypeName::new(Some("geometry_msgs"), "Pose")));
//! assert_eq!(Message::parse("printed", &door.to_string())?, door);
//! # Ok::<(), diagnostics::FileProblems>(())
//! ```
//!
//! [`Bundle`] reads the definitions in recordings, in this language or in the IDL that ROS generates from it.
//! [`Service::messages`] and [`Action::messages`] are the messages that ROS sends for services and actions.
//!
//! **Types.** A [`Layout`] is a message type with all types in it resolved, from the definitions in [`Folders`] or
//! wherever [`Layout::resolve`] finds them.
//!
//! **Messages.** A [`Decoder`] decodes CDR into a [`Value`], and skips what is not wanted; a [`Structure`] accesses its
//! fields by name. What a program sends is [`messages!`]: structs with both definition and encoding.

mod decoder;
mod definition;
mod folders;
mod layout;
mod reader;
mod rust;
mod structure;
mod value;
mod writer;

pub use decoder::{Decoder, Want};
pub use definition::{
    Action, Base, Bundle, Constant, Count, Field, Literal, Message, Primitive, Service, Type, TypeName,
};
pub use folders::Folders;
pub use layout::{Layout, Undefined};
pub use rust::{Byte, RosMessage, RosType};
pub use structure::Structure;
pub use value::{Mismatch, Value};
pub use writer::CdrWriter;
