//! Reads what a user wrote in TOML or YAML: typed values, and every problem at once, each with its location.
//!
//! A [`Document`] is parsed, optionally changed by `--set`, and read once. The reader requests from a [`Table`] the
//! keys that the program has. Values that are missing, of the wrong type or out of range are recorded, and reading
//! continues. At the end, every key that was not requested is reported too, with the nearest known key as a suggestion.
//!
//! ```
//! use diagnostics::document::Document;
//!
//! let mut document = Document::parse_toml("robot.toml", "radius_m = 0.3\n[battery]\ncharge_pct = 80\n")?;
//! document.override_with(["battery.charge_pct=35"])?;
//! let (radius_m, charge_pct) = document.read(|root| {
//!     let radius_m = root.number("radius_m").within(0.05..=2.0).or(0.30);
//!     let battery = root.table("battery");
//!     let charge_pct = battery.and_then(|battery| battery.number("charge_pct").within(0.0..=100.0).required());
//!     Some((radius_m, charge_pct.required()?))
//! })?;
//! assert_eq!((radius_m, charge_pct), (0.3, 35.0));
//! # Ok::<(), diagnostics::FileProblems>(())
//! ```
//!
//! A key may also carry its meaning and default: [`Key::all`] collects them from the reader, without a file, for JSON
//! schemas and references.
//!
//! To find every problem, ask for all the keys of a table before a `?` can end the reading, and use
//! [`each`](Field::each) for arrays.

mod field;
mod item;
mod key;
mod log;
mod node;
mod overrides;
mod table;
mod toml_text;
mod yaml_text;

pub use field::Field;
pub use item::{FromItem, Item};
pub use key::{Key, Own, Referent, Written};
pub use table::Table;

use crate::{FileProblems, Source, Spanned};
use log::Log;
use node::{Kind, Node};

/// A parsed file, ready to be read.
#[derive(Debug)]
pub struct Document {
    root: Node,
}

impl Document {
    /// Parses TOML. `name` is the file's name in diagnostics.
    ///
    /// # Errors
    /// All syntax errors. A file with syntax errors is not checked further, because its meaning is uncertain.
    pub fn parse_toml(name: &str, text: &str) -> Result<Self, FileProblems> {
        Self::of_toml(&Source::new(name, text))
    }

    /// Parses TOML like [`parse_toml`](Self::parse_toml).
    ///
    /// # Errors
    /// All syntax errors.
    pub fn of_toml(source: &Source) -> Result<Self, FileProblems> {
        toml_text::document(source).map(|root| Self { root })
    }

    /// Parses YAML whose top level is a mapping. `name` is the file's name in diagnostics.
    ///
    /// # Errors
    /// The first syntax error, a second document, or a top level that is not a mapping. A text of more than 16 KiB is
    /// also refused: no file of this project needs more.
    pub fn parse_yaml(name: &str, text: &str) -> Result<Self, FileProblems> {
        yaml_text::document(&Source::new(name, text)).map(|root| Self { root })
    }

    /// Applies assignments of the form `a.b.c=value`, as the command line's `--set` takes them, in order.
    ///
    /// Dots separate the parts of a key; a number selects an item of an array (`faults.0.charge_pct=5`). Missing tables
    /// on the way are created, so that a key with a default can be set. The value is TOML. A value that is not TOML and
    /// does not begin with a quote or bracket is read as text (`--set mode=scale`). Keys that contain a dot cannot be
    /// set.
    ///
    /// # Errors
    /// Every assignment that is malformed or leads nowhere, with the location in the assignment. Unknown keys and wrong
    /// values are found when the document is read.
    pub fn override_with<'a>(&mut self, assignments: impl IntoIterator<Item = &'a str>) -> Result<(), FileProblems> {
        let problems = assignments.into_iter().filter_map(|text| overrides::apply(&mut self.root, text).err());
        FileProblems::none_of(problems.collect())
    }

    /// Takes every key that this document lacks from `base`, recursively in tables that both have. An array is one
    /// value: the document's own array replaces the base's. Problems with inherited values point into the base.
    ///
    /// `forms` are tables of the top level, each with the keys of which an entry has at most one: an entry that has
    /// another one than the base's takes nothing from it.
    pub fn inherit(&mut self, mut base: Self, forms: &[(&str, &[&str])]) {
        for (table, forms) in forms {
            self.root.replace_other_forms(&mut base.root, table, forms);
        }
        self.root.inherit(base.root);
    }

    /// Removes a key of the top level.
    pub fn remove(&mut self, key: &str) {
        if let Kind::Table(entries) = &mut self.root.kind {
            entries.by_key.remove(key);
        }
    }

    /// The text under a key of the top level, if there is one. This does not count as reading.
    #[must_use]
    pub fn peek_text(&self, key: &str) -> Option<Spanned<&str>> {
        let Kind::Table(entries) = &self.root.kind else { return None };
        let value = &entries.by_key.get(key)?.value;
        let Kind::Text(text) = &value.kind else { return None };
        Some(Spanned { value: text, span: value.span.clone() })
    }

    /// The value under a key of the top level in TOML, if there is one. This does not count as reading.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<toml::Value> {
        let Kind::Table(entries) = &self.root.kind else { return None };
        toml_text::value_of(&entries.by_key.get(key)?.value)
    }

    /// Reads the document with `read`, which gets its top level.
    ///
    /// # Errors
    /// Every problem reported by `read` or by the types it asked for, and every key that it did not ask for. If `read`
    /// returns `None` without a problem, that is reported as an error.
    pub fn read<T>(&self, read: impl for<'d> FnOnce(Table<'d>) -> Option<T>) -> Result<T, FileProblems> {
        let log = Log::default();
        let root = Item::new(&self.root, "this file".into(), &log);
        let value = root.as_table().and_then(read);
        let mut problems = log.problems.into_inner();
        self.root.left_over(&mut problems);
        // The file comes before its overrides.
        problems.sort_by_key(|problem| !problem.is_of(self.root.span.source()));
        FileProblems::none_of(problems)?;
        value.ok_or_else(|| self.root.span.problem("the file was refused, but its reader gave no reason").into())
    }

    /// The keys that `read` requests and that have a value, the document's or a default, in the order of [`Key::all`].
    /// Tables that the document does not have exist as well, but nothing is added to its arrays, whose items have
    /// numbers: `lasers.0.beams`. Keys that need one that it does not have are left out. What `read` returns and
    /// reports has no meaning; [`read`](Self::read) the document first.
    pub fn in_effect<T>(&self, read: impl for<'d> FnOnce(Table<'d>) -> T) -> Vec<Key> {
        let log = Log::of_declarations(true);
        let Kind::Table(present) = &self.root.kind else { return Vec::new() };
        read(Table::open(present, &self.root.span, &log, None));
        let mut keys = log.keys();
        keys.iter_mut().for_each(|key| key.value = key.value.take().or(key.default()));
        keys.retain(|key| {
            key.value.is_some() && key.needs.as_deref().is_none_or(|needed| present.by_key.contains_key(needed))
        });
        keys
    }
}

impl Key {
    /// All keys that `read` requests: in each table those that are no tables, in this order, and then the tables. It
    /// reads an empty file in which every table exists once, in all its [forms](Table::form) and with one of all
    /// possible [names](Table::names), so what it returns and reports has no meaning.
    ///
    /// ```
    /// use diagnostics::document::Key;
    ///
    /// let keys = Key::all(|root| {
    ///     let battery = root.table("battery").about("The battery.").optional();
    ///     battery.map(|battery| battery.number("charge_pct").about("Its charge.").within(0.0..=100.0).default(80.0));
    /// });
    /// assert_eq!(keys[1].path, "battery.charge_pct");
    /// assert_eq!(keys[1].accepts(), "a number from 0 to 100");
    /// assert_eq!(keys[1].default().as_deref(), Some("80"));
    /// ```
    pub fn all<T>(read: impl for<'d> FnOnce(Table<'d>) -> T) -> Vec<Self> {
        let (log, span) = (Log::of_declarations(false), Source::new("", "").span(0..0));
        read(Table::open(&log.nothing, &span, &log, None));
        log.keys()
    }
}

#[cfg(test)]
mod tests;
