//! The writers of a participant.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use rustdds::no_key::DataWriter;
use rustdds::policy::History;
use rustdds::{DomainParticipant, QosPolicyBuilder, RTPSEntity as _, SampleIdentity, TopicKind, WriteOptionsBuilder};

use super::as_is::{AsIs, KEPT_SMALL, qos};
use super::exchange::{ListenerMessage, NODES};
use crate::clock::now;

/// How long rustdds may take to register a new writer. What is written before that may never be sent.
const REGISTERING: Duration = Duration::from_millis(50);

/// How many samples of a topic are kept for readers that have not acknowledged them.
const OFFERED: i32 = 32;

/// The writers of a participant, by topic.
pub(super) struct Writers {
    participant: DomainParticipant,
    /// Each with the time of its creation.
    writers: BTreeMap<String, (DataWriter<Vec<u8>, AsIs>, Instant)>,
    /// The messages for which a writer had no room, as a reader does not acknowledge earlier ones. They are sent once
    /// rustdds has given up that reader.
    unsent: BTreeMap<String, VecDeque<Vec<u8>>>,
    /// The topics on which messages were dropped.
    dropped: BTreeSet<String>,
    /// Reports of dropped messages that have not been sent.
    pub(super) unreported: Vec<ListenerMessage>,
    /// Whether there are new writers since the nodes were announced, beside the one that announces them.
    pub(super) has_new: bool,
}

impl Writers {
    pub(super) fn of(participant: DomainParticipant) -> Self {
        let (writers, unsent, dropped) = (BTreeMap::new(), BTreeMap::new(), BTreeSet::new());
        Self { participant, writers, unsent, dropped, unreported: Vec::new(), has_new: false }
    }

    pub(super) fn has(&self, topic: &str) -> bool {
        self.writers.contains_key(topic)
    }

    /// The topics and GUIDs of all writers but the one that announces nodes.
    pub(super) fn guids(&self) -> Vec<(String, [u8; 16])> {
        let writers = self.writers.iter().filter(|(topic, _)| *topic != NODES);
        writers.map(|(topic, (writer, _))| (topic.clone(), writer.guid().to_bytes())).collect()
    }

    /// Publishes a message, reliably. If the body is empty, the topic is only offered.
    ///
    /// # Errors
    /// If there can be no such writer: the reason.
    pub(super) fn write(&mut self, topic: String, kind: String, is_latched: bool, body: Vec<u8>) -> Result<(), String> {
        if !self.writers.contains_key(&topic) {
            // A latched topic keeps one sample, for later readers. The topic of nodes keeps more: a sample that was
            // replaced before it was sent would leave a gap in the numbers, for which a new reader would wait.
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
            // Of latched messages, only the last one matters.
            let most = if is_latched { 1 } else { OFFERED as usize };
            if unsent.len() > most && unsent.pop_front().is_some() && !is_latched && self.dropped.insert(topic.clone())
            {
                self.unreported.push(ListenerMessage::Unsent(topic));
            }
            self.send();
        }
        Ok(())
    }

    /// Sends the messages that wait, where there is room now.
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

    /// Sends a request or a response, which may be `related` to another message. Returns its sequence number. None if
    /// there is no such writer, or no room now.
    pub(super) fn send_related(&self, topic: &str, body: Vec<u8>, related: Option<SampleIdentity>) -> Option<i64> {
        let options = WriteOptionsBuilder::new().related_sample_identity_opt(related);
        let (writer, since) = self.writers.get(topic)?;
        if since.elapsed() < REGISTERING {
            return None;
        }
        let identity = writer.write_with_options(body, options.build()).ok()?;
        Some(i64::from(identity.sequence_number))
    }
}
