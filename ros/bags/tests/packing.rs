//! Compressed chunks, and messages that are compressed one by one.

use std::fs;
use std::io::Write as _;

use bags::Bag;
use mcap::records::op;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use crate::messages::{PLAIN, TWIST, plain, twist};
use crate::reading::times;
use crate::writer::{Written, bag_of, written};

/// A compression.
type Pack = fn(&[u8]) -> Vec<u8>;

fn zstd(plain: &[u8]) -> Vec<u8> {
    compress_to_vec(plain, CompressionLevel::Fastest)
}

fn lz4(plain: &[u8]) -> Vec<u8> {
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    encoder.write_all(plain).expect("there is room");
    encoder.finish().expect("there is room")
}

/// A file without a summary, in chunks of about 500 bytes that are compressed.
fn packed(messages: &[Written<'_>], compression: &str, pack: Pack) -> Vec<u8> {
    let options = mcap::WriteOptions::new().chunk_size(Some(500)).emit_summary_records(false);
    let whole = written(messages, options);
    let (mut at, mut bytes) = (mcap::MAGIC.len(), mcap::MAGIC.to_vec());
    while at < whole.len() - mcap::MAGIC.len() {
        let length = u64::from_le_bytes(whole[at + 1..at + 9].try_into().expect("eight bytes")) as usize;
        let (kind, body) = (whole[at], &whole[at + 9..at + 9 + length]);
        at += 9 + length;
        let packed = if kind == op::CHUNK {
            // Times, size and checksum remain. The name of the compression, empty so far, and the length follow.
            const NAME: usize = 8 + 8 + 8 + 4;
            let records = pack(&body[NAME + 4 + 8..]);
            let name = [&(compression.len() as u32).to_le_bytes(), compression.as_bytes()].concat();
            [&body[..NAME], &name, &(records.len() as u64).to_le_bytes(), &records].concat()
        } else {
            body.to_vec()
        };
        bytes.push(kind);
        bytes.extend((packed.len() as u64).to_le_bytes());
        bytes.extend(packed);
    }
    [bytes.as_slice(), mcap::MAGIC].concat()
}

fn twists() -> Vec<Written<'static>> {
    (0..60).map(|ms| ("/cmd_vel", TWIST, ms, twist(ms as f64))).collect()
}

const COMPRESSIONS: [(&str, Pack); 2] = [("zstd", zstd), ("lz4", lz4)];

#[test]
fn compressed_chunks_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    for (name, pack) in COMPRESSIONS {
        fs::write(&path, packed(&twists(), name, pack)).expect("room for a file");
        let bag = Bag::open(&path).expect("a bag");
        assert_eq!((&bag.survey().counts, bag.survey().span_ns), (&vec![60], Some((0, 59_000_000))), "{name}");
        let (mut messages, mut body) = (bag.messages(&[0]), Vec::new());
        for (_, _, ms, data) in twists() {
            let head = messages.next_into(&mut body).expect("a message");
            assert_eq!((head.log_ns, &body), (ms as i64 * 1_000_000, &data), "{name}");
        }
        assert_eq!((messages.next_into(&mut body), messages.lost()), (None, &[][..]), "{name}");
    }
}

#[test]
fn what_precedes_the_damage_of_a_compressed_file_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.mcap");
    for (name, pack) in COMPRESSIONS {
        let whole = packed(&twists(), name, pack);
        let mut most = 0;
        for end in (8..whole.len()).step_by(7).chain([whole.len()]) {
            fs::write(&path, &whole[..end]).expect("room for a file");
            let (times, lost) = times(&Bag::open(&path).expect("a bag"));
            assert!(times.iter().copied().eq(0..times.len() as i64), "{name}, {end} bytes: {times:?}");
            assert!(times.len() == 60 || !lost.is_empty(), "{name}, {end} bytes: the loss is not reported");
            assert!(times.len() >= most, "{name}: a longer file has more messages");
            most = times.len();
        }
        assert_eq!(most, 60, "{name}");
    }
}

#[test]
fn a_compressed_chunk_with_a_wrong_byte_is_lost_and_the_rest_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    for (name, pack) in COMPRESSIONS {
        let mut bytes = packed(&twists(), name, pack);
        // The middle of the file is in a chunk.
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0xff;
        fs::write(&path, bytes).expect("room for a file");
        let (times, lost) = times(&Bag::open(&path).expect("a bag"));
        assert!(times.len() >= 40 && times.len() < 60, "{name}: {times:?}");
        assert!(times.is_sorted() && times.last() == Some(&59), "{name}: {times:?}");
        assert!(lost.len() == 1 && lost[0].contains("contains a damaged chunk"), "{name}: {lost:?}");
    }
}

#[test]
fn an_unknown_compression_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    fs::write(&path, packed(&twists()[..1], "brotli", <[u8]>::to_vec)).expect("room for a file");
    let (times, lost) = times(&Bag::open(&path).expect("a bag"));
    let why = "(the compression `brotli` is not supported): the rest of it is lost";
    assert!(times.is_empty() && lost.len() == 1 && lost[0].ends_with(why), "{lost:?}");
}

#[test]
fn messages_that_are_compressed_one_by_one_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = plain(7, 8, &[9; 100]);
    let mut damaged = zstd(&data);
    damaged.truncate(damaged.len() / 2);
    let bag = bag_of(
        folder.path(),
        &[("/p", PLAIN, 0, zstd(&data)), ("/p", PLAIN, 1, data.clone()), ("/p", PLAIN, 2, damaged)],
    );
    let (mut messages, mut body) = (bag.messages(&[0]), Vec::new());
    for _ in 0..2 {
        messages.next_into(&mut body).expect("a message");
        assert_eq!((&body, messages.lost()), (&data, &[][..]));
    }
    messages.next_into(&mut body).expect("a message");
    assert!(
        messages.lost().concat().starts_with("a compressed message is lost: its Zstandard data is cut off or damaged"),
        "{:?}",
        messages.lost()
    );
    assert_eq!(messages.next_into(&mut body), None);
}
