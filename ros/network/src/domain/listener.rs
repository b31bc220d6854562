//! The process that takes part in a DDS domain: all that is known of rustdds is here.
//!
//! It only listens, unless it is to publish verdicts, and never asks for more than writers offer. It has no reader on a
//! topic of requests: with one, Fast DDS would report the robot's services as unavailable.
//!
//! It is a process of its own, because what others send can make rustdds panic, or take gigabytes for a message of
//! which a fragment has come: it then ends, and [another](super::participant) takes its place.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::{BufWriter, Write, stdin, stdout};
use std::net::{IpAddr, Ipv4Addr};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Wake, Waker};
use std::thread::Thread;
use std::time::{Duration, Instant};

use rustdds::bytes::Bytes;
use rustdds::discovery::PublicationBuiltinTopicData;
use rustdds::no_key::{DataWriter, Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter, SimpleDataReader};
use rustdds::policy::{Durability, History, Reliability, ResourceLimits};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantStatusEvent, DomainParticipantStatusListener, GUID,
    LostReason, QosPolicies, QosPolicyBuilder, RTPSEntity as _, RepresentationIdentifier, SampleIdentity,
    SequenceNumber, StatusEvented as _, Subscriber, Timestamp, TopicKind, WriteOptionsBuilder,
};

use super::announcements::Announcements;
use super::goodbye;
use super::heard::{
    self, Ask, Heard, LEAVING, NODES, NodeName, Offers, Prefix, Publication, Request, Response, Sample, Server,
    Subscribed, Writer, participant, prefix,
};
use super::names::{self, RosName};
use super::options::Options;
use super::requests::{Correlation, Requests};
use crate::clock::{Clock, now, sleep};

/// How long the thread waits for something to happen.
const PATIENCE: Duration = Duration::from_millis(10);

/// How long to wait for more once something has come: messages often come several at a time.
const GATHERING: Duration = Duration::from_millis(2);

/// How often silence is reported.
const QUIET_NS: i64 = 10_000_000;

/// How often what others offer is looked at, if it has changed.
const LOOK: Duration = Duration::from_millis(20);

/// How long a participant stays after it has unsubscribed.
const FAREWELL: Duration = Duration::from_millis(100);

/// How long it may take to read two clocks, in nanoseconds.
const LONGEST_READING: i64 = 1_000_000;

/// The most memory that the process may take, in bytes of addresses: with 4 MB maps, it takes a third of it.
const MOST_MEMORY: u64 = 1 << 30;

/// The exit status after a panic.
const PANICKED: i32 = 101;

/// The most readers that are made at a time: rustdds has room for a hundred at once.
const MOST_MADE: usize = 50;

/// The most samples of a topic that rustdds keeps; and, once it is known that they are small, the most small ones.
const KEPT: i32 = 16;
const KEPT_SMALL: i32 = 1024;
const SMALL: usize = 1 << 14;

/// How often a node says again which readers and writers it has, and how long it waits between that.
const SAID_AGAIN: u32 = 3;
const SAYING_AGAIN: Duration = Duration::from_millis(500);

/// How many samples of a topic are kept for readers that have not received them.
const OFFERED: i32 = 32;

/// The most writers that are known of, and the longest name of a topic or type.
const MOST_WRITERS: usize = 20_000;
const LONGEST_NAME: usize = 512;

/// The most servers of a service that are known of.
const MOST_SERVERS: usize = 100;

/// The longest step back of the system's clock that does not matter: rustdds holds samples back until it has caught up.
const LONGEST_STEP: i64 = 50_000_000;

/// Whether the process is to end, what is to be read, and what is left to publish.
struct Asked {
    is_to_end: AtomicBool,
    subscribed: Mutex<Subscribed>,
    messages: Mutex<Vec<Ask>>,
}

/// Does what the process that started this one asks for, until that one has gone.
pub(super) fn work() -> ExitCode {
    std::panic::set_hook(Box::new(|info| {
        // Whichever thread it is: a participant that lacks one is deaf. A line is what whoever started this one tells.
        eprintln!("{:.1000}", info.payload_as_str().unwrap_or("a defect in rustdds"));
        std::process::exit(PANICKED);
    }));
    // Each reader has four files.
    #[cfg(unix)]
    {
        let files = rustix::process::getrlimit(rustix::process::Resource::Nofile);
        let all = rustix::process::Rlimit { current: files.maximum, ..files };
        let _ = rustix::process::setrlimit(rustix::process::Resource::Nofile, all);
    }
    // What others send decides how much memory rustdds takes. If it cannot be limited, it is not.
    #[cfg(unix)]
    let _ = rustix::process::setrlimit(
        rustix::process::Resource::As,
        rustix::process::Rlimit { current: Some(MOST_MEMORY), maximum: Some(MOST_MEMORY) },
    );
    let Some(Ask::Join { options, ahead_ns, node }) = Ask::read(&mut stdin().lock()) else { return ExitCode::FAILURE };
    let asked = Arc::new(Asked {
        is_to_end: AtomicBool::new(false),
        subscribed: Mutex::new(Subscribed::Nothing),
        messages: Mutex::new(Vec::new()),
    });
    let (listening, heard) = (std::thread::current(), Arc::clone(&asked));
    std::thread::spawn(move || {
        while let Some(ask) = Ask::read(&mut stdin().lock()) {
            match ask {
                Ask::Join { .. } => {}
                Ask::Subscribe(to) => *heard.subscribed.lock().unwrap_or_else(PoisonError::into_inner) = to,
                Ask::Publish(_) | Ask::Request(_) => {
                    heard.messages.lock().unwrap_or_else(PoisonError::into_inner).push(ask);
                }
            }
            listening.unpark();
        }
        heard.is_to_end.store(true, Ordering::Relaxed);
        listening.unpark();
        // Whoever asked for it has gone: nothing may keep this process.
        sleep(LEAVING);
        std::process::exit(0);
    });
    let listener = Listener::join(options, Clock::ahead(ahead_ns), node);
    match listener.and_then(|listener| listener.listen(&asked, &mut BufWriter::new(stdout()))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

/// A participant, with its readers.
struct Listener {
    participant: DomainParticipant,
    events: DomainParticipantStatusListener,
    subscriber: Subscriber,
    readers: BTreeMap<String, Reader>,
    /// What publishes, by topic; and what had no room there: one reader that does not answer must not keep messages
    /// from the others for longer than it takes to forget it.
    writers: BTreeMap<String, DataWriter<Vec<u8>, AsIs>>,
    unsent: BTreeMap<String, VecDeque<Vec<u8>>>,
    /// Where messages were left out, and where that is not told yet.
    left_out: BTreeSet<String>,
    untold: Vec<Heard>,
    /// What services are asked, and the vendors of participants, which say how they are asked.
    requests: Requests,
    vendors: BTreeMap<Prefix, [u8; 2]>,
    options: Options,
    /// Its name, if this is a node; and whether it has other readers or writers than it has said.
    node: Option<NodeName>,
    has_changed: bool,
    /// When it last said so, and how often it is still to say it: whoever has just come may have missed it.
    said: Option<Instant>,
    again: u32,
    clock: Clock,
    /// The system's clock minus ours; until when that has to catch up, as it went back a little.
    offset_ns: i64,
    behind_ns: i64,
    /// The writers that are known to whoever is told of them.
    known: BTreeSet<[u8; 16]>,
    /// Those that are gone without a goodbye. If they come back, rustdds does not tell their readers.
    given_up: BTreeSet<[u8; 16]>,
    announcements: Option<Announcements>,
    /// Those that said goodbye since it was told the last time.
    goodbyes: BTreeSet<[u8; 16]>,
}

struct Reader {
    topic: Arc<str>,
    /// The service whose responses come here.
    service: Option<String>,
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
    fn join(options: Options, clock: Clock, node: Option<NodeName>) -> Result<Self, String> {
        let mut builder = DomainParticipantBuilder::new(options.domain);
        if options.is_local {
            builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let participant = builder.build().map_err(|error| error.to_string())?;
        let subscriber = participant.create_subscriber(&QosPolicies::qos_none()).map_err(|error| error.to_string())?;
        let events = participant.status_listener();
        let offset_ns = nanoseconds(Timestamp::now()) - clock.now_ns();
        let [known, given_up, goodbyes] = [(); 3].map(|()| BTreeSet::new());
        let (readers, writers, behind_ns) = (BTreeMap::new(), BTreeMap::new(), i64::MIN);
        Ok(Self {
            requests: Requests::of(&participant.guid().to_bytes()),
            vendors: BTreeMap::new(),
            participant,
            events,
            subscriber,
            readers,
            writers,
            unsent: BTreeMap::new(),
            left_out: BTreeSet::new(),
            untold: Vec::new(),
            options,
            has_changed: node.is_some(),
            said: None,
            again: 0,
            node,
            clock,
            offset_ns,
            behind_ns,
            known,
            given_up,
            announcements: Announcements::of(options),
            goodbyes,
        })
    }

    fn listen(mut self, asked: &Asked, out: &mut impl Write) -> Result<(), String> {
        let (mut subscribed, mut looked, mut is_due) = (Subscribed::Nothing, None, true);
        let (mut told, mut quiet_ns) = (Vec::new(), 0);
        while !asked.is_to_end.load(Ordering::Relaxed) {
            if let Some(why) = self.is_set_back() {
                self.leave();
                return Err(why);
            }
            if self.take_note() {
                (is_due, self.again) = (true, SAID_AGAIN);
            }
            let is_given_up = |of: &_| self.given_up.iter().any(|guid| prefix(guid) == *of);
            if self.announcements.as_mut().is_some_and(|announcements| announcements.has_returned(is_given_up)) {
                self.leave();
                return Err("a participant that was given up goes on".to_owned());
            }
            self.obey(asked)?;
            let unanswered = self.requests.given_up().into_iter();
            self.untold.extend(unanswered.map(|number| Heard::Response(Response { number, body: Vec::new() })));
            let wanted = asked.subscribed.lock().unwrap_or_else(PoisonError::into_inner).clone();
            is_due |= wanted != subscribed;
            // What a writer says last is taken before it is gone.
            let now_ns = self.clock.now_ns();
            told.append(&mut self.untold);
            self.take(&mut told);
            let is_silent = told.is_empty();
            let has_new =
                told.iter().any(|heard| matches!(heard, Heard::Sample(of) if !self.known.contains(&of.writer)));
            if has_new || is_due && looked.is_none_or(|looked: Instant| looked.elapsed() > LOOK) {
                (looked, subscribed) = (Some(now()), wanted);
                let offers = self.offers()?;
                // rustdds tells of a goodbye after it has forgotten who said it.
                if self.lacks_goodbyes(&offers.writers) {
                    sleep(GATHERING);
                    self.take_note();
                }
                self.requests.note(&offers, |of| Correlation::of(self.vendors.get(of).copied()));
                is_due = self.read(&offers.writers, &subscribed)?;
                self.known = offers.writers.iter().map(|writer| writer.guid).collect();
                let heard = Heard::Others { offers, goodbyes: std::mem::take(&mut self.goodbyes) };
                // Who has come is known before what it says, and who has gone after that.
                told.insert(if has_new { 0 } else { told.len() }, heard);
            }
            if is_silent && now_ns.saturating_sub(quiet_ns) >= QUIET_NS {
                quiet_ns = now_ns;
                told.push(Heard::Quiet(now_ns));
            }
            let written = told.drain(..).try_for_each(|heard| heard.write(out)).and_then(|()| out.flush());
            if written.is_err() {
                // Nobody listens any more.
                break;
            }
            self.introduce()?;
            if is_silent {
                std::thread::park_timeout(PATIENCE);
            } else if self.node.is_none() {
                sleep(GATHERING);
            }
        }
        // What was asked last is still sent.
        self.obey(asked)?;
        self.leave();
        Ok(())
    }

    /// Publishes and requests what is asked.
    fn obey(&mut self, asked: &Asked) -> Result<(), String> {
        let messages = std::mem::take(&mut *asked.messages.lock().unwrap_or_else(PoisonError::into_inner));
        messages.into_iter().try_for_each(|ask| match ask {
            Ask::Publish(message) => self.publish(message),
            Ask::Request(request) => self.ask(request),
            Ask::Join { .. } | Ask::Subscribe(_) => Ok(()),
        })?;
        self.send();
        self.request();
        Ok(())
    }

    /// Takes note of what has happened in the domain. Returns whether anything has.
    fn take_note(&mut self) -> bool {
        let mut has_happened = false;
        while let Some(event) = self.events.try_recv_status() {
            has_happened = true;
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
                    self.goodbyes.insert(guid.to_bytes());
                }
                _ => {}
            }
        }
        has_happened
    }

    /// Whether a writer is gone that has not said goodbye, as far as it has been noted.
    fn lacks_goodbyes(&mut self, writers: &[Writer]) -> bool {
        self.take_note();
        let there: BTreeSet<[u8; 16]> = writers.iter().map(|writer| writer.guid).collect();
        let said = |guid: &[u8; 16]| [*guid, participant(guid)].iter().any(|guid| self.goodbyes.contains(guid));
        self.known.difference(&there).any(|guid| !said(guid))
    }

    /// Leaves the domain. What is left to send is sent only while the participant is there.
    fn leave(mut self) {
        self.readers.clear();
        sleep(FAREWELL);
        let (options, guid) = (self.options, self.participant.guid().to_bytes());
        drop(self);
        goodbye::say(options, &guid);
    }

    /// Why samples would be held back for long, if they would: the system's clock was set back.
    fn is_set_back(&mut self) -> Option<String> {
        let before_ns = self.clock.now_ns();
        let system_ns = nanoseconds(Timestamp::now());
        if self.clock.now_ns().saturating_sub(before_ns) > LONGEST_READING {
            // Something came in between.
            return None;
        }
        let back_ns = self.offset_ns - (system_ns - before_ns);
        self.offset_ns -= back_ns;
        if back_ns > LONGEST_READING {
            self.behind_ns = before_ns.saturating_add(2 * back_ns);
        }
        if before_ns <= self.behind_ns {
            // What is held back until then rings no more.
            self.readers.values().for_each(|reader| reader.alarm.rings.store(true, Ordering::Release));
        }
        let words = || format!("the clock of this machine was set back by {:.3} s", back_ns as f64 * 1e-9);
        (back_ns > LONGEST_STEP).then(words)
    }

    fn offers(&self) -> Result<Offers, String> {
        let found = self.participant.discovered_writers();
        if found.len() > MOST_WRITERS {
            return Err(format!("there are more than {MOST_WRITERS} writers in the domain"));
        }
        let is_named = |topic: &str, kind: &str| topic.len() <= LONGEST_NAME && kind.len() <= LONGEST_NAME;
        let writers = found.into_iter().filter_map(|writer| {
            let data = writer.publication_topic_data;
            is_named(&data.topic_name, &data.type_name).then(|| Writer {
                guid: data.key.to_bytes(),
                // Without a word, it is.
                is_reliable: data.reliability.is_none_or(|offered| offered != Reliability::BestEffort),
                is_latched: data.durability.is_some_and(|durability| durability >= Durability::TransientLocal),
                unfit: unfit(&data),
                hash: names::hash(&writer.user_data),
                topic: data.topic_name,
                kind: data.type_name,
            })
        });
        let (mut requests, mut read): (BTreeMap<String, Vec<Server>>, _) = (BTreeMap::new(), BTreeSet::new());
        for reader in self.participant.discovered_readers() {
            let (topic, kind) =
                (reader.subscription_topic_data.topic_name(), reader.subscription_topic_data.type_name());
            if topic.starts_with("rq/") {
                if is_named(topic, kind) && requests.len() < MOST_WRITERS {
                    let reader = reader.reader_proxy.remote_reader_guid.to_bytes();
                    let servers = requests.entry(topic.clone()).or_default();
                    servers.extend((servers.len() < MOST_SERVERS).then(|| Server { reader, kind: kind.clone() }));
                }
            } else if self.writers.contains_key(topic) {
                read.insert(topic.clone());
            }
        }
        Ok(Offers { writers: writers.collect(), requests, read })
    }

    /// Makes the readers fit the writers: a topic is read reliably if all offer that, and likewise what is latched.
    /// Returns whether some readers are left to make.
    fn read(&mut self, writers: &[Writer], subscribed: &Subscribed) -> Result<bool, String> {
        let now: BTreeSet<[u8; 16]> = writers.iter().map(|writer| writer.guid).collect();
        let silent = self.known.difference(&now).filter(|guid| !self.goodbyes.contains(*guid));
        self.given_up.extend(silent.filter(|guid| !self.goodbyes.contains(&participant(guid))));
        let mut offered: BTreeMap<&str, (&str, bool, bool)> = BTreeMap::new();
        for writer in
            writers.iter().filter(|writer| subscribed.has(&writer.topic, &writer.kind) && writer.unfit.is_none())
        {
            let known = offered.entry(&writer.topic).or_insert((&writer.kind, true, true));
            known.1 &= writer.is_reliable;
            let hears_latched = self.node.as_ref().is_none_or(|node| node.hears_latched);
            known.2 &= writer.is_latched && (hears_latched || writer.topic == NODES);
            if self.given_up.remove(&writer.guid) {
                self.readers.remove(&writer.topic);
            }
        }
        let mut made = 0;
        for (topic, (kind, is_reliable, is_latched)) in offered {
            let reader = self.readers.get(topic);
            // One that asks for less still hears everybody.
            if reader.is_some_and(|reader| (!reader.is_reliable || is_reliable) && (!reader.is_latched || is_latched)) {
                continue;
            }
            if made == MOST_MADE {
                return Ok(true);
            }
            made += 1;
            let (kind, was_reliable, was_latched) = reader.map_or((kind.to_owned(), true, true), |reader| {
                (reader.kind.clone(), reader.is_reliable, reader.is_latched)
            });
            self.readers.remove(topic);
            match self.reader(topic, kind, is_reliable && was_reliable, is_latched && was_latched) {
                Ok(reader) => drop(self.readers.insert(topic.to_owned(), reader)),
                // Of all topics, those are heard for which there is room.
                Err(_) if *subscribed == Subscribed::All => {}
                Err(why) => return Err(why),
            }
        }
        Ok(false)
    }

    fn reader(&mut self, topic: &str, kind: String, is_reliable: bool, is_latched: bool) -> Result<Reader, String> {
        let wanted = qos(is_reliable, is_latched, KEPT);
        let make = || {
            let made = self.participant.create_topic(topic.to_owned(), kind.clone(), &wanted, TopicKind::NoKey)?;
            self.subscriber.create_simple_datareader_no_key(&made, Some(wanted.clone()))
        };
        let data = make().map_err(|error| format!("{topic} cannot be read: {error}"))?;
        let alarm = Arc::new(Alarm { rings: AtomicBool::new(true), thread: std::thread::current() });
        self.has_changed = self.node.is_some();
        let service = match RosName::of(topic) {
            Some(RosName::Reply(service)) => Some(service),
            _ => None,
        };
        Ok(Reader { topic: topic.into(), service, kind, is_reliable, is_latched, data, alarm, is_small: false })
    }

    /// Publishes a message, reliably.
    fn publish(&mut self, Publication { topic, kind, is_latched, body }: Publication) -> Result<(), String> {
        self.write(names::topic(&topic), names::dds_kind(&kind), is_latched, body)
    }

    /// Takes a request, or offers to ask a service.
    fn ask(&mut self, request: Request) -> Result<(), String> {
        self.write(names::request(&request.service), request.dds_kind(), false, Vec::new())?;
        if !request.body.is_empty() {
            self.requests.ask(request);
        }
        Ok(())
    }

    /// Sends the requests that servers wait for.
    fn request(&mut self) {
        for (request, form) in self.requests.due() {
            let writer = self.writers.get(&names::request(&request.service));
            // A server that knows the reader of responses waits until it has found it.
            let reader = self.readers.get(&names::reply(&request.service)).map(|reader| reader.data.guid());
            let Some((writer, writer_guid)) = writer.zip(reader) else {
                self.requests.ask(request);
                continue;
            };
            let related = SampleIdentity { writer_guid, sequence_number: SequenceNumber::UNKNOWN };
            let options = match form {
                Correlation::Beside => WriteOptionsBuilder::new().related_sample_identity(related),
                Correlation::Header => WriteOptionsBuilder::new(),
            };
            match writer.write_with_options(self.requests.body(&request, form), options.build()) {
                Ok(identity) => self.requests.sent(request, i64::from(identity.sequence_number)),
                // There is no room now.
                Err(_) => self.requests.ask(request),
            }
        }
    }

    /// Says which node this is, and what it reads and writes, if that has changed.
    fn introduce(&mut self) -> Result<(), String> {
        let is_due = self.again > 0 && self.said.is_none_or(|said| said.elapsed() > SAYING_AGAIN);
        let Some(node) = self.node.as_ref().filter(|_| self.has_changed || is_due) else { return Ok(()) };
        self.again = if self.has_changed { SAID_AGAIN } else { self.again - 1 };
        self.said = Some(now());
        let readers: Vec<[u8; 16]> = self.readers.values().map(|reader| reader.data.guid().to_bytes()).collect();
        let writers = self.writers.iter().filter(|(topic, _)| *topic != NODES);
        let writers: Vec<[u8; 16]> = writers.map(|(_, writer)| writer.guid().to_bytes()).collect();
        let body = heard::node::<16>(&self.participant.guid().to_bytes(), &node.name, &readers, &writers);
        self.has_changed = false;
        self.write(NODES.to_owned(), names::dds_kind("rmw_dds_common/msg/ParticipantEntitiesInfo"), true, body)
    }

    fn write(&mut self, topic: String, kind: String, is_latched: bool, body: Vec<u8>) -> Result<(), String> {
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
            self.has_changed = self.node.is_some() && topic != NODES;
            self.writers.insert(topic.clone(), made);
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
    fn send(&mut self) {
        for (topic, bodies) in &mut self.unsent {
            let Some(writer) = self.writers.get(topic) else { continue };
            while bodies.front().is_some_and(|body| writer.write(body.clone(), None).is_ok()) {
                bodies.pop_front();
            }
        }
    }

    /// What the readers have received, in order.
    fn take(&mut self, told: &mut Vec<Heard>) {
        let (now_ns, system_ns) = (self.clock.now_ns(), nanoseconds(Timestamp::now()));
        let mut samples = Vec::new();
        for reader in self.readers.values_mut() {
            if !reader.alarm.rings.swap(false, Ordering::Acquire) {
                continue;
            }
            reader.data.set_waker(Some(Waker::from(Arc::clone(&reader.alarm))));
            reader.data.drain_read_notifications();
            let begun = samples.len();
            loop {
                match reader.data.try_take_one() {
                    // What is published here is not heard.
                    Ok(Some(change)) if change.writer_guid.prefix == self.participant.guid().prefix => {}
                    Ok(Some(change)) if let Some(service) = &reader.service => {
                        let vendor = self.vendors.get(&prefix(&change.writer_guid.to_bytes())).copied();
                        // All clients of a service read all responses.
                        let own = |of: &SampleIdentity| of.writer_guid.prefix == self.participant.guid().prefix;
                        let related = change.related_sample_identity().filter(own);
                        let related = related.map(|of| i64::from(of.sequence_number));
                        let response = self.requests.response(service, Correlation::of(vendor), related, change.sample);
                        told.extend(response.map(|(number, body)| Heard::Response(Response { number, body })));
                    }
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
                    Err(why) => told.push(Heard::Unreadable(Arc::clone(&reader.topic), why.to_string())),
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
        // Those of one writer stay in the order of their numbers: one that had to be sent again is older than the next.
        let mut latest: BTreeMap<[u8; 16], i64> = BTreeMap::new();
        let keyed = samples.into_iter().map(|sample: Sample| {
            let at_ns = latest.entry(sample.writer).or_insert(sample.received_ns);
            *at_ns = sample.received_ns.max(*at_ns);
            (*at_ns, sample)
        });
        let mut samples: Vec<(i64, Sample)> = keyed.collect();
        samples.sort_by_key(|(at_ns, _)| *at_ns);
        told.extend(samples.into_iter().map(|(_, sample)| Heard::of(sample)));
    }
}

/// Why no message of a writer can be received, if none can.
fn unfit(writer: &PublicationBuiltinTopicData) -> Option<String> {
    // The kinds of entities: a writer of a topic with a key does not fit a reader of one without.
    const KIND: u8 = 0x3f;
    const WITH_KEY: u8 = 0x02;
    if writer.key.to_bytes()[15] & KIND == WITH_KEY {
        return Some("key".to_owned());
    }
    writer.qos().compliance_failure_wrt(&qos(false, false, KEPT)).map(|policy| format!("{policy:?}"))
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

impl SerializerAdapter<Vec<u8>> for AsIs {
    type Error = std::convert::Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(message: &Vec<u8>) -> Result<Bytes, Self::Error> {
        // What a message begins with says how it is encoded.
        Ok(Bytes::copy_from_slice(message.get(4..).unwrap_or_default()))
    }
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
