//! Events in transit, and when they are due.

use std::sync::Arc;
use std::time::Duration;

use miette::SourceSpan;

use super::{Event, Outgoing};

/// A delayed event, and when it is due. Timers are sorted by due time, then by the order in which they were sent.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Timer {
    pub(super) due: Duration,
    pub(super) send_id: Option<Arc<str>>,
    pub(super) delivery: Delivery,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Delivery {
    /// To the machine's own internal queue.
    Internal(Event),
    /// To the machine's own external queue.
    Own(Event),
    /// To another process.
    Away(Outgoing, Spot),
}

/// The position of a `<send>` in the file, for messages. It is left out of hashes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Spot(pub(super) SourceSpan);

impl std::hash::Hash for Spot {
    fn hash<H: std::hash::Hasher>(&self, _: &mut H) {}
}
