//! What a reader records while it reads.

use std::cell::RefCell;

use serde_json::Value;

use super::Key;
use crate::Problem;

/// The problems of a file, or the keys that its reader declares.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub(super) problems: RefCell<Vec<Problem>>,
    /// Only while there is no file.
    pub(super) declared: Option<RefCell<Vec<Key>>>,
}

impl Log {
    /// Declares a key of the table with this number, unless a file is read. Returns the key's number.
    pub(super) fn declare(&self, table: Option<usize>, key: &str, takes: impl FnOnce() -> Value) -> Option<usize> {
        let mut declared = self.declared.as_ref()?.borrow_mut();
        let mut takes = takes();
        let table = table.map_or_else(String::new, |table| format!("{}.", declared[table].path));
        let mut path = format!("{table}{key}");
        if takes["items"]["type"] == "object" {
            takes = takes["items"].take();
            path += "[]";
        }
        if let Some(known) = declared.iter().position(|known| known.path == path) {
            return Some(known);
        }
        declared.push(Key::new(path, takes));
        Some(declared.len() - 1)
    }

    /// Changes a declaration, if there is one.
    pub(super) fn amend(&self, key: Option<usize>, change: impl FnOnce(&mut Key)) {
        if let (Some(declared), Some(key)) = (&self.declared, key) {
            change(&mut declared.borrow_mut()[key]);
        }
    }
}
