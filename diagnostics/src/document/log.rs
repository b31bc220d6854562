//! What a reader records while it reads.

use std::cell::RefCell;

use super::DeclaredKey;
use crate::Problem;

/// The problems of a file, or the keys that its reader declares.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub(super) problems: RefCell<Vec<Problem>>,
    /// Only while there is no file.
    pub(super) declared: Option<RefCell<Vec<DeclaredKey>>>,
}
