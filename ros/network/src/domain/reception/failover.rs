//! What is known of the reception itself: until when messages could be received, and what a failure of DDS leaves open.

use std::collections::BTreeSet;

/// How long a new participant may take to find the publishers again.
const FINDING_NS: i64 = 3_000_000_000;

/// Whether messages can be received. After DDS has failed, a new participant looks for all publishers again.
pub(super) struct Failover {
    /// Until when messages could be received.
    pub(super) alive_ns: i64,
    /// Whether DDS has failed, and publishers are still being looked for.
    pub(super) has_failed: bool,
    /// Until when publishers may still be found. The greatest number until reception is confirmed again.
    finding_ns: i64,
    /// The writers that the present participant has discovered.
    pub(super) present: BTreeSet<[u8; 16]>,
    /// Until when messages could be received before the first failure. What has been published since then on topics
    /// that were not known may be missing.
    pub(super) unseen_since_ns: Option<i64>,
}

impl Failover {
    pub(super) fn new() -> Self {
        Self { alive_ns: 0, has_failed: false, finding_ns: i64::MIN, present: BTreeSet::new(), unseen_since_ns: None }
    }

    /// DDS has failed. No publisher has been found again.
    pub(super) fn begin(&mut self) {
        (self.has_failed, self.finding_ns) = (true, i64::MAX);
        self.present.clear();
    }

    /// Messages could be received until this time. Returns whether the time to find publishers again is over.
    pub(super) fn advance(&mut self, alive_ns: i64) -> bool {
        self.alive_ns = self.alive_ns.max(alive_ns);
        if self.finding_ns == i64::MAX {
            self.finding_ns = alive_ns.saturating_add(FINDING_NS);
        }
        self.has_failed && alive_ns >= self.finding_ns
    }
}
