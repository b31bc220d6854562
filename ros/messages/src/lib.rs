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
//! wherever [`Layout::resolve`] finds them. Those of common types are [`on_board`]. [`Layout::type_hash`] is the hash
//! that ROS programs exchange.
//!
//! ```
//! use std::path::{Path, PathBuf};
//! use ros_messages::{Decoder, Folders, Structure, TypeName, Value, Want};
//!
//! let read = |path: &Path| match path.to_str() {
//!     Some("share/door_msgs/msg/Door.msg") => Ok(b"bool is_open\nfloat64 angle\n".to_vec()),
//!     _ => Err(std::io::ErrorKind::NotFound.into()),
//! };
//! let folders = Folders { paths: &[PathBuf::from("share")], read: &read };
//! let door = folders.layout(&TypeName::new(Some("door_msgs"), "Door"))?;
//! assert_eq!(door.type_hash(), "RIHS01_270d491be735b5990e252bbe0e4f71fad1a74604a5292ba4edc0e6f5ae3982b2");
//!
//! let message = Value::Message(vec![Value::Bool(true), Value::Real(0.5)]);
//! let bytes = door.encode(&message)?;
//! assert_eq!(bytes.len(), 4 + 16);
//! let decoded = Decoder::new(&door, &Want::All).decode(&bytes)?;
//! assert_eq!(Structure::of(&door, &decoded).and_then(|door| door.number("angle")), Some(0.5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Messages.** A [`Decoder`] decodes CDR into a [`Value`], and skips what is not wanted; a [`Structure`] accesses its
//! fields by name. [`Layout::encode`] is the way back. [`messages!`] makes structs with a definition and both
//! directions of the encoding, for types that are known when a program is compiled; those of ROS's common packages are
//! [`standard`]. [`CdrReader`] and [`CdrWriter`] are what all of them use.

mod decoder;
mod definition;
mod encoder;
mod folders;
mod hash;
mod layout;
mod on_board;
mod reader;
mod rust;
pub mod standard;
mod structure;
mod value;
mod writer;

pub use decoder::{Decoder, Want};
pub use definition::{
    Action, Base, Bundle, Constant, Count, Field, Message, Primitive, Service, Type, TypeName, is_name,
};
pub use folders::Folders;
pub use layout::{Layout, Undefined};
pub use on_board::{EDITIONS, messages_on_board, on_board};
pub use reader::CdrReader;
pub use rust::{Byte, RosMessage, RosType};
pub use structure::Structure;
pub use value::{Mismatch, Value, WideWidth};
pub use writer::CdrWriter;
