//! Reading what a user wrote in TOML or YAML: typed values, every problem at once, each at its place.
//!
//! A [`Document`] is parsed, perhaps changed by `--set`, and read once. Reading asks a [`Table`] for the keys that the
//! program knows; what is missing, of the wrong type or out of range is noted and reading goes on. When it is over,
//! every key that nobody asked for is a problem too, with the nearest known key as a suggestion.
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
//! So that every problem is found, ask for all the keys of a table before `?` ends its reading, and use
//! [`each`](Field::each) for arrays.

mod field;
mod item;
mod node;
mod overrides;
mod table;
mod toml_text;
mod yaml_text;

use std::cell::RefCell;

pub use field::Field;
pub use item::{FromItem, Item};
pub use table::Table;

use crate::{FileProblems, Source, Spanned};
use node::{Kind, Node};

/// A parsed file, ready to be read.
#[derive(Debug)]
pub struct Document {
    root: Node,
}

impl Document {
    /// Parses TOML. `name` is what diagnostics call the file.
    ///
    /// # Errors
    /// All syntax errors. A file that has some is not judged any further: what was meant is anybody's guess.
    pub fn parse_toml(name: &str, text: &str) -> Result<Self, FileProblems> {
        toml_text::document(&Source::new(name, text)).map(|root| Self { root })
    }

    /// Parses YAML whose top level is a mapping. `name` is what diagnostics call the file.
    ///
    /// # Errors
    /// The first syntax error, a second document, or a top level that is not a mapping; also a text of more than
    /// 16 KiB, since nothing in this project has need of longer ones.
    pub fn parse_yaml(name: &str, text: &str) -> Result<Self, FileProblems> {
        yaml_text::document(&Source::new(name, text)).map(|root| Self { root })
    }

    /// Applies assignments of the form `a.b.c=value`, as the command line's `--set` takes them, one after the other.
    ///
    /// The key's parts are separated by dots; a number picks an entry of an array (`faults.0.charge_pct=5`). Tables on
    /// the way that do not exist are made, so that a key with a default can be set. The value is TOML; what is no TOML
    /// and does not begin with a quote or bracket is taken as text (`--set mode=scale`). Keys that themselves contain
    /// a dot cannot be set.
    ///
    /// # Errors
    /// Every assignment that is malformed or leads nowhere, at its place in the assignment. Whether the key is known
    /// and the value right is found when the document is read.
    pub fn override_with<'a>(&mut self, assignments: impl IntoIterator<Item = &'a str>) -> Result<(), FileProblems> {
        let problems = assignments.into_iter().filter_map(|text| overrides::apply(&mut self.root, text).err());
        FileProblems::none_of(problems.collect())
    }

    /// Takes over from `base` whatever this document does not say itself: keys that it lacks, and inside tables that
    /// both have, theirs in turn. An array is one value: the document's own replaces the base's. Problems with what was
    /// taken over are shown where the base says it.
    pub fn inherit(&mut self, base: Self) {
        self.root.inherit(base.root);
    }

    /// The text under a key of the top level, if there is one, without reading the document.
    #[must_use]
    pub fn peek_text(&self, key: &str) -> Option<Spanned<&str>> {
        let Kind::Table(entries) = &self.root.kind else { return None };
        let value = &entries.by_key.get(key)?.value;
        let Kind::Text(text) = &value.kind else { return None };
        Some(Spanned { value: text, span: value.span.clone() })
    }

    /// Reads the document with `read`, which gets its top level.
    ///
    /// # Errors
    /// Every problem that `read` or the types it asked for reported, and every key that it did not ask for. A `read`
    /// that gives `None` without a reason is reported as such.
    pub fn read<T>(self, read: impl for<'d> FnOnce(Table<'d>) -> Option<T>) -> Result<T, FileProblems> {
        let log = RefCell::new(Vec::new());
        let root = Item::new(&self.root, "this file".into(), &log);
        let value = root.as_table().and_then(read);
        let mut problems = log.into_inner();
        self.root.left_over(&mut problems);
        // The file before what overrides it.
        problems.sort_by_key(|problem| !problem.is_of(self.root.span.source()));
        FileProblems::none_of(problems)?;
        value.ok_or_else(|| self.root.span.problem("the file is refused, but its reader does not say why").into())
    }
}

#[cfg(test)]
mod tests;
