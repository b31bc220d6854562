//! Recordings that are still being written.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{Cursor, Write as _};
use std::path::Path;

use bags::{Bag, Error, Events, Following, Found, Ground, Mapping, Received, Source, Survey, Through};
use channels::{ChannelId, FieldKind, Shape};
use mcap::records::MessageHeader;

use crate::events::MAPPING;
use crate::messages::{ODD, TWIST, odd, twist};
use crate::reading::{lines, mapping, nothing, read_with, received, times};
use crate::writer::{Written, written};

/// Items of an array as messages.
const EACH: &str =
    "[[messages]]\ntopic = \"/odd\"\nfrom = \"a\"\nto = \"b\"\neach = \"items\"\nfields = { name = \"name\" }\n";

/// Both mapped topics from the start, so that every prefix can be compiled.
fn messages() -> Vec<Written<'static>> {
    let each = (0..40u64).map(|at| match at % 3 {
        0 => ("/odd", ODD, at * 30, odd(false, at as u32 * 30, (at % 2) as u8, &[("a", 0.5)])),
        _ => ("/cmd_vel", TWIST, at * 30, twist(at as f64)),
    });
    each.collect()
}

fn chunked(size: u64) -> mcap::WriteOptions {
    mcap::WriteOptions::new().chunk_size(Some(size))
}

fn unchunked() -> mcap::WriteOptions {
    mcap::WriteOptions::new().use_chunks(false)
}

#[test]
fn each_message_comes_once_it_has_been_written_as_a_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, cut) = (folder.path().join("growing.mcap"), folder.path().join("cut.mcap"));
    for (name, options, is_chunked) in [("plain", unchunked(), false), ("chunks", chunked(300), true)] {
        let whole = written(&messages()[..12], options);
        let mut file = File::create(&path).expect("a file");
        let mut following = Following::open(&path, ["/odd", "/cmd_vel"]).expect("a file that has been begun");
        let mut all = Vec::new();
        for (at, byte) in whole.iter().enumerate() {
            file.write_all(&[*byte]).expect("room for a byte");
            let (times_now, end) = received(&mut following);
            all.extend(times_now);
            if end == Received::Over {
                assert_eq!(all.len(), 12, "{name}: it ends with the data, and not before");
                break;
            }
            assert_eq!((end, following.lost()), (Received::Idle, &[][..]), "{name} at {at}");
            // What a reader of the file as it is finds: of a chunk also the messages before its end.
            fs::write(&cut, &whole[..=at]).expect("room for a file");
            let Ok(bag) = Bag::open(&cut) else { continue };
            let before = times(&bag).0;
            assert!(before.starts_with(&all) && (is_chunked || before.len() == all.len()), "{name} at {at}");
        }
        assert_eq!(received(&mut following), (vec![], Received::Over), "{name}");
        assert_eq!(following.survey().counts.iter().sum::<u64>(), 12, "{name}");
    }
}

#[test]
fn the_files_of_a_bag_follow_one_another_until_rosbag2_has_written_its_metadata() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("room for a file");
    let mut following = Following::open(folder.path(), ["/cmd_vel"]).expect("a folder");
    assert_eq!(received(&mut following), (vec![], Received::Idle), "there is no file yet");
    let parts = [0, 1, 2].map(|part| written(&[("/cmd_vel", TWIST, part, twist(0.0))], chunked(100)));
    write("bag_0.mcap", &parts[0]);
    assert_eq!(received(&mut following), (vec![0], Received::Idle));
    write("bag_1.mcap", b"\x89MC");
    assert_eq!(received(&mut following), (vec![], Received::Idle));
    write("bag_1.mcap", &parts[1]);
    write("bag_10.mcap", &parts[2]);
    assert_eq!(received(&mut following), (vec![1, 2], Received::Idle));
    write("metadata.yaml", b"rosbag2_bagfile_information:\n");
    assert_eq!(received(&mut following), (vec![], Received::Over));
    let unread = "metadata.yaml cannot be read, so files that it lists may be missing";
    assert_eq!(following.lost(), ["bag_2.mcap to bag_9.mcap are missing: bag_10.mcap is there", unread]);
    assert_eq!(received(&mut following.restart().expect("the same folder")), (vec![0, 1, 2], Received::Over));
}

#[test]
fn a_file_that_is_missing_at_the_end_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("room for a file");
    write("bag_1.mcap", &written(&[("/cmd_vel", TWIST, 1, twist(0.0))], chunked(100)));
    write(
        "metadata.yaml",
        b"rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.mcap\n    - bag_1.mcap\n  duration: 1\n",
    );
    let mut following = Following::open(folder.path(), ["/cmd_vel"]).expect("a folder");
    assert_eq!(received(&mut following), (vec![1], Received::Over));
    assert_eq!(following.lost(), ["bag_0.mcap is missing, although metadata.yaml lists it"]);
    fs::remove_file(folder.path().join("metadata.yaml")).expect("a file");
    let mut following = following.restart().expect("the same folder");
    assert_eq!(received(&mut following), (vec![1], Received::Idle));
    fs::remove_dir_all(folder.path()).expect("a folder");
    assert_eq!(received(&mut following), (vec![], Received::Over));
    assert_eq!(following.lost()[0], "bag_0.mcap is missing: bag_1.mcap is there");
    assert!(following.lost()[1].starts_with("cannot read"), "{:?}", following.lost());
}

#[test]
fn a_file_that_is_not_closed_or_changes_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag_0.mcap");
    let whole = written(&messages(), unchunked());
    fs::write(&path, &whole[..whole.len() / 2]).expect("room for a file");
    let mut following = Following::open(folder.path(), ["/cmd_vel"]).expect("a folder");
    assert_eq!(received(&mut following).1, Received::Idle);
    fs::write(&path, &whole[..whole.len() / 4]).expect("room for a file");
    assert_eq!(received(&mut following).1, Received::Idle, "there may be another file");
    assert!(following.lost()[0].contains("it has become shorter"), "{:?}", following.lost());
    // A damaged chunk does not end the recording.
    let mut damaged = written(&messages(), chunked(300));
    let place = damaged.windows(8).position(|bytes| bytes == 20_f64.to_le_bytes()).expect("a message in the middle");
    damaged[place] ^= 1;
    fs::write(&path, damaged).expect("room for a file");
    let mut following = Following::open(&path, ["/cmd_vel", "/odd"]).expect("a file");
    let (times, end) = received(&mut following);
    assert_eq!((end, following.lost().len()), (Received::Over, 1), "{:?}", following.lost());
    assert!(times.len() > 30 && times.len() < 40 && times.ends_with(&[1170]), "{times:?}");
}

/// Where the records of a file begin, apart from those in chunks.
fn records(bytes: &[u8]) -> BTreeSet<usize> {
    let (mut at, mut all) = (8, BTreeSet::new());
    while let Some(length) = bytes.get(at + 1..at + 9) {
        all.insert(at);
        at += 9 + u64::from_le_bytes(length.try_into().expect("eight bytes")) as usize;
    }
    all
}

#[test]
fn what_is_there_of_an_incomplete_record_is_lost_when_following_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("growing.mcap");
    for options in [unchunked(), chunked(300)] {
        let whole = written(&messages(), options);
        let records = records(&whole);
        let ends = (1..whole.len() / 2).step_by(7).chain(records.iter().copied().filter(|at| *at < whole.len() / 2));
        for end in ends {
            fs::write(&path, &whole[..end]).expect("room for a file");
            let mut following = Following::open(&path, ["/odd", "/cmd_vel"]).expect("a file that has been begun");
            assert_eq!(received(&mut following).1, Received::Idle, "{end} bytes");
            assert_eq!(following.lost(), [""; 0], "{end} bytes: more may come");
            following.end();
            let lost = following.lost();
            assert_eq!(lost.len(), usize::from(!records.contains(&end)), "{end} bytes: {lost:?}");
            let is_reported = |what: &String| what.contains("mcap breaks off ") && what.ends_with(": the rest is lost");
            assert!(lost.iter().all(is_reported), "{end} bytes: {lost:?}");
            assert_eq!(received(&mut following), (vec![], Received::Over), "{end} bytes");
        }
    }
    // If it ends while there is more to read, nothing of that is judged, and nothing is lost.
    let whole = written(&messages(), unchunked());
    fs::write(&path, &whole[..whole.len() / 2]).expect("room for a file");
    let mut following = Following::open(&path, ["/odd", "/cmd_vel"]).expect("a file that has been begun");
    assert!(matches!(following.receive(&mut Vec::new()), Received::Message(_)));
    following.end();
    assert_eq!(following.lost(), [""; 0]);
}

#[test]
fn an_incomplete_record_makes_a_gap_when_following_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, mapping) = (folder.path().join("growing.mcap"), mapping(LATER));
    let whole = written(&[1, 2, 3].map(|ms| ("/cmd_vel", TWIST, ms, twist(1.0))), unchunked());
    let third = records(&whole).into_iter().filter(|at| whole[*at] == 5).nth(2).expect("a message");
    let ended = |end: usize| {
        fs::write(&path, &whole[..end]).expect("room for a file");
        let following = Following::open(&path, mapping.topics()).expect("a file that has been begun");
        let source = Through::new(following, |source: &mut Following, body: &mut Vec<u8>| match source.receive(body) {
            Received::Idle => {
                source.end();
                Received::Over
            }
            received => received,
        });
        let compiled = mapping.compile(&Survey::default(), None, &nothing).expect("a type that is on board");
        let topology = compiled.topology.clone();
        let mut events = Events::new(Box::new(source), &mapping, compiled, &nothing);
        let lines: Vec<String> = lines(&mut events, &topology).collect();
        (lines, events.notes())
    };
    let expected =
        ["0 ms: 0, tick 0", "0 ms: 1, tick 0: base → monitor [1.0]", "1 ms: 2, tick 0: base → monitor [1.0]"];
    assert_eq!(ended(third), (expected.map(str::to_owned).to_vec(), vec![]));
    let (lines, notes) = ended(third + 40);
    let what = "breaks off 0.001 s after the first message of the bag: the rest is lost";
    assert!(notes.len() == 1 && notes[0].ends_with(what), "{notes:?}");
    assert_eq!(lines, [&[notes[0].as_str()][..], &expected].concat());
}

#[test]
fn what_follows_the_end_of_a_followed_file_is_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let kinds: [fn() -> mcap::WriteOptions; 3] =
        [unchunked, mcap::WriteOptions::new, || unchunked().emit_summary_records(false)];
    for options in kinds {
        let [first, second] = [0, 1000].map(|ms| written(&[("/cmd_vel", TWIST, ms, twist(1.0))], options()));
        for end in [&b""[..], &second[..], &second[..30], &b"x"[..]] {
            fs::write(&path, [&first[..], end].concat()).expect("room for a file");
            let mut following = Following::open(&path, ["/cmd_vel"]).expect("a file");
            assert_eq!(received(&mut following), (vec![0], Received::Over));
            let what = format!("{} goes on after its end: the last {} bytes are not read", path.display(), end.len());
            let expected: Vec<String> = (!end.is_empty()).then_some(what).into_iter().collect();
            assert_eq!(following.lost(), expected);
        }
    }
}

#[test]
fn the_checksum_of_a_followed_file_without_chunks_is_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let mut bytes = written(&[1, 2].map(|ms| ("/cmd_vel", TWIST, ms, twist(0.5))), unchunked());
    let place = bytes.windows(8).position(|bytes| bytes == 0.5_f64.to_le_bytes()).expect("a message");
    for is_damaged in [false, true] {
        bytes[place] ^= u8::from(is_damaged);
        fs::write(&path, &bytes).expect("room for a file");
        let mut following = Following::open(&path, ["/cmd_vel"]).expect("a file");
        assert_eq!(received(&mut following), (vec![1, 2], Received::Over));
        let what = format!("{}: its checksum is not that of its records", path.display());
        let expected: Vec<(usize, String)> = is_damaged.then_some((0, what)).into_iter().collect();
        assert_eq!(following.survey().missing, expected);
    }
}

#[test]
fn a_folder_that_is_finished_gets_the_checks_of_a_bag() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("room for a file");
    let part =
        |from: u64| written(&[from, from + 9].map(|ms| ("/cmd_vel", TWIST, ms, twist(1.0))), mcap::WriteOptions::new());
    write("metadata.yaml", b"relative_file_paths: [bag_0.mcap, bag_1.mcap]\n");
    write("bag_0.mcap", &part(0));
    write("bag_1.mcap", &part(0));
    let opened = || Following::open(folder.path(), ["/cmd_vel"]);
    let refused = opened().err().map(|error| error.to_string()).unwrap_or_default();
    assert!(refused.ends_with("bag_0.mcap and bag_1.mcap have the same messages"), "{refused}");
    // What plain reading reports is reported, and once.
    write("bag_1.mcap", &[&part(10)[..], b"xyz"].concat());
    write("bag_5.mcap", &part(50));
    let bag = Bag::open(folder.path()).expect("a bag");
    let mut following = opened().expect("a folder");
    assert_eq!(received(&mut following), (vec![0, 9, 10, 19], Received::Over));
    let damaged = folder.path().join("bag_1.mcap");
    let after_end = format!("{} goes on after its end: the last 3 bytes are not read", damaged.display());
    assert_eq!(following.lost(), [after_end]);
    assert_eq!(following.lost(), bag.survey().lost);
    assert_eq!(following.notes(), ["bag_5.mcap is not read: metadata.yaml does not list it"]);
    assert_eq!(following.notes(), bag.survey().notes);
}

#[test]
fn only_mcap_files_are_followed() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("room for a file");
        Following::open(&path, []).err().map(|error| (error.to_string(), error.help()))
    };
    let (why, help) = refused("bag_0.db3", b"SQLite format 3\0").expect("an error");
    assert!(why.ends_with("bag_0.db3 cannot be read while it is being written: it is not an MCAP file"), "{why}");
    assert_eq!(help, "record with `ros2 bag record --storage mcap`");
    assert!(matches!(Following::open(folder.path(), []), Err(Error::Followed(_))));
    assert!(refused("text.mcap", b"no recording").is_some());
    assert!(matches!(Following::open(&folder.path().join("none"), []), Err(Error::Read(_))));
}

/// The events of a file that is written in parts, as lines, and the notes.
fn followed(path: &Path, parts: &[&[u8]], mapping: &Mapping) -> (Vec<String>, Vec<String>) {
    fs::write(path, parts.concat()).expect("room for a file");
    let mut ahead = Following::open(path, mapping.topics()).expect("a file");
    while mapping.awaited(ahead.survey()).is_some() && matches!(ahead.receive(&mut Vec::new()), Received::Message(_)) {}
    let compiled = mapping.compile(ahead.survey(), None, &nothing);
    let compiled = compiled.unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let topology = compiled.topology.clone();
    let mut file = File::create(path).expect("a file");
    let following = ahead.restart().expect("a file that has been begun");
    let mut events = Events::new(Box::new(following), mapping, compiled, &nothing);
    let mut found = Vec::new();
    for part in parts {
        file.write_all(part).expect("room for a part");
        found.extend(lines(&mut events, &topology).take_while(|line| line != "idle"));
    }
    (found, events.notes())
}

#[test]
fn the_events_are_those_of_the_finished_bag() {
    let folder = tempfile::tempdir().expect("a folder");
    for options in [unchunked(), chunked(300), chunked(2000)] {
        let whole = written(&messages(), options);
        let (finished, growing) = (folder.path().join("finished.mcap"), folder.path().join("growing.mcap"));
        fs::write(&finished, &whole).expect("room for a file");
        let bag = Bag::open(&finished).expect("a bag");
        for size in [1, 7, 100, 1000, whole.len()] {
            let parts: Vec<&[u8]> = whole.chunks(size).collect();
            for text in [MAPPING, EACH] {
                let found = followed(&growing, &parts, &mapping(text));
                assert_eq!(found, read_with(&bag, text), "in parts of {size} bytes");
            }
        }
    }
}

/// Maps a topic that may come later.
const LATER: &str = r#"
[[messages]]
topic = "/cmd_vel"
type = "geometry_msgs/msg/Twist"
from = "base"
to = "monitor"
fields = { x = "linear.x" }
"#;

#[test]
fn a_topic_whose_type_the_mapping_names_may_come_later() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("growing.mcap");
    let mapping = mapping(LATER);
    assert_eq!(mapping.awaited(&Survey::default()), None);
    let bytes = written(&[("/cmd_vel", TWIST, 0, twist(0.5))], unchunked());
    let (lines, notes) = followed(&path, &[&bytes], &mapping);
    assert_eq!(lines, ["0 ms: 0, tick 0", "0 ms: 1, tick 0: base → monitor [0.5]"]);
    assert_eq!(notes, [""; 0]);
    // Another type, or a definition without the field, makes a gap.
    let pose = ("geometry_msgs/msg/Pose", "float64 x\n");
    let other = ("geometry_msgs/msg/Twist", "float64 x\n");
    for (kind, why) in [(pose, "the messages on /cmd_vel are of geometry_msgs/msg/Pose"), (other, "no field `linear`")]
    {
        let bytes = written(&[("/cmd_vel", kind, 0, vec![0; 12]), ("/cmd_vel", kind, 1, vec![0; 12])], unchunked());
        let (lines, notes) = followed(&path, &[&bytes], &mapping);
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].contains(why), "{lines:?}");
        assert!(notes[0].starts_with("2 messages on /cmd_vel are left out: the mapping does not fit"), "{notes:?}");
    }
    // Its messages carry what the type contains, also if none comes.
    let compiled = mapping.compile(&Survey::default(), None, &nothing).expect("a type that is on board");
    let channel = compiled.topology.find_channel("base", "monitor").expect("the mapping's channel");
    let shape = Shape::new([("x", FieldKind::Optional(Box::new(FieldKind::Real)))]);
    assert!(compiled.topology.get(channel).domain.shapes()[0].fields() == shape.fields());
    let (lines, notes) = followed(&path, &[&written(&[], unchunked())], &mapping);
    assert_eq!(lines, [""; 0]);
    assert_eq!(notes, ["there is no topic /cmd_vel, so none of its messages is judged"]);
}

#[test]
fn a_type_that_only_the_recording_defines_is_awaited() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("growing.mcap");
    let odd = format!("{EACH}type = \"odd_msgs/msg/Odd\"\n");
    let bytes = written(&messages()[..1], unchunked());
    let (lines, notes) = followed(&path, &[&bytes], &mapping(&odd));
    assert_eq!(lines, ["0 ms: 0, tick 0", "0 ms: 1, tick 0: a → b [\"a\"]"]);
    assert_eq!(notes, [""; 0]);
    let without = odd.replace("[[messages]]", "definitions = [\"share\"]\n[[messages]]");
    assert_eq!(mapping(&without).awaited(&Survey::default()), None, "a folder may define it");
}

#[test]
fn what_the_metadata_counts_is_compared_with_what_came() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("room for a file");
    write("bag_0.mcap", &written(&[("/cmd_vel", TWIST, 1, twist(0.0))], chunked(100)));
    let metadata = "relative_file_paths: [bag_0.mcap]\n- topic_metadata:\n    name: /cmd_vel\n  message_count: 2\n";
    write("metadata.yaml", metadata.as_bytes());
    let mut following = Following::open(folder.path(), ["/cmd_vel"]).expect("a folder");
    assert_eq!(received(&mut following), (vec![1], Received::Over));
    let counted = "metadata.yaml counts 2 messages on /cmd_vel, and 1 are there".to_owned();
    assert_eq!(following.survey().missing, [(0, counted)]);
    // What the file itself counts.
    let mut bytes = written(&[1, 2].map(|ms| ("/cmd_vel", TWIST, ms, twist(0.0))), unchunked());
    let message = (0..bytes.len()).rev().find(|at| bytes[*at..].starts_with(&[5, 22 + 52, 0, 0, 0, 0, 0, 0, 0]));
    bytes[message.expect("a message")] = 0x85;
    let path = folder.path().join("bag_0.mcap");
    fs::write(&path, bytes).expect("room for a file");
    let mut following = Following::open(&path, ["/cmd_vel"]).expect("a file");
    assert_eq!(received(&mut following), (vec![1], Received::Over));
    assert!(following.survey().missing[0].1.ends_with("bag_0.mcap counts 2 messages on /cmd_vel, and 1 are there"));
}

/// What vouches in the end for the messages of each channel, and the notes.
fn grounds(source: Box<dyn Source>, survey: &Survey, mapping: &Mapping) -> (BTreeMap<ChannelId, Ground>, Vec<String>) {
    let compiled = mapping.compile(survey, None, &nothing).unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let mut events = Events::new(source, mapping, compiled, &nothing);
    let vouched = events.by_ref().filter_map(|found| match found {
        Found::Vouched(channel, ground) => Some((channel, ground)),
        _ => None,
    });
    (vouched.collect(), events.notes())
}

#[test]
fn a_topic_without_messages_is_vouched_for_once_the_file_is_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, mapping) = (folder.path().join("finished.mcap"), mapping(LATER));
    let mut bytes = Cursor::new(Vec::new());
    // Its bytes will be changed.
    let options = unchunked().calculate_data_section_crc(false);
    let mut writer = options.create(&mut bytes).expect("a writer");
    let schema = writer.add_schema(TWIST.0, "ros2msg", TWIST.1.as_bytes()).expect("a schema");
    let channels = ["/other", "/cmd_vel"].map(|topic| writer.add_channel(schema, topic, "cdr", &BTreeMap::new()));
    let channel_id = *channels[0].as_ref().expect("a channel");
    let header = MessageHeader { channel_id, sequence: 0, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, &twist(0.5)).expect("room for a message");
    writer.finish().expect("room for the end");
    drop(writer);
    fs::write(&path, bytes.get_ref()).expect("room for a file");
    let bag = Bag::open(&path).expect("a bag");
    let expected = grounds(Box::new(bag.messages_on(mapping.topics())), bag.survey(), &mapping);
    assert!(matches!(expected.0.values().collect::<Vec<_>>()[..], [Ground::Assumed(_)]), "{expected:?}");
    // Some writers list such a topic only in the summary: here, its first record is of a kind that is passed over.
    let name = bytes.get_ref().windows(8).position(|text| text == b"/cmd_vel").expect("its name");
    let channel = (0..name).rposition(|at| bytes.get_ref()[at..].starts_with(b"\x04")).expect("its record");
    let mut only_in_summary = bytes.get_ref().clone();
    only_in_summary[channel] = 0x84;
    for bytes in [bytes.get_ref(), &only_in_summary] {
        fs::write(&path, bytes).expect("room for a file");
        let following = Following::open(&path, mapping.topics()).expect("a file");
        assert_eq!(grounds(Box::new(following), &Survey::default(), &mapping), expected);
    }
}
