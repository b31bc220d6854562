//! The process that takes part in a DDS domain. All that is known of rustdds is here, in its `readers` and its
//! `writers`.
//!
//! It only listens, unless it is to publish or to serve, and never asks for more than writers offer. It has no reader
//! on a topic of requests, except for services of its own: with one, Fast DDS would report the robot's services as
//! unavailable.
//!
//! It is a process of its own, because what others send can make rustdds panic, or take gigabytes for a message of
//! which a fragment has come: it then ends, and [another](super::participant) takes its place.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufWriter, Write, stdin, stdout};
use std::net::{IpAddr, Ipv4Addr};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rustdds::discovery::PublicationBuiltinTopicData;
use rustdds::policy::{Durability, Reliability};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantStatusEvent, DomainParticipantStatusListener, GUID,
    LostReason, RTPSEntity as _, SampleIdentity, SequenceNumber, StatusEvented as _, Timestamp,
};

use super::announcements::Announcements;
use super::as_is::{KEPT, qos};
use super::correlation::Correlation;
use super::goodbye;
use super::heard::{
    self, Ask, Heard, LEAVING, NODES, NodeNames, Offers, Prefix, Publication, Request, Response, Sample, Server,
    Subscribed, Writer, participant, prefix, whole,
};
use super::names::{self, RosName};
use super::options::Options;
use super::pulse::Pulse;
use super::readers::{FromReader, Readers, nanoseconds};
use super::requests::Requests;
use super::services::{Services, served};
use super::writers::Writers;
use crate::clock::{Clock, now, sleep};

/// How long the thread waits for something to happen.
const PATIENCE: Duration = Duration::from_millis(10);

/// How long to wait for more once something has come: messages often come several at a time.
const GATHERING: Duration = Duration::from_millis(2);

/// How often silence is reported, and how often it is that samples can be received, where there is none.
const QUIET_NS: i64 = 10_000_000;
const ALIVE_NS: i64 = 50_000_000;

/// How often what others offer is looked at, if it has changed.
const LOOK: Duration = Duration::from_millis(20);

/// How long a participant stays after it has unsubscribed.
const FAREWELL: Duration = Duration::from_millis(100);

/// How long it may take to read two clocks, in nanoseconds.
const LONGEST_READING: i64 = 1_000_000;

/// The most memory that the process may take, in bytes of addresses: with 4 MB maps, it takes a third of it.
const MOST_MEMORY: u64 = 1 << 30;

/// The exit status after a panic, and that of a process whose rustdds has ended.
const PANICKED: i32 = 101;
const EXIT_DEAD: i32 = 1;

/// How often a node says again which readers and writers it has, and how long it waits between that.
const SAID_AGAIN: u32 = 3;
const SAYING_AGAIN: Duration = Duration::from_millis(500);

/// How long others may take to say which nodes they have, and how often they are asked again, by a new reader. Of 100
/// times, Fast DDS says it once or twice only after seconds.
const NAMING: Duration = Duration::from_millis(600);
const ASKED_AGAIN: u32 = 3;

/// The most writers that are known of, and the longest name of a topic or type.
const MOST_WRITERS: usize = 20_000;
const LONGEST_NAME: usize = 512;

/// The most servers of a service that are known of.
const MOST_SERVERS: usize = 100;

/// The longest step back of the system's clock that does not matter: rustdds holds samples back until it has caught up.
const LONGEST_STEP: i64 = 50_000_000;

/// Whether the process is to end, what else is to be read from now on, and what is left to publish.
struct Asked {
    is_to_end: AtomicBool,
    subscribed: Mutex<Option<Subscribed>>,
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
        subscribed: Mutex::new(None),
        messages: Mutex::new(Vec::new()),
    });
    let (listening, heard) = (std::thread::current(), Arc::clone(&asked));
    std::thread::spawn(move || {
        while let Some(ask) = Ask::read(&mut stdin().lock()) {
            match ask {
                Ask::Join { .. } => {}
                Ask::Subscribe(to) => *heard.subscribed.lock().unwrap_or_else(PoisonError::into_inner) = Some(to),
                Ask::Publish(_) | Ask::Request(_) | Ask::Serve(..) | Ask::Respond(_) => {
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
    readers: Readers,
    writers: Writers,
    /// What is to be told.
    untold: Vec<Heard>,
    /// What services are asked, what those that are offered here respond, and the vendors of participants, which say
    /// how that is written.
    requests: Requests,
    services: Services,
    vendors: BTreeMap<Prefix, [u8; 2]>,
    /// Whether something has been noted that has not been looked at.
    has_news: bool,
    options: Options,
    /// Its names, if this is a node.
    node: Option<NodeNames>,
    /// When it last said which readers and writers it has, and how often it is still to say it: whoever has just come
    /// may have missed it.
    said: Option<Instant>,
    again: u32,
    clock: Clock,
    /// The system's clock minus ours; until when that has to catch up, as it went back a little.
    offset_ns: i64,
    behind_ns: i64,
    /// The writers that are known to whoever is told of them.
    known: BTreeSet<[u8; 16]>,
    announcements: Option<Announcements>,
    pulse: Pulse,
    /// The writers that have not said yet which nodes they belong to, until when they may, and how often they have been
    /// asked again.
    unnamed: BTreeSet<[u8; 16]>,
    named_by: Instant,
    asked_again: u32,
    /// Those that said goodbye since it was told the last time, and the writers that ever did.
    goodbyes: BTreeSet<[u8; 16]>,
    departed: BTreeSet<[u8; 16]>,
}

impl Listener {
    fn join(options: Options, clock: Clock, node: Option<NodeNames>) -> Result<Self, String> {
        let mut builder = DomainParticipantBuilder::new(options.domain);
        if options.is_local {
            builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let participant = builder.build().map_err(|error| error.to_string())?;
        let events = participant.status_listener();
        let offset_ns = nanoseconds(Timestamp::now()) - clock.now_ns();
        let pulse = Pulse::of(options, participant.participant_id(), &participant.guid().to_bytes())?;
        Ok(Self {
            readers: Readers::of(participant.clone())?,
            writers: Writers::of(participant.clone()),
            requests: Requests::of(&participant.guid().to_bytes()),
            services: Services::default(),
            vendors: BTreeMap::new(),
            has_news: false,
            participant,
            events,
            untold: Vec::new(),
            options,
            // A node without readers and writers is one, too.
            again: if node.is_some() { SAID_AGAIN } else { 0 },
            said: None,
            node,
            clock,
            offset_ns,
            behind_ns: i64::MIN,
            known: BTreeSet::new(),
            announcements: Announcements::of(options),
            pulse,
            unnamed: BTreeSet::new(),
            named_by: now(),
            asked_again: 0,
            goodbyes: BTreeSet::new(),
            departed: BTreeSet::new(),
        })
    }

    fn listen(mut self, asked: &Asked, out: &mut impl Write) -> Result<(), String> {
        let (mut subscribed, mut looked, mut is_due) = (Subscribed::Nothing, None, true);
        let (mut told, mut quiet_ns, mut alive_ns) = (Vec::new(), 0, 0);
        while !asked.is_to_end.load(Ordering::Relaxed) {
            if let Some(why) = self.is_set_back() {
                self.leave();
                return Err(why);
            }
            if self.take_note() | std::mem::take(&mut self.has_news) {
                (is_due, self.again) = (true, SAID_AGAIN);
            }
            if let Some(why) = self.pulse.is_dead() {
                // What is left of rustdds need not end.
                goodbye::say(self.options, &self.participant.guid().to_bytes());
                eprintln!("{why}");
                std::process::exit(EXIT_DEAD);
            }
            self.pulse.beat(self.clock.now_ns());
            let (why, anew) = self.look_around();
            if let Some(why) = why {
                return self.begin_anew(&anew, out, why);
            }
            self.obey(asked)?;
            is_due |= self.ask_for_nodes();
            let unanswered = self.requests.given_up().into_iter();
            self.untold.extend(unanswered.map(|number| Heard::Response(Response { number, body: Vec::new() })));
            if let Some(wanted) = asked.subscribed.lock().unwrap_or_else(PoisonError::into_inner).take() {
                (subscribed, is_due) = (wanted, true);
            }
            // What a writer says last is taken before it is gone.
            let now_ns = self.clock.now_ns();
            told.append(&mut self.untold);
            told.append(&mut self.writers.untold);
            self.take(&mut told);
            let is_silent = told.is_empty();
            if told.iter().any(|heard| matches!(heard, Heard::Sample(_))) {
                self.pulse.note_message();
            }
            let has_new =
                told.iter().any(|heard| matches!(heard, Heard::Sample(of) if !self.known.contains(&of.writer)));
            if has_new || is_due && looked.is_none_or(|looked: Instant| looked.elapsed() > LOOK) {
                looked = Some(now());
                let offers = self.offers()?;
                let again = self.departed.iter().find(|guid| offers.writers.iter().any(|writer| writer.guid == **guid));
                if let Some(again) = again.copied() {
                    let why = "a publisher has begun anew with the GUID of an earlier one".to_owned();
                    return self.begin_anew(&[again], out, why);
                }
                // rustdds tells of a goodbye after it has forgotten who said it.
                if self.lacks_goodbyes(&offers.writers) {
                    sleep(GATHERING);
                    self.take_note();
                }
                self.requests.note(&offers, |of| Correlation::of(self.vendors.get(of).copied()));
                is_due = self.read(&offers.writers, &subscribed)?;
                self.expect_nodes(&offers.writers);
                self.known = offers.writers.iter().map(|writer| writer.guid).collect();
                let heard = Heard::Others { offers, goodbyes: std::mem::take(&mut self.goodbyes) };
                // Who has come is known before what it says, and who has gone after that.
                told.insert(if has_new { 0 } else { told.len() }, heard);
            }
            for heard in &told {
                if let Heard::Sample(of) = heard {
                    self.unnamed.remove(&of.writer);
                }
            }
            // Time that passes proves nothing, unless something could have come.
            let lived_ns = self.pulse.lived_ns().map_or(0, |lived_ns| lived_ns.min(now_ns));
            if is_silent && lived_ns.saturating_sub(quiet_ns) >= QUIET_NS {
                (quiet_ns, alive_ns) = (lived_ns, lived_ns);
                told.push(Heard::Quiet(lived_ns));
            } else if lived_ns.saturating_sub(alive_ns) >= ALIVE_NS {
                alive_ns = lived_ns;
                told.push(Heard::Alive(lived_ns));
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

    /// Tells who has begun anew. What they say has numbers that rustdds has heard, and leaves out: another participant
    /// must hear them.
    fn begin_anew(self, all: &[[u8; 16]], out: &mut impl Write, why: String) -> Result<(), String> {
        // A process that does not listen any more need not be told.
        let _ = all.iter().try_for_each(|guid| Heard::Anew(*guid).write(out)).and_then(|()| out.flush());
        self.leave();
        Err(why)
    }

    /// Publishes, requests and responds what is asked.
    fn obey(&mut self, asked: &Asked) -> Result<(), String> {
        let messages = std::mem::take(&mut *asked.messages.lock().unwrap_or_else(PoisonError::into_inner));
        messages.into_iter().try_for_each(|ask| match ask {
            Ask::Publish(Publication { topic, kind, is_latched, body }) => {
                self.writers.write(names::topic(&topic), names::dds_kind(&kind), is_latched, body)
            }
            Ask::Request(request) => self.ask(request),
            Ask::Serve(service, kind) => self.serve(&service, &kind),
            Ask::Respond(reply) => {
                self.services.respond(reply);
                Ok(())
            }
            Ask::Join { .. } | Ask::Subscribe(_) => Ok(()),
        })?;
        self.writers.send();
        self.request();
        self.respond();
        Ok(())
    }

    /// Looks for those that rustdds does not hear. Returns why another participant must hear them, if one must, and
    /// which participants have begun anew.
    fn look_around(&mut self) -> (Option<String>, Vec<[u8; 16]>) {
        let Some(announcements) = &mut self.announcements else { return (None, Vec::new()) };
        announcements.look(|of| self.readers.given_up.iter().any(|guid| prefix(guid) == *of));
        let has_returned = announcements.has_returned();
        let anew: Vec<[u8; 16]> = announcements.take_anew().iter().map(whole).collect();
        let why = if anew.is_empty() {
            has_returned.then(|| "a participant that was given up goes on".to_owned())
        } else {
            Some("a participant has begun anew with the GUID of an earlier one".to_owned())
        };
        (why, anew)
    }

    /// Takes note of what has happened in the domain. Returns whether anything has.
    fn take_note(&mut self) -> bool {
        let mut has_happened = false;
        while let Some(event) = self.events.try_recv_status() {
            if let DomainParticipantStatusEvent::ParticipantLost { id, .. } = &event
                && self.pulse.is_answer(&prefix(&GUID { prefix: *id, ..GUID::GUID_UNKNOWN }.to_bytes()))
            {
                continue;
            }
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
                    if self.departed.len() >= MOST_WRITERS {
                        self.departed.clear();
                    }
                    self.departed.insert(guid.to_bytes());
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
            self.readers.look();
        }
        let words = || format!("the clock of this machine was set back by {:.3} s", back_ns as f64 * 1e-9);
        (back_ns > LONGEST_STEP).then(words)
    }

    /// What others offer. Takes note of who reads responses.
    fn offers(&mut self) -> Result<Offers, String> {
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
        let mut clients = BTreeSet::new();
        for reader in self.participant.discovered_readers() {
            let (topic, kind) =
                (reader.subscription_topic_data.topic_name(), reader.subscription_topic_data.type_name());
            let reader = reader.reader_proxy.remote_reader_guid.to_bytes();
            if topic.starts_with("rq/") {
                if is_named(topic, kind) && requests.len() < MOST_WRITERS {
                    let servers = requests.entry(topic.clone()).or_default();
                    servers.extend((servers.len() < MOST_SERVERS).then(|| Server { reader, kind: kind.clone() }));
                }
            } else if self.writers.has(topic) {
                read.insert(topic.clone());
                clients.extend(topic.starts_with("rr/").then(|| (topic.clone(), prefix(&reader))));
            }
        }
        self.services.note(clients);
        Ok(Offers { writers: writers.collect(), requests, read })
    }

    /// Makes the readers fit the writers. Returns whether some are left to make.
    fn read(&mut self, writers: &[Writer], subscribed: &Subscribed) -> Result<bool, String> {
        let now: BTreeSet<[u8; 16]> = writers.iter().map(|writer| writer.guid).collect();
        let silent = self.known.difference(&now).filter(|guid| !self.goodbyes.contains(*guid));
        self.readers.given_up.extend(silent.filter(|guid| !self.goodbyes.contains(&participant(guid))));
        self.readers.fit(writers, subscribed, self.node.as_ref().is_none_or(|node| node.hears_latched))
    }

    /// Takes note of who is to say which nodes there are.
    fn expect_nodes(&mut self, writers: &[Writer]) {
        let all: BTreeSet<_> =
            writers.iter().filter(|writer| writer.topic == NODES).map(|writer| writer.guid).collect();
        self.unnamed.retain(|guid| all.contains(guid));
        for guid in all.difference(&self.known) {
            self.unnamed.insert(*guid);
            (self.named_by, self.asked_again) = (now() + NAMING, 0);
        }
    }

    /// Asks anew for what has not been said of nodes. Returns whether a reader is to be made for it.
    fn ask_for_nodes(&mut self) -> bool {
        if self.unnamed.is_empty() || self.asked_again == ASKED_AGAIN || now() < self.named_by {
            return false;
        }
        (self.named_by, self.asked_again) = (now() + NAMING, self.asked_again + 1);
        self.readers.remove(NODES);
        true
    }

    /// Takes a request, or offers to ask a service.
    fn ask(&mut self, request: Request) -> Result<(), String> {
        let (topic, kind) = (names::request(&request.service), names::request_kind(&request.kind));
        self.writers.write(topic, kind, false, Vec::new())?;
        if !request.body.is_empty() {
            self.requests.ask(request);
        }
        Ok(())
    }

    /// Sends the requests that servers wait for.
    fn request(&mut self) {
        for (request, form) in self.requests.due() {
            // A server that knows the reader of responses waits until it has found it.
            let reader = self.readers.guid(&names::reply(&request.service));
            let related =
                reader.map(|guid| SampleIdentity { writer_guid: guid, sequence_number: SequenceNumber::UNKNOWN });
            let topic = names::request(&request.service);
            let beside = related.filter(|_| form == Correlation::Beside);
            let body = self.requests.body(&request, form);
            match related.and_then(|_| self.writers.converse(&topic, body, beside)) {
                Some(number) => self.requests.sent(request, number),
                // There is no reader of responses yet, or no room now.
                None => self.requests.ask(request),
            }
        }
    }

    /// Offers a service.
    fn serve(&mut self, service: &str, kind: &str) -> Result<(), String> {
        self.writers.write(names::reply(service), names::response_kind(kind), false, Vec::new())?;
        self.readers.read(&names::request(service), names::request_kind(kind), true, false)
    }

    /// Sends the responses that clients can receive.
    fn respond(&mut self) {
        for reply in self.services.due() {
            let client = reply.client;
            let identity = SampleIdentity {
                writer_guid: GUID::from_bytes(client.asker),
                sequence_number: SequenceNumber::from(client.number),
            };
            let related = client.header.is_none().then_some(identity);
            if self.writers.converse(&names::reply(&reply.service), Services::body(&reply), related).is_none() {
                // There is no room now.
                self.services.respond(reply);
            }
        }
    }

    /// Says which node this is, and what it reads and writes, if that has changed.
    fn introduce(&mut self) -> Result<(), String> {
        let has_changed = self.readers.has_new || self.writers.has_new;
        let is_due = self.again > 0 && self.said.is_none_or(|said| said.elapsed() > SAYING_AGAIN);
        let Some(node) = self.node.as_ref().filter(|_| has_changed || is_due) else { return Ok(()) };
        self.again = if has_changed { SAID_AGAIN } else { self.again - 1 };
        self.said = Some(now());
        let participant = self.participant.guid().to_bytes();
        let (readers, writers) = (self.readers.guids(), self.writers.guids());
        // What is in nobody's namespace belongs to the first.
        let space = |name: &str| name.rsplit_once('/').map_or(0, |(space, _)| space.len());
        let owner = |topic: &str| {
            let name = topic.split_once('/').map_or(topic, |(_, name)| name);
            let has = |node: &&String| {
                let space = node[..space(node)].trim_start_matches('/');
                space.is_empty() || name.strip_prefix(space).is_some_and(|rest| rest.starts_with('/'))
            };
            node.names.iter().filter(has).max_by_key(|name| space(name)).unwrap_or(&node.names[0])
        };
        let of = |node: &String, all: &[(String, [u8; 16])]| {
            all.iter().filter(|(topic, _)| owner(topic) == node).map(|(_, guid)| *guid).collect()
        };
        let nodes = node.names.iter().map(|node| (node.as_str(), [of(node, &readers), of(node, &writers)]));
        let body = heard::introduction::<16>(&participant, &nodes.collect::<Vec<_>>());
        (self.readers.has_new, self.writers.has_new) = (false, false);
        let kind = names::dds_kind("rmw_dds_common/msg/ParticipantEntitiesInfo");
        self.writers.write(NODES.to_owned(), kind, true, body)
    }

    /// What the readers have received, in order.
    fn take(&mut self, told: &mut Vec<Heard>) {
        let (now_ns, system_ns) = (self.clock.now_ns(), nanoseconds(Timestamp::now()));
        let lived_ns = self.pulse.lived_ns().unwrap_or(i64::MIN);
        for taken in self.readers.take(now_ns, system_ns, lived_ns) {
            told.extend(match taken {
                FromReader::Heard(heard) => Some(heard),
                FromReader::Said { sample, related } => self.heed(sample, related),
            });
        }
    }

    /// What a request or a response is, if it belongs to a service that is offered or asked here.
    fn heed(&mut self, sample: Sample, related: Option<([u8; 16], i64)>) -> Option<Heard> {
        if !self.vendors.contains_key(&prefix(&sample.writer)) {
            // It has just come.
            self.has_news |= self.take_note();
        }
        let form = Correlation::of(self.vendors.get(&prefix(&sample.writer)).copied());
        match RosName::of(&sample.topic)? {
            RosName::Request(service) => {
                served(service, form, sample, related.map(|(guid, _)| guid)).map(Heard::Served)
            }
            RosName::Reply(service) => {
                // All clients of a service read all responses.
                let own = |(guid, _): &([u8; 16], i64)| prefix(guid) == prefix(&self.participant.guid().to_bytes());
                let related = related.filter(own).map(|(_, number)| number);
                let response = self.requests.response(&service, form, related, sample.body);
                response.map(|(number, body)| Heard::Response(Response { number, body }))
            }
            RosName::Topic(_) => None,
        }
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
