//! What publishes in a DDS domain.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use rustdds::no_key::DataWriter;
use rustdds::policy::History;
use rustdds::{DomainParticipant, QosPolicyBuilder, RTPSEntity as _, SampleIdentity, TopicKind, WriteOptionsBuilder};

use super::as_is::{AsIs, KEPT_SMALL, qos};
use super::heard::{Heard, NODES};
use crate::clock::now;

/// How long rustdds may take to know a new writer: what is written before then may never be sent.
const REGISTERING: Duration = Duration::from_millis(50);

/// How many samples of a topic are kept for readers that have not received them.
const OFFERED: i32 = 32;

/// The writers of a participant, by topic.
pub(super) struct Writers {
    participant: DomainParticipant,
    /// Each with when it was made.
    writers: BTreeMap<String, (DataWriter<Vec<u8>, AsIs>, Instant)>,
    /// What had no room there: one reader that does not answer must not keep messages from the others for longer than
    /// it takes to forget it.
    unsent: BTreeMap<String, VecDeque<Vec<u8>>>,
    /// Where messages were left out, and where that is not told yet.
    left_out: BTreeSet<String>,
    pub(super) untold: Vec<Heard>,
    /// Whether there are more than before, apart from that which says which nodes there are.
    pub(super) has_new: bool,
}

impl Writers {
    pub(super) fn of(participant: DomainParticipant) -> Self {
        let (writers, unsent, left_out) = (BTreeMap::new(), BTreeMap::new(), BTreeSet::new());
        Self { participant, writers, unsent, left_out, untold: Vec::new(), has_new: false }
    }

    pub(super) fn has(&self, topic: &str) -> bool {
        self.writers.contains_key(topic)
    }

    /// The topics and the GUIDs of all but the one that says which nodes there are.
    pub(super) fn guids(&self) -> Vec<(String, [u8; 16])> {
        let writers = self.writers.iter().filter(|(topic, _)| *topic != NODES);
        writers.map(|(topic, (writer, _))| (topic.clone(), writer.guid().to_bytes())).collect()
    }

    /// Publishes a message, reliably; without one, only offers to.
    ///
    /// # Errors
    /// Why there can be no such writer.
    pub(super) fn write(&mut self, topic: String, kind: String, is_latched: bool, body: Vec<u8>) -> Result<(), String> {
        if !self.writers.contains_key(&topic) {
            // Who comes later receives the last one. What follows at once must not replace what is not sent yet, for
            // which whoever has come meanwhile would wait.
            let is_single = is_latched && topic != NODES;
            let mut qos = qos(true, is_latched, if is_single { 1 } else { KEPT_SMALL });
            if !is_single {
                qos = qos.modify_by(&QosPolicyBuilder::new().history(History::KeepLast { depth: OFFERED }).build());
            }
            let make = || {
                let made = self.participant.create_topic(topic.clone(), kind, &qos, TopicKind::NoKey)?;
                self.participant.create_publisher(&qos)?.create_datawriter_no_key(&made, Some(qos.clone()))
            };
            let made = make().map_err(|error| format!("{topic} cannot be published: {error}"))?;
            self.has_new |= topic != NODES;
            self.writers.insert(topic.clone(), (made, now()));
        }
        if !body.is_empty() {
            let unsent = self.unsent.entry(topic.clone()).or_default();
            unsent.push_back(body);
            // What is latched is as good as the last.
            let most = if is_latched { 1 } else { OFFERED as usize };
            if unsent.len() > most && unsent.pop_front().is_some() && !is_latched && self.left_out.insert(topic.clone())
            {
                self.untold.push(Heard::Unsent(topic));
            }
            self.send();
        }
        Ok(())
    }

    /// Sends what has not been sent, where there is room now.
    pub(super) fn send(&mut self) {
        for (topic, bodies) in &mut self.unsent {
            let Some((writer, since)) = self.writers.get(topic) else { continue };
            if since.elapsed() < REGISTERING {
                continue;
            }
            while bodies.front().is_some_and(|body| writer.write(body.clone(), None).is_ok()) {
                bodies.pop_front();
            }
        }
    }

    /// Sends a request or a response, which may be `related` to another message. Returns the number that it gets; none
    /// if there is no such writer, or no room now.
    pub(super) fn converse(&self, topic: &str, body: Vec<u8>, related: Option<SampleIdentity>) -> Option<i64> {
        let options = WriteOptionsBuilder::new().related_sample_identity_opt(related);
        let (writer, since) = self.writers.get(topic)?;
        if since.elapsed() < REGISTERING {
            return None;
        }
        let identity = writer.write_with_options(body, options.build()).ok()?;
        Some(i64::from(identity.sequence_number))
    }
}
