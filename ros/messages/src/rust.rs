//! Rust types that are ROS types: their definition, and both directions of their encoding, are made from the same list
//! of fields.

use std::borrow::Cow;

use crate::definition::{Base, Bundle, Count, Message, Primitive, Type, TypeName};
use crate::reader::CdrReader;
use crate::value::Mismatch;
use crate::writer::CdrWriter;

/// A Rust type that can be a field of a message.
pub trait RosType: Sized {
    /// Its type in ROS.
    fn kind() -> Type;

    /// Adds its own definition, if it is a message, and those of the messages in it, each once.
    fn define(_types: &mut Vec<(TypeName, Message)>) {}

    /// Writes a value.
    fn write(&self, cdr: &mut CdrWriter);

    /// Reads a value.
    ///
    /// # Errors
    /// [`Mismatch`] if the bytes that follow are not of this type.
    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch>;

    /// Writes several values, one after the other.
    fn write_all(items: &[Self], cdr: &mut CdrWriter) {
        items.iter().for_each(|item| item.write(cdr));
    }

    /// Reads several values, one after the other.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn read_all(count: usize, cdr: &mut CdrReader<'_>) -> Result<Vec<Self>, Mismatch> {
        (0..count).map(|_| Self::read(cdr)).collect()
    }

    /// A message that consists of this value.
    fn encode(&self) -> Vec<u8> {
        let mut cdr = CdrWriter::reusing(Vec::new());
        self.write(&mut cdr);
        cdr.bytes()
    }

    /// The value with which a message begins. What follows is ignored.
    ///
    /// # Errors
    /// [`Mismatch`] if the message is not in CDR, or does not begin with a value of this type.
    fn decode(message: &[u8]) -> Result<Self, Mismatch> {
        Self::read(&mut CdrReader::new(message)?)
    }
}

/// A Rust type that is a message. [`messages!`](crate::messages) makes them.
pub trait RosMessage: RosType {
    /// Its name, with the package.
    fn name() -> TypeName;

    /// Its definition, with all types in it.
    #[must_use]
    fn definition() -> Bundle {
        let mut types = Vec::new();
        Self::define(&mut types);
        let mut types = types.into_iter();
        Bundle { message: types.next().map(|(_, own)| own).unwrap_or_default(), types: types.collect() }
    }
}

macro_rules! numbers {
    ($($number:ty = $kind:ident),* $(,)?) => {$(
        impl RosType for $number {
            fn kind() -> Type {
                one(Primitive::$kind)
            }

            fn write(&self, cdr: &mut CdrWriter) {
                cdr.number(self.to_le_bytes());
            }

            fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
                cdr.number().map(Self::from_le_bytes)
            }

            fn write_all(items: &[Self], cdr: &mut CdrWriter) {
                cdr.numbers(items.iter().map(|item| item.to_le_bytes()));
            }

            fn read_all(count: usize, cdr: &mut CdrReader<'_>) -> Result<Vec<Self>, Mismatch> {
                Ok(cdr.numbers(count)?.map(Self::from_le_bytes).collect())
            }
        }
    )*};
}

numbers!(u8 = Uint8, u16 = Uint16, u32 = Uint32, u64 = Uint64, i8 = Int8, i16 = Int16, i32 = Int32, i64 = Int64);
numbers!(f32 = Float32, f64 = Float64);

fn one(primitive: Primitive) -> Type {
    Type { base: Base::Primitive(primitive), count: Count::One }
}

impl RosType for bool {
    fn kind() -> Type {
        one(Primitive::Bool)
    }

    fn write(&self, cdr: &mut CdrWriter) {
        cdr.number([u8::from(*self)]);
    }

    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
        match cdr.number()? {
            [byte @ (0 | 1)] => Ok(byte == 1),
            _ => Err(Mismatch::Bool),
        }
    }
}

/// Invalid UTF-8 in a string that is read is replaced.
impl RosType for String {
    fn kind() -> Type {
        one(Primitive::String(None))
    }

    fn write(&self, cdr: &mut CdrWriter) {
        cdr.text(self);
    }

    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
        Ok(Self::from_utf8_lossy(cdr.string(None)?).into_owned())
    }
}

/// For strings of which most are known at compile time, such as the names of frames.
impl RosType for Cow<'static, str> {
    fn kind() -> Type {
        String::kind()
    }

    fn write(&self, cdr: &mut CdrWriter) {
        cdr.text(self);
    }

    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
        String::read(cdr).map(Self::Owned)
    }
}

/// ROS's `byte`: eight bits without a meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Byte(pub u8);

impl RosType for Byte {
    fn kind() -> Type {
        one(Primitive::Byte)
    }

    fn write(&self, cdr: &mut CdrWriter) {
        self.0.write(cdr);
    }

    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
        u8::read(cdr).map(Self)
    }
}

/// An array of this length; not of arrays, which ROS does not have.
impl<T: RosType + Copy + Default, const LENGTH: usize> RosType for [T; LENGTH] {
    fn kind() -> Type {
        Type { count: Count::Exactly(LENGTH), ..T::kind() }
    }

    fn define(types: &mut Vec<(TypeName, Message)>) {
        T::define(types);
    }

    fn write(&self, cdr: &mut CdrWriter) {
        T::write_all(self, cdr);
    }

    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
        let mut items = [T::default(); LENGTH];
        items.iter_mut().try_for_each(|item| T::read(cdr).map(|read| *item = read))?;
        Ok(items)
    }
}

/// An array of any length; not of arrays, which ROS does not have.
impl<T: RosType> RosType for Vec<T> {
    fn kind() -> Type {
        Type { count: Count::Any, ..T::kind() }
    }

    fn define(types: &mut Vec<(TypeName, Message)>) {
        T::define(types);
    }

    fn write(&self, cdr: &mut CdrWriter) {
        cdr.length(self.len());
        T::write_all(self, cdr);
    }

    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
        let count = cdr.length(usize::MAX)?;
        T::read_all(count, cdr)
    }
}

/// Makes structs that are messages: each with its name in ROS, and fields that are [`RosType`]s.
///
/// ```
/// use ros_messages::{RosMessage, RosType, messages};
///
/// messages! {
///     /// A point in a plane.
///     pub Point = "plane_msgs/Point" { x: f32, y: f32 }
///     /// A line through points.
///     pub Line = "plane_msgs/Line" { points: Vec<Point> }
/// }
///
/// let rule = "=".repeat(80);
/// let definition = format!("plane_msgs/Point[] points\n{rule}\nMSG: plane_msgs/Point\nfloat32 x\nfloat32 y\n");
/// assert_eq!(Line::definition().to_string(), definition);
/// let line = Line { points: vec![Point { x: 0.0, y: 0.0 }] };
/// assert_eq!(line.encode(), [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
/// assert_eq!(Line::decode(&line.encode()), Ok(line));
/// ```
///
/// The name of a field may be a raw identifier: `r#type`.
#[macro_export]
macro_rules! messages {
    ($($(#[$meta:meta])* $pub:vis $message:ident = $name:literal { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq)]
        $pub struct $message {
            $($pub $field: $kind,)*
        }

        impl $crate::RosType for $message {
            fn kind() -> $crate::Type {
                let base = $crate::Base::Message(<Self as $crate::RosMessage>::name());
                $crate::Type { base, count: $crate::Count::One }
            }

            fn define(types: &mut ::std::vec::Vec<($crate::TypeName, $crate::Message)>) {
                let name = <Self as $crate::RosMessage>::name();
                if types.iter().any(|(known, _)| *known == name) {
                    return;
                }
                let fields = vec![$($crate::Field::new(
                    stringify!($field).trim_start_matches("r#"),
                    <$kind as $crate::RosType>::kind(),
                )),*];
                types.push((name, $crate::Message { fields, ..$crate::Message::default() }));
                $(<$kind as $crate::RosType>::define(types);)*
            }

            fn write(&self, cdr: &mut $crate::CdrWriter) {
                $($crate::RosType::write(&self.$field, cdr);)*
            }

            fn read(cdr: &mut $crate::CdrReader<'_>) -> ::core::result::Result<Self, $crate::Mismatch> {
                Ok(Self { $($field: $crate::RosType::read(cdr)?),* })
            }
        }

        impl $crate::RosMessage for $message {
            fn name() -> $crate::TypeName {
                $crate::TypeName::parse($name).expect("a name that ROS permits")
            }
        }
    )*};
}
