//! A client of Foxglove's WebSocket protocol.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::{Duration, Instant};

use bags::{Account, Ground, Head, Received, Source, Survey, Topic};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::http::{HeaderValue, Uri};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{HandshakeError, Message, WebSocket};

use crate::Error;
use crate::clock::{Clock, now, sleep};
use crate::protocol::{Data, ERROR, GRAPH, NAMES, ServerMessage, subscribe, subscribe_graph};
use crate::robot::{Live, Robot, is_of_action};

/// How long one call waits for a message.
const PATIENCE: Duration = Duration::from_millis(2);

/// How often a ping is sent. A deadline that passes without a message is noticed with at most this delay.
const PING: Duration = Duration::from_millis(50);

/// How long a server may send nothing, not even the answer to a ping.
const DEAD: Duration = Duration::from_secs(5);

/// How long before the end the last ping may have been sent. If it was earlier, the server did not answer in time, or
/// this process did not read the answer: messages since that ping may be missing.
const LATE: Duration = Duration::from_secs(1);

/// How long a server may take to answer a connection.
const ANSWER: Duration = Duration::from_secs(5);

/// If this process has not read for longer than this, the arrival times of what it reads next are unknown.
const STALL_NS: i64 = 250_000_000;

const TOO_MUCH: &str = "it advertises more than 10,000 topics, or more than 64 MiB of definitions";

/// The note on what verdicts leave open, as a bridge may drop messages silently.
const AS_FORWARDED: &str =
    "as the bridge forwarded it: a bridge that is too slow drops messages, and may not report it";

/// How long a server may take to advertise its topics.
const TOPICS: Duration = Duration::from_millis(500);

/// How long a server may take to close the connection.
const GRACE: Duration = Duration::from_millis(200);

/// How long to wait before connecting again.
const RECONNECT: Duration = Duration::from_secs(1);

/// The largest message, in bytes. A larger one ends the connection, so that a server cannot exhaust the memory.
const LARGEST: usize = 1 << 26;

/// The most topics that are accepted, and the most bytes of their names and definitions.
const MOST_TOPICS: usize = 10_000;
const MOST_DEFINED: usize = 1 << 26;

/// The most losses that are described. After the first, any message may be missing anyway.
const MOST_LOST: usize = 100;

/// Part of the warning with which `foxglove_bridge` before 3.2 reports dropped messages, at most every few seconds.
const FULL: &str = "buffer limit";

/// The port of `foxglove_bridge`.
const PORT: u16 = 8765;

/// A connection to a bridge. It is a source of the messages on some topics, or on all.
///
/// The time of a message is when it was received, by a clock of this machine that never goes back. Its publish time is
/// the bridge's stamp. If this process was paused, the messages that arrived meanwhile are late. The clock advances
/// without messages only while the bridge answers pings.
///
/// A connection that breaks, or on which nothing arrives any more, is opened again. The messages of the meantime are
/// lost. While the bridge does not offer a topic, its messages are lost until the next one arrives. This includes the
/// first messages of a topic that the bridge offers later than others: it discovers a new publisher only after a while.
pub struct Bridge {
    uri: Uri,
    connection: Option<Connection>,
    clock: Clock,
    survey: Survey,
    /// The names of the wanted topics; none for all.
    wanted: Option<BTreeSet<String>>,
    /// The topics that are only shown: losses there do not matter.
    shown: BTreeSet<String>,
    /// The size of all names and definitions, in bytes.
    defined: usize,
    lost: Vec<String>,
    /// The losses and delays on single topics that have not been returned.
    missing: VecDeque<Received>,
    notes: Vec<String>,
    /// When messages began to count, in nanoseconds since 1970.
    begun_ns: i64,
    /// The indices of topics that the bridge has withdrawn.
    gone: BTreeSet<usize>,
    /// When this process last read from the connection.
    read_ns: i64,
    /// The same before this process was paused, until it has read everything that has arrived since.
    stalled_ns: Option<i64>,
    /// When to connect again.
    reconnect_at: Instant,
    name: String,
    has_advertised: bool,
    /// Whether a message has been returned.
    has_returned: bool,
    robot: Robot,
}

struct Connection {
    socket: WebSocket<TcpStream>,
    /// The topics by the numbers of their subscriptions.
    topics: BTreeMap<u32, usize>,
    /// The numbers of subscriptions by the server's channels.
    subscriptions: BTreeMap<u64, u32>,
    /// When the server last sent anything.
    received: Instant,
    /// When the last ping was sent, also in nanoseconds since 1970.
    pinged: (Instant, i64),
    is_answered: bool,
    /// Whether the server has answered a ping. Then it has advertised all topics that existed at first.
    is_settled: bool,
}

impl Bridge {
    /// Connects to a bridge, for topics with these names, or for all.
    ///
    /// # Errors
    /// If the address is wrong, or no bridge answers.
    pub fn connect(address: &str, wanted: Option<BTreeSet<String>>) -> Result<Self, Error> {
        let wrong = || Error::Address(address.to_owned());
        let uri: Uri = address.parse().map_err(|_| wrong())?;
        match (uri.scheme_str(), uri.host()) {
            (Some("ws"), Some(_)) => {}
            (Some("wss"), Some(_)) => return Err(Error::Encrypted(address.to_owned())),
            _ => return Err(wrong()),
        }
        let ground = Ground::Assumed("the bridge forwards every message that it receives".to_owned());
        let mut bridge = Self {
            uri,
            connection: None,
            clock: Clock::start(),
            survey: Survey { ground, ..Survey::default() },
            wanted,
            shown: BTreeSet::new(),
            defined: 0,
            lost: Vec::new(),
            missing: VecDeque::new(),
            notes: vec![AS_FORWARDED.to_owned()],
            begun_ns: 0,
            gone: BTreeSet::new(),
            read_ns: 0,
            stalled_ns: None,
            reconnect_at: now(),
            name: String::new(),
            has_advertised: false,
            has_returned: false,
            robot: Robot::default(),
        };
        bridge.open().map_err(|reason| Error::Silent { address: bridge.uri.to_string(), reason })?;
        bridge.begun_ns = bridge.clock.now_ns();
        Ok(bridge)
    }

    /// Connects, and waits until the bridge has advertised its topics.
    fn open(&mut self) -> Result<(), String> {
        let mut connection = Connection::open(&self.uri)?;
        (self.name, self.has_advertised) = (String::new(), false);
        // The first message of a bridge contains its name; other servers send no such message. Its topics follow.
        let begun = now();
        while self.name.is_empty() || !self.has_advertised && begun.elapsed() < TOPICS {
            match connection.socket.read() {
                Ok(message) => drop(self.handle(&message, &mut connection, &mut Vec::new())?),
                Err(error) if is_pause(&error) => {}
                Err(error) => return Err(error.to_string()),
            }
            if self.name.is_empty() && begun.elapsed() > ANSWER {
                return Err("it does not send its name".to_owned());
            }
        }
        self.connection = Some(connection);
        (self.read_ns, self.stalled_ns) = (self.clock.now_ns(), None);
        Ok(())
    }

    /// Handles a frame of the server. If it contains the message of a topic, writes its body to `body`, and returns it.
    fn handle(
        &mut self,
        message: &Message,
        connection: &mut Connection,
        body: &mut Vec<u8>,
    ) -> Result<Option<Head>, String> {
        match message {
            Message::Text(text) => {
                let message = serde_json::from_str(text.as_str());
                self.handle_text(
                    message.map_err(|error| format!("it sent a message that is not of the protocol: {error}"))?,
                    connection,
                )?;
            }
            Message::Binary(frame) => {
                let Some(Data { subscription, sent_ns, body: bytes }) = Data::of(frame) else { return Ok(None) };
                let Some(topic) = connection.topics.get(&subscription) else { return Ok(None) };
                body.clear();
                body.extend_from_slice(bytes);
                let log_ns = self.clock.now_ns();
                self.survey.count(*topic, log_ns);
                let publish_ns = i64::try_from(sent_ns).unwrap_or(i64::MAX);
                return Ok(Some(Head { topic: *topic, log_ns, publish_ns }));
            }
            Message::Close(_) => return Err("it has closed the connection".to_owned()),
            _ => {}
        }
        Ok(None)
    }

    /// Receives what is next on a connection.
    ///
    /// # Errors
    /// If the connection is broken: the reason.
    fn receive_next(&mut self, connection: &mut Connection, body: &mut Vec<u8>) -> Result<Received, String> {
        let now_ns = self.clock.now_ns();
        if now_ns.saturating_sub(self.read_ns) > STALL_NS {
            self.stalled_ns.get_or_insert(self.read_ns);
        }
        connection.ping(now_ns)?;
        let begun = now();
        // Frames without messages must not keep this function from returning in time.
        while begun.elapsed() < PATIENCE {
            let read = connection.socket.read();
            self.read_ns = self.clock.now_ns();
            let message = match read {
                Ok(message) => message,
                Err(error) if is_pause(&error) && connection.is_dead() => {
                    return Err(format!("it has sent nothing for {} s", DEAD.as_secs()));
                }
                Err(error) if is_pause(&error) => {
                    self.stalled_ns = None;
                    break;
                }
                Err(error) => return Err(error.to_string()),
            };
            connection.received = now();
            let is_answer = |payload: &[u8]| payload == connection.pinged.1.to_le_bytes();
            if matches!(&message, Message::Pong(payload) if !connection.is_answered && is_answer(payload)) {
                // Everything that the server had sent before its answer has been received.
                (connection.is_answered, connection.is_settled) = (true, true);
                return Ok(Received::ClockAdvanced(connection.pinged.1));
            }
            if let Some(head) = self.handle(&message, connection, body)? {
                let late = self.stalled_ns.map(|since_ns| Received::Late { topic: head.topic, since_ns });
                self.missing.extend(late);
                return Ok(Received::Message(head));
            }
            if let Some(lost) = self.missing.pop_front() {
                return Ok(lost);
            }
        }
        Ok(Received::Idle)
    }

    /// Handles a text message. Subscribes to the wanted channels that it advertises.
    fn handle_text(&mut self, message: ServerMessage, connection: &mut Connection) -> Result<(), String> {
        match message {
            ServerMessage::ServerInfo { name, capabilities } => {
                if self.wanted.is_none() && capabilities.iter().any(|capability| capability == GRAPH) {
                    connection.send(subscribe_graph())?;
                }
                self.name = if name.is_empty() { "a bridge without a name".to_owned() } else { name };
            }
            ServerMessage::Advertise { channels } => {
                self.has_advertised = true;
                let mut subscriptions = Vec::new();
                for channel in channels {
                    let (id, topic) = (channel.id, channel.into_topic());
                    if self.wanted.as_ref().is_none_or(|wanted| wanted.contains(&topic.name)) {
                        let topic = self.index(topic)?;
                        let is_known = connection.topics.values().any(|known| *known == topic);
                        if !self.gone.remove(&topic) && connection.is_settled && !is_known {
                            self.lose_on(topic, self.begun_ns, "offers it only now");
                        }
                        subscriptions.push((connection.subscribe(id, topic)?, id));
                    }
                }
                connection.request(&subscriptions)?;
            }
            ServerMessage::Unadvertise { channel_ids } => {
                for id in channel_ids {
                    if let Some(topic) = connection.forget(id)
                        && self.gone.insert(topic)
                    {
                        self.lose_on(topic, self.clock.now_ns(), "no longer offers it");
                    }
                }
            }
            ServerMessage::AdvertiseServices { services } => {
                services.into_iter().for_each(|service| self.robot.add_name(&service.name, Some(service.kind)));
            }
            ServerMessage::ConnectionGraphUpdate { published_topics, subscribed_topics, advertised_services } => {
                let topics = published_topics.iter().filter(|topic| is_of_action(&topic.name));
                let names =
                    topics.map(|topic| &topic.name).chain(advertised_services.iter().map(|service| &service.name));
                names.for_each(|name| self.robot.add_name(name, None));
                let publishers = published_topics.into_iter().flat_map(|topic| topic.publisher_ids);
                let subscribers = subscribed_topics.into_iter().flat_map(|topic| topic.subscriber_ids);
                let providers = advertised_services.into_iter().flat_map(|service| service.provider_ids);
                self.robot.add_nodes(publishers.chain(subscribers).chain(providers));
            }
            ServerMessage::Status { level, message } if level >= ERROR || message.contains(FULL) => {
                self.lose(format!("the bridge reports: {message}"));
            }
            ServerMessage::Status { .. } | ServerMessage::Other => {}
        }
        Ok(())
    }

    /// The index of a topic in the survey. Fails if there are too many topics or definitions.
    fn index(&mut self, topic: Topic) -> Result<usize, String> {
        let known = self.survey.topics.len();
        let text = topic.definition.as_ref().map_or(0, |definition| definition.text.len());
        let size = topic.name.len() + topic.kind.len() + text;
        let index = self.survey.add(topic);
        if index == known {
            self.defined += size;
        }
        let is_too_much = index >= MOST_TOPICS || self.defined > MOST_DEFINED;
        if is_too_much { Err(TOO_MUCH.to_owned()) } else { Ok(index) }
    }

    /// The messages of a topic since then are missing until the next one arrives, unless losses there do not matter.
    fn lose_on(&mut self, topic: usize, since_ns: i64, why: &str) {
        let name = &self.survey.topics[topic].name;
        if self.shown.contains(name) {
            return;
        }
        let (now, since) = (bags::moment(self.clock.now_ns()), bags::moment(since_ns));
        match self.notes.len() {
            ..MOST_LOST => self.notes.push(format!(
                "{name}: at {now}, the bridge {why}: what is published there after {since} is missing until it comes again"
            )),
            MOST_LOST => self.notes.push("later, the bridge withdrew and offered more topics".to_owned()),
            _ => {}
        }
        self.missing.push_back(Received::Lost { topic, count: None, since_ns });
    }

    fn lose(&mut self, what: String) {
        match self.lost.len() {
            ..MOST_LOST => self.lost.push(what),
            MOST_LOST => self.lost.push("more was lost later".to_owned()),
            _ => {}
        }
    }

    /// Connects again, if it is time. Once topics are advertised, they are subscribed to again.
    fn reconnect(&mut self) -> Option<Connection> {
        let rest = self.reconnect_at.saturating_duration_since(now());
        if !rest.is_zero() {
            sleep(rest.min(PATIENCE));
            return None;
        }
        self.reconnect_at = now() + RECONNECT;
        let opened = Connection::open(&self.uri).ok()?;
        (self.read_ns, self.stalled_ns) = (self.clock.now_ns(), None);
        Some(opened)
    }
}

impl Source for Bridge {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        if let Some(lost) = self.missing.pop_front() {
            return lost;
        }
        let Some(mut connection) = self.connection.take().or_else(|| self.reconnect()) else {
            return Received::Idle;
        };
        match self.receive_next(&mut connection, body) {
            Ok(received) => {
                self.has_returned |= matches!(received, Received::Message(_));
                self.connection = Some(connection);
                received
            }
            Err(reason) => {
                self.reconnect_at = now() + RECONNECT;
                self.gone.clear();
                let (uri, when) = (&self.uri, bags::moment(self.clock.now_ns()));
                self.lose(format!(
                    "the connection to {uri} broke at {when}: {reason}; what came until it was back is missing"
                ));
                Received::Idle
            }
        }
    }

    fn end(&mut self) {
        let Some(connection) = self.connection.take() else { return };
        if connection.pinged.0.elapsed() > LATE {
            let since = if connection.pinged.1 > 0 { connection.pinged.1 } else { self.begun_ns };
            let since = bags::moment(since);
            self.lose(format!("nothing is known of {} since {since}: what came from then on is missing", self.uri));
        }
        let mut socket = connection.socket;
        // The close handshake is a courtesy: its errors do not matter any more.
        let _ = socket.close(None).and_then(|()| Ok(socket.get_ref().set_read_timeout(Some(GRACE))?));
        let begun = now();
        while begun.elapsed() < GRACE && socket.read().is_ok() {}
    }

    fn account(&self) -> Account<'_> {
        Account { survey: &self.survey, lost: &self.lost, notes: &self.notes, counts_losses: false }
    }
}

impl Live for Bridge {
    fn name(&self) -> &str {
        &self.name
    }

    fn robot(&self) -> &Robot {
        &self.robot
    }

    fn only_show(&mut self, topics: BTreeSet<String>) {
        self.shown = topics;
    }

    fn begin(&mut self) -> Result<(), Error> {
        (self.missing, self.gone) = (VecDeque::new(), BTreeSet::new());
        self.notes.truncate(1);
        self.begun_ns = self.clock.now_ns();
        (self.read_ns, self.stalled_ns) = (self.begun_ns, None);
        if !self.has_returned {
            return Ok(());
        }
        self.end();
        (self.lost, self.has_returned) = (Vec::new(), false);
        self.open().map_err(|reason| Error::Silent { address: self.uri.to_string(), reason })
    }
}

impl Connection {
    fn open(uri: &Uri) -> Result<Self, String> {
        let host = uri.host().unwrap_or_default().trim_matches(['[', ']']);
        let addresses = (host, uri.port_u16().unwrap_or(PORT)).to_socket_addrs().map_err(in_words)?;
        let mut reason = "the host's name has no address".to_owned();
        for address in addresses {
            match TcpStream::connect_timeout(&address, ANSWER) {
                Ok(stream) => return Self::shake_hands(uri, stream),
                Err(error) => reason = in_words(error),
            }
        }
        Err(reason)
    }

    fn shake_hands(uri: &Uri, stream: TcpStream) -> Result<Self, String> {
        let prepare = || {
            stream.set_read_timeout(Some(ANSWER))?;
            stream.set_write_timeout(Some(ANSWER))?;
            stream.set_nodelay(true)
        };
        prepare().map_err(in_words)?;
        let mut request = uri.into_client_request().map_err(|error| error.to_string())?;
        request.headers_mut().insert("Sec-WebSocket-Protocol", HeaderValue::from_static(NAMES));
        let config = WebSocketConfig::default().max_message_size(Some(LARGEST)).max_frame_size(Some(LARGEST));
        let shaken = tungstenite::client::client_with_config(request, stream, Some(config));
        let (socket, _) = shaken.map_err(|error| match error {
            HandshakeError::Interrupted(_) => "it does not answer in time".to_owned(),
            HandshakeError::Failure(error) => error.to_string(),
        })?;
        socket.get_ref().set_read_timeout(Some(PATIENCE)).map_err(in_words)?;
        let (topics, subscriptions) = (BTreeMap::new(), BTreeMap::new());
        let (received, pinged) = (now(), (now(), 0));
        Ok(Self { socket, topics, subscriptions, received, pinged, is_answered: true, is_settled: false })
    }

    /// Adds the subscription of a channel. Returns its number, which its messages will bear.
    fn subscribe(&mut self, channel: u64, topic: usize) -> Result<u32, String> {
        let next = self.topics.last_key_value().map_or(0, |(last, _)| last + 1);
        let number = *self.subscriptions.entry(channel).or_insert(next);
        self.topics.insert(number, topic);
        let is_too_much = self.topics.len() > MOST_TOPICS;
        if is_too_much { Err(TOO_MUCH.to_owned()) } else { Ok(number) }
    }

    /// Forgets a channel, and returns its topic.
    fn forget(&mut self, channel: u64) -> Option<usize> {
        self.topics.remove(&self.subscriptions.remove(&channel)?)
    }

    /// Sends a ping, if one is due.
    fn ping(&mut self, now_ns: i64) -> Result<(), String> {
        if self.is_answered && self.pinged.0.elapsed() > PING {
            (self.pinged, self.is_answered) = ((now(), now_ns), false);
            let payload = now_ns.to_le_bytes().to_vec();
            return self.socket.send(Message::Ping(payload.into())).map_err(|error| error.to_string());
        }
        Ok(())
    }

    /// Whether the server has sent nothing, not even the answer to a ping, although there was time to read it.
    fn is_dead(&self) -> bool {
        !self.is_answered && self.received.max(self.pinged.0).elapsed() > DEAD
    }

    /// Requests the messages of channels.
    fn request(&mut self, subscriptions: &[(u32, u64)]) -> Result<(), String> {
        if subscriptions.is_empty() {
            return Ok(());
        }
        self.send(subscribe(subscriptions))
    }

    fn send(&mut self, text: String) -> Result<(), String> {
        self.socket.send(Message::text(text)).map_err(|error| error.to_string())
    }
}

/// Whether nothing was received within the timeout, or a signal interrupted the call.
fn is_pause(error: &tungstenite::Error) -> bool {
    let tungstenite::Error::Io(error) = error else { return false };
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

fn in_words(error: io::Error) -> String {
    match error.kind() {
        ErrorKind::ConnectionRefused => "the connection is refused".to_owned(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock => "it does not answer in time".to_owned(),
        _ => error.to_string(),
    }
}
