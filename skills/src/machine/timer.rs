//! Events on their way, and when they are due.

use std::sync::Arc;
use std::time::Duration;

use miette::SourceSpan;

use super::{Event, Outgoing};

/// A delayed event, and when it is due. Timers are kept in the order they are due, earlier sent ones first.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Timer {
    pub(super) due: Duration,
    pub(super) send_id: Option<Arc<str>>,
    pub(super) parcel: Parcel,
}

/// An event on its way.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Parcel {
    /// To the machine's own internal queue.
    Internal(Event),
    /// To the machine's own external queue.
    Own(Event),
    /// To somebody else.
    Away(Outgoing, Spot),
}

/// Where a `<send>` stands in the file, for messages; two machines of one chart have equal places for equal parcels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Spot(pub(super) SourceSpan);

impl std::hash::Hash for Spot {
    fn hash<H: std::hash::Hasher>(&self, _: &mut H) {}
}
