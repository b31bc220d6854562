//! Definitions as text, in the form that the parser reads.

use std::fmt;

use super::{Action, Base, Constant, Count, Field, Message, Primitive, Service, Type, TypeName};
use crate::value::Value;

/// Separates the parts of services and actions.
pub(super) const SEPARATOR: &str = "---";

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.constants.iter().try_for_each(|constant| writeln!(f, "{constant}"))?;
        self.fields.iter().try_for_each(|field| writeln!(f, "{field}"))
    }
}

impl fmt::Display for Service {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{SEPARATOR}\n{}", self.request, self.response)
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{SEPARATOR}\n{}{SEPARATOR}\n{}", self.goal, self.result, self.feedback)
    }
}

impl fmt::Display for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}={}", self.kind, self.name, self.value)
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.is_optional { "@optional " } else { "" })?;
        f.write_str(if self.is_key { "@key " } else { "" })?;
        write!(f, "{} {}", self.kind, self.name)?;
        self.default.as_ref().map_or(Ok(()), |default| write!(f, " {default}"))
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.base, self.count)
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One => Ok(()),
            Self::Exactly(count) => write!(f, "[{count}]"),
            Self::UpTo(count) => write!(f, "[<={count}]"),
            Self::Any => f.write_str("[]"),
        }
    }
}

impl fmt::Display for Base {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Primitive(primitive) => primitive.fmt(f),
            Self::Message(name) => name.fmt(f),
        }
    }
}

impl fmt::Display for Primitive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::String(Some(bound)) => write!(f, "string<={bound}"),
            Self::WString(Some(bound)) => write!(f, "wstring<={bound}"),
            simple => {
                let known = Self::NAMES.iter().find(|(_, kind)| kind == simple);
                f.write_str(known.map_or("", |(name, _)| name))
            }
        }
    }
}

impl fmt::Display for TypeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.package.iter().try_for_each(|package| write!(f, "{package}/"))?;
        f.write_str(&self.name)
    }
}

/// As a definition writes it. In ROS, a string cannot contain a `#`, a tab or a line end; in an array, none can end
/// with a backslash; and rosidl refuses a default value that contains `=`. Messages have no values in definitions.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Passed => Ok(()),
            Self::Bool(truth) => truth.fmt(f),
            Self::Int(number) => number.fmt(f),
            Self::Real(number) => write!(f, "{number:?}"),
            Self::Text(text) => write!(f, "\"{}\"", text.replace('"', "\\\"")),
            Self::List(items) | Self::Message(items) => {
                let items: Vec<String> = items.iter().map(Self::to_string).collect();
                write!(f, "[{}]", items.join(", "))
            }
        }
    }
}
