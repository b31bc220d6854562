//! The view of a run whose records this program makes.

use std::ops::Deref;

use crate::{End, Happening, Header, Inconsistent, RunView, Step};

/// The [`RunView`] of records that this program makes itself. Unlike those of a file, which may be damaged, they refer
/// only to what their header contains and never go back in time, so that each of them can be applied.
///
/// # Panics
/// Its methods do if a record does not fit: this is a mistake in what makes the records.
#[derive(Clone, Debug)]
pub struct TrustedView(RunView);

impl TrustedView {
    /// The run at its start: see [`RunView::new`].
    #[must_use]
    pub fn new(header: Header, start: Step) -> Self {
        Self(fitting(RunView::new(header, start)))
    }

    /// Advances by one step.
    pub fn apply(&mut self, step: Step) {
        fitting(self.0.apply(step));
    }

    /// Adds the verdicts that the end of the run decides to its last step.
    pub fn decide(&mut self, verdicts: Vec<Happening>) {
        fitting(self.0.decide(verdicts));
    }

    /// Finishes the run.
    pub fn finish(&mut self, end: End) {
        fitting(self.0.finish(end));
    }

    /// The view alone.
    #[must_use]
    pub fn into_inner(self) -> RunView {
        self.0
    }
}

impl Deref for TrustedView {
    type Target = RunView;

    fn deref(&self) -> &RunView {
        &self.0
    }
}

fn fitting<T>(applied: Result<T, Inconsistent>) -> T {
    applied.expect("a run's records refer only to what its header contains")
}
