//! The context of parsing a script, and the errors in its text.

use std::ops::Range;

use crate::blackboard::Slot;

/// An error in the text of a script, and its position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SyntaxError {
    pub(crate) message: String,
    /// In bytes of the script.
    pub(crate) range: Range<usize>,
}

pub(crate) trait Names {
    fn constant(&self, name: &str) -> Option<i64>;

    fn slot(&mut self, name: &str) -> Slot;
}
