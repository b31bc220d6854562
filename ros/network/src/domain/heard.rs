//! What is heard in a DDS domain, as it is handed from the process that listens to the one that judges, and what that
//! one asks for.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufRead, Read, Write};
use std::sync::Arc;
use std::time::Duration;

use ros_messages::{CdrReader, Mismatch};
use serde::{Deserialize, Serialize};

use super::options::Options;

/// The topic on which participants say which nodes they have.
pub(super) const NODES: &str = "ros_discovery_info";

/// How long a process that listens may take to leave its domain.
pub(super) const LEAVING: Duration = Duration::from_secs(2);

/// The largest message that is handed over, and the largest description of writers, in bytes.
const LARGEST: u32 = 1 << 26;

/// What is heard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Heard {
    Sample(Sample),
    /// A message for which there was no room.
    Dropped(Sample),
    /// A message on this topic could not be read, for this reason.
    Unreadable(Arc<str>, String),
    /// Which writers there are, and the GUIDs of those that said goodbye; those of participants end with zeros.
    Writers {
        writers: Vec<Writer>,
        requests: BTreeMap<String, String>,
        goodbyes: BTreeSet<[u8; 16]>,
    },
    /// Every sample received before this time, in nanoseconds since 1970, has been returned.
    Quiet(i64),
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
    /// It follows all else as it is.
    #[serde(skip)]
    pub(super) body: Vec<u8>,
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

/// What stands for the participant of an entity among those that said goodbye.
pub(super) fn participant(guid: &[u8; 16]) -> [u8; 16] {
    let mut participant = *guid;
    participant[12..].fill(0);
    participant
}

/// What is to be read: nothing yet, topics with these names, or all.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Subscribed {
    Nothing,
    To(BTreeSet<String>),
    All,
}

impl Subscribed {
    pub(super) fn has(&self, topic: &str) -> bool {
        match self {
            Self::Nothing => topic == NODES,
            Self::To(topics) => topic == NODES || topics.contains(topic),
            Self::All => topic == NODES || topic.starts_with("rt/"),
        }
    }
}

/// What is asked of the process that listens, as a line of JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Ask {
    /// This comes first. The clock that gives messages their times is so far ahead of the system's, in nanoseconds.
    Join {
        options: Options,
        ahead_ns: i64,
    },
    Subscribe(Subscribed),
    Publish(Publication),
}

/// A message to be published.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Publication {
    /// The topic in ROS 2, and the type in DDS.
    pub(super) topic: String,
    pub(super) kind: String,
    /// Whether who comes later receives it, too.
    pub(super) is_latched: bool,
    pub(super) body: Vec<u8>,
}

impl Ask {
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let line = serde_json::to_string(self).map_err(io::Error::other)?;
        writeln!(out, "{line}").and_then(|()| out.flush())
    }

    /// The next line; none at the end.
    pub(super) fn read(from: &mut impl BufRead) -> Option<Self> {
        let mut line = String::new();
        from.read_line(&mut line).ok().filter(|length| *length > 0)?;
        serde_json::from_str(&line).ok()
    }
}

impl Heard {
    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let head = postcard::to_stdvec(self).map_err(io::Error::other)?;
        let body: &[u8] = if let Self::Sample(sample) = self { &sample.body } else { &[] };
        for part in [head.as_slice(), body] {
            let length = u32::try_from(part.len()).ok().filter(|length| *length <= LARGEST);
            out.write_all(&length.ok_or_else(|| io::Error::other("too large"))?.to_le_bytes())?;
            out.write_all(part)?;
        }
        Ok(())
    }

    /// What comes next, and its size in bytes.
    ///
    /// # Errors
    /// At the end, and if it is nothing that can be heard.
    pub(super) fn read(from: &mut impl Read) -> io::Result<(Self, usize)> {
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
        let size = size_of::<Self>() + head.len() + body.len();
        let mut heard = postcard::from_bytes(&head).map_err(io::Error::other)?;
        if let Self::Sample(sample) = &mut heard {
            sample.body = body;
        }
        Ok((heard, size))
    }
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use ros_messages::CdrWriter;

    use super::*;

    /// A node with two writers, where GUIDs have this size.
    fn message(size: usize) -> Vec<u8> {
        let mut body = CdrWriter::reusing(Vec::new());
        let guid = |body: &mut CdrWriter| body.numbers(vec![[7]; size].into_iter());
        guid(&mut body);
        body.length(1);
        body.text("/robot");
        body.text("base");
        body.length(0);
        body.length(2);
        guid(&mut body);
        guid(&mut body);
        body.bytes()
    }

    #[test]
    fn nodes_are_read_in_both_versions_of_the_message() {
        for size in [16, 24] {
            let node = Node { name: "/robot/base".to_owned(), writers: vec![[7; 16]; 2] };
            assert_eq!(nodes(&message(size)), Some(([7; 12], vec![node])));
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
            body: vec![7; 300],
        };
        let writers = Heard::Writers { writers: vec![writer], requests: BTreeMap::new(), goodbyes: [[1; 16]].into() };
        let (all, mut bytes) = ([Heard::Sample(sample), writers, Heard::Quiet(8)], Vec::new());
        all.iter().for_each(|heard| heard.write(&mut bytes).expect("room"));
        let mut from = bytes.as_slice();
        for heard in all {
            assert_eq!(Heard::read(&mut from).expect("what was written").0, heard);
        }
        assert!(Heard::read(&mut from).is_err());
        let asks = [
            Ask::Join { options: Options { domain: 3, is_local: true }, ahead_ns: 7 },
            Ask::Subscribe(Subscribed::To(["rt/a".to_owned()].into())),
            Ask::Publish(Publication { topic: "/a".to_owned(), kind: "k".to_owned(), is_latched: true, body: vec![1] }),
        ];
        let mut lines = Vec::new();
        asks.iter().for_each(|ask| ask.write(&mut lines).expect("room"));
        let mut from = lines.as_slice();
        assert_eq!(asks.map(Some), [(); 3].map(|()| Ask::read(&mut from)));
        assert_eq!(Ask::read(&mut from), None);
    }

    proptest! {
        #[test]
        fn any_bytes_are_nodes_or_none(size in 0..90_usize, at in 0..90_usize, byte: u8) {
            let mut bytes = message(16);
            bytes.truncate(size);
            if let Some(changed) = bytes.get_mut(at) {
                *changed = byte;
            }
            let _ = nodes(&bytes);
        }
    }
}
