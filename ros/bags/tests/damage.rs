//! Files that are damaged, incomplete, or no bags.

use std::fs;
use std::path::PathBuf;

use bags::{Bag, Contents, Definitions, Error, Survey, is_bag};

use crate::messages::{ODD, TWIST, twist};
use crate::reading::{nothing, read_with, times};
use crate::writer::{Written, written};

#[test]
fn everything_before_the_point_where_a_file_is_cut_off_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let messages: Vec<Written<'_>> = (0..12).map(|ms| ("/cmd_vel", TWIST, ms, twist(1.0))).collect();
    for options in [
        mcap::WriteOptions::new().chunk_size(Some(200)),
        mcap::WriteOptions::new().use_chunks(false),
        mcap::WriteOptions::new().chunk_size(Some(200)).emit_summary_records(false),
    ] {
        let whole = written(&messages, options);
        let path = folder.path().join("cut.mcap");
        let mut most = 0;
        for end in (0..whole.len()).step_by(5).chain([whole.len()]) {
            fs::write(&path, &whole[..end]).expect("room for a file");
            let Ok(bag) = Bag::open(&path) else {
                assert!(end < 8, "{end} bytes");
                continue;
            };
            let all: Vec<usize> = (0..bag.survey().topics.len()).collect();
            let (mut reader, mut body, mut count) = (bag.messages(&all), Vec::new(), 0);
            while let Some(head) = reader.next_into(&mut body) {
                assert_eq!((head.log_ns, body.len()), (count * 1_000_000, 52));
                count += 1;
            }
            assert!(count >= most, "a longer file has more messages");
            assert!(count == 12 || !reader.lost().is_empty(), "{end} bytes");
            most = count;
        }
        assert_eq!(most, 12);
    }
}

#[test]
fn a_chunk_with_a_wrong_checksum_is_lost_and_the_rest_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    // The second chunk does not fit into memory as a whole.
    for size in [10, (1 << 24) + 1] {
        let messages = [("/camera", ODD, 0, vec![7; size]), ("/cmd_vel", TWIST, 1, twist(1.0))];
        let mut bytes = written(&messages, mcap::WriteOptions::new().chunk_size(Some(1)));
        let read = |bytes: &[u8]| {
            fs::write(&path, bytes).expect("room for a file");
            let (times, lost) = times(&Bag::open(&path).expect("a bag"));
            (times, lost.concat())
        };
        assert_eq!(read(&bytes), (vec![0, 1], String::new()));
        let at = bytes.windows(8).position(|bytes| bytes == [7; 8]).expect("the message");
        bytes[at] ^= 1;
        let (times, lost) = read(&bytes);
        let why = "contains a damaged chunk before its first message (its checksum is not that of its messages): the rest of it \
                    is lost";
        assert!(times == [1] && lost.ends_with(why), "{times:?}: {lost}");
    }
}

#[test]
fn only_the_files_that_the_metadata_lists_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = |name: &str, ms| {
        let bytes = written(&[("/cmd_vel", TWIST, ms, twist(1.0))], mcap::WriteOptions::new());
        fs::write(folder.path().join(name), bytes).expect("room for a file");
    };
    part("bag_10.mcap", 10);
    part("bag_9.mcap", 9);
    let found = || {
        let bag = Bag::open(folder.path()).expect("a bag");
        let contents =
            Contents::of(bag.survey(), &Definitions { survey: &Survey::default(), folders: &[], read: &nothing });
        (times(&bag).0, contents.lost, contents.notes)
    };
    let before = "bag_0.mcap to bag_8.mcap are missing: bag_9.mcap is there".to_owned();
    let unlisted = "bag_9.mcap and bag_10.mcap are read as one recording: no metadata.yaml lists its files, so a later \
                    one may be missing";
    assert_eq!(found(), (vec![9, 10], vec![before], vec![unlisted.to_owned()]));
    let missing = "bag_11.mcap is missing, although metadata.yaml lists it".to_owned();
    let other = "bag_9.mcap is not read: metadata.yaml does not list it".to_owned();
    for metadata in [
        "info:\n  relative_file_paths:\n    - bag_10.mcap\n    - \"bag_11.mcap\"\n  duration: 1\n",
        "relative_file_paths: [drive/bag_10.mcap,\n  'bag_11.mcap.zstd']\n",
    ] {
        fs::write(folder.path().join("metadata.yaml"), metadata).expect("room for a file");
        assert_eq!(found(), (vec![10], vec![missing.clone()], vec![other.clone()]));
    }
    fs::write(folder.path().join("metadata.yaml"), "relative_file_paths:\n- bag_1.mcap\nduration: 1\n")
        .expect("room for a file");
    let error = Bag::open(folder.path()).expect_err("no listed file is there");
    let text = format!("{error}: {}", error.help()).replace(&*folder.path().to_string_lossy(), "…");
    let expected = "… has no bag_1.mcap, which its metadata.yaml lists; bag_9.mcap is there: name the file: …/bag_9.mcap; \
                    or correct the list";
    assert_eq!(text, expected);
}

#[test]
fn files_that_are_not_one_recording_are_refused() {
    let opened = |parts: &[(&str, [u64; 2], (&str, &str))]| {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, times, kind) in parts {
            let messages = times.map(|ms| ("/cmd_vel", *kind, ms, twist(1.0)));
            fs::write(folder.path().join(name), written(&messages, mcap::WriteOptions::new()))
                .expect("room for a file");
        }
        match Bag::open(folder.path()) {
            Ok(bag) => (bag.survey().lost.join("; "), bag.survey().notes.join("; ")),
            Err(error) => {
                assert!(error.help().starts_with("name the file: "), "{}", error.help());
                (error.to_string().replace(&*folder.path().to_string_lossy(), "…"), "refused".to_owned())
            }
        }
    };
    let refused = |why: &str| (format!("… contains more than one recording: {why}"), "refused".to_owned());
    let nothing = || (String::new(), String::new());
    assert_eq!(opened(&[("bag_0.mcap", [0, 9], TWIST)]), nothing());
    // It is unknown how many files there are.
    let unlisted = |files: &str| {
        format!("{files} are read as one recording: no metadata.yaml lists its files, so a later one may be missing")
    };
    let two = [("bag_0.mcap", [0, 9], TWIST), ("bag_1.mcap", [8, 20], TWIST)];
    assert_eq!(opened(&two), (String::new(), unlisted("bag_0.mcap and bag_1.mcap")));
    let three = [two[0], two[1], ("bag_2.mcap", [21, 30], TWIST)];
    assert_eq!(opened(&three), (String::new(), unlisted("bag_0.mcap to bag_2.mcap")));
    let skipped = "bag_1.mcap is missing: bag_2.mcap is there".to_owned();
    let gap = [("bag_0.mcap", [0, 9], TWIST), ("bag_2.mcap", [20, 30], TWIST)];
    assert_eq!(opened(&gap), (skipped, unlisted("bag_0.mcap and bag_2.mcap")));
    let copy = [("bag_0.mcap", [0, 9], TWIST), ("bag_1.mcap", [0, 9], TWIST)];
    assert_eq!(opened(&copy), refused("bag_0.mcap and bag_1.mcap have the same messages"));
    let listed = tempfile::tempdir().expect("a folder");
    for (name, times, kind) in copy {
        let messages = times.map(|ms| ("/cmd_vel", kind, ms, twist(1.0)));
        fs::write(listed.path().join(name), written(&messages, mcap::WriteOptions::new())).expect("room for a file");
    }
    let metadata = "relative_file_paths: [bag_0.mcap, bag_1.mcap]\nmessage_count: 4\n";
    fs::write(listed.path().join("metadata.yaml"), metadata).expect("room for a file");
    let error = Bag::open(listed.path()).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(error.ends_with("bag_0.mcap and bag_1.mcap have the same messages"), "{error}");
    let beside = [("a.mcap", [0, 9], TWIST), ("b.mcap", [1, 8], TWIST)];
    assert_eq!(opened(&beside), refused("a.mcap and b.mcap have messages of the same time"));
    let types = [("a.mcap", [0, 9], TWIST), ("b.mcap", [10, 20], ODD)];
    assert_eq!(opened(&types), refused("a.mcap and b.mcap have other types on the same topic"));
    let one = "a.mcap and b.mcap are read as one recording: no metadata.yaml lists its files".to_owned();
    assert_eq!(opened(&[("a.mcap", [0, 9], TWIST), ("b.mcap", [10, 20], TWIST)]), (String::new(), one));
    // A copy in the other format has the ending of it, whatever is in it.
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in [("bag_0.mcap", b"\x89MCAP0\r\n".as_slice()), ("bag_0.db3", b"SQLite format 3\0")] {
        fs::write(folder.path().join(name), bytes).expect("room for a file");
    }
    let error = Bag::open(folder.path()).expect_err("a copy").to_string();
    assert!(error.ends_with("bag_0.db3 and bag_0.mcap have different formats"), "{error}");
}

#[test]
fn what_is_no_bag_is_refused_with_advice() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("room for a file");
        let error = Bag::open(&path).expect_err("no bag");
        format!("{error}: {}", error.help()).replace(&*folder.path().to_string_lossy(), "…")
    };
    assert_eq!(refused("a.mcap", b""), "…/a.mcap is empty: the recorder was stopped before it wrote anything");
    let help = "a bag is a file `.mcap` or `.db3` that rosbag2 wrote, or the folder that contains them";
    assert_eq!(refused("b.mcap", b"not MCAP"), format!("…/b.mcap is not a bag: {help}"));
    assert_eq!(refused("c.txt", b"text"), format!("…/c.txt is not a bag: {help}"));
    let convert = "convert it: `rosbags-convert --src …/d.bag --dst …/d --dst-storage mcap`";
    let ros_1 = "…/d.bag is a bag of ROS 1, which cannot be read";
    assert_eq!(refused("d.bag", b"#ROSBAG V2.0\n"), format!("{ros_1}: {convert}"));
    let error = Bag::open(&PathBuf::from("there is none.mcap")).expect_err("no bag");
    assert_eq!(error.to_string(), "cannot read there is none.mcap: No such file or directory (os error 2)");
    fs::write(folder.path().join("d.mcap.zstd"), b"").expect("room for a file");
    assert!(matches!(Bag::open(folder.path()), Err(Error::Packed(_))));
}

#[test]
fn the_damaged_part_of_a_folder_is_read_up_to_the_damage() {
    let folder = tempfile::tempdir().expect("a folder");
    let messages = |from: u64| (from..from + 20).map(|ms| ("/cmd_vel", TWIST, ms, twist(1.0))).collect::<Vec<_>>();
    let options = || mcap::WriteOptions::new().chunk_size(Some(200));
    let damaged = written(&messages(0), options());
    fs::write(folder.path().join("bag_0.mcap"), &damaged[..damaged.len() / 2]).expect("room for a file");
    fs::write(folder.path().join("bag_1.mcap"), written(&messages(20), options())).expect("room for a file");
    let (times, lost) = times(&Bag::open(folder.path()).expect("a bag"));
    let before = times.iter().position(|ms| *ms == 20).expect("the whole part follows");
    assert!((1..20).contains(&before), "{before} messages precede the damage");
    assert!(times[..before].iter().copied().eq(0..before as i64) && times[before..].iter().copied().eq(20..40));
    assert!(lost.len() == 1 && lost[0].contains("bag_0.mcap breaks off 0.0"), "{lost:?}");
    assert!(lost[0].ends_with("s after the first message of the bag: the rest is lost"), "{lost:?}");
}

#[test]
fn folders_and_files_of_either_format_are_bags() {
    let folder = tempfile::tempdir().expect("a folder");
    let is_bag = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("room for a file");
        is_bag(&path)
    };
    // The name or the first bytes decide.
    assert!(is_bag("a.mcap", b"") && is_bag("b.db3", b"") && is_bag("c", b"\x89MCAP0\r\n"));
    assert!(is_bag("d", b"SQLite format 3\0") && !is_bag("e.jsonl", b"{}\n"));
    assert!(bags::is_bag(folder.path()) && !bags::is_bag(&folder.path().join("there is none.mcap")));
}

#[cfg(not(feature = "sqlite"))]
#[test]
fn without_sqlite_its_files_are_refused_with_advice() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("old.db3");
    fs::write(&path, b"SQLite format 3\0").expect("room for a file");
    let error = Bag::open(&path).expect_err("it cannot be read");
    assert!(error.to_string().ends_with("old.db3 is an SQLite file, which this build cannot read"), "{error}");
    assert!(error.help().contains("feature `sqlite`") && error.help().contains("rosbags-convert"), "{}", error.help());
}

/// Twelve messages, and where the record of each begins and ends in a file.
fn numbered(options: mcap::WriteOptions) -> (Vec<u8>, Vec<std::ops::Range<usize>>) {
    let messages: Vec<Written<'_>> = (0..12).map(|ms| ("/cmd_vel", TWIST, ms, twist(ms as f64))).collect();
    let bytes = written(&messages, options);
    let begins = |at: &usize| bytes[*at] == 5 && bytes[at + 1..].starts_with(&(22_u64 + 52).to_le_bytes());
    let records: Vec<_> = (8..bytes.len() - 100).filter(begins).map(|at| at..at + 9 + 22 + 52).collect();
    assert_eq!(records.len(), 12);
    (bytes, records)
}

/// What is lost of a bag, anywhere and on single topics, when it has been read.
fn all_lost(path: &std::path::Path) -> Vec<String> {
    let bag = match Bag::open(path) {
        Ok(bag) => bag,
        Err(error) => return vec![error.to_string()],
    };
    let (mut messages, mut body) = (bag.messages_on(["/cmd_vel"]), Vec::new());
    while messages.next_into(&mut body).is_some() {}
    let survey = bags::Source::survey(&messages);
    let missing = survey.missing.iter().map(|(_, what)| what);
    let all = survey.lost.iter().chain(messages.lost()).chain(missing);
    all.map(|what| what.replace(&*path.to_string_lossy(), "…")).collect()
}

#[test]
fn messages_that_a_file_counts_and_does_not_have_are_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let lost = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("room for a file");
        all_lost(&path)
    };
    let plain = || mcap::WriteOptions::new().use_chunks(false).calculate_data_section_crc(false);
    let (whole, records) = numbered(plain());
    assert_eq!(lost(&whole), [""; 0]);
    let counted = "… counts 12 messages on /cmd_vel, and 11 are there";
    let with = |at: usize, byte: u8| {
        let mut bytes = whole.clone();
        bytes[records[6].start + at] = byte;
        bytes
    };
    // A record that a program has for itself, one that MCAP does not define, one that does not belong there, and a
    // message of a channel that nothing declares.
    assert_eq!(lost(&with(0, 0x85)), [counted]);
    let odd = "… has records of an unknown kind, 0x42, which may have been messages";
    assert_eq!(lost(&with(0, 0x42)), [odd, counted]);
    assert_eq!(lost(&with(0, 0x0b)), [&odd.replace("42", "0b"), counted]);
    assert_eq!(lost(&with(9, 77)), ["… has messages of a channel that it does not declare", counted]);
    let mut hole = whole.clone();
    hole[records[6].clone()].fill(0);
    assert!(lost(&hole)[0].contains("(there are zeros in place of records): the rest is lost"), "{:?}", lost(&hole));
    // Without a summary of where messages are, it counts them, or the chunks do.
    let mut cut = whole.clone();
    cut.drain(records[6].clone());
    assert_eq!(lost(&cut), ["… counts 12 messages, and 11 are there"]);
    let chunked = || mcap::WriteOptions::new().chunk_size(Some(200)).calculate_chunk_crcs(false);
    for (options, expected) in [
        (chunked().emit_statistics(false), "… has a chunk whose index counts 3 messages, and 2 are there"),
        (chunked(), counted),
    ] {
        let (mut bytes, records) = numbered(options.calculate_data_section_crc(false));
        bytes[records[6].start] = 0x85;
        assert_eq!(lost(&bytes), [expected]);
    }
    let mut cut = numbered(plain().emit_statistics(false)).0;
    cut.drain(records[6].clone());
    assert_eq!(lost(&cut), ["… is not as long as it was when it was written"]);
    // A chunk that is cut out, with the indexes after it.
    for statistics in [true, false] {
        let (mut bytes, records) = numbered(chunked().emit_statistics(statistics));
        let chunk_of = |record: usize| {
            (0..records[record].start).rev().find(|at| bytes[*at] == 6 && bytes[at + 3..at + 9] == [0; 6])
        };
        let [first, next] = [4, 8].map(|record| chunk_of(record).expect("a chunk"));
        assert!(first < next);
        bytes.drain(first..next);
        let lost = lost(&bytes);
        assert!(!lost.is_empty(), "with statistics: {statistics}");
    }
}

#[test]
fn what_is_missing_from_a_topic_makes_a_gap_in_its_channel() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let (mut bytes, records) = numbered(mcap::WriteOptions::new().use_chunks(false).calculate_data_section_crc(false));
    bytes[records[6].start] = 0x85;
    fs::write(&path, bytes).expect("room for a file");
    let mapping =
        "[[messages]]\ntopic = \"/cmd_vel\"\nfrom = \"a\"\nto = \"b\"\nLOSSY\nfields = { x = \"linear.x\" }\n";
    let bag = Bag::open(&path).expect("a bag");
    let counted = format!("{} counts 12 messages on /cmd_vel, and 11 are there", path.display());
    let (events, notes) = read_with(&bag, &mapping.replace("LOSSY", ""));
    assert!(events.len() == 13 && events.contains(&counted), "{events:?}");
    assert_eq!(notes, [counted.as_str()]);
    // Only those matter that are there.
    let (events, notes) = read_with(&bag, &mapping.replace("LOSSY", "lossy = true"));
    assert_eq!((events.len(), notes), (12, vec![counted]));
}

#[test]
fn what_follows_the_end_of_a_file_is_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let part = |ms, options: mcap::WriteOptions| written(&[("/cmd_vel", TWIST, ms, twist(1.0))], options);
    let kinds: [fn() -> mcap::WriteOptions; 3] = [
        || mcap::WriteOptions::new().use_chunks(false),
        mcap::WriteOptions::new,
        || mcap::WriteOptions::new().use_chunks(false).emit_summary_records(false),
    ];
    for options in kinds {
        let (first, second) = (part(0, options()), part(1000, options()));
        for end in [&second[..], &second[..30], &b"x"[..]] {
            fs::write(&path, [&first[..], end].concat()).expect("room for a file");
            let what = format!("… goes on after its end: the last {} bytes are not read", end.len());
            assert_eq!(all_lost(&path), [what]);
        }
        fs::write(&path, &first).expect("room for a file");
        assert_eq!(all_lost(&path), [""; 0]);
    }
}

#[test]
fn a_file_without_chunks_is_read_as_its_checksum_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    let plain = || mcap::WriteOptions::new().use_chunks(false);
    for options in [plain(), plain().emit_summary_records(false)] {
        let (mut bytes, records) = numbered(options);
        fs::write(&path, &bytes).expect("room for a file");
        assert_eq!(all_lost(&path), [""; 0]);
        bytes[records[6].end - 1] ^= 1;
        fs::write(&path, &bytes).expect("room for a file");
        assert_eq!(all_lost(&path), ["…: its checksum is not that of its records"]);
    }
}

#[test]
fn what_the_metadata_counts_is_compared_with_what_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let messages = [("/cmd_vel", TWIST, 1, twist(1.0)), ("/odd", ODD, 2, vec![0; 8])];
    fs::write(folder.path().join("bag_0.mcap"), written(&messages, mcap::WriteOptions::new())).expect("room");
    let lost = |topics: &str, file: u64, all: u64| {
        let text = format!(
            "rosbag2_bagfile_information:\n  message_count: {all}\n  topics_with_message_count:\n{topics}  \
             relative_file_paths:\n    - bag_0.mcap\n  files:\n    - path: bag_0.mcap\n      message_count: {file}\n"
        );
        fs::write(folder.path().join("metadata.yaml"), text).expect("room for a file");
        let survey = Bag::open(folder.path()).expect("a bag").survey().clone();
        let missing = survey.missing.into_iter().map(|(topic, what)| format!("{}: {what}", survey.topics[topic].name));
        survey.lost.into_iter().chain(missing).collect::<Vec<_>>()
    };
    let topic = |name: &str, count: u64| {
        format!("    - topic_metadata:\n        name: {name}\n        type: a\n      message_count: {count}\n")
    };
    let right = topic("/cmd_vel", 1) + &topic("/odd", 1);
    assert_eq!(lost(&right, 2, 2), [""; 0]);
    let less = topic("/cmd_vel", 3) + &topic("/odd", 1);
    assert_eq!(lost(&less, 4, 4), ["/cmd_vel: metadata.yaml counts 3 messages on /cmd_vel, and 1 are there"]);
    assert_eq!(lost("", 4, 4), ["metadata.yaml counts 4 messages in bag_0.mcap, and 2 are there"]);
    assert_eq!(lost("", 2, 1), ["metadata.yaml counts 1 messages, and 2 are there"]);
    // `rosbags` sorts keys, and does not indent lists.
    let sorted = |name: &str, count: u64| {
        format!(
            "  - message_count: {count}\n    topic_metadata:\n      name: {name}\n      offered_qos_profiles:\n      - depth: 1\n"
        )
    };
    assert_eq!(lost(&(sorted("/odd", 1) + &sorted("/cmd_vel", 1)), 2, 2), [""; 0]);
    let less = sorted("/odd", 1) + &sorted("/cmd_vel", 3) + &sorted("/never", 0);
    assert_eq!(lost(&less, 4, 4), ["/cmd_vel: metadata.yaml counts 3 messages on /cmd_vel, and 1 are there"]);
    let text = "info:\n  files:\n  - message_count: 7\n    path: bag_0.mcap\n  message_count: 7\n  relative_file_paths:\n  \
                - bag_0.mcap\n  ros_distro: rosbags\n";
    fs::write(folder.path().join("metadata.yaml"), text).expect("room for a file");
    let survey = Bag::open(folder.path()).expect("a bag").survey().clone();
    assert_eq!(survey.lost, ["metadata.yaml counts 7 messages in bag_0.mcap, and 2 are there"]);
}

#[cfg(unix)]
#[test]
fn a_listed_file_that_is_no_file_is_missing_and_one_with_two_names_is_read_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::write(path("bag_0.mcap"), written(&[("/cmd_vel", TWIST, 1, twist(1.0))], mcap::WriteOptions::new()))
        .expect("room for a file");
    let found = || {
        let bag = Bag::open(folder.path()).expect("a bag");
        (times(&bag).0, bag.survey().lost.clone(), bag.survey().notes.clone())
    };
    let list = |names: &str| {
        fs::write(path("metadata.yaml"), format!("relative_file_paths: [{names}]\n")).expect("room for a file");
    };
    list("bag_0.mcap, bag_1.mcap");
    let missing = vec!["bag_1.mcap is missing, although metadata.yaml lists it".to_owned()];
    fs::create_dir(path("bag_1.mcap")).expect("a folder");
    assert_eq!(found(), (vec![1], missing.clone(), vec![]));
    fs::remove_dir(path("bag_1.mcap")).expect("a folder");
    for to in ["nowhere", "/dev/null"] {
        std::os::unix::fs::symlink(to, path("bag_1.mcap")).expect("a link");
        assert_eq!(found(), (vec![1], missing.clone(), vec![]), "{to}");
        // It stands for a part of the bag without a list, too.
        fs::remove_file(path("metadata.yaml")).expect("a file");
        assert_eq!(found(), (vec![1], vec!["bag_1.mcap is not a file".to_owned()], vec![]), "{to}");
        list("bag_0.mcap, bag_1.mcap");
        fs::remove_file(path("bag_1.mcap")).expect("a link");
    }
    fs::hard_link(path("bag_0.mcap"), path("bag_1.mcap")).expect("a link");
    let note = "bag_1.mcap is not read: it is the same file as bag_0.mcap".to_owned();
    assert_eq!(found(), (vec![1], vec![], vec![note]));
    list("bag_0.mcap, ./bag_0.mcap");
    fs::remove_file(path("bag_1.mcap")).expect("a link");
    let note = "bag_0.mcap is read once, although metadata.yaml lists it twice".to_owned();
    assert_eq!(found(), (vec![1], vec![], vec![note]));
}

#[test]
fn metadata_without_a_whole_list_leaves_open_which_files_are_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(
        folder.path().join("bag_0.mcap"),
        written(&[("/cmd_vel", TWIST, 1, twist(1.0))], mcap::WriteOptions::new()),
    )
    .expect("room for a file");
    let path = folder.path().join("metadata.yaml");
    let lost = || Bag::open(folder.path()).expect("a bag").survey().lost.join("; ");
    let whole = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.mcap\n\n    # a comment\n    \
                 - bag_1.mcap\n  files:\n    - path: bag_0.mcap\n";
    fs::write(&path, whole).expect("room for a file");
    assert_eq!(lost(), "bag_1.mcap is missing, although metadata.yaml lists it");
    let wide: Vec<u8> = whole.bytes().flat_map(|byte| [byte, 0]).collect();
    let after_first = whole.find("\n\n").expect("a line");
    let in_second = whole.find("_1").expect("a name");
    let renamed = whole.replace("relative_file_paths", "relative_paths");
    let begun = "relative_file_paths: [bag_0.mcap, ";
    for text in [&b""[..], b"{{{", &wide[..], renamed.as_bytes(), begun.as_bytes()]
        .into_iter()
        .chain([after_first, in_second].map(|end| &whole.as_bytes()[..end]))
    {
        fs::write(&path, text).expect("room for a file");
        let expected = "metadata.yaml cannot be read, so files that it lists may be missing";
        assert_eq!(lost(), expected, "{:?}", String::from_utf8_lossy(text));
    }
    fs::remove_file(&path).expect("a file");
    fs::create_dir(&path).expect("a folder");
    assert_eq!(lost(), "metadata.yaml cannot be read, so files that it lists may be missing");
    fs::remove_dir(&path).expect("a folder");
    assert_eq!(lost(), "");
}
