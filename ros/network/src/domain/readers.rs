//! The readers of a participant.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Wake, Waker};
use std::thread::Thread;

use rustdds::no_key::SimpleDataReader;
use rustdds::{DomainParticipant, GUID, QosPolicies, RTPSEntity as _, Subscriber, Timestamp, TopicKind};

use super::as_is::{AsIs, KEPT, KEPT_SMALL, qos};
use super::exchange::{LARGEST, ListenerMessage, NODES, Sample, Subscribed, Writer};
use super::names::RosName;

/// The most readers that are created at a time: rustdds has room for a hundred at once.
const MOST_CREATED: usize = 50;

/// The size up to which a message is small, in bytes.
const SMALL: usize = 1 << 14;

/// How long ago reception may have been confirmed when a sample is received. After that, the sample may be late.
const UNCONFIRMED_NS: i64 = 250_000_000;

/// The readers of a participant, by topic.
pub(super) struct Readers {
    participant: DomainParticipant,
    subscriber: Subscriber,
    readers: BTreeMap<String, Reader>,
    /// Writers that rustdds has given up. If they come back, it does not match them with existing readers.
    pub(super) given_up: BTreeSet<[u8; 16]>,
    /// Whether there are new readers since the nodes were announced.
    pub(super) has_new: bool,
}

struct Reader {
    topic: Arc<str>,
    kind: String,
    is_reliable: bool,
    is_latched: bool,
    data: SimpleDataReader<Vec<u8>, AsIs>,
    alarm: Arc<Alarm>,
    is_small: bool,
}

/// What a reader has received.
pub(super) enum FromReader {
    Message(ListenerMessage),
    /// A request or a response. It may be `related` to a sample, given by its writer and its sequence number.
    Service {
        sample: Sample,
        related: Option<([u8; 16], i64)>,
    },
}

/// Wakes the listener's thread when a reader has received something.
struct Alarm {
    is_set: AtomicBool,
    thread: Thread,
}

impl Wake for Alarm {
    fn wake(self: Arc<Self>) {
        self.is_set.store(true, Ordering::Release);
        self.thread.unpark();
    }
}

impl Readers {
    /// No readers yet.
    ///
    /// # Errors
    /// If a participant cannot have readers: the reason.
    pub(super) fn of(participant: DomainParticipant) -> Result<Self, String> {
        let subscriber = participant.create_subscriber(&QosPolicies::qos_none()).map_err(|error| error.to_string())?;
        let (readers, given_up) = (BTreeMap::new(), BTreeSet::new());
        Ok(Self { participant, subscriber, readers, given_up, has_new: false })
    }

    pub(super) fn guid(&self, topic: &str) -> Option<GUID> {
        self.readers.get(topic).map(|reader| reader.data.guid())
    }

    /// The topics and GUIDs of all readers.
    pub(super) fn guids(&self) -> Vec<(String, [u8; 16])> {
        self.readers.iter().map(|(topic, reader)| (topic.clone(), reader.data.guid().to_bytes())).collect()
    }

    pub(super) fn clear(&mut self) {
        self.readers.clear();
    }

    /// Removes the reader of a topic. The next [`Self::fit`] creates another.
    pub(super) fn remove(&mut self, topic: &str) {
        self.readers.remove(topic);
    }

    /// Makes [`Self::take`] read from all readers, even if they have not woken the thread.
    pub(super) fn wake_all(&self) {
        self.readers.values().for_each(|reader| reader.alarm.is_set.store(true, Ordering::Release));
    }

    /// Makes the readers fit the writers. A topic is read reliably if all of its writers are reliable. Latched messages
    /// are read if all of its writers latch, and if that is wanted. Returns whether some readers are left to create.
    ///
    /// # Errors
    /// If there can be no such reader: the reason.
    pub(super) fn fit(
        &mut self,
        writers: &[Writer],
        subscribed: &Subscribed,
        receives_latched: bool,
    ) -> Result<bool, String> {
        let mut offered: BTreeMap<&str, (&str, bool, bool)> = BTreeMap::new();
        for writer in
            writers.iter().filter(|writer| subscribed.has(&writer.topic, &writer.kind) && writer.unfit.is_none())
        {
            let known = offered.entry(&writer.topic).or_insert((&writer.kind, true, true));
            known.1 &= writer.is_reliable;
            known.2 &= writer.is_latched && (receives_latched || writer.topic == NODES);
            if self.given_up.remove(&writer.guid) {
                self.readers.remove(&writer.topic);
            }
        }
        let mut made = 0;
        for (topic, (kind, is_reliable, is_latched)) in offered {
            let reader = self.readers.get(topic);
            // A reader with weaker policies still receives from all writers.
            if reader.is_some_and(|reader| (!reader.is_reliable || is_reliable) && (!reader.is_latched || is_latched)) {
                continue;
            }
            if made == MOST_CREATED {
                return Ok(true);
            }
            made += 1;
            let (kind, was_reliable, was_latched) = reader.map_or((kind.to_owned(), true, true), |reader| {
                (reader.kind.clone(), reader.is_reliable, reader.is_latched)
            });
            self.readers.remove(topic);
            match self.read(topic, kind, is_reliable && was_reliable, is_latched && was_latched) {
                Ok(()) => {}
                // If all topics are wanted, those are read for which there is room.
                Err(_) if *subscribed == Subscribed::All => {}
                Err(why) => return Err(why),
            }
        }
        Ok(false)
    }

    /// Creates the reader of a topic, if there is none yet.
    ///
    /// # Errors
    /// If there can be no such reader: the reason.
    pub(super) fn read(
        &mut self,
        topic: &str,
        kind: String,
        is_reliable: bool,
        is_latched: bool,
    ) -> Result<(), String> {
        if self.readers.contains_key(topic) {
            return Ok(());
        }
        let wanted = qos(is_reliable, is_latched, KEPT);
        let make = || {
            let made = self.participant.create_topic(topic.to_owned(), kind.clone(), &wanted, TopicKind::NoKey)?;
            self.subscriber.create_simple_datareader_no_key(&made, Some(wanted.clone()))
        };
        let data = make().map_err(|error| format!("{topic} cannot be read: {error}"))?;
        let alarm = Arc::new(Alarm { is_set: AtomicBool::new(true), thread: std::thread::current() });
        self.has_new = true;
        let reader = Reader { topic: topic.into(), kind, is_reliable, is_latched, data, alarm, is_small: false };
        self.readers.insert(topic.to_owned(), reader);
        Ok(())
    }

    /// What the readers have received, in order. `now_ns` is the time of the clock of messages, and `system_ns` that of
    /// the system. Samples could be received until `alive_ns`.
    pub(super) fn take(&mut self, now_ns: i64, system_ns: i64, alive_ns: i64) -> Vec<FromReader> {
        let (mut taken, mut samples) = (Vec::new(), Vec::new());
        for reader in self.readers.values_mut() {
            if !reader.alarm.is_set.swap(false, Ordering::Acquire) {
                continue;
            }
            reader.data.set_waker(Some(Waker::from(Arc::clone(&reader.alarm))));
            reader.data.drain_read_notifications();
            let is_of_service = matches!(RosName::of(&reader.topic), Some(RosName::Request(_) | RosName::Reply(_)));
            let (mut has_new, mut are_small) = (false, true);
            loop {
                match reader.data.try_take_one() {
                    // It was published by this participant.
                    Ok(Some(change)) if change.writer_guid.prefix == self.participant.guid().prefix => {}
                    Ok(Some(change)) => {
                        has_new = true;
                        are_small &= change.sample.len() <= SMALL;
                        let age_ns = system_ns.saturating_sub(nanoseconds(change.receive_instant)).max(0);
                        let sent = change.source_timestamp().filter(|stamp| *stamp != Timestamp::INVALID);
                        let related = change.related_sample_identity();
                        let sample = Sample {
                            topic: Arc::clone(&reader.topic),
                            writer: change.writer_guid.to_bytes(),
                            number: i64::from(change.sequence_number),
                            received_ns: now_ns.saturating_sub(age_ns),
                            sent_ns: sent.map(nanoseconds),
                            by_ns: None,
                            stalled_ns: None,
                            body: change.sample,
                        };
                        if is_of_service && sample.body.len() > LARGEST as usize {
                            // No request or response is so large.
                        } else if is_of_service {
                            let related = related.map(|of| (of.writer_guid.to_bytes(), i64::from(of.sequence_number)));
                            taken.push(FromReader::Service { sample, related });
                        } else {
                            samples.push(sample);
                        }
                    }
                    Ok(None) => break,
                    Err(why) => {
                        let message = ListenerMessage::Unreadable(Arc::clone(&reader.topic), why.to_string());
                        taken.push(FromReader::Message(message));
                    }
                }
            }
            if !reader.is_small && has_new && are_small {
                reader.is_small = true;
                let more = qos(reader.is_reliable, reader.is_latched, KEPT_SMALL);
                let topic = reader.topic.as_ref().to_owned();
                // This raises the limits of the topic: they only ever grow. If it fails, fewer samples are kept.
                let _ = self.participant.create_topic(topic, reader.kind.clone(), &more, TopicKind::NoKey);
            }
        }
        let mut first: BTreeMap<[u8; 16], i64> = BTreeMap::new();
        for sample in samples.iter_mut().rev() {
            let first_ns = first.entry(sample.writer).or_insert(i64::MAX);
            sample.stalled_ns = Some(alive_ns).filter(|ns| sample.received_ns.saturating_sub(*ns) > UNCONFIRMED_NS);
            sample.by_ns = Some(*first_ns).filter(|first_ns| *first_ns < sample.received_ns);
            *first_ns = sample.received_ns.min(*first_ns);
        }
        // The samples of one writer keep the order of their numbers. One that had to be sent again was received after
        // the next, but precedes it.
        let mut latest: BTreeMap<[u8; 16], i64> = BTreeMap::new();
        let keyed = samples.into_iter().map(|sample: Sample| {
            let at_ns = latest.entry(sample.writer).or_insert(sample.received_ns);
            *at_ns = sample.received_ns.max(*at_ns);
            (*at_ns, sample)
        });
        let mut samples: Vec<(i64, Sample)> = keyed.collect();
        samples.sort_by_key(|(at_ns, _)| *at_ns);
        taken.extend(samples.into_iter().map(|(_, sample)| FromReader::Message(ListenerMessage::of(sample))));
        taken
    }
}

/// Nanoseconds since 1970.
pub(super) fn nanoseconds(stamp: Timestamp) -> i64 {
    let ticks = u128::from(stamp.to_ticks());
    i64::try_from((ticks * 1_000_000_000) >> 32).unwrap_or(i64::MAX)
}
