//! The keys that a reader asks for, collected without a file.

use std::cell::RefCell;
use std::time::Duration;

use super::Table;
use super::log::Log;
use super::node::Entries;
use crate::{Source, Spanned};

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
    fn new(path: String, takes: Takes) -> Self {
        let (about, filled, required) = (String::new(), false, false);
        Self { path, about, takes, words: None, range: None, filled, default: None, required }
    }

    /// All keys that `read` asks for, in this order. It reads an empty file in which every table exists once, so what
    /// it returns and reports has no meaning.
    ///
    /// ```
    /// use diagnostics::document::DeclaredKey;
    ///
    /// let keys = DeclaredKey::all(|root| {
    ///     let battery = root.table("battery").about("The battery.").optional();
    ///     battery.map(|battery| battery.number("charge_pct").about("Charge, in percent.").default(80.0));
    /// });
    /// assert_eq!(keys[1].path, "battery.charge_pct");
    /// assert_eq!(keys[1].default, Some(80.0.into()));
    /// ```
    pub fn all(read: impl for<'d> FnOnce(Table<'d>)) -> Vec<Self> {
        let (entries, span) = (Entries::default(), Source::new("", "").span(0..0));
        let log = Log { declared: Some(RefCell::default()), ..Log::default() };
        read(Table::open(&entries, &span, &log));
        log.declared.map(RefCell::into_inner).unwrap_or_default()
    }
}

impl Log {
    /// Declares a key of the table with this number, unless a file is read. Returns the key's number.
    pub(super) fn declare(&self, table: Option<usize>, key: &str, takes: Takes) -> Option<usize> {
        let mut declared = self.declared.as_ref()?.borrow_mut();
        let many = matches!(&takes, Takes::Array(of, _) if **of == Takes::Table);
        let table = table.map_or_else(String::new, |table| format!("{}.", declared[table].path));
        let path = format!("{table}{key}{}", if many { "[]" } else { "" });
        if let Some(known) = declared.iter().position(|known| known.path == path) {
            return Some(known);
        }
        declared.push(DeclaredKey::new(path, takes));
        Some(declared.len() - 1)
    }

    /// Changes a declaration, if there is one.
    pub(super) fn amend(&self, key: Option<usize>, change: impl FnOnce(&mut DeclaredKey)) {
        if let (Some(declared), Some(key)) = (&self.declared, key) {
            change(&mut declared.borrow_mut()[key]);
        }
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
