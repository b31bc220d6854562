//! What the listener and the process that judges exchange: messages from the listener, and commands to it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::time::Duration;

use ros_messages::RosMessage;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::options::Options;

/// The DDS topic on which participants list their nodes.
pub(super) const NODES: &str = "ros_discovery_info";

/// How long the listener may take to leave its domain.
pub(super) const LEAVING: Duration = Duration::from_secs(2);

/// The largest message that is exchanged, and the largest description of writers, in bytes.
pub(super) const LARGEST: u32 = 1 << 26;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum ListenerMessage {
    Sample(Sample),
    /// A sample for which there was no room. It has no body.
    Dropped(Sample),
    /// A message on this topic could not be read, for this reason.
    Unreadable(Arc<str>, String),
    /// What others offer now. And the GUIDs of the participants and writers that have announced their departure: the
    /// GUID of a participant ends with zeros.
    Discovered {
        offers: Offers,
        goodbyes: BTreeSet<[u8; 16]>,
    },
    /// A message on this topic could not be published. This is reported once for each topic.
    Unsent(String),
    Response(Response),
    Request(IncomingRequest),
    /// Every sample that was received before this time, in nanoseconds since 1970, has been sent. Samples could be
    /// received until then.
    ClockAdvanced(i64),
    /// Samples could be received until this time, in nanoseconds since 1970. Some of them may not have been sent yet.
    Alive(i64),
    /// A writer has restarted with the GUID of an earlier one. A GUID that ends with zeros is that of a participant,
    /// and stands for all of its writers.
    WriterRestarted([u8; 16]),
    /// The listener has ended, for this reason. What follows comes from its replacement.
    Failed(String),
}

impl ListenerMessage {
    /// A sample, without its body if it is too large.
    pub(super) fn of(sample: Sample) -> Self {
        if sample.body.len() > LARGEST as usize {
            return Self::Dropped(Sample { body: Vec::new(), ..sample });
        }
        Self::Sample(sample)
    }
}

/// What others offer in a domain.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Offers {
    pub(super) writers: Vec<Writer>,
    /// The servers of services, by the DDS topics of their requests.
    pub(super) requests: BTreeMap<String, Vec<Server>>,
    /// The DDS topics that are published here and have a subscriber.
    pub(super) read: BTreeSet<String>,
}

/// A server of a service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Server {
    /// The GUID of its reader of requests.
    pub(super) reader: [u8; 16],
    /// The DDS type of the requests.
    pub(super) kind: String,
}

/// The beginning of all GUIDs of a participant.
pub(super) type Prefix = [u8; 12];

/// A message as it was received.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sample {
    /// The DDS topic.
    pub(super) topic: Arc<str>,
    pub(super) writer: [u8; 16],
    /// Its sequence number.
    pub(super) number: i64,
    /// When it was received and sent, in nanoseconds since 1970.
    pub(super) received_ns: i64,
    pub(super) sent_ns: Option<i64>,
    /// When one with a greater number was received, if that was earlier. Then this one had to be sent again.
    pub(super) by_ns: Option<i64>,
    /// Since when it may have waited to be received, if the process was paused.
    pub(super) stalled_ns: Option<i64>,
    /// The message with its encapsulation header. It is transferred separately, unchanged.
    #[serde(skip)]
    pub(super) body: Vec<u8>,
}

/// The response to a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Response {
    /// The number of the request.
    pub number: u64,
    /// The message, with the four bytes of its encapsulation header. Empty if no server has appeared in time.
    #[serde(skip)]
    pub body: Vec<u8>,
}

/// A request to a service that is offered here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IncomingRequest {
    /// The service, such as `/say`.
    pub service: String,
    /// The client.
    pub client: Client,
    /// The message, with the four bytes of its encapsulation header.
    #[serde(skip)]
    pub body: Vec<u8>,
}

/// The client that sent a request, and which request it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Client {
    pub(super) writer: [u8; 16],
    /// The entity and the sequence number to which the response must refer; or the header with which it must begin.
    pub(super) entity: [u8; 16],
    pub(super) number: i64,
    pub(super) header: Option<[u8; 16]>,
}

/// The response of a service that is offered here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// The service, such as `/say`.
    pub service: String,
    /// Its type, such as `std_srvs/srv/Trigger`.
    pub kind: String,
    /// The client that gets it.
    pub client: Client,
    /// The message, with the four bytes of its encapsulation header.
    #[serde(skip)]
    pub body: Vec<u8>,
}

/// A writer of messages on a topic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Writer {
    pub(super) guid: [u8; 16],
    /// The DDS topic, and the type there.
    pub(super) topic: String,
    pub(super) kind: String,
    pub(super) hash: Option<String>,
    pub(super) is_reliable: bool,
    pub(super) is_latched: bool,
    /// Which of its policies makes it incompatible with every reader, if one does.
    pub(super) unfit: Option<String>,
}

impl Writer {
    pub(super) fn participant(&self) -> Prefix {
        prefix(&self.guid)
    }
}

pub(super) fn prefix(guid: &[u8; 16]) -> Prefix {
    *guid.first_chunk().expect("a GUID is longer")
}

/// The GUID that stands for a whole participant: its prefix, followed by zeros.
pub(super) fn padded(participant: &Prefix) -> [u8; 16] {
    let mut guid = [0; 16];
    guid[..12].copy_from_slice(participant);
    guid
}

/// The same for the participant of an entity.
pub(super) fn participant(guid: &[u8; 16]) -> [u8; 16] {
    padded(&prefix(guid))
}

/// What is subscribed to: no topic yet, the DDS topics with these names and types, or all topics. A name without a type
/// stands for any type.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Subscribed {
    Nothing,
    To(BTreeMap<String, Option<String>>),
    All,
}

impl Subscribed {
    pub(super) fn has(&self, topic: &str, kind: &str) -> bool {
        let fits = |wanted: &Option<String>| wanted.as_ref().is_none_or(|wanted| wanted == kind);
        match self {
            Self::Nothing => topic == NODES,
            Self::To(topics) => topic == NODES || topics.get(topic).is_some_and(fits),
            Self::All => topic == NODES || topic.starts_with("rt/"),
        }
    }
}

/// The nodes as which a participant announces itself: at least one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct NodeNames {
    pub(super) names: Vec<String>,
    /// Whether they receive messages that were latched before they joined.
    pub(super) receives_latched: bool,
}

/// A command to the listener.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum ListenerCommand {
    /// The first command. The clock that stamps received messages is `ahead_ns` nanoseconds ahead of the system's. With
    /// a `node`, the listener announces these nodes, and forwards every sample at once.
    Join {
        options: Options,
        ahead_ns: i64,
        node: Option<NodeNames>,
    },
    Subscribe(Subscribed),
    Publish(Publication),
    Request(Request),
    /// Offer a service with this name and type.
    Serve(String, String),
    Respond(Reply),
}

/// A message to be published.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Publication {
    /// The topic, such as `/scan`.
    pub topic: String,
    /// The type, such as `sensor_msgs/msg/LaserScan`.
    pub kind: String,
    /// Whether later subscribers receive it if it is the newest on its topic.
    pub is_latched: bool,
    /// The message, with the four bytes of its encapsulation header. If it is empty, the topic is only offered.
    #[serde(skip)]
    pub body: Vec<u8>,
}

impl Publication {
    /// A message of this type.
    pub fn of<T: RosMessage>(topic: &str, is_latched: bool, message: &T) -> Self {
        Self { topic: topic.to_owned(), kind: T::name().full(), is_latched, body: message.encode() }
    }
}

/// A request to a service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The service, such as `/say`.
    pub service: String,
    /// Its type, such as `std_srvs/srv/Trigger`.
    pub kind: String,
    /// The number that its response will bear.
    pub number: u64,
    /// The message, with the four bytes of its encapsulation header. If it is empty, nothing is sent yet, but servers
    /// can already discover the client.
    #[serde(skip)]
    pub body: Vec<u8>,
}

impl ListenerCommand {
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let body: &[u8] = match self {
            Self::Publish(Publication { body, .. })
            | Self::Request(Request { body, .. })
            | Self::Respond(Reply { body, .. }) => body,
            Self::Join { .. } | Self::Subscribe(_) | Self::Serve(..) => &[],
        };
        write(self, body, out)
    }

    /// The next command. None at the end.
    pub(super) fn read(from: &mut impl Read) -> Option<Self> {
        let (mut command, read, _) = read(from).ok()?;
        if let Self::Publish(Publication { body, .. })
        | Self::Request(Request { body, .. })
        | Self::Respond(Reply { body, .. }) = &mut command
        {
            *body = read;
        }
        Some(command)
    }
}

impl ListenerMessage {
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let body: &[u8] = match self {
            Self::Sample(Sample { body, .. })
            | Self::Response(Response { body, .. })
            | Self::Request(IncomingRequest { body, .. }) => body,
            _ => &[],
        };
        write(self, body, out)
    }

    /// The next message, and its size in bytes.
    ///
    /// # Errors
    /// At the end, and if it is not a valid message.
    pub(super) fn read(from: &mut impl Read) -> io::Result<(Self, usize)> {
        let (mut message, read, size) = read(from)?;
        if let Self::Sample(Sample { body, .. })
        | Self::Response(Response { body, .. })
        | Self::Request(IncomingRequest { body, .. }) = &mut message
        {
            *body = read;
        }
        Ok((message, size_of::<Self>() + size))
    }
}

/// Writes a message or command, followed by its body unchanged.
fn write(head: &impl Serialize, body: &[u8], out: &mut impl Write) -> io::Result<()> {
    let head = postcard::to_stdvec(head).map_err(io::Error::other)?;
    for part in [head.as_slice(), body] {
        let length = u32::try_from(part.len()).ok().filter(|length| *length <= LARGEST);
        out.write_all(&length.ok_or_else(|| io::Error::other("too large"))?.to_le_bytes())?;
        out.write_all(part)?;
    }
    Ok(())
}

/// Reads a message or command and its body. The last number is the size of both in bytes.
fn read<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<(T, Vec<u8>, usize)> {
    let mut part = || {
        let mut length = [0; 4];
        from.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length);
        if length > LARGEST {
            return Err(io::Error::other("too large"));
        }
        let mut bytes = vec![0; length as usize];
        from.read_exact(&mut bytes)?;
        Ok(bytes)
    };
    let (head, body) = (part()?, part()?);
    let size = head.len() + body.len();
    Ok((postcard::from_bytes(&head).map_err(io::Error::other)?, body, size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_and_command_arrives_as_it_was_sent() {
        let writer = Writer {
            guid: [3; 16],
            topic: "rt/a".to_owned(),
            kind: "k".to_owned(),
            hash: None,
            is_reliable: true,
            is_latched: false,
            unfit: None,
        };
        let sample = Sample {
            topic: "rt/a".into(),
            writer: [3; 16],
            number: 9,
            received_ns: 5,
            sent_ns: Some(4),
            by_ns: Some(3),
            stalled_ns: Some(2),
            body: vec![7; 300],
        };
        let offers = Offers { writers: vec![writer], ..Offers::default() };
        let discovered = ListenerMessage::Discovered { offers, goodbyes: [[1; 16]].into() };
        let response = ListenerMessage::Response(Response { number: 1 << 40, body: vec![1, 2] });
        let client = Client { writer: [1; 16], entity: [2; 16], number: 3, header: Some([4; 16]) };
        let request = ListenerMessage::Request(IncomingRequest { service: "/s".to_owned(), client, body: vec![5] });
        let (sample, time) = (ListenerMessage::Sample(sample), ListenerMessage::ClockAdvanced(8));
        let (messages, mut bytes) = ([sample, discovered, response, request, time], Vec::new());
        messages.iter().for_each(|message| message.write(&mut bytes).expect("room"));
        let mut from = bytes.as_slice();
        for message in messages {
            assert_eq!(ListenerMessage::read(&mut from).expect("what was written").0, message);
        }
        assert!(ListenerMessage::read(&mut from).is_err());
        let node = NodeNames { names: vec!["/a".to_owned()], receives_latched: true };
        let commands = [
            ListenerCommand::Join { options: Options { domain: 3, is_local: true }, ahead_ns: 7, node: Some(node) },
            ListenerCommand::Subscribe(Subscribed::To([("rt/a".to_owned(), Some("k".to_owned()))].into())),
            ListenerCommand::Publish(Publication {
                topic: "/a".to_owned(),
                kind: "k".to_owned(),
                is_latched: true,
                body: vec![1],
            }),
            ListenerCommand::Request(Request {
                service: "/s".to_owned(),
                kind: "k".to_owned(),
                number: 2,
                body: vec![3],
            }),
            ListenerCommand::Serve("/s".to_owned(), "k".to_owned()),
            ListenerCommand::Respond(Reply { service: "/s".to_owned(), kind: "k".to_owned(), client, body: vec![6] }),
        ];
        let mut bytes = Vec::new();
        commands.iter().for_each(|command| command.write(&mut bytes).expect("room"));
        let mut from = bytes.as_slice();
        assert_eq!(commands.map(Some), [(); 6].map(|()| ListenerCommand::read(&mut from)));
        assert_eq!(ListenerCommand::read(&mut from), None);
    }
}
