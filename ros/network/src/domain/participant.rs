//! A participant in a DDS domain, in a thread of its own: all that is known of rustdds is here.
//!
//! It only listens, and never asks for more than writers offer. It has no reader on a topic of requests: with one, Fast
//! DDS would report the robot's services as unavailable.

use std::collections::{BTreeMap, BTreeSet};
use std::net::{IpAddr, Ipv4Addr};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, Once};
use std::task::{Wake, Waker};
use std::thread::{JoinHandle, Thread};
use std::time::{Duration, Instant};

use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SimpleDataReader};
use rustdds::policy::{Durability, History, Reliability, ResourceLimits};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantStatusEvent, DomainParticipantStatusListener, GUID,
    LostReason, QosPolicies, QosPolicyBuilder, RTPSEntity as _, RepresentationIdentifier, StatusEvented as _,
    Subscriber, Timestamp, TopicKind,
};

use super::goodbye;
use super::heard::{Heard, NODES, Sample, Writer, prefix};
use super::names;
use super::options::Options;
use crate::clock::{Clock, now, sleep};

/// How long the thread waits for something to happen.
const PATIENCE: Duration = Duration::from_millis(5);

/// How often what others offer is looked at, if it has changed.
const LOOK: Duration = Duration::from_millis(20);

/// How long a participant may take to leave.
const LEAVING: Duration = Duration::from_secs(2);

/// How long a participant stays after it has unsubscribed.
const FAREWELL: Duration = Duration::from_millis(100);

/// The most bytes of messages that wait for whoever judges them: what comes then is missing.
const MOST_WAITING: usize = 1 << 27;

/// The most samples of a topic that rustdds keeps; and, once it is known that they are small, the most small ones.
const KEPT: i32 = 16;
const KEPT_SMALL: i32 = 1024;
const SMALL: usize = 1 << 14;

/// The most writers that are known of, and the longest name of a topic or type.
const MOST_WRITERS: usize = 20_000;
const LONGEST_NAME: usize = 512;

/// The longest step back of the system's clock that does not matter: rustdds holds samples back until it has caught up.
const LONGEST_STEP: i64 = 50_000_000;

/// What is to be read: nothing yet, topics with these names, or all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Subscribed {
    Nothing,
    To(BTreeSet<String>),
    All,
}

impl Subscribed {
    fn has(&self, topic: &str) -> bool {
        match self {
            Self::Nothing => topic == NODES,
            Self::To(topics) => topic == NODES || topics.contains(topic),
            Self::All => topic == NODES || topic.starts_with("rt/"),
        }
    }
}

/// The thread, seen from outside. It ends when this is dropped.
pub(super) struct Participant {
    heard: Receiver<Heard>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    is_to_end: AtomicBool,
    /// The bytes of samples that wait.
    waiting: AtomicUsize,
    subscribed: Mutex<Subscribed>,
}

impl Participant {
    pub(super) fn join(options: Options, clock: Clock, subscribed: Subscribed) -> Self {
        let (sender, heard) = channel();
        let shared = Arc::new(Shared {
            is_to_end: AtomicBool::new(false),
            waiting: AtomicUsize::new(0),
            subscribed: Mutex::new(subscribed),
        });
        note_panics();
        let thread = std::thread::Builder::new().name(THREAD.to_owned()).spawn({
            let shared = Arc::clone(&shared);
            move || listen(&options, clock, &shared, &sender)
        });
        Self { heard, shared, thread: thread.ok() }
    }

    /// What comes next, if anything does within this time.
    pub(super) fn next(&self, patience: Duration) -> Option<Heard> {
        let heard = self.heard.recv_timeout(patience).ok()?;
        if let Heard::Sample(sample) = &heard {
            self.shared.waiting.fetch_sub(sample.body.len(), Ordering::Relaxed);
        }
        Some(heard)
    }

    pub(super) fn subscribe(&self, subscribed: Subscribed) {
        *self.shared.subscribed.lock().expect("no thread panics with it") = subscribed;
    }
}

impl Drop for Participant {
    fn drop(&mut self) {
        self.shared.is_to_end.store(true, Ordering::Relaxed);
        let Some(thread) = self.thread.take() else { return };
        thread.thread().unpark();
        let asked = now();
        while !thread.is_finished() && asked.elapsed() < LEAVING {
            sleep(Duration::from_millis(1));
        }
        if thread.is_finished() {
            // What it panicked with has been told.
            let _ = thread.join();
        }
    }
}

/// The name of our thread, and what those of rustdds begin with.
const THREAD: &str = "RustDDS listener";
const THREADS: &str = "RustDDS";

/// What the last panic in a thread of DDS said.
static PANICKED: Mutex<Option<String>> = Mutex::new(None);

/// Takes note of panics in threads of DDS, instead of printing them: they end neither this program nor the watch.
fn note_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let others = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if std::thread::current().name().is_some_and(|name| name.starts_with(THREADS)) {
                let words = info.payload_as_str().unwrap_or("a defect in rustdds").to_owned();
                PANICKED.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(words);
            } else {
                others(info);
            }
        }));
    });
}

fn panicked() -> Option<String> {
    PANICKED.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take()
}

/// Listens until it is to end. After a failure, begins again with another participant.
fn listen(options: &Options, clock: Clock, shared: &Shared, sender: &Sender<Heard>) {
    const AGAIN: Duration = Duration::from_secs(1);
    while !shared.is_to_end.load(Ordering::Relaxed) {
        let listened = catch_unwind(AssertUnwindSafe(|| Listener::join(options, clock)?.listen(shared, sender)));
        let why = match listened {
            Ok(Ok(())) => return,
            Ok(Err(why)) => why,
            Err(_) => panicked().unwrap_or_else(|| "a defect in rustdds".to_owned()),
        };
        if sender.send(Heard::Died(why)).is_err() {
            return;
        }
        std::thread::park_timeout(AGAIN);
    }
}

/// A participant, with its readers.
struct Listener {
    participant: DomainParticipant,
    events: DomainParticipantStatusListener,
    subscriber: Subscriber,
    readers: BTreeMap<String, Reader>,
    clock: Clock,
    /// The system's clock minus ours.
    offset_ns: i64,
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

/// Wakes the thread when a reader has something.
struct Alarm {
    rings: AtomicBool,
    thread: Thread,
}

impl Wake for Alarm {
    fn wake(self: Arc<Self>) {
        self.rings.store(true, Ordering::Release);
        self.thread.unpark();
    }
}

impl Listener {
    fn join(options: &Options, clock: Clock) -> Result<Self, String> {
        panicked();
        let mut builder = DomainParticipantBuilder::new(options.domain);
        if options.is_local {
            builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let participant = builder.build().map_err(|error| error.to_string())?;
        let subscriber = participant.create_subscriber(&QosPolicies::qos_none()).map_err(|error| error.to_string())?;
        let events = participant.status_listener();
        let offset_ns = nanoseconds(Timestamp::now()) - clock.now_ns();
        Ok(Self { participant, events, subscriber, readers: BTreeMap::new(), clock, offset_ns })
    }

    fn listen(mut self, shared: &Shared, sender: &Sender<Heard>) -> Result<(), String> {
        let (mut silent, mut subscribed, mut looked, mut is_due) = (BTreeSet::new(), Subscribed::Nothing, None, true);
        let mut samples = Vec::new();
        while !shared.is_to_end.load(Ordering::Relaxed) {
            if let Some(why) = panicked().or_else(|| self.is_set_back()) {
                return Err(why);
            }
            while let Some(event) = self.events.try_recv_status() {
                is_due = true;
                if let DomainParticipantStatusEvent::ParticipantLost { id, reason: LostReason::Timeout { .. } } = event
                {
                    silent.insert(prefix(&GUID { prefix: id, ..GUID::GUID_UNKNOWN }.to_bytes()));
                }
            }
            let wanted = shared.subscribed.lock().expect("no thread panics with it").clone();
            is_due |= wanted != subscribed;
            if is_due && looked.is_none_or(|looked: Instant| looked.elapsed() > LOOK) {
                (looked, is_due, subscribed) = (Some(now()), false, wanted);
                let (writers, requests) = self.offers()?;
                self.read(&writers, &subscribed)?;
                let heard = Heard::Writers { writers, requests, silent: std::mem::take(&mut silent) };
                if sender.send(heard).is_err() {
                    return Ok(());
                }
            }
            let quiet_ns = self.clock.now_ns();
            self.take(&mut samples);
            if samples.is_empty() {
                if sender.send(Heard::Quiet(quiet_ns)).is_err() {
                    return Ok(());
                }
                std::thread::park_timeout(PATIENCE);
            }
            samples.sort_by_key(|sample: &Sample| sample.received_ns);
            for sample in samples.drain(..) {
                let size = sample.body.len();
                // The gap in the numbers will show that it is missing.
                if shared.waiting.fetch_add(size, Ordering::Relaxed) > MOST_WAITING {
                    shared.waiting.fetch_sub(size, Ordering::Relaxed);
                } else if sender.send(Heard::Sample(sample)).is_err() {
                    return Ok(());
                }
            }
        }
        self.leave();
        Ok(())
    }

    /// Leaves the domain. What is left to send is sent only while the participant is there.
    fn leave(mut self) {
        self.readers.clear();
        sleep(FAREWELL);
        let (domain, guid) = (self.participant.domain_id(), self.participant.guid().to_bytes());
        drop(self);
        goodbye::say(domain, &guid);
    }

    /// Why samples would be held back, if they would: the system's clock was set back.
    fn is_set_back(&mut self) -> Option<String> {
        let offset_ns = nanoseconds(Timestamp::now()) - self.clock.now_ns();
        let back_ns = self.offset_ns - offset_ns;
        self.offset_ns = offset_ns;
        let words = || format!("the clock of this machine was set back by {:.3} s", back_ns as f64 * 1e-9);
        (back_ns > LONGEST_STEP).then(words)
    }

    /// All writers, and who answers requests: the types of requests by the topics.
    fn offers(&self) -> Result<(Vec<Writer>, BTreeMap<String, String>), String> {
        let found = self.participant.discovered_writers();
        if found.len() > MOST_WRITERS {
            return Err(format!("there are more than {MOST_WRITERS} writers in the domain"));
        }
        let is_named = |topic: &str, kind: &str| topic.len() <= LONGEST_NAME && kind.len() <= LONGEST_NAME;
        let writers = found.into_iter().filter_map(|writer| {
            let data = writer.publication_topic_data;
            is_named(&data.topic_name, &data.type_name).then(|| Writer {
                guid: data.key.to_bytes(),
                is_reliable: matches!(data.reliability, Some(Reliability::Reliable { .. })),
                is_latched: data.durability.is_some_and(|durability| durability >= Durability::TransientLocal),
                unfit: data.qos().compliance_failure_wrt(&qos(false, false, KEPT)).map(|policy| format!("{policy:?}")),
                hash: names::hash(&writer.user_data),
                topic: data.topic_name,
                kind: data.type_name,
            })
        });
        let readers = self.participant.discovered_readers();
        let requests = readers.into_iter().filter_map(|reader| {
            let data = reader.subscription_topic_data;
            let is_request = data.topic_name().starts_with("rq/") && is_named(data.topic_name(), data.type_name());
            is_request.then(|| (data.topic_name().clone(), data.type_name().clone()))
        });
        Ok((writers.collect(), requests.take(MOST_WRITERS).collect()))
    }

    /// Makes the readers fit the writers: a topic is read reliably if all offer that, and likewise what is latched.
    fn read(&mut self, writers: &[Writer], subscribed: &Subscribed) -> Result<(), String> {
        let mut offered: BTreeMap<&str, (&str, bool, bool)> = BTreeMap::new();
        for writer in writers.iter().filter(|writer| subscribed.has(&writer.topic) && writer.unfit.is_none()) {
            let known = offered.entry(&writer.topic).or_insert((&writer.kind, true, true));
            known.1 &= writer.is_reliable;
            known.2 &= writer.is_latched;
        }
        for (topic, (kind, is_reliable, is_latched)) in offered {
            let reader = self.readers.get(topic);
            // One that asks for less still hears everybody.
            if reader.is_some_and(|reader| (!reader.is_reliable || is_reliable) && (!reader.is_latched || is_latched)) {
                continue;
            }
            let (known_kind, was_reliable, was_latched) = reader.map_or((kind.to_owned(), true, true), |reader| {
                (reader.kind.clone(), reader.is_reliable, reader.is_latched)
            });
            self.readers.remove(topic);
            let reader = self.reader(topic, known_kind, is_reliable && was_reliable, is_latched && was_latched)?;
            self.readers.insert(topic.to_owned(), reader);
        }
        Ok(())
    }

    fn reader(&self, topic: &str, kind: String, is_reliable: bool, is_latched: bool) -> Result<Reader, String> {
        let wanted = qos(is_reliable, is_latched, KEPT);
        let make = || {
            let made = self.participant.create_topic(topic.to_owned(), kind.clone(), &wanted, TopicKind::NoKey)?;
            self.subscriber.create_simple_datareader_no_key(&made, Some(wanted.clone()))
        };
        let data = make().map_err(|error| format!("{topic} cannot be read: {error}"))?;
        let alarm = Arc::new(Alarm { rings: AtomicBool::new(true), thread: std::thread::current() });
        Ok(Reader { topic: topic.into(), kind, is_reliable, is_latched, data, alarm, is_small: false })
    }

    /// Adds what the readers have received.
    fn take(&mut self, samples: &mut Vec<Sample>) {
        let (now_ns, system_ns) = (self.clock.now_ns(), nanoseconds(Timestamp::now()));
        for reader in self.readers.values_mut() {
            if !reader.alarm.rings.swap(false, Ordering::Acquire) {
                continue;
            }
            reader.data.set_waker(Some(Waker::from(Arc::clone(&reader.alarm))));
            reader.data.drain_read_notifications();
            let begun = samples.len();
            loop {
                match reader.data.try_take_one() {
                    Ok(Some(change)) => {
                        let age_ns = system_ns.saturating_sub(nanoseconds(change.receive_instant)).max(0);
                        let sent = change.source_timestamp().filter(|stamp| *stamp != Timestamp::INVALID);
                        samples.push(Sample {
                            topic: Arc::clone(&reader.topic),
                            writer: change.writer_guid.to_bytes(),
                            number: i64::from(change.sequence_number),
                            received_ns: now_ns.saturating_sub(age_ns),
                            sent_ns: sent.map(nanoseconds),
                            body: change.sample,
                        });
                    }
                    Ok(None) => break,
                    // What cannot be taken is missing, as the next number will show.
                    Err(_) => {}
                }
            }
            let taken = &samples[begun..];
            if !reader.is_small && !taken.is_empty() && taken.iter().all(|sample| sample.body.len() <= SMALL) {
                reader.is_small = true;
                let more = qos(reader.is_reliable, reader.is_latched, KEPT_SMALL);
                let topic = reader.topic.as_ref().to_owned();
                // The limits of a topic only ever grow; without more room, less is kept.
                let _ = self.participant.create_topic(topic, reader.kind.clone(), &more, TopicKind::NoKey);
            }
        }
    }
}

/// What a reader asks for.
fn qos(is_reliable: bool, is_latched: bool, kept: i32) -> QosPolicies {
    let zero = rustdds::Duration::ZERO;
    let reliability =
        if is_reliable { Reliability::Reliable { max_blocking_time: zero } } else { Reliability::BestEffort };
    QosPolicyBuilder::new()
        .reliability(reliability)
        .durability(if is_latched { Durability::TransientLocal } else { Durability::Volatile })
        .history(History::KeepLast { depth: 1 })
        .resource_limits(ResourceLimits { max_samples: kept, max_instances: 1, max_samples_per_instance: kept })
        .build()
}

/// Nanoseconds since 1970.
fn nanoseconds(stamp: Timestamp) -> i64 {
    let ticks = u128::from(stamp.to_ticks());
    i64::try_from((ticks * 1_000_000_000) >> 32).unwrap_or(i64::MAX)
}

/// Messages as they are encoded.
struct AsIs;

impl DeserializerAdapter<Vec<u8>> for AsIs {
    type Error = std::convert::Infallible;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[
            RepresentationIdentifier::CDR_LE,
            RepresentationIdentifier::CDR_BE,
            RepresentationIdentifier::XCDR2_LE,
            RepresentationIdentifier::XCDR2_BE,
            RepresentationIdentifier::D_CDR2_LE,
            RepresentationIdentifier::D_CDR2_BE,
        ]
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for AsIs {
    type Decoder = Whole;

    const DECODER: Whole = Whole;
}

/// Puts the encoding before a message again.
#[derive(Clone)]
struct Whole;

impl Decode<'_, Vec<u8>> for Whole {
    type Error = std::convert::Infallible;

    fn decode_bytes(self, bytes: &[u8], encoding: RepresentationIdentifier) -> Result<Vec<u8>, Self::Error> {
        let mut message = Vec::with_capacity(bytes.len() + 4);
        message.extend_from_slice(&encoding.to_bytes());
        message.extend_from_slice(&[0, 0]);
        message.extend_from_slice(bytes);
        Ok(message)
    }
}
