//! Turns what the listener received into what is judged.
//!
//! [`Discovery`] contains the publishers and what they offer, [`SequenceGaps`] the messages and what is missing between
//! them, [`ServiceTraffic`] requests and responses. `publishers` has what concerns both publishers and messages.

mod discovery;
mod failover;
mod known_writer;
mod publishers;
mod remarks;
mod sequence_gaps;
mod service_traffic;

use std::collections::{BTreeMap, BTreeSet};

use bags::Received;

use super::exchange::{ListenerMessage, NODES, Offers};
use super::names::RosName;
use discovery::Discovery;
use failover::Failover;
use remarks::Remarks;
use sequence_gaps::{Phase, SequenceGaps};
use service_traffic::ServiceTraffic;

/// What has been received in a DDS domain.
pub(super) struct Reception {
    pub(super) discovery: Discovery,
    pub(super) services: ServiceTraffic,
    pub(super) remarks: Remarks,
    gaps: SequenceGaps,
    failover: Failover,
}

impl Reception {
    /// Nothing yet, of topics with these names, or of all.
    pub(super) fn new(wanted: Option<BTreeSet<String>>) -> Self {
        let phase = if wanted.is_some() { Phase::Looking } else { Phase::Watching };
        Self {
            discovery: Discovery::new(wanted),
            services: ServiceTraffic::default(),
            remarks: Remarks::default(),
            gaps: SequenceGaps::new(phase),
            failover: Failover::new(),
        }
    }

    /// The wanted topics are subscribed to now.
    pub(super) fn begin(&mut self) {
        self.gaps.phase = Phase::Settling(None);
        self.remarks.lost.clear();
        let guids: Vec<[u8; 16]> = self.discovery.writers.keys().copied().collect();
        guids.iter().for_each(|guid| self.report_unreceivable(guid));
    }

    /// Whether nothing is subscribed to yet.
    pub(super) fn is_looking(&self) -> bool {
        self.gaps.phase == Phase::Looking
    }

    /// The DDS topics to subscribe to, those of requests and responses included, with their types if these are known.
    /// None for all topics.
    pub(super) fn dds_topics(&self) -> Option<BTreeMap<String, Option<String>>> {
        let mut topics = self.discovery.wanted.dds_topics()?;
        topics.extend(self.services.dds_topics());
        Some(topics)
    }

    /// What is to be returned next, if there is anything.
    pub(super) fn next(&mut self, body: &mut Vec<u8>) -> Option<Received> {
        let (received, bytes) = self.gaps.ready.pop_front()?;
        if let Received::Message(_) = received {
            *body = bytes;
        }
        Some(received)
    }

    pub(super) fn receive(&mut self, message: ListenerMessage) {
        let (discovery, remarks) = (&mut self.discovery, &mut self.remarks);
        match message {
            ListenerMessage::Sample(sample) if *sample.topic == *NODES => discovery.add_nodes(&sample.body),
            ListenerMessage::Sample(sample) => self.gaps.receive(sample, true, discovery, remarks),
            ListenerMessage::Dropped(sample) => self.gaps.receive(sample, false, discovery, remarks),
            ListenerMessage::Unreadable(topic, why) => {
                self.gaps.receive_unreadable(&topic, &why, &discovery.survey, remarks);
            }
            ListenerMessage::Discovered { offers: Offers { writers, requests, read }, goodbyes } => {
                let topic = |topic: &String| match RosName::of(topic) {
                    Some(RosName::Topic(name)) => Some(name),
                    _ => None,
                };
                discovery.read = read.iter().filter_map(topic).collect();
                self.compare(writers, &requests, goodbyes);
                self.services.servers = requests;
            }
            ListenerMessage::Response(response) => self.services.responses.push_back(response),
            ListenerMessage::Request(request) => self.services.requests.push_back(request),
            ListenerMessage::ClockAdvanced(now_ns) => self.advance_clock(now_ns),
            ListenerMessage::Alive(alive_ns) => self.confirm(alive_ns),
            ListenerMessage::WriterRestarted(guid) => self.restart(&guid),
            ListenerMessage::Unsent(topic) => {
                remarks.note(format!("{topic} has a reader that does not answer: messages are left out"));
            }
            ListenerMessage::Failed(why) => self.fail(&why),
        }
    }

    /// Every message before this time has been received.
    fn advance_clock(&mut self, now_ns: i64) {
        self.gaps.newest_ns = self.gaps.newest_ns.max(now_ns);
        self.confirm(now_ns);
        if self.gaps.settle(now_ns, &mut self.discovery.survey, &mut self.remarks) {
            self.note_publishers(now_ns);
            self.gaps.report_clock(now_ns);
        }
    }

    /// Messages could be received until this time.
    fn confirm(&mut self, alive_ns: i64) {
        if self.failover.advance(alive_ns) {
            self.remove_absent();
        }
        let complete = self.gaps.absences.settle(alive_ns);
        self.gaps.resume(complete, alive_ns);
    }

    /// DDS has failed. Messages are missing on every topic, from the time until which they could be received, until
    /// each publisher has been found again by a new participant.
    fn fail(&mut self, why: &str) {
        let Self { discovery, services, remarks, gaps, failover } = self;
        services.failures += 1;
        let alive_ns = failover.alive_ns;
        let when = if alive_ns > 0 { bags::moment(alive_ns) } else { "the beginning".to_owned() };
        remarks.note(format!("DDS failed after {when}: {why}; it is tried again, and what comes meanwhile is missing"));
        failover.begin();
        if let Phase::Settling(by_ns) = &mut gaps.phase {
            *by_ns = None;
        }
        if gaps.phase == Phase::Looking || discovery.wanted.names.is_none() {
            return;
        }
        failover.unseen_since_ns.get_or_insert(alive_ns);
        for topic in (0..discovery.survey.topics.len()).filter(|topic| !discovery.is_only_shown(*topic)) {
            let of_it = discovery.writers.iter().filter(|(_, known)| known.topic == Some(topic) && known.is_read);
            let last_ns = of_it.clone().filter_map(|(_, known)| Some(known.last?.at_ns)).max().unwrap_or(i64::MIN);
            gaps.absences.add_all(topic, of_it.map(|(guid, _)| *guid));
            gaps.lose_on(topic, last_ns.max(alive_ns));
        }
    }
}

#[cfg(test)]
mod tests;
