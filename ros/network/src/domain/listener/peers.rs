//! The other participants and their writers, as rustdds discovers them.

use std::collections::{BTreeMap, BTreeSet};

use rustdds::{DomainParticipantStatusEvent, DomainParticipantStatusListener, GUID, LostReason, StatusEvented as _};

use crate::domain::correlation::Correlation;
use crate::domain::exchange::{Prefix, Writer, participant, prefix};
use crate::domain::pulse::Pulse;

/// The most writers in a domain.
pub(super) const MOST_WRITERS: usize = 20_000;

/// Which participants and writers there are, and which have left.
pub(super) struct Peers {
    events: DomainParticipantStatusListener,
    /// The vendors of participants. They determine the form of requests and responses.
    vendors: BTreeMap<Prefix, [u8; 2]>,
    /// The writers that have been reported.
    known: BTreeSet<[u8; 16]>,
    /// The participants and writers whose departure has not been reported.
    goodbyes: BTreeSet<[u8; 16]>,
    /// The writers that have ever left.
    departed: BTreeSet<[u8; 16]>,
}

impl Peers {
    pub(super) fn of(events: DomainParticipantStatusListener) -> Self {
        let (known, goodbyes, departed) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        Self { events, vendors: BTreeMap::new(), known, goodbyes, departed }
    }

    /// Processes what rustdds has discovered. Returns whether there was anything.
    pub(super) fn process_events(&mut self, pulse: &mut Pulse) -> bool {
        let mut has_events = false;
        while let Some(event) = self.events.try_recv_status() {
            if let DomainParticipantStatusEvent::ParticipantLost { id, .. } = &event
                && pulse.is_answer(&prefix(&GUID { prefix: *id, ..GUID::GUID_UNKNOWN }.to_bytes()))
            {
                continue;
            }
            has_events = true;
            match event {
                DomainParticipantStatusEvent::ParticipantDiscovered { dpd } => {
                    self.vendors.insert(prefix(&dpd.guid.to_bytes()), dpd.vendor_id.vendor_id);
                }
                DomainParticipantStatusEvent::ParticipantLost { id, reason } => {
                    let guid = GUID { prefix: id, ..GUID::GUID_UNKNOWN }.to_bytes();
                    self.vendors.remove(&prefix(&guid));
                    self.goodbyes.extend(matches!(reason, LostReason::Disposed).then(|| participant(&guid)));
                }
                DomainParticipantStatusEvent::WriterLost { guid, reason: LostReason::Disposed } => {
                    if self.departed.len() >= MOST_WRITERS {
                        self.departed.clear();
                    }
                    self.departed.insert(guid.to_bytes());
                    self.goodbyes.insert(guid.to_bytes());
                }
                _ => {}
            }
        }
        has_events
    }

    /// Whether a participant has been discovered.
    pub(super) fn is_discovered(&self, participant: &Prefix) -> bool {
        self.vendors.contains_key(participant)
    }

    /// How responses of a participant refer to requests.
    pub(super) fn correlation(&self, participant: &Prefix) -> Correlation {
        Correlation::of(self.vendors.get(participant).copied())
    }

    /// Whether a writer has been reported.
    pub(super) fn is_known(&self, writer: &[u8; 16]) -> bool {
        self.known.contains(writer)
    }

    /// The reported writers that are not among these, although rustdds has not reported their departure.
    pub(super) fn vanished(&self, writers: &[Writer]) -> impl Iterator<Item = [u8; 16]> {
        let there: BTreeSet<[u8; 16]> = writers.iter().map(|writer| writer.guid).collect();
        let has_left = |guid: &[u8; 16]| [*guid, participant(guid)].iter().any(|guid| self.goodbyes.contains(guid));
        self.known.iter().copied().filter(move |guid| !there.contains(guid) && !has_left(guid))
    }

    /// One of these writers that has left before.
    pub(super) fn returned(&self, writers: &[Writer]) -> Option<[u8; 16]> {
        self.departed.iter().copied().find(|guid| writers.iter().any(|writer| writer.guid == *guid))
    }

    /// These writers are reported. Returns the departures to be reported with them.
    pub(super) fn report(&mut self, writers: &[Writer]) -> BTreeSet<[u8; 16]> {
        self.known = writers.iter().map(|writer| writer.guid).collect();
        std::mem::take(&mut self.goodbyes)
    }
}
