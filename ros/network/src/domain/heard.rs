//! What is heard in a DDS domain, as it is handed from the thread that listens to the one that judges.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use ros_messages::{CdrReader, Mismatch};

/// The topic on which participants say which nodes they have.
pub(super) const NODES: &str = "ros_discovery_info";

/// What is heard.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Heard {
    Sample(Sample),
    /// Which writers there are, and whose participants have been silent too long rather than said goodbye.
    Writers {
        writers: Vec<Writer>,
        requests: BTreeMap<String, String>,
        silent: BTreeSet<Prefix>,
    },
    /// Every sample received before this time, in nanoseconds since 1970, has been returned.
    Quiet(i64),
    /// Nothing more comes, and why. What comes from another participant follows.
    Died(String),
}

/// What the GUIDs of a participant's writers begin with.
pub(super) type Prefix = [u8; 12];

/// A message, as it was received.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sample {
    /// The DDS topic.
    pub(super) topic: Arc<str>,
    pub(super) writer: [u8; 16],
    /// The number that the writer gave it.
    pub(super) number: i64,
    /// When it was received and sent, in nanoseconds since 1970.
    pub(super) received_ns: i64,
    pub(super) sent_ns: Option<i64>,
    pub(super) body: Vec<u8>,
}

/// Somebody who offers messages on a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
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

/// The nodes of a participant, from its message on [`NODES`]: `rmw_dds_common/msg/ParticipantEntitiesInfo`.
pub(super) fn nodes(message: &[u8]) -> Option<(Prefix, Vec<String>)> {
    // GUIDs have 24 bytes in Humble, and 16 since Iron, under one name of the type.
    let read = |size: usize| -> Result<Option<(Prefix, Vec<String>)>, Mismatch> {
        let mut reader = CdrReader::new(message)?;
        let participant = *reader.take(size)?.first_chunk().ok_or(Mismatch::Short)?;
        let nodes = (0..reader.length(usize::MAX)?).map(|_| {
            let space = String::from_utf8_lossy(reader.string(None)?).into_owned();
            let name = String::from_utf8_lossy(reader.string(None)?).into_owned();
            for _ in ["readers", "writers"] {
                let count = reader.length(usize::MAX)?;
                reader.take(count.checked_mul(size).ok_or(Mismatch::Short)?)?;
            }
            Ok(format!("{}/{name}", space.trim_end_matches('/')))
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
            assert_eq!(nodes(&message(size)), Some(([7; 12], vec!["/robot/base".to_owned()])));
        }
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
