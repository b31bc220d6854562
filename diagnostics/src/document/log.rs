//! What a reader records while it reads.

use std::cell::RefCell;

use super::declared::{DeclaredKey, Takes};
use crate::Problem;

/// The problems of a file, or the keys that its reader declares.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub(super) problems: RefCell<Vec<Problem>>,
    /// Only while there is no file.
    pub(super) declared: Option<RefCell<Vec<DeclaredKey>>>,
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
