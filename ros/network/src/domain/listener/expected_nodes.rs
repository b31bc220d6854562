//! The nodes that other participants have still to announce.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use super::peers::Peers;
use crate::clock::now;
use crate::domain::exchange::{NODES, Writer};

/// How long others may take to announce their nodes, and how often that is requested again, by a new reader. In one or
/// two of 100 cases, Fast DDS announces them only after seconds.
const NAMING: Duration = Duration::from_millis(600);
const MOST_RETRIES: u32 = 3;

/// The writers that announce nodes and have not done so.
pub(super) struct ExpectedNodes {
    unnamed: BTreeSet<[u8; 16]>,
    /// Until when they may, before that is requested again.
    named_by: Instant,
    /// How often that has been requested again.
    retries: u32,
}

impl ExpectedNodes {
    pub(super) fn none() -> Self {
        Self { unnamed: BTreeSet::new(), named_by: now(), retries: 0 }
    }

    /// Expects each writer of nodes to announce them.
    pub(super) fn expect(&mut self, writers: &[Writer], peers: &Peers) {
        let all: BTreeSet<_> =
            writers.iter().filter(|writer| writer.topic == NODES).map(|writer| writer.guid).collect();
        self.unnamed.retain(|guid| all.contains(guid));
        for guid in all.into_iter().filter(|guid| !peers.is_known(guid)) {
            self.unnamed.insert(guid);
            (self.named_by, self.retries) = (now() + NAMING, 0);
        }
    }

    /// A sample of this writer was received.
    pub(super) fn note_sample(&mut self, writer: &[u8; 16]) {
        self.unnamed.remove(writer);
    }

    /// Whether to request that again now, with a new reader.
    pub(super) fn take_retry(&mut self) -> bool {
        if self.unnamed.is_empty() || self.retries == MOST_RETRIES || now() < self.named_by {
            return false;
        }
        (self.named_by, self.retries) = (now() + NAMING, self.retries + 1);
        true
    }
}
