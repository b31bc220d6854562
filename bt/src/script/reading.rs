//! What reading a script takes, and what may be wrong with its text.

use std::ops::Range;

use crate::blackboard::Slot;

/// What is wrong with the text of a script, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SyntaxError {
    pub(crate) message: String,
    /// In bytes of the script.
    pub(crate) range: Range<usize>,
}

/// What names in scripts mean.
pub(crate) trait Names {
    /// The number that a constant stands for.
    fn constant(&self, name: &str) -> Option<i64>;

    /// The entry that a name means.
    fn slot(&mut self, name: &str) -> Slot;
}
