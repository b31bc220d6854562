//! What is heard in a DDS domain, as it is handed from the process that listens to the one that judges, and what that
//! one asks for.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::time::Duration;

use ros_messages::{CdrReader, CdrWriter, Mismatch};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::options::Options;

/// The topic on which participants say which nodes they have.
pub(super) const NODES: &str = "ros_discovery_info";

/// How long a process that listens may take to leave its domain.
pub(super) const LEAVING: Duration = Duration::from_secs(2);

/// The largest message that is handed over, and the largest description of writers, in bytes.
pub(super) const LARGEST: u32 = 1 << 26;

/// What is heard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Heard {
    Sample(Sample),
    /// A message for which there was no room.
    Dropped(Sample),
    /// A message on this topic could not be read, for this reason.
    Unreadable(Arc<str>, String),
    /// What others offer, and the GUIDs of those that said goodbye; those of participants end with zeros.
    Others {
        offers: Offers,
        goodbyes: BTreeSet<[u8; 16]>,
    },
    /// For the first time, a message on this topic could not be published.
    Unsent(String),
    Response(Response),
    Served(Served),
    /// Every sample received before this time, in nanoseconds since 1970, has been returned; and it is known that
    /// samples could be received until then.
    Quiet(i64),
    /// The same, beside what is not quiet.
    Alive(i64),
    /// A writer, or all of a participant, whose GUID ends with zeros, have begun anew with the GUIDs of earlier ones.
    Anew([u8; 16]),
    /// Nothing more comes, and why. What comes from another participant follows.
    Died(String),
}

impl Heard {
    /// A sample, if it is not too large to be handed over.
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
    /// Who takes requests, by the DDS topics.
    pub(super) requests: BTreeMap<String, Vec<Server>>,
    /// The DDS topics of what is published here that somebody reads.
    pub(super) read: BTreeSet<String>,
}

/// Somebody who takes requests.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Server {
    pub(super) reader: [u8; 16],
    /// The DDS type of the requests.
    pub(super) kind: String,
}

/// What the GUIDs of a participant's writers begin with.
pub(super) type Prefix = [u8; 12];

/// A message, as it was received.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sample {
    /// The DDS topic.
    pub(super) topic: Arc<str>,
    pub(super) writer: [u8; 16],
    /// The number that the writer gave it.
    pub(super) number: i64,
    /// When it was received and sent, in nanoseconds since 1970.
    pub(super) received_ns: i64,
    pub(super) sent_ns: Option<i64>,
    /// When one with a later number was received, if that was before it: it had to be sent again.
    pub(super) by_ns: Option<i64>,
    /// Since when it may have waited to be received, if the process stood still.
    pub(super) stalled_ns: Option<i64>,
    /// It follows all else as it is.
    #[serde(skip)]
    pub(super) body: Vec<u8>,
}

/// The response to a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Response {
    /// That of the request.
    pub number: u64,
    /// The message, with the four bytes that say how it is encoded. Without any, nobody has come who could answer.
    #[serde(skip)]
    pub body: Vec<u8>,
}

/// A request to a service that is offered here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Served {
    /// The service, such as `/say`.
    pub service: String,
    /// Who asks.
    pub client: Client,
    /// The message, with the four bytes that say how it is encoded.
    #[serde(skip)]
    pub body: Vec<u8>,
}

/// Who has asked a service, and with which request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Client {
    pub(super) writer: [u8; 16],
    /// The entity and the number to which a response refers, or the header with which it begins.
    pub(super) asker: [u8; 16],
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
    /// Who has asked.
    pub client: Client,
    /// The message, with the four bytes that say how it is encoded.
    #[serde(skip)]
    pub body: Vec<u8>,
}

/// Somebody who offers messages on a topic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Writer {
    pub(super) guid: [u8; 16],
    /// The DDS topic, and the type there.
    pub(super) topic: String,
    pub(super) kind: String,
    pub(super) hash: Option<String>,
    pub(super) is_reliable: bool,
    pub(super) is_latched: bool,
    /// Why no message of it can be received, if none can.
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

/// What stands for a participant among those that said goodbye.
pub(super) fn whole(participant: &Prefix) -> [u8; 16] {
    let mut whole = [0; 16];
    whole[..12].copy_from_slice(participant);
    whole
}

/// The same for the participant of an entity.
pub(super) fn participant(guid: &[u8; 16]) -> [u8; 16] {
    whole(&prefix(guid))
}

/// What is to be read: nothing yet, topics with these names and, where that is given, these types, or all.
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

/// How a participant is known to others: as at least one node.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct NodeNames {
    pub(super) names: Vec<String>,
    /// Whether what was latched before it came is for it, too.
    pub(super) hears_latched: bool,
}

/// What is asked of the process that listens.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Ask {
    /// This comes first. The clock that gives messages their times is so far ahead of the system's, in nanoseconds. It
    /// may be nodes, with these names: then it says so, and hands on what it hears at once.
    Join {
        options: Options,
        ahead_ns: i64,
        node: Option<NodeNames>,
    },
    Subscribe(Subscribed),
    Publish(Publication),
    Request(Request),
    /// Offers a service with this name and type.
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
    /// Whether who comes later receives it, too, if it is the last one.
    pub is_latched: bool,
    /// The message, with the four bytes that say how it is encoded. Without any, the topic is only offered.
    #[serde(skip)]
    pub body: Vec<u8>,
}

/// A request to a service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The service, such as `/say`.
    pub service: String,
    /// Its type, such as `std_srvs/srv/Trigger`.
    pub kind: String,
    /// What the response refers to.
    pub number: u64,
    /// The message, with the four bytes that say how it is encoded. Without any, nothing is asked yet: the server may
    /// find out who will ask.
    #[serde(skip)]
    pub body: Vec<u8>,
}

impl Ask {
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let body: &[u8] = match self {
            Self::Publish(Publication { body, .. })
            | Self::Request(Request { body, .. })
            | Self::Respond(Reply { body, .. }) => body,
            Self::Join { .. } | Self::Subscribe(_) | Self::Serve(..) => &[],
        };
        write(self, body, out)
    }

    /// What is asked next; none at the end.
    pub(super) fn read(from: &mut impl Read) -> Option<Self> {
        let (mut ask, read, _) = read(from).ok()?;
        if let Self::Publish(Publication { body, .. })
        | Self::Request(Request { body, .. })
        | Self::Respond(Reply { body, .. }) = &mut ask
        {
            *body = read;
        }
        Some(ask)
    }
}

impl Heard {
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let body: &[u8] = match self {
            Self::Sample(Sample { body, .. })
            | Self::Response(Response { body, .. })
            | Self::Served(Served { body, .. }) => body,
            _ => &[],
        };
        write(self, body, out)
    }

    /// What comes next, and its size in bytes.
    ///
    /// # Errors
    /// At the end, and if it is nothing that can be heard.
    pub(super) fn read(from: &mut impl Read) -> io::Result<(Self, usize)> {
        let (mut heard, read, size) = read(from)?;
        if let Self::Sample(Sample { body, .. })
        | Self::Response(Response { body, .. })
        | Self::Served(Served { body, .. }) = &mut heard
        {
            *body = read;
        }
        Ok((heard, size_of::<Self>() + size))
    }
}

/// Hands something over to another process, with a message that follows it as it is.
fn write(head: &impl Serialize, body: &[u8], out: &mut impl Write) -> io::Result<()> {
    let head = postcard::to_stdvec(head).map_err(io::Error::other)?;
    for part in [head.as_slice(), body] {
        let length = u32::try_from(part.len()).ok().filter(|length| *length <= LARGEST);
        out.write_all(&length.ok_or_else(|| io::Error::other("too large"))?.to_le_bytes())?;
        out.write_all(part)?;
    }
    Ok(())
}

/// What was handed over, the message that followed it, and the size of both in bytes.
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

/// A node of a participant, and the GUIDs of its writers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Node {
    pub(super) name: String,
    pub(super) writers: Vec<[u8; 16]>,
}

/// The nodes of a participant, from its message on [`NODES`]: `rmw_dds_common/msg/ParticipantEntitiesInfo`.
pub(super) fn nodes(message: &[u8]) -> Option<(Prefix, Vec<Node>)> {
    // GUIDs have 24 bytes in Humble, and 16 since Iron, under one name of the type.
    let read = |size: usize| -> Result<Option<(Prefix, Vec<Node>)>, Mismatch> {
        let mut reader = CdrReader::new(message)?;
        let participant = *reader.take(size)?.first_chunk().ok_or(Mismatch::Short)?;
        let nodes = (0..reader.length(usize::MAX)?).map(|_| {
            let space = String::from_utf8_lossy(reader.string(None)?).into_owned();
            let name = String::from_utf8_lossy(reader.string(None)?).into_owned();
            let mut all = || {
                let count = reader.length(usize::MAX)?;
                reader.take(count.checked_mul(size).ok_or(Mismatch::Short)?)
            };
            let (_readers, writers) = (all()?, all()?);
            let writers = writers.chunks_exact(size).filter_map(|guid| guid.first_chunk().copied()).collect();
            Ok(Node { name: format!("{}/{name}", space.trim_end_matches('/')), writers })
        });
        let nodes = nodes.collect::<Result<_, Mismatch>>()?;
        Ok((reader.left() == 0).then_some((participant, nodes)))
    };
    [16, 24].into_iter().find_map(|size| read(size).ok().flatten())
}

/// The message that says which nodes a participant has, each with its readers and its writers. GUIDs have `SIZE` bytes.
pub(super) fn introduction<const SIZE: usize>(participant: &[u8; 16], nodes: &[(&str, [Vec<[u8; 16]>; 2])]) -> Vec<u8> {
    let mut body = CdrWriter::reusing(Vec::new());
    let write = |guid: &[u8; 16], body: &mut CdrWriter| {
        body.numbers((0..SIZE).map(|index| [guid.get(index).copied().unwrap_or_default()]));
    };
    write(participant, &mut body);
    body.length(nodes.len());
    for (name, entities) in nodes {
        let (space, name) = name.rsplit_once('/').unwrap_or(("", name));
        body.text(if space.is_empty() { "/" } else { space });
        body.text(name);
        for guids in entities {
            body.length(guids.len());
            guids.iter().for_each(|guid| write(guid, &mut body));
        }
    }
    body.bytes()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn nodes_are_read_in_both_versions_of_the_message() {
        let (of, writers) = ([7; 16], vec![[8; 16], [9; 16]]);
        for name in ["/robot/base", "/base"] {
            let both = [(name, [vec![of], writers.clone()]), ("/other", [vec![], vec![]])];
            for message in [introduction::<16>(&of, &both), introduction::<24>(&of, &both)] {
                let node = Node { name: name.to_owned(), writers: writers.clone() };
                let other = Node { name: "/other".to_owned(), writers: vec![] };
                assert_eq!(nodes(&message), Some(([7; 12], vec![node, other])));
            }
        }
    }

    #[test]
    fn what_is_handed_over_arrives() {
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
        let writers = Heard::Others { offers, goodbyes: [[1; 16]].into() };
        let response = Heard::Response(Response { number: 1 << 40, body: vec![1, 2] });
        let client = Client { writer: [1; 16], asker: [2; 16], number: 3, header: Some([4; 16]) };
        let served = Heard::Served(Served { service: "/s".to_owned(), client, body: vec![5] });
        let (all, mut bytes) = ([Heard::Sample(sample), writers, response, served, Heard::Quiet(8)], Vec::new());
        all.iter().for_each(|heard| heard.write(&mut bytes).expect("room"));
        let mut from = bytes.as_slice();
        for heard in all {
            assert_eq!(Heard::read(&mut from).expect("what was written").0, heard);
        }
        assert!(Heard::read(&mut from).is_err());
        let node = NodeNames { names: vec!["/a".to_owned()], hears_latched: true };
        let asks = [
            Ask::Join { options: Options { domain: 3, is_local: true }, ahead_ns: 7, node: Some(node) },
            Ask::Subscribe(Subscribed::To([("rt/a".to_owned(), Some("k".to_owned()))].into())),
            Ask::Publish(Publication { topic: "/a".to_owned(), kind: "k".to_owned(), is_latched: true, body: vec![1] }),
            Ask::Request(Request { service: "/s".to_owned(), kind: "k".to_owned(), number: 2, body: vec![3] }),
            Ask::Serve("/s".to_owned(), "k".to_owned()),
            Ask::Respond(Reply { service: "/s".to_owned(), kind: "k".to_owned(), client, body: vec![6] }),
        ];
        let mut lines = Vec::new();
        asks.iter().for_each(|ask| ask.write(&mut lines).expect("room"));
        let mut from = lines.as_slice();
        assert_eq!(asks.map(Some), [(); 6].map(|()| Ask::read(&mut from)));
        assert_eq!(Ask::read(&mut from), None);
    }

    proptest! {
        #[test]
        fn any_bytes_are_nodes_or_none(size in 0..90_usize, at in 0..90_usize, byte: u8) {
            let mut bytes = introduction::<16>(&[7; 16], &[("/a", [vec![], vec![[7; 16]; 2]])]);
            bytes.truncate(size);
            if let Some(changed) = bytes.get_mut(at) {
                *changed = byte;
            }
            let _ = nodes(&bytes);
        }
    }
}
