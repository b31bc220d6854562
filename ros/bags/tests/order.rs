//! Messages are read in the order of their times, however a recording is written and divided.

use std::fs;
use std::path::Path;

use bags::Bag;
use mcap::WriteOptions;
use proptest::prelude::*;

use crate::writer::{Written, written};

const BYTES: (&str, &str) = ("p/msg/B", "uint8[] bytes\n");

/// A message at a time, with its number, and larger than it need be.
type Stamped = (u64, u32, usize);

/// Writes messages as a file of this kind.
fn write(folder: &Path, name: &str, kind: usize, messages: &[Stamped]) {
    let each = messages.iter().map(|(ms, number, size)| {
        let topic = if number % 3 == 0 { "/a" } else { "/b" };
        (topic, BYTES, *ms, [&number.to_le_bytes()[..], &vec![7; *size]].concat())
    });
    let each: Vec<Written<'_>> = each.collect();
    let none = || WriteOptions::new().compression(None);
    let options = match kind {
        #[cfg(feature = "sqlite")]
        0 => return crate::sqlite::write(&folder.join(format!("{name}.db3")), &each, true),
        1 => none().use_chunks(false),
        2 => none().use_chunks(false).emit_summary_records(false),
        3 => none().chunk_size(Some(100)),
        4 => none().chunk_size(Some(400)).emit_summary_records(false),
        5 => none().chunk_size(Some(300)).calculate_chunk_crcs(false),
        6 => none().chunk_size(Some(300)).emit_chunk_indexes(false),
        _ => none().chunk_size(Some(1 << 30)),
    };
    fs::write(folder.join(format!("{name}.mcap")), written(&each, options)).expect("room for a file");
}

/// When the messages of a bag were recorded, and their numbers.
fn read(path: &Path, topics: &[&str]) -> Vec<(u64, u32)> {
    let bag = Bag::open(path).expect("a bag");
    let (mut messages, mut body, mut found) = (bag.messages_on(topics.iter().copied()), Vec::new(), Vec::new());
    while let Some(head) = messages.next_into(&mut body) {
        found.push((head.log_ns as u64 / 1_000_000, u32::from_le_bytes(body[..4].try_into().expect("a number"))));
    }
    assert!(messages.lost().is_empty(), "{:?}", messages.lost());
    found
}

fn metadata(names: &[String]) -> String {
    let names: String = names.iter().map(|name| format!("    - {name}\n")).collect();
    format!("rosbag2_bagfile_information:\n  relative_file_paths:\n{names}  duration:\n    nanoseconds: 1\n")
}

proptest! {
    #[test]
    fn messages_come_in_the_order_of_their_times(
        times in prop::collection::vec(0_u64..40, 1..60),
        kinds in prop::collection::vec(0_usize..8, 1..5),
        files in prop::collection::vec(0_usize..4, 60),
    ) {
        let folder = tempfile::tempdir().expect("a folder");
        let mut parts = vec![Vec::new(); kinds.len()];
        for (number, ms) in times.iter().enumerate() {
            parts[files[number] % kinds.len()].push((*ms, number as u32, number % 30));
        }
        let mut names = Vec::new();
        for (number, (kind, part)) in kinds.iter().zip(&parts).enumerate() {
            let name = format!("bag_{number}");
            write(folder.path(), &name, *kind, part);
            let is_sqlite = cfg!(feature = "sqlite") && *kind == 0;
            names.push(name + if is_sqlite { ".db3" } else { ".mcap" });
        }
        fs::write(folder.path().join("metadata.yaml"), metadata(&names)).expect("room for a file");
        // Those of one time stay in the order of the files, and in that of each file.
        let mut expected: Vec<(u64, u32)> = parts.concat().iter().map(|(ms, number, _)| (*ms, *number)).collect();
        expected.sort_by_key(|(ms, _)| *ms);
        prop_assert_eq!(&read(folder.path(), &["/a", "/b"]), &expected);
        expected.retain(|(_, number)| number % 3 == 0);
        prop_assert_eq!(&read(folder.path(), &["/a"]), &expected);
    }
}

/// Each chunk has messages of the whole time: all of them together do not fit into the memory that is used.
#[test]
fn disorder_that_does_not_fit_into_memory_is_read_in_order() {
    const CHUNKS: u64 = 40;
    let folder = tempfile::tempdir().expect("a folder");
    // Each second, the chunks in another order.
    let message = |chunk: u64, second: u64| (second * 1000 + chunk * (2 * second + 1) % CHUNKS, chunk as u32, 100_000);
    let messages: Vec<Stamped> =
        (0..CHUNKS).flat_map(|chunk| (0..20).map(move |second| message(chunk, second))).collect();
    let mut expected: Vec<(u64, u32)> = messages.iter().map(|(ms, number, _)| (*ms, *number)).collect();
    expected.sort_by_key(|(ms, _)| *ms);
    for (size, summary) in [(2_000_000, true), (2_000_000, false), (1 << 30, true)] {
        let each = messages
            .iter()
            .map(|(ms, number, size)| ("/a", BYTES, *ms, [&number.to_le_bytes()[..], &vec![7; *size]].concat()));
        let each: Vec<Written<'_>> = each.collect();
        let options = WriteOptions::new().compression(None).chunk_size(Some(size)).emit_summary_records(summary);
        fs::write(folder.path().join("bag.mcap"), written(&each, options)).expect("room for a file");
        assert!(read(&folder.path().join("bag.mcap"), &["/a"]) == expected, "in chunks of {size} bytes");
    }
}
