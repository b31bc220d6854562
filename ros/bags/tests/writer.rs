//! Writes MCAP files.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use bags::Bag;
use mcap::records::MessageHeader;

/// A message: topic, type with definition, milliseconds when it was recorded, bytes.
pub(crate) type Written<'w> = (&'w str, (&'w str, &'w str), u64, Vec<u8>);

pub(crate) fn written(messages: &[Written<'_>], options: mcap::WriteOptions) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = options.compression(None).profile("ros2").create(&mut bytes).expect("a writer");
    let mut channels = BTreeMap::new();
    for (sequence, (topic, (kind, definition), ms, data)) in messages.iter().enumerate() {
        let channel_id = *channels.entry((topic, kind)).or_insert_with(|| {
            let schema = writer.add_schema(kind, "ros2msg", definition.as_bytes()).expect("a schema");
            writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("a channel")
        });
        let log_time = ms * 1_000_000;
        let header = MessageHeader { channel_id, sequence: sequence as u32, log_time, publish_time: log_time + 1 };
        writer.write_to_known_channel(&header, data).expect("room for a message");
    }
    writer.finish().expect("room for the end");
    drop(writer);
    bytes.into_inner()
}

pub(crate) fn bag_of(folder: &Path, messages: &[Written<'_>]) -> Bag {
    let path = folder.join("bag.mcap");
    fs::write(&path, written(messages, mcap::WriteOptions::new().chunk_size(Some(100)))).expect("room for a bag");
    Bag::open(&path).expect("a bag")
}
