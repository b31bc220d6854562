//! Files that are damaged, incomplete, or no bags.

use std::fs;
use std::path::PathBuf;

use bags::{Bag, Contents, Definitions, Error, Survey, is_bag};

use crate::messages::{ODD, TWIST, twist};
use crate::reading::{nothing, times};
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
    assert_eq!(found(), (vec![9, 10], vec![before], vec![]));
    let missing = "bag_11.mcap is missing, although metadata.yaml lists it".to_owned();
    let other = "bag_9.mcap is not read: metadata.yaml does not list it".to_owned();
    for metadata in [
        "info:\n  relative_file_paths:\n    - bag_10.mcap\n    - \"bag_11.mcap\"\n  duration: 1\n",
        "relative_file_paths: [drive/bag_10.mcap, 'bag_11.mcap.zstd']\n",
    ] {
        fs::write(folder.path().join("metadata.yaml"), metadata).expect("room for a file");
        assert_eq!(found(), (vec![10], vec![missing.clone()], vec![other.clone()]));
    }
    fs::write(folder.path().join("metadata.yaml"), "relative_file_paths:\n- bag_1.mcap\n").expect("room for a file");
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
    assert_eq!(opened(&[("bag_0.mcap", [0, 9], TWIST), ("bag_1.mcap", [8, 20], TWIST)]), nothing());
    let skipped = "bag_1.mcap is missing: bag_2.mcap is there".to_owned();
    let gap = [("bag_0.mcap", [0, 9], TWIST), ("bag_2.mcap", [20, 30], TWIST)];
    assert_eq!(opened(&gap), (skipped, String::new()));
    let copy = [("bag_0.mcap", [0, 9], TWIST), ("bag_1.mcap", [0, 9], TWIST)];
    assert_eq!(opened(&copy), refused("bag_0.mcap and bag_1.mcap have the same messages"));
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
    // The name or the first bytes tell.
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
