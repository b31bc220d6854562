//! The types of fields, as ROS writes them: `float64[3]`, `string<=10`, `geometry_msgs/Pose[]`.

use super::names::{is_field_name, is_type_name};

/// The type of a field. A message in it is a name in a definition, and a [`Layout`](crate::Layout) once it is resolved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Type<M = TypeName> {
    /// The type of one item.
    pub base: Base<M>,
    /// The number of items.
    pub count: Count,
}

/// The type of one item.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Base<M = TypeName> {
    /// A Boolean, a number or a string.
    Primitive(Primitive),
    /// A message.
    Message(M),
}

/// A type that is not a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// `true` or `false`.
    Bool,
    /// Eight bits.
    Byte,
    /// A character of eight bits, an unsigned number to ROS 2.
    Char,
    /// A signed integer of 8 bits.
    Int8,
    /// An unsigned integer of 8 bits.
    Uint8,
    /// A signed integer of 16 bits.
    Int16,
    /// An unsigned integer of 16 bits.
    Uint16,
    /// A signed integer of 32 bits.
    Int32,
    /// An unsigned integer of 32 bits.
    Uint32,
    /// A signed integer of 64 bits.
    Int64,
    /// An unsigned integer of 64 bits.
    Uint64,
    /// A floating-point number of 32 bits.
    Float32,
    /// A floating-point number of 64 bits.
    Float64,
    /// A string of bytes, usually UTF-8, with at most this many bytes.
    String(Option<usize>),
    /// A string of UTF-16, with at most this many units.
    WString(Option<usize>),
}

/// How many items a field has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// One: not an array.
    One,
    /// `[3]`: always this many.
    Exactly(usize),
    /// `[<=3]`: at most this many.
    UpTo(usize),
    /// `[]`: any number.
    Any,
}

/// The name of a message type.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TypeName {
    /// The package; `None` for the package of the definition that names the type.
    pub package: Option<String>,
    /// The name in the package.
    pub name: String,
}

impl TypeName {
    /// The type with this name, in this package or in that of the definition that names it.
    #[must_use]
    pub fn new(package: Option<&str>, name: &str) -> Self {
        Self { package: package.map(str::to_owned), name: name.to_owned() }
    }

    /// Reads the name of a message type: `Pose`, `geometry_msgs/Pose` or `geometry_msgs/msg/Pose`. `None` if ROS does
    /// not permit it.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let name = match *text.split('/').collect::<Vec<_>>() {
            [name] => Self::new(None, name),
            [package, name] | [package, "msg" | "srv" | "action", name] => Self::new(Some(package), name),
            _ => return None,
        };
        let is_sound = name.package.as_deref().is_none_or(is_field_name) && is_type_name(&name.name);
        is_sound.then_some(name)
    }

    /// The name as used for topics: `geometry_msgs/msg/Pose`. Only what a service or an action defines has an
    /// underscore in its name: `std_srvs/srv/SetBool_Request`, `nav2_msgs/action/Spin_FeedbackMessage`.
    #[must_use]
    pub fn full(&self) -> String {
        let kind = match self.name.split_once('_') {
            None => "msg",
            Some((_, "Request" | "Response" | "Event")) => "srv",
            Some(_) => "action",
        };
        format!("{}/{kind}/{}", self.package.as_deref().unwrap_or_default(), self.name)
    }

    /// The name of what defines the message: `Spin_Goal` is in Spin.action. A message of its own defines itself.
    pub(crate) fn whole(&self) -> Self {
        let whole = self.name.split_once('_').map_or(self.name.as_str(), |(whole, _)| whole);
        Self::new(self.package.as_deref(), whole)
    }

    /// The name with its package, as used in a definition of `package`.
    #[must_use]
    pub fn within(&self, package: &str) -> Self {
        Self { package: Some(self.package.as_deref().unwrap_or(package).to_owned()), name: self.name.clone() }
    }
}

impl Primitive {
    /// The types by name. Strings are listed without a bound.
    pub(super) const NAMES: [(&str, Self); 15] = [
        ("bool", Self::Bool),
        ("byte", Self::Byte),
        ("char", Self::Char),
        ("int8", Self::Int8),
        ("uint8", Self::Uint8),
        ("int16", Self::Int16),
        ("uint16", Self::Uint16),
        ("int32", Self::Int32),
        ("uint32", Self::Uint32),
        ("int64", Self::Int64),
        ("uint64", Self::Uint64),
        ("float32", Self::Float32),
        ("float64", Self::Float64),
        ("string", Self::String(None)),
        ("wstring", Self::WString(None)),
    ];

    /// The least and the greatest value, if it is an integer.
    #[must_use]
    pub fn range(self) -> Option<(i128, i128)> {
        let signed = |bits: u32| Some((-(1 << (bits - 1)), (1 << (bits - 1)) - 1));
        let unsigned = |bits: u32| Some((0, (1 << bits) - 1));
        match self {
            Self::Byte | Self::Char | Self::Uint8 => unsigned(8),
            Self::Uint16 => unsigned(16),
            Self::Uint32 => unsigned(32),
            Self::Uint64 => unsigned(64),
            Self::Int8 => signed(8),
            Self::Int16 => signed(16),
            Self::Int32 => signed(32),
            Self::Int64 => signed(64),
            _ => None,
        }
    }
}
