//! Code for the engine.

use std::sync::Arc;

use crate::ids::DataId;

/// The kinds of code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Form {
    /// It has a value.
    Expression,
    /// It does something.
    Script,
    /// A value is assigned to it.
    Location,
}

/// Code for the engine that has been checked to be readable.
#[derive(Clone, Debug)]
pub(crate) struct Code {
    /// The program that the engine runs.
    pub(crate) program: Arc<str>,
    pub(crate) mentions: Vec<DataId>,
    pub(crate) mentions_event: bool,
}
