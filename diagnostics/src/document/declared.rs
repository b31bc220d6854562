//! Keys as their readers declare them.

use std::time::Duration;

use crate::Spanned;

/// A key as its reader declares it.
#[derive(Clone, Debug)]
pub struct DeclaredKey {
    /// Its path: `battery.initial_pct`. `[]` follows an array of tables.
    pub path: String,
    /// Its meaning, with its unit. Empty if the reader does not give it.
    pub about: String,
    /// The type of its value.
    pub takes: Takes,
    /// The accepted values in words, where the type does not say it all.
    pub words: Option<String>,
    /// The least and the greatest value.
    pub range: Option<[toml::Value; 2]>,
    /// Whether a text must have at least one character.
    pub filled: bool,
    /// The value of a missing key.
    pub default: Option<toml::Value>,
    /// Whether its table needs it.
    pub required: bool,
}

/// The type of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Takes {
    /// A text.
    Text,
    /// A text among these.
    OneOf(Vec<String>),
    /// A finite number.
    Number,
    /// An integer.
    Integer,
    /// An integer of at least 0.
    Count,
    /// True or false.
    Flag,
    /// A time span in seconds.
    Seconds,
    /// A table.
    Table,
    /// An array; of this length, if it is fixed.
    Array(Box<Self>, Option<usize>),
    /// Something that only its reader knows.
    Other,
}

impl DeclaredKey {
    pub(super) fn new(path: String, takes: Takes) -> Self {
        let (about, filled, required) = (String::new(), false, false);
        Self { path, about, takes, words: None, range: None, filled, default: None, required }
    }
}

/// A value as a file contains it.
pub trait Written {
    /// The value in TOML.
    fn written(&self) -> toml::Value;
}

/// Implements [`Written`] for types that TOML has.
macro_rules! written {
    ($($type:ty)*) => {
        $(impl Written for $type {
            fn written(&self) -> toml::Value {
                self.clone().into()
            }
        })*
    };
}

written!(f64 i64 bool String);

impl Written for u64 {
    fn written(&self) -> toml::Value {
        i64::try_from(*self).unwrap_or(i64::MAX).into()
    }
}

impl Written for Duration {
    fn written(&self) -> toml::Value {
        self.as_secs_f64().into()
    }
}

impl<T: Written> Written for Spanned<T> {
    fn written(&self) -> toml::Value {
        self.value.written()
    }
}

impl<T: Written> Written for Vec<T> {
    fn written(&self) -> toml::Value {
        toml::Value::Array(self.iter().map(T::written).collect())
    }
}

impl<T: Written, const N: usize> Written for [T; N] {
    fn written(&self) -> toml::Value {
        toml::Value::Array(self.iter().map(T::written).collect())
    }
}
