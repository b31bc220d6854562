//! How long a tree waits for a leaf.

use std::time::Duration;

use channels::NormalForm;

use crate::Request;

/// The default time that a tree waits for a leaf's answer: long enough for a skill to notice that its component is
/// silent.
pub const LEAF_TIMEOUT: Duration = Duration::from_secs(2);

/// The deadline for the answer to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Patience {
    timeout: Duration,
    /// While a request is under way.
    deadline: Option<Duration>,
}

impl Patience {
    pub(super) fn new(timeout: Duration) -> Self {
        Self { timeout, deadline: None }
    }

    /// Starts the timeout for a request: it must be sent and answered within that time.
    pub(super) fn begin(&mut self, now: Duration) {
        self.deadline = Some(now.saturating_add(self.timeout));
    }

    /// It has been answered.
    pub(super) fn end(&mut self) {
        self.deadline = None;
    }

    pub(super) fn deadline(&self) -> Option<Duration> {
        self.deadline
    }

    /// Brings the deadline into [normal form](NormalForm).
    pub(super) fn normalize(&mut self, form: &NormalForm<'_>) {
        self.deadline.iter_mut().for_each(|deadline| form.time(deadline));
    }

    pub(super) fn is_over(&self, now: Duration) -> bool {
        self.deadline.is_some_and(|deadline| deadline <= now)
    }

    /// The message about a leaf that has not answered.
    pub(super) fn reason(&self, leaf: &str, request: Request) -> String {
        let what = match request {
            Request::Tick => "answer its tick",
            Request::Halt => "confirm that it has halted",
        };
        format!("{leaf} did not {what} within {} s", diagnostics::seconds(self.timeout))
    }
}
