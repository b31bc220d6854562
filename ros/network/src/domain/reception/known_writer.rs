//! What is known of one writer.

use crate::domain::exchange::{Sample, Writer};

/// A sequence number that falls by more than this is not that of a late message: the writer has restarted.
const MOST_REORDERED: i64 = 1000;

/// A writer that is in the domain, or has left it.
pub(super) struct KnownWriter {
    pub(super) writer: Writer,
    /// Its topic in the survey, if that is wanted.
    pub(super) topic: Option<usize>,
    /// Whether its messages are read: they have the type of the topic's first writer, and its policies are compatible.
    pub(super) is_read: bool,
    /// Its newest message. None before the first.
    pub(super) last: Option<LastSample>,
    /// Whether it was discovered when messages counted already. Then everything that it has published counts.
    pub(super) is_late: bool,
    /// When it was discovered.
    pub(super) since_ns: i64,
    /// If it has left: whether it has announced that.
    pub(super) has_left: bool,
    /// If it has left: when that was noticed.
    pub(super) left_ns: i64,
    /// If it has left: the name of its node, as far as that was known.
    pub(super) node: Option<String>,
}

/// The newest message of a writer.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastSample {
    /// The sequence number after its own.
    pub(super) next: i64,
    /// When it was received, or found missing.
    pub(super) at_ns: i64,
    /// The earliest time at which it may have been due.
    pub(super) due_ns: i64,
    pub(super) sent_ns: Option<i64>,
}

impl LastSample {
    /// Whether a sample with a smaller number is neither late nor a repetition, but from a writer that has restarted.
    pub(super) fn is_before_restart(&self, sample: &Sample) -> bool {
        let is_newer = sample.sent_ns.zip(self.sent_ns).is_some_and(|(sent, last)| sent > last);
        is_newer || self.next.saturating_sub(sample.number) > MOST_REORDERED
    }
}
