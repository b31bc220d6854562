//! The nodes of participants, as messages `rmw_dds_common/msg/ParticipantEntitiesInfo` list them.

use ros_messages::{CdrReader, CdrWriter, Mismatch, RosType as _};

use super::exchange::Prefix;

/// A node of a participant, and the GUIDs of its writers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Node {
    pub(super) name: String,
    pub(super) writers: Vec<[u8; 16]>,
}

/// The participant and its nodes in a message. None if it cannot be read.
pub(super) fn decode_nodes(message: &[u8]) -> Option<(Prefix, Vec<Node>)> {
    // A GUID has 24 bytes in Humble and 16 since Iron. The name of the type is the same.
    read_nodes::<16>(message).or_else(|_| read_nodes::<24>(message)).ok()
}

fn read_nodes<const SIZE: usize>(message: &[u8]) -> Result<(Prefix, Vec<Node>), Mismatch> {
    let mut reader = CdrReader::new(message)?;
    let participant = *<[u8; SIZE]>::read(&mut reader)?.first_chunk().ok_or(Mismatch::Short)?;
    let nodes = (0..reader.length(usize::MAX)?).map(|_| {
        let (space, name) = (String::read(&mut reader)?, String::read(&mut reader)?);
        let [_readers, writers] = [Vec::<[u8; SIZE]>::read(&mut reader)?, Vec::read(&mut reader)?];
        let writers = writers.iter().filter_map(|guid| guid.first_chunk().copied()).collect();
        Ok(Node { name: format!("{}/{name}", space.trim_end_matches('/')), writers })
    });
    let nodes = nodes.collect::<Result<_, Mismatch>>()?;
    if reader.left() == 0 { Ok((participant, nodes)) } else { Err(Mismatch::Long) }
}

/// The message that lists these nodes of a participant. A reader or writer, given by its DDS topic and its GUID,
/// belongs to the node in whose namespace its topic is. If that is none, it belongs to the first node.
///
/// # Panics
/// Without a name.
pub(super) fn nodes_message(
    participant: &[u8; 16],
    names: &[String],
    readers: &[(String, [u8; 16])],
    writers: &[(String, [u8; 16])],
) -> Vec<u8> {
    let namespace = |node: &str| node.rsplit_once('/').map_or(0, |(namespace, _)| namespace.len());
    let owner = |topic: &str| {
        let name = topic.split_once('/').map_or(topic, |(_, name)| name);
        let contains = |node: &&String| {
            let namespace = node[..namespace(node)].trim_start_matches('/');
            namespace.is_empty() || name.strip_prefix(namespace).is_some_and(|rest| rest.starts_with('/'))
        };
        names.iter().filter(contains).max_by_key(|node| namespace(node)).unwrap_or(&names[0])
    };
    let of = |node: &String, all: &[(String, [u8; 16])]| -> Vec<[u8; 16]> {
        all.iter().filter(|(topic, _)| owner(topic) == node).map(|(_, guid)| *guid).collect()
    };
    let nodes = names.iter().map(|node| (node.as_str(), [of(node, readers), of(node, writers)]));
    encode_nodes::<16>(participant, &nodes.collect::<Vec<_>>())
}

/// The message that lists the nodes of a participant, each with its readers and its writers. A GUID has `SIZE` bytes.
pub(super) fn encode_nodes<const SIZE: usize>(participant: &[u8; 16], nodes: &[(&str, [Vec<[u8; 16]>; 2])]) -> Vec<u8> {
    let mut body = CdrWriter::reusing(Vec::new());
    let whole =
        |guid: &[u8; 16]| -> [u8; SIZE] { std::array::from_fn(|index| guid.get(index).copied().unwrap_or_default()) };
    whole(participant).write(&mut body);
    body.length(nodes.len());
    for (name, entities) in nodes {
        let (space, name) = name.rsplit_once('/').unwrap_or(("", name));
        body.text(if space.is_empty() { "/" } else { space });
        body.text(name);
        for guids in entities {
            guids.iter().map(whole).collect::<Vec<_>>().write(&mut body);
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
            for message in [encode_nodes::<16>(&of, &both), encode_nodes::<24>(&of, &both)] {
                let node = Node { name: name.to_owned(), writers: writers.clone() };
                let other = Node { name: "/other".to_owned(), writers: vec![] };
                assert_eq!(decode_nodes(&message), Some(([7; 12], vec![node, other])));
            }
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_nodes_or_none(size in 0..90_usize, at in 0..90_usize, byte: u8) {
            let mut bytes = encode_nodes::<16>(&[7; 16], &[("/a", [vec![], vec![[7; 16]; 2]])]);
            bytes.truncate(size);
            if let Some(changed) = bytes.get_mut(at) {
                *changed = byte;
            }
            let _ = decode_nodes(&bytes);
        }
    }
}
