//! What a reader records while it reads.

use std::cell::RefCell;

use serde_json::Value;

use super::node::{Entries, Node};
use super::{Key, toml_text};
use crate::Problem;

/// The problems of a file, or the keys that its reader declares.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub(super) problems: RefCell<Vec<Problem>>,
    /// Only while keys are declared.
    pub(super) declared: Option<RefCell<Vec<Key>>>,
    /// Whether they are declared as a file has them, with their values.
    pub(super) of_file: bool,
    /// The contents of a declared table that the file does not have.
    pub(super) nothing: Entries,
}

impl Log {
    /// A log of declarations, with the values of a file or without a file.
    pub(super) fn of_declarations(of_file: bool) -> Self {
        Self { declared: Some(RefCell::default()), of_file, ..Self::default() }
    }

    /// Whether keys are declared without a file: every table exists once, in all its forms.
    pub(super) fn is_without_file(&self) -> bool {
        self.declared.is_some() && !self.of_file
    }

    /// Declares a key of the table with this number, with its value if it has one, unless a file is only read. Returns
    /// the key's number.
    pub(super) fn declare(
        &self,
        table: Option<usize>,
        key: &str,
        takes: impl FnOnce() -> Value,
        value: Option<&Node>,
    ) -> Option<usize> {
        let mut declared = self.declared.as_ref()?.borrow_mut();
        let mut takes = takes();
        let table = table.map_or_else(String::new, |table| format!("{}.", declared[table].path));
        let mut path = format!("{table}{key}");
        if takes["items"]["type"] == "object" {
            takes = takes["items"].take();
            path += if self.of_file { "" } else { "[]" };
        }
        if let Some(known) = declared.iter().position(|known| known.path == path) {
            return Some(known);
        }
        let value = value.filter(|_| takes["type"] != "object").and_then(toml_text::value_of);
        declared.push(Key { value: value.map(|value| value.to_string()), ..Key::new(path, takes) });
        Some(declared.len() - 1)
    }

    /// Declares an item of an array of tables.
    pub(super) fn declare_item(&self, array: Option<usize>, place: usize) -> Option<usize> {
        let mut declared = self.declared.as_ref()?.borrow_mut();
        let array = declared[array?].clone();
        if !array.is_table() {
            return None;
        }
        declared.push(Key { path: format!("{}.{place}", array.path), ..array });
        Some(declared.len() - 1)
    }

    /// The declared keys, table by table.
    pub(super) fn keys(self) -> Vec<Key> {
        Key::in_order(&self.declared.map(RefCell::into_inner).unwrap_or_default(), "")
    }

    /// Changes a declaration, if there is one.
    pub(super) fn amend(&self, key: Option<usize>, change: impl FnOnce(&mut Key)) {
        if let (Some(declared), Some(key)) = (&self.declared, key) {
            change(&mut declared.borrow_mut()[key]);
        }
    }
}
