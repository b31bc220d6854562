//! Files whose parts contradict one another, and parts that are read without the others.

use std::fs;
use std::path::Path;

use bags::{Bag, Events, Following, Received, Source, Survey};
use mcap::WriteOptions;
use mcap::records::op;

use crate::messages::{ODD, TWIST, twist};
use crate::reading::{lines, mapping, nothing, read_with, received, times};
use crate::writer::{Written, written};

const MAPPING: &str = r#"
tick_s = 1
[[messages]]
topic = "/cmd_vel"
type = "geometry_msgs/msg/Twist"
from = "a"
to = "b"
fields = { x = "linear.x" }
"#;

/// One message each millisecond.
fn twists(count: u64) -> Vec<Written<'static>> {
    (0..count).map(|ms| ("/cmd_vel", TWIST, ms, twist(ms as f64))).collect()
}

/// Without chunks and checksums of the data.
fn plain() -> WriteOptions {
    WriteOptions::new().use_chunks(false).calculate_data_section_crc(false)
}

/// Each message in a chunk of its own.
fn chunked() -> WriteOptions {
    WriteOptions::new().chunk_size(Some(1))
}

/// Where the records of this kind begin, apart from those in chunks.
fn records(bytes: &[u8], kind: u8) -> Vec<usize> {
    let (mut at, mut all) = (mcap::MAGIC.len(), Vec::new());
    while let Some(length) = bytes.get(at + 1..at + 9) {
        all.extend((bytes[at] == kind).then_some(at));
        at += 9 + u64::from_le_bytes(length.try_into().expect("eight bytes")) as usize;
    }
    all
}

fn opened(path: &Path, bytes: &[u8]) -> Bag {
    fs::write(path, bytes).expect("room for a file");
    Bag::open(path).expect("a bag")
}

#[test]
fn a_record_that_only_has_the_kind_of_an_end_ends_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let mut bytes = written(&twists(3), plain().emit_summary_records(false));
    let second = records(&bytes, op::MESSAGE)[1];
    for kind in [op::DATA_END, op::FOOTER] {
        bytes[second] = kind;
        let odd = format!("{} has records of an unknown kind, {kind:#04x}", path.display());
        let odd = format!("{odd}, which may have been messages");
        assert_eq!(times(&opened(&path, &bytes)), (vec![0, 2], vec![odd.clone()]));
        let mut following = Following::open(&path, ["/cmd_vel"]).expect("a file");
        assert_eq!(received(&mut following), (vec![0, 2], Received::Over));
        assert_eq!(following.lost(), [odd]);
    }
}

#[test]
fn a_chunk_that_claims_to_be_endless_is_not_the_one_in_the_index() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let mut bytes = written(&twists(4), chunked());
    let second = records(&bytes, op::CHUNK)[1];
    bytes[second + 1..second + 9].fill(0xff);
    let absent = format!("{}: its index names chunks that it does not have", path.display());
    assert_eq!(times(&opened(&path, &bytes)), (vec![1, 2, 3], vec![absent]));
}

#[test]
fn a_chunk_that_is_read_as_a_stream_has_the_length_that_it_states() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let messages = [("/camera", ODD, 0, vec![7; (1 << 24) + 1]), ("/cmd_vel", TWIST, 1, twist(1.0))];
    let mut bytes = written(&messages, chunked());
    // Its times precede it.
    let at = records(&bytes, op::CHUNK)[0] + 9 + 8 + 8;
    let size = u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
    for stated in [size + 1, size - 1] {
        bytes[at..at + 8].copy_from_slice(&stated.to_le_bytes());
        let (times, lost) = times(&opened(&path, &bytes));
        assert!(times.ends_with(&[1]), "{times:?}");
        assert!(lost.len() == 1 && lost[0].contains("contains a damaged chunk"), "{lost:?}");
    }
}

#[test]
fn a_summary_with_a_wrong_checksum_or_without_schemas_is_not_used() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let mut changed = written(&twists(3), chunked());
    let name = changed.windows(8).rposition(|text| text == b"/cmd_vel").expect("its name in the summary");
    changed[name + 7] = b'm';
    for bytes in [changed, written(&twists(3), chunked().repeat_schemas(false))] {
        let bag = opened(&path, &bytes);
        let [topic] = &bag.survey().topics[..] else { panic!("{:?}", bag.survey().topics) };
        assert_eq!((topic.name.as_str(), topic.kind.as_str()), ("/cmd_vel", TWIST.0));
        assert_eq!(bag.survey().lost, [""; 0]);
        assert_eq!(times(&bag), (vec![0, 1, 2], vec![]));
    }
}

/// Writers write the schema of several channels once, with the first of them.
#[test]
fn a_topic_is_read_without_the_chunk_that_has_its_schema() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let bag = opened(&path, &written(&[("/a", TWIST, 0, twist(0.0)), ("/cmd_vel", TWIST, 1, twist(0.5))], chunked()));
    let topic = bag.survey().topics.iter().position(|topic| topic.name == "/cmd_vel").expect("a topic");
    for mut messages in [bag.messages(&[topic]), bag.messages_on(["/cmd_vel"])] {
        let mut body = Vec::new();
        let found = messages.next_into(&mut body).map(|head| (head.topic, head.log_ns));
        assert_eq!(found, Some((topic, 1_000_000)));
        assert_eq!((messages.next_into(&mut body), messages.lost()), (None, &[][..]));
    }
    assert_eq!(read_with(&bag, MAPPING).0, ["0 ms: 0, tick 0", "0 ms: 1, tick 0: a → b [0.5]"]);
}

#[test]
fn a_channel_that_is_declared_in_different_ways_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let mut bytes = written(&twists(3), plain());
    let name = bytes.windows(8).position(|text| text == b"/cmd_vel").expect("its name among the messages");
    bytes[name + 7] = b'm';
    let told = format!("{} declares a channel in different ways", path.display());
    assert_eq!(times(&opened(&path, &bytes)), (vec![0, 1, 2], vec![told.clone()]));
    let mut following = Following::open(&path, ["/cmd_vel"]).expect("a file");
    assert_eq!(received(&mut following), (vec![], Received::Over));
    assert_eq!((following.lost(), &following.survey().missing[..]), (&[told.clone()][..], &[(0, told)][..]));
}

#[test]
fn a_topic_of_which_following_finds_only_the_count_has_a_gap() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, mapping) = (folder.path().join("bag.mcap"), mapping(MAPPING));
    let mut bytes = written(&[("/a", TWIST, 0, twist(0.0)), ("/cmd_vel", TWIST, 1, twist(0.5))], plain());
    // Records that programs have for themselves are passed over.
    for kind in [op::CHANNEL, op::MESSAGE] {
        let second = records(&bytes, kind)[1];
        bytes[second] |= 0x80;
    }
    fs::write(&path, bytes).expect("room for a file");
    let following = Following::open(&path, mapping.topics()).expect("a file");
    let compiled = mapping.compile(&Survey::default(), None, &nothing).expect("a type that is on board");
    let topology = compiled.topology.clone();
    let mut events = Events::new(Box::new(following), &mapping, compiled, &nothing);
    let counted = format!("{} counts 1 messages on /cmd_vel, and 0 are there", path.display());
    assert_eq!(lines(&mut events, &topology).collect::<Vec<_>>(), [counted.as_str()]);
    assert_eq!(events.notes(), [counted]);
}

#[test]
fn what_does_not_fit_at_the_end_of_a_followed_file_may_concern_its_beginning() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    // Its summary is not used, as it lacks the channel.
    let mut bytes = written(&twists(3), plain().repeat_channels(false));
    let first = records(&bytes, op::MESSAGE)[0];
    bytes[first] |= 0x80;
    fs::write(&path, bytes).expect("room for a file");
    let mut following = Following::open(&path, ["/cmd_vel"]).expect("a file");
    assert_eq!(received(&mut following), (vec![1, 2], Received::Over));
    let counted = format!("{} counts 3 messages, and 2 are there", path.display());
    assert_eq!((following.lost(), &following.survey().missing[..]), (&[counted.clone()][..], &[(0, counted)][..]));
}

#[test]
fn a_listed_file_that_never_came_may_have_been_the_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("room for a file");
    write("bag_0.mcap", &written(&twists(1), chunked()));
    let mut following = Following::open(folder.path(), ["/cmd_vel"]).expect("a folder");
    assert_eq!(received(&mut following), (vec![0], Received::Idle));
    write("metadata.yaml", b"relative_file_paths: [a.mcap, bag_0.mcap]\n");
    assert_eq!(received(&mut following), (vec![], Received::Over));
    let missing = "a.mcap is missing, although metadata.yaml lists it".to_owned();
    assert_eq!((following.lost(), &following.survey().missing[..]), (&[missing.clone()][..], &[(0, missing)][..]));
}

#[cfg(unix)]
#[test]
fn a_followed_file_that_cannot_be_opened_again_is_reported() {
    use std::io::Write as _;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let whole = written(&twists(3), plain());
    let mut file = fs::File::create(&path).expect("a file");
    let (first, rest) = whole.split_at(whole.len() / 2);
    file.write_all(first).expect("room for a part");
    let mut following = Following::open(&path, ["/cmd_vel"]).expect("a file");
    let (mut times, end) = received(&mut following);
    assert_eq!(end, Received::Idle);
    file.write_all(rest).expect("room for the rest");
    fs::remove_file(&path).expect("a file");
    let (others, end) = received(&mut following);
    times.extend(others);
    assert_eq!((times, end), (vec![0, 1, 2], Received::Over));
    let lost = following.lost();
    assert!(lost.len() == 1 && lost[0].starts_with("cannot read "), "{lost:?}");
}

#[test]
fn a_clock_that_cannot_be_read_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let (clock, told) = (("rosgraph_msgs/msg/Clock", ""), vec![0, 1, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0]);
    let messages = [
        ("/clock", clock, 0, told),
        ("/cmd_vel", TWIST, 1, twist(0.5)),
        ("/clock", clock, 2, vec![0, 1, 0, 0]),
        ("/cmd_vel", TWIST, 3, twist(1.5)),
    ];
    let bag = opened(&folder.path().join("bag.mcap"), &written(&messages, plain()));
    let (lines, notes) = read_with(&bag, &format!("time = \"clock\"\n{MAPPING}"));
    let why = "left out: the bytes do not fit the definition: they end before their definition does; the first: \
               0.002 s after the first message of the bag";
    assert!(lines.contains(&format!("messages on /clock are {why}")), "{lines:?}");
    assert_eq!(notes, [format!("1 message on /clock is {why}")]);
}

#[test]
fn counts_that_are_too_large_to_be_added_do_not_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("bag_0.mcap"), written(&twists(1), chunked())).expect("room for a file");
    let topic = format!("- topic_metadata:\n    name: /cmd_vel\n  message_count: {}\n", u64::MAX);
    let metadata = format!("relative_file_paths: [bag_0.mcap]\n{topic}{topic}");
    fs::write(folder.path().join("metadata.yaml"), metadata).expect("room for a file");
    let bag = Bag::open(folder.path()).expect("a bag");
    let counted = format!("metadata.yaml counts {} messages on /cmd_vel, and 1 are there", u64::MAX);
    assert_eq!(bag.survey().missing, [(0, counted)]);
}

#[test]
fn what_is_wrong_with_compressed_messages_is_reported_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let damaged = [0, 1].map(|ms| ("/cmd_vel", TWIST, ms, vec![0x28, 0xb5, 0x2f, 0xfd]));
    let (times, lost) = times(&opened(&folder.path().join("bag.mcap"), &written(&damaged, plain())));
    assert_eq!(times, [0, 1]);
    assert!(lost.len() == 1 && lost[0].starts_with("a compressed message is lost: "), "{lost:?}");
}
