//! The listener: a process of its own with a participant in a DDS domain. Only this module, `readers`, `writers` and
//! `as_is` use rustdds.
//!
//! It only subscribes, unless it is commanded to publish or to serve. It requests no policies that writers do not
//! offer. It reads requests only of services that it offers itself: with a reader on the topic of requests of another
//! service, Fast DDS would report that service as unavailable.
//!
//! It is a separate process because of what others may send: it can make rustdds panic, or allocate gigabytes for a
//! message of which one fragment has arrived. The listener then ends, and [another](super::participant) takes its
//! place.

mod expected_nodes;
mod own_nodes;
mod peers;
mod service_messages;
mod system_clock;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufWriter, Write, stdin, stdout};
use std::net::{IpAddr, Ipv4Addr};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rustdds::discovery::PublicationBuiltinTopicData;
use rustdds::policy::{Durability, Reliability};
use rustdds::{DomainParticipant, DomainParticipantBuilder, RTPSEntity as _, Timestamp};

use super::announcements::Announcements;
use super::as_is::{KEPT, qos};
use super::exchange::{
    ListenerCommand, ListenerMessage, NODES, NodeNames, Offers, Publication, Response, Sample, Server, Subscribed,
    Writer, padded, prefix,
};
use super::goodbye;
use super::inbox::Inbox;
use super::names;
use super::options::Options;
use super::pulse::Pulse;
use super::readers::{FromReader, Readers, nanoseconds};
use super::requests::Requests;
use super::services::Services;
use super::writers::Writers;
use crate::clock::{Clock, now, sleep};
use expected_nodes::ExpectedNodes;
use own_nodes::OwnNodes;
use peers::{MOST_WRITERS, Peers};
use system_clock::SystemClock;

/// How long the thread waits until it is woken.
const PATIENCE: Duration = Duration::from_millis(10);

/// How long to wait for more once something was received: messages often arrive several at a time.
const GATHERING: Duration = Duration::from_millis(2);

/// How often it is reported that the clock has advanced, while nothing is received; and that samples can be received,
/// while some are.
const CLOCK_PERIOD_NS: i64 = 10_000_000;
const ALIVE_PERIOD_NS: i64 = 50_000_000;

/// How often changes of what others offer are read.
const DISCOVERY_PERIOD: Duration = Duration::from_millis(20);

/// How long a participant stays after it has unsubscribed.
const GRACE: Duration = Duration::from_millis(100);

/// The most address space of the process, in bytes. While it receives maps of 4 MB, it uses a third of it.
const MOST_MEMORY: u64 = 1 << 30;

/// The exit statuses after a panic, and after a thread of rustdds has ended.
const PANICKED: i32 = 101;
const EXIT_DEAD: i32 = 1;

/// The longest name of a topic or type.
const LONGEST_NAME: usize = 512;

/// The most servers of a service.
const MOST_SERVERS: usize = 100;

/// Executes the commands of the process that started this one, until its input ends.
pub(super) fn work() -> ExitCode {
    std::panic::set_hook(Box::new(|info| {
        // A participant without one of its threads may receive nothing, so a panic in any thread ends the process. The
        // process that started this one reports the first line.
        eprintln!("{:.1000}", info.payload_as_str().unwrap_or("a defect in rustdds"));
        std::process::exit(PANICKED);
    }));
    // Each reader has four open files.
    #[cfg(unix)]
    {
        let files = rustix::process::getrlimit(rustix::process::Resource::Nofile);
        let all = rustix::process::Rlimit { current: files.maximum, ..files };
        let _ = rustix::process::setrlimit(rustix::process::Resource::Nofile, all);
    }
    // Messages of others determine how much memory rustdds allocates. If there can be no limit, there is none.
    #[cfg(unix)]
    let _ = rustix::process::setrlimit(
        rustix::process::Resource::As,
        rustix::process::Rlimit { current: Some(MOST_MEMORY), maximum: Some(MOST_MEMORY) },
    );
    let Some(ListenerCommand::Join { options, ahead_ns, node }) = ListenerCommand::read(&mut stdin().lock()) else {
        return ExitCode::FAILURE;
    };
    let inbox = Inbox::open();
    let listener = Listener::join(options, Clock::ahead(ahead_ns), node);
    match listener.and_then(|listener| listener.listen(&inbox, &mut BufWriter::new(stdout()))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

/// A participant with its readers and writers.
struct Listener {
    participant: DomainParticipant,
    peers: Peers,
    readers: Readers,
    writers: Writers,
    /// Messages that have not been sent.
    unsent: Vec<ListenerMessage>,
    /// The services that are called from here.
    requests: Requests,
    /// The services that are offered here.
    services: Services,
    /// Whether there were events that have not led to a look at what others offer.
    has_events: bool,
    options: Options,
    /// If this is a node.
    own_nodes: Option<OwnNodes>,
    expected_nodes: ExpectedNodes,
    clock: Clock,
    system_clock: SystemClock,
    announcements: Option<Announcements>,
    pulse: Pulse,
}

impl Listener {
    fn join(options: Options, clock: Clock, node: Option<NodeNames>) -> Result<Self, String> {
        let mut builder = DomainParticipantBuilder::new(options.domain);
        if options.is_local {
            builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let participant = builder.build().map_err(|error| error.to_string())?;
        let peers = Peers::of(participant.status_listener());
        let pulse = Pulse::of(options, participant.participant_id(), &participant.guid().to_bytes())?;
        Ok(Self {
            readers: Readers::of(participant.clone())?,
            writers: Writers::of(participant.clone()),
            requests: Requests::of(&participant.guid().to_bytes()),
            services: Services::default(),
            has_events: false,
            participant,
            peers,
            unsent: Vec::new(),
            options,
            own_nodes: node.map(OwnNodes::of),
            expected_nodes: ExpectedNodes::none(),
            clock,
            system_clock: SystemClock::beside(clock),
            announcements: Announcements::of(options),
            pulse,
        })
    }

    /// Executes commands and sends what is received, until the input ends.
    fn listen(mut self, inbox: &Inbox, out: &mut impl Write) -> Result<(), String> {
        let (mut subscribed, mut looked, mut is_due) = (Subscribed::Nothing, None, true);
        let (mut messages, mut clock_ns, mut confirmed_ns) = (Vec::new(), 0, 0);
        while !inbox.is_closed() {
            if let Some(why) = self.system_clock.is_set_back(&self.readers) {
                self.leave();
                return Err(why);
            }
            if self.peers.process_events(&mut self.pulse) | std::mem::take(&mut self.has_events) {
                is_due = true;
                self.own_nodes.iter_mut().for_each(OwnNodes::repeat);
            }
            if let Some(why) = self.pulse.is_dead() {
                // The remaining threads of rustdds need not end by themselves.
                goodbye::send(self.options, &self.participant.guid().to_bytes());
                eprintln!("{why}");
                std::process::exit(EXIT_DEAD);
            }
            self.pulse.beat(self.clock.now_ns());
            let (why, restarted) = self.read_announcements();
            if let Some(why) = why {
                return self.hand_over(&restarted, out, why);
            }
            self.execute(inbox)?;
            if self.expected_nodes.take_retry() {
                self.readers.remove(NODES);
                is_due = true;
            }
            let expired = self.requests.take_expired().into_iter();
            let none = |number| ListenerMessage::Response(Response { number, body: Vec::new() });
            self.unsent.extend(expired.map(none));
            if let Some(wanted) = inbox.take_subscribed() {
                (subscribed, is_due) = (wanted, true);
            }
            // The last samples of a writer are taken before its departure is noticed.
            let now_ns = self.clock.now_ns();
            messages.append(&mut self.unsent);
            messages.append(&mut self.writers.unreported);
            self.take(&mut messages);
            let is_idle = messages.is_empty();
            if messages.iter().any(|message| matches!(message, ListenerMessage::Sample(_))) {
                self.pulse.note_message();
            }
            let is_of_new = |of: &Sample| !self.peers.is_known(&of.writer);
            let has_new =
                messages.iter().any(|message| matches!(message, ListenerMessage::Sample(of) if is_of_new(of)));
            if has_new || is_due && looked.is_none_or(|looked: Instant| looked.elapsed() > DISCOVERY_PERIOD) {
                looked = Some(now());
                let offers = self.offers()?;
                if let Some(again) = self.peers.returned(&offers.writers) {
                    let why = "a publisher has begun anew with the GUID of an earlier one".to_owned();
                    return self.hand_over(&[again], out, why);
                }
                // rustdds reports that an entity has left only after it has forgotten the entity.
                self.peers.process_events(&mut self.pulse);
                if self.peers.vanished(&offers.writers).next().is_some() {
                    sleep(GATHERING);
                    self.peers.process_events(&mut self.pulse);
                }
                self.requests.set_servers(&offers, |of| self.peers.correlation(of));
                is_due = self.read(&offers.writers, &subscribed)?;
                self.expected_nodes.expect(&offers.writers, &self.peers);
                let goodbyes = self.peers.report(&offers.writers);
                let message = ListenerMessage::Discovered { offers, goodbyes };
                // A new writer is reported before its samples, and a departure after them.
                messages.insert(if has_new { 0 } else { messages.len() }, message);
            }
            for message in &messages {
                if let ListenerMessage::Sample(of) = message {
                    self.expected_nodes.note_sample(&of.writer);
                }
            }
            // The clock only advances as far as samples could have been received.
            let alive_ns = self.pulse.alive_ns().map_or(0, |alive_ns| alive_ns.min(now_ns));
            if is_idle && alive_ns.saturating_sub(clock_ns) >= CLOCK_PERIOD_NS {
                (clock_ns, confirmed_ns) = (alive_ns, alive_ns);
                messages.push(ListenerMessage::ClockAdvanced(alive_ns));
            } else if alive_ns.saturating_sub(confirmed_ns) >= ALIVE_PERIOD_NS {
                confirmed_ns = alive_ns;
                messages.push(ListenerMessage::Alive(alive_ns));
            }
            let written = messages.drain(..).try_for_each(|message| message.write(out)).and_then(|()| out.flush());
            if written.is_err() {
                // The process that started this one has ended.
                break;
            }
            if let Some(nodes) = &mut self.own_nodes {
                nodes.announce(&self.participant.guid().to_bytes(), &mut self.readers, &mut self.writers)?;
            }
            if is_idle {
                std::thread::park_timeout(PATIENCE);
            } else if self.own_nodes.is_none() {
                sleep(GATHERING);
            }
        }
        // The last commands are still executed.
        self.execute(inbox)?;
        self.leave();
        Ok(())
    }

    /// Ends, so that a new participant takes over: rustdds would discard the messages of those that have restarted, as
    /// it has already received their sequence numbers.
    fn hand_over(self, restarted: &[[u8; 16]], out: &mut impl Write, why: String) -> Result<(), String> {
        let mut messages = restarted.iter().map(|guid| ListenerMessage::WriterRestarted(*guid));
        // If this fails, the process that started this one has ended.
        let _ = messages.try_for_each(|message| message.write(out)).and_then(|()| out.flush());
        self.leave();
        Err(why)
    }

    /// Executes the commands that have been received, and sends what had to wait.
    fn execute(&mut self, inbox: &Inbox) -> Result<(), String> {
        inbox.take_commands().into_iter().try_for_each(|command| match command {
            ListenerCommand::Publish(Publication { topic, kind, is_latched, body }) => {
                self.writers.write(names::topic(&topic), names::dds_kind(&kind), is_latched, body)
            }
            ListenerCommand::Request(request) => self.request(request),
            ListenerCommand::Serve(service, kind) => self.serve(&service, &kind),
            ListenerCommand::Respond(reply) => {
                self.services.respond(reply);
                Ok(())
            }
            ListenerCommand::Join { .. } | ListenerCommand::Subscribe(_) => Ok(()),
        })?;
        self.writers.send();
        self.send_requests();
        self.send_responses();
        Ok(())
    }

    /// Finds participants that rustdds does not receive. Returns why a new participant must take over, if one must, and
    /// which participants have restarted.
    fn read_announcements(&mut self) -> (Option<String>, Vec<[u8; 16]>) {
        let Some(announcements) = &mut self.announcements else { return (None, Vec::new()) };
        announcements.read(|of| self.readers.given_up.iter().any(|guid| prefix(guid) == *of));
        let has_returned = announcements.has_returned();
        let restarted: Vec<[u8; 16]> = announcements.take_restarted().iter().map(padded).collect();
        let why = if restarted.is_empty() {
            has_returned.then(|| "a participant that was given up goes on".to_owned())
        } else {
            Some("a participant has begun anew with the GUID of an earlier one".to_owned())
        };
        (why, restarted)
    }

    /// Leaves the domain. rustdds sends what it has left to send only while the participant exists.
    fn leave(mut self) {
        self.readers.clear();
        sleep(GRACE);
        let (options, guid) = (self.options, self.participant.guid().to_bytes());
        drop(self);
        goodbye::send(options, &guid);
    }

    /// What others offer. Also updates the clients of services that are offered here.
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
                // Reliable is the default of writers.
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
        self.services.set_readers(clients);
        Ok(Offers { writers: writers.collect(), requests, read })
    }

    /// Makes the readers fit the writers. Returns whether some are left to create.
    fn read(&mut self, writers: &[Writer], subscribed: &Subscribed) -> Result<bool, String> {
        self.readers.given_up.extend(self.peers.vanished(writers));
        self.readers.fit(writers, subscribed, self.own_nodes.as_ref().is_none_or(OwnNodes::receives_latched))
    }

    /// Takes what the readers have received, in order.
    fn take(&mut self, messages: &mut Vec<ListenerMessage>) {
        let (now_ns, system_ns) = (self.clock.now_ns(), nanoseconds(Timestamp::now()));
        let alive_ns = self.pulse.alive_ns().unwrap_or(i64::MIN);
        for taken in self.readers.take(now_ns, system_ns, alive_ns) {
            messages.extend(match taken {
                FromReader::Message(message) => Some(message),
                FromReader::Service { sample, related } => self.service_message(sample, related),
            });
        }
    }
}

/// The policy that makes a writer incompatible with every reader, if there is one.
fn unfit(writer: &PublicationBuiltinTopicData) -> Option<String> {
    // The kind of an entity: a writer of a topic with a key is incompatible with a reader of one without.
    const KIND: u8 = 0x3f;
    const WITH_KEY: u8 = 0x02;
    if writer.key.to_bytes()[15] & KIND == WITH_KEY {
        return Some("key".to_owned());
    }
    writer.qos().compliance_failure_wrt(&qos(false, false, KEPT)).map(|policy| format!("{policy:?}"))
}
