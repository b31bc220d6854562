//! What a reader records while it reads.

use std::cell::RefCell;
use std::collections::BTreeMap;

use serde_json::Value;

use super::key::is_chosen;
use super::node::{Entries, Node};
use super::{Key, toml_text};
use crate::Problem;

/// The problems of a file, or the keys that its reader declares.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub(super) problems: RefCell<Vec<Problem>>,
    /// Only while keys are declared.
    pub(super) declared: Option<RefCell<Vec<Key>>>,
    /// The numbers of the declared keys, by path.
    numbers: RefCell<BTreeMap<String, usize>>,
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
        let declared = self.declared.as_ref()?.borrow();
        let mut takes = takes();
        let table = table.map_or_else(String::new, |table| format!("{}.", declared[table].path));
        let mut path = format!("{table}{key}");
        if takes["items"]["type"] == "object" {
            takes = takes["items"].take();
            path += if self.of_file { "" } else { "[]" };
        }
        drop(declared);
        let value = value.filter(|_| takes["type"] != "object").and_then(toml_text::value_of);
        self.add(Key { value: value.map(|value| value.to_string()), ..Key::new(path, takes) })
    }

    /// Declares an item of an array of tables.
    pub(super) fn declare_item(&self, array: Option<usize>, place: usize) -> Option<usize> {
        let array = self.declared.as_ref()?.borrow()[array?].clone();
        if array.is_table() { self.add(Key { path: format!("{}.{place}", array.path), ..array }) } else { None }
    }

    /// Adds a key, unless its table has been asked for it before.
    fn add(&self, key: Key) -> Option<usize> {
        let mut declared = self.declared.as_ref()?.borrow_mut();
        let number = *self.numbers.borrow_mut().entry(key.path.clone()).or_insert(declared.len());
        if number == declared.len() {
            declared.push(key);
        }
        Some(number)
    }

    /// The declared keys in the order of a reference: in each table names that the file chooses, other keys, and then
    /// the tables in it, each followed by its own keys.
    pub(super) fn keys(self) -> Vec<Key> {
        let numbers = self.numbers.into_inner();
        let mut keys = self.declared.map(RefCell::into_inner).unwrap_or_default();
        keys.sort_by_cached_key(|key| {
            let table = if key.is_table() { &key.path } else { key.split().0 };
            let ends = table.match_indices('.').map(|(end, _)| end).chain([table.len()]);
            let around: Vec<usize> = ends.filter_map(|end| numbers.get(&table[..end]).copied()).collect();
            (around, !key.is_table(), !is_chosen(key.split().1))
        });
        keys
    }

    /// Changes a declaration, if there is one.
    pub(super) fn amend(&self, key: Option<usize>, change: impl FnOnce(&mut Key)) {
        if let (Some(declared), Some(key)) = (&self.declared, key) {
            change(&mut declared.borrow_mut()[key]);
        }
    }
}
