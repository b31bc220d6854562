//! SQLite files, rosbag2's first format.

use std::fs;
use std::path::Path;

use bags::{Bag, Definitions};
use rusqlite::{Connection, params};

use crate::events::MAPPING;
use crate::messages::{Encoder, ODD, TWIST, odd, twist};
use crate::reading::{nothing, read_with, times};
use crate::writer::{Written, bag_of};

const TABLES: &str = "
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
    offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
";

/// Since Iron.
const DEFINITIONS: &str = "
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
    encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
";

/// Writes a file as rosbag2 does, with definitions or, like Humble, without.
pub(crate) fn write(path: &Path, messages: &[Written<'_>], has_definitions: bool) {
    let file = Connection::open(path).expect("room for a file");
    // Nothing of a test need survive a power cut.
    file.pragma_update(None, "synchronous", "OFF").expect("a known setting");
    file.execute_batch(TABLES).expect("tables");
    if has_definitions {
        file.execute_batch(DEFINITIONS).expect("a table");
    }
    let mut topics: Vec<&str> = Vec::new();
    for (topic, (kind, definition), ms, data) in messages {
        let known = topics.iter().position(|known| known == topic);
        let index = known.unwrap_or_else(|| {
            topics.push(topic);
            let topic = params![topics.len() as i64, topic, kind];
            file.execute("INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr', '')", topic).expect("a topic");
            if has_definitions {
                let row = params![kind, definition];
                file.execute("INSERT INTO message_definitions VALUES (NULL, ?1, 'ros2msg', ?2, '')", row)
                    .expect("a row");
            }
            topics.len() - 1
        });
        let row = params![index as i64 + 1, *ms as i64 * 1_000_000, data];
        file.execute("INSERT INTO messages VALUES (NULL, ?1, ?2, ?3)", row).expect("a message");
    }
    file.close().expect("the file is closed");
}

fn messages() -> Vec<Written<'static>> {
    vec![
        ("/cmd_vel", TWIST, 5000, twist(0.5)),
        ("/odd", ODD, 5200, odd(false, 1, 1, &[("a", 1.0)])),
        ("/cmd_vel", TWIST, 5100, twist(f64::NAN)),
        ("/odd", ODD, 5300, odd(true, 1, 2, &[])),
        ("/cmd_vel", TWIST, 7500, twist(2.0)[..20].to_vec()),
    ]
}

#[test]
fn a_file_gives_the_same_events_in_either_format() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.db3");
    write(&path, &messages(), true);
    let (sqlite, mcap) = (Bag::open(&path).expect("a bag"), bag_of(folder.path(), &messages()));
    let surveyed = |bag: &Bag| (bag.survey().topics.clone(), bag.survey().counts.clone(), bag.survey().span_ns);
    assert_eq!(surveyed(&sqlite), surveyed(&mcap));
    assert_eq!(surveyed(&sqlite).2, Some((5_000_000_000, 7_500_000_000)));
    assert_eq!(read_with(&sqlite, MAPPING), read_with(&mcap, MAPPING));
    assert_eq!(times(&sqlite), (vec![5000, 5100, 5200, 5300, 7500], vec![]));
}

#[test]
fn only_the_wanted_messages_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.db3");
    write(&path, &messages(), true);
    let bag = Bag::open(&path).expect("a bag");
    let (mut wanted, mut body, mut found) = (bag.messages(&[1]), Vec::new(), Vec::new());
    while let Some(head) = wanted.next_into(&mut body) {
        // rosbag2 stores no other time.
        assert_eq!((head.topic, head.publish_ns), (1, head.log_ns));
        found.push(head.log_ns / 1_000_000);
    }
    assert_eq!(found, [5200, 5300]);
}

#[test]
fn a_file_without_definitions_needs_them_from_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.db3");
    write(&path, &messages(), false);
    let bag = Bag::open(&path).expect("a bag");
    let topics = &bag.survey().topics;
    assert!(topics.len() == 2 && topics.iter().all(|topic| topic.definition.is_none()), "{topics:?}");
    let undefined = Definitions { survey: bag.survey(), folders: &[], read: &nothing }
        .layout(&topics[1])
        .expect_err("none is known");
    assert!(undefined.to_string().starts_with("there is no definition of odd_msgs/Odd"), "{undefined}");
    assert_eq!(times(&bag).0.len(), 5);
}

/// A message of `sensor_msgs/msg/BatteryState`.
fn battery(percentage: f32) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.put(&5_i32.to_le_bytes()).put(&0_u32.to_le_bytes()).text("base");
    for number in [12.5, 20.0, -1.5, f32::NAN, f32::NAN, f32::NAN, percentage] {
        encoder.put(&number.to_le_bytes());
    }
    encoder.put(&[2]).put(&[1]).put(&[3]).put(&[1]);
    // Cells without voltages and temperatures.
    encoder.put(&0_u32.to_le_bytes()).put(&0_u32.to_le_bytes()).text("left").text("B-17");
    encoder.message()
}

#[test]
fn a_file_of_humble_is_read_with_the_definitions_on_board() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.db3");
    let kind = ("sensor_msgs/msg/BatteryState", "");
    write(&path, &[("/battery", kind, 5000, battery(0.75)), ("/battery", kind, 5500, battery(0.5))], false);
    let mapping = "[[messages]]\ntopic = \"/battery\"\nfrom = \"battery\"\nto = \"monitor\"\n[messages.fields]\n\
                   level = \"percentage\"\nstatus = { path = \"power_supply_status\", symbols = { 2 = \"DISCHARGING\" } }\n\
                   serial = \"serial_number\"\n";
    let (events, notes) = read_with(&Bag::open(&path).expect("a bag"), mapping);
    let expected = [
        "0 ms: 0, tick 0",
        "0 ms: 1, tick 0: battery → monitor [0.75, <DISCHARGING>, \"B-17\"]",
        "500 ms: 2, tick 0: battery → monitor [0.5, <DISCHARGING>, \"B-17\"]",
    ];
    assert_eq!(events, expected);
    assert_eq!(notes, ["/battery is decoded with the sensor_msgs/msg/BatteryState on board, as in dashing to lyrical"]);
}

#[test]
fn the_distribution_and_the_hashes_of_a_file_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.db3");
    write(&path, &messages(), false);
    let named = "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        INSERT INTO schema VALUES (4, 'iron');
        ALTER TABLE topics ADD COLUMN type_description_hash TEXT NOT NULL DEFAULT '';
        UPDATE topics SET type_description_hash = 'RIHS01_12' WHERE name = '/odd';";
    Connection::open(&path).and_then(|file| file.execute_batch(named)).expect("room for tables");
    let survey = Bag::open(&path).expect("a bag").survey().clone();
    assert_eq!(survey.distributions.iter().collect::<Vec<_>>(), ["iron"]);
    let hashes = survey.topics.iter().map(|topic| topic.hash.as_deref());
    assert_eq!(hashes.collect::<Vec<_>>(), [None, Some("RIHS01_12")]);
}

#[test]
fn everything_before_the_point_where_a_file_is_cut_off_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, cut) = (folder.path().join("bag.db3"), folder.path().join("cut.db3"));
    let messages: Vec<Written<'_>> = (0..300).map(|ms| ("/cmd_vel", TWIST, ms, twist(1.0))).collect();
    write(&path, &messages, true);
    let whole = fs::read(&path).expect("the file is there");
    let mut most = 0;
    for end in (0..whole.len()).step_by(511).chain([whole.len() - 1, whole.len()]) {
        fs::write(&cut, &whole[..end]).expect("room for a file");
        let Ok(bag) = Bag::open(&cut) else { continue };
        let (times, lost) = times(&bag);
        assert!(times.iter().copied().eq(0..times.len() as i64), "{end} bytes: {times:?}");
        assert!(times.len() == 300 || lost.concat().contains("cut.db3 breaks off"), "{end} bytes: {lost:?}");
        most = most.max(times.len() * usize::from(end < whole.len()));
    }
    assert!(most > 100, "at most {most} messages are read of a file that is cut off");
    assert_eq!(times(&Bag::open(&path).expect("a bag")), ((0..300).collect(), vec![]));
}

#[test]
fn what_sqlite_cannot_read_is_refused_with_advice() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("room for a file");
        let error = Bag::open(&path).expect_err("no bag");
        assert_eq!(error.help(), "the file is damaged, or another program is writing it");
        error.to_string().replace(&*folder.path().to_string_lossy(), "…")
    };
    let first_page = "it ends within its first page";
    assert_eq!(refused("short.db3", b"SQLite format 3\0"), format!("…/short.db3: {first_page}"));
    assert_eq!(refused("other.db3", &[0; 100]), format!("…/other.db3: {first_page}"));
    let path = folder.path().join("empty.db3");
    Connection::open(&path).and_then(|file| file.execute_batch("CREATE TABLE t(x)")).expect("room for a file");
    let bytes = fs::read(&path).expect("the file is there");
    assert_eq!(refused("foreign.db3", &bytes), "…/foreign.db3: no such table: topics");
}

#[test]
fn a_message_of_a_topic_that_is_not_there_is_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.db3");
    write(&path, &messages(), true);
    assert_eq!(Bag::open(&path).expect("a bag").survey().lost, [""; 0]);
    let change = "UPDATE messages SET topic_id = 77 WHERE id = 2";
    Connection::open(&path).and_then(|file| file.execute_batch(change)).expect("a row");
    let lost = Bag::open(&path).expect("a bag").survey().lost.concat();
    assert!(lost.ends_with("bag.db3 has 1 messages of topics that it does not have"), "{lost}");
}
