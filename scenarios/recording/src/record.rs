//! The records of a run, in their order.

use serde::{Deserialize, Serialize};

use crate::{End, Header, RunView, Step};

/// The version of the format. It goes up with every change of the records.
pub const FORMAT: u32 = 25;

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

impl Record {
    /// The same record, borrowed.
    #[must_use]
    pub fn borrowed(&self) -> RecordRef<'_> {
        match self {
            Self::Header(header) => RecordRef::Header(header),
            Self::Step(step) => RecordRef::Step(step),
            Self::End(end) => RecordRef::End(end),
        }
    }
}

/// A borrowed [`Record`], which is written in the same way.
#[derive(Clone, Copy, Debug, Serialize)]
pub enum RecordRef<'r> {
    /// What does not change during the run; the first record.
    Header(&'r Header),
    /// A step.
    Step(&'r Step),
    /// The end; the last record.
    End(&'r End),
}

impl<'r> RecordRef<'r> {
    /// The first two records, if the run is at its start.
    pub(crate) fn at_start(view: &'r RunView) -> impl Iterator<Item = Self> {
        [Self::Header(view.header()), Self::Step(view.step())].into_iter()
    }

    /// The record of the last step, and the end if it has come.
    pub(crate) fn newest(view: &'r RunView) -> impl Iterator<Item = Self> {
        std::iter::once(Self::Step(view.step())).chain(view.end().map(Self::End))
    }
}
