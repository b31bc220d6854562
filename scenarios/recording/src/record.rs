//! The records of a run, in their order.

use serde::{Deserialize, Serialize};

use crate::{End, Header, Step};

/// The version of the format. It goes up with every change of the records.
pub const FORMAT: u32 = 9;

/// One record of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Record {
    /// What does not change during the run; the first record.
    Header(Box<Header>),
    /// A step.
    Step(Step),
    /// The end; the last record.
    End(Box<End>),
}

/// A [`Record`] on its way to a file, which is written alike.
#[derive(Clone, Copy, Debug, Serialize)]
pub enum RecordRef<'r> {
    /// What does not change during the run; the first record.
    Header(&'r Header),
    /// A step.
    Step(&'r Step),
    /// The end; the last record.
    End(&'r End),
}
