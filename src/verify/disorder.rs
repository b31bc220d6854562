//! Recordings of one run, written in different ways: in any order, in one file or in several that overlap, with copies
//! beside them. The verdicts are those of the run; where a file is missing, or where messages come too late to be put
//! in order, each is the run's or unsure.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use bags::{Bag, Events, Following, Mapping, Received, Source, Survey};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use monitors::Outcome;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use recording::{Doubts, Evidence};
use rusqlite::Connection;

use super::around::Around;
use super::judge::judge_in_words;

const TOPICS: [&str; 3] = ["/level", "/ask", "/reply"];

const DEFINITION: &str = "builtin_interfaces/Time stamp\nint32 x\n";

/// Properties whose verdicts depend on the order of messages, and on their times.
const PROPERTIES: &str = "
    property low := always (level, monitor, m.x >= 2)
    property once_asked := always ((reply, monitor, true) implies once (ask, monitor, true))
    property recent := always ((reply, monitor, m.x > 5) implies once[<= 2 s] (ask, monitor, m.x > 3))
    property answered := always ((ask, monitor, m.x > 4) implies time_until (reply, monitor, true) < 1.5 s)
    property next_one := always ((ask, monitor, m.x = 7) implies next (reply, monitor, m.x != 3))
    property first := (not (ask, monitor, m.x = 9)) until (level, monitor, m.x < 6)
    property comes := eventually ((ask, monitor, m.x = 9) and next (level, monitor, true))
    property steady := always ((level, monitor, m.x as now) implies not previous (level, monitor, m.x < now - 8))
    property ends := eventually (always (level, monitor, m.x > 3))
    property never := always not (reply, monitor, m.x = 6)
    timed property soon := always ((ask, monitor, m.x > 8) implies time_until (reply, monitor, true) < 0.8 s)";

/// How long a mapping waits unless it says otherwise.
const REORDER_MS: u64 = 1000;

/// A message: its time, how much later it was recorded, its topic, and its number.
#[derive(Clone, Copy, Debug)]
struct Sent {
    ms: u64,
    late_ms: u64,
    topic: usize,
    x: i32,
}

/// A run; no two messages have the same time.
fn run(random: &mut ChaCha8Rng) -> Vec<Sent> {
    let mut ms = 1_700_000_000_000;
    let message = |_| {
        ms += 1 + u64::from(random.next_u32() % 900);
        // Numbers that violate hardly ever come: most runs satisfy something.
        let rare = random.next_u32().is_multiple_of(8);
        let x = random.next_u32() % if rare { 12 } else { 5 } + if rare { 0 } else { 3 };
        Sent { ms, late_ms: 0, topic: random.next_u32() as usize % 3, x: x.cast_signed() }
    };
    (0..30).map(message).collect()
}

/// An order of so many things.
fn permutation(count: usize, random: &mut ChaCha8Rng) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for at in (1..count).rev() {
        order.swap(at, random.next_u32() as usize % (at + 1));
    }
    order
}

fn body(sent: &Sent) -> Vec<u8> {
    let (s, ns) = ((sent.ms / 1000) as u32, (sent.ms % 1000) as u32 * 1_000_000);
    [&[0, 1, 0, 0][..], &s.to_le_bytes(), &ns.to_le_bytes(), &sent.x.to_le_bytes()].concat()
}

/// Writes a file of SQLite, with or without an index of times.
fn database(sent: &[Sent], path: &Path, way: u32) {
    let write = || {
        let file = Connection::open(path)?;
        let index = if way.is_multiple_of(2) { "" } else { "CREATE INDEX timestamp_idx ON messages (timestamp ASC);" };
        file.execute_batch(&format!(
            "PRAGMA synchronous = OFF; BEGIN;
            CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
            CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
                data BLOB NOT NULL);
            CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
                encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
            INSERT INTO message_definitions VALUES (NULL, 'p/msg/P', 'ros2msg', '{DEFINITION}', ''); {index}"
        ))?;
        for (id, topic) in TOPICS.iter().enumerate() {
            file.execute("INSERT INTO topics VALUES (?1, ?2, 'p/msg/P', 'cdr', '')", (id as i64 + 1, topic))?;
        }
        for sent in sent {
            let time = (sent.ms + sent.late_ms).cast_signed() * 1_000_000;
            file.execute("INSERT INTO messages VALUES (NULL, ?1, ?2, ?3)", (sent.topic as i64 + 1, time, body(sent)))?;
        }
        file.execute_batch("COMMIT")
    };
    write().expect("room for a database");
}

/// Writes a file in one of several ways.
fn file(sent: &[Sent], way: u32) -> Vec<u8> {
    let options = WriteOptions::new().compression(None).profile("ros2");
    let options = match way % 5 {
        0 => options.use_chunks(false),
        1 => options.use_chunks(false).emit_summary_records(false),
        2 => options.chunk_size(Some(200)),
        3 => options.chunk_size(Some(200)).emit_summary_records(false),
        _ => options,
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = options.create(&mut bytes).expect("a writer");
    let schema = writer.add_schema("p/msg/P", "ros2msg", DEFINITION.as_bytes()).expect("a schema");
    let channels = TOPICS.map(|topic| writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("a channel"));
    for sent in sent {
        let body = body(sent);
        let time = (sent.ms + sent.late_ms) * 1_000_000;
        let header =
            MessageHeader { channel_id: channels[sent.topic], sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &body).expect("room for a message");
    }
    writer.finish().expect("room for the end");
    drop(writer);
    bytes.into_inner()
}

fn mapping(time: &str) -> Mapping {
    let entry = |topic: &str| {
        let from = &topic[1..];
        format!("[[messages]]\ntopic = {topic:?}\nfrom = {from:?}\nto = \"monitor\"\nfields = {{ x = \"x\" }}\n")
    };
    let text = format!("tick_s = 0.5\ntime = {time:?}\n{}", TOPICS.map(entry).concat());
    Mapping::load(Path::new("m.toml"), &|_| Ok(text.clone().into_bytes())).expect("correct")
}

/// The outcome of each property, unless it is unsure.
fn outcomes(survey: &Survey, source: Box<dyn Source>, mapping: &Mapping) -> Vec<(String, Option<Outcome>)> {
    let Ok(compiled) = mapping.compile(survey, None, &diagnostics::from_disk) else { panic!("it fits") };
    let topology = compiled.topology.clone();
    let mut properties = monitors::load("p.scope", PROPERTIES, &topology, mapping.tick).expect("correct").properties;
    let doubts = match source.counts_losses() {
        true => Doubts::about_losses(&properties, &topology),
        false => Doubts::about_any_messages(&properties, &topology),
    };
    let found = Events::new(source, mapping, compiled, &diagnostics::from_disk).map(Ok);
    let Ok(judgment) = judge_in_words(found, &mut properties, doubts, &Around::default(), None) else {
        panic!("no event is an error")
    };
    let all = properties.iter().zip(&judgment.evidence);
    let sure = |(property, evidence): (&monitors::Property, &Evidence)| {
        (property.name.clone(), evidence.has_verdict().then(|| Outcome::of(property.monitor.as_ref())))
    };
    all.map(sure).collect()
}

fn of_bag(path: &Path, mapping: &Mapping) -> Vec<(String, Option<Outcome>)> {
    let bag = Bag::open(path).expect("a bag");
    outcomes(bag.survey(), Box::new(bag.messages_on(mapping.topics())), mapping)
}

fn followed(path: &Path, mapping: &Mapping) -> Vec<(String, Option<Outcome>)> {
    let mut ahead = Following::open(path, mapping.topics()).expect("a file");
    while matches!(ahead.receive(&mut Vec::new()), Received::Message(_)) {}
    let survey = ahead.survey().clone();
    outcomes(&survey, Box::new(ahead.restart().expect("the same file")), mapping)
}

/// Whether each verdict is that of the run or unsure; and how many are sure.
fn sure(found: &[(String, Option<Outcome>)], truth: &[(String, Option<Outcome>)], what: &str, sent: &[Sent]) -> usize {
    for ((name, found), (_, truth)) in found.iter().zip(truth) {
        assert!(found.is_none() || found == truth, "{what}: {name} is {found:?} and not {truth:?}: {sent:?}");
    }
    found.iter().filter(|(_, found)| found.is_some()).count()
}

/// How many recordings were checked, and how many of their verdicts are sure.
#[derive(Debug, Default)]
struct Counts {
    recordings: u64,
    verdicts: usize,
    /// In how many a message came later than the mapping waits.
    late: usize,
    /// With a file missing, by stamps, while they are written, and by stamps of messages that were recorded late.
    sure: [usize; 4],
}

fn check(runs: u64, seed: u64) -> Counts {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let [by_log, by_stamp] = ["log", "stamp"].map(mapping);
    let mut counts = Counts::default();
    for _ in 0..runs {
        let sent = run(&mut random);
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let write = |name: &str, bytes: &[u8]| fs::write(path(name), bytes).expect("room for a file");
        write("truth.mcap", &file(&sent, 0));
        let truth = of_bag(&path("truth.mcap"), &by_log);
        assert!(truth.iter().all(|(_, outcome)| outcome.is_some()), "nothing is missing: {sent:?}");
        // Any order.
        let order = permutation(sent.len(), &mut random);
        let permuted: Vec<Sent> = order.iter().map(|index| sent[*index]).collect();
        write("permuted.mcap", &file(&permuted, random.next_u32()));
        assert_eq!(of_bag(&path("permuted.mcap"), &by_log), truth, "{permuted:?}");
        database(&permuted, &path("permuted.db3"), random.next_u32());
        assert_eq!(of_bag(&path("permuted.db3"), &by_log), truth, "as a database: {permuted:?}");
        // Any files, in any order, and a copy that the metadata does not list.
        fs::create_dir(path("split")).expect("a folder");
        let files = 2 + random.next_u32() as usize % 3;
        let mut parts = vec![Vec::new(); files];
        let is_in_order = random.next_u32().is_multiple_of(2);
        for (index, sent) in if is_in_order { &sent } else { &permuted }.iter().enumerate() {
            let part = if is_in_order { index * files / 30 } else { random.next_u32() as usize % files };
            parts[part].push(*sent);
        }
        let names: Vec<String> = (0..files).map(|part| format!("bag_{part}.mcap")).collect();
        for (name, part) in names.iter().zip(&parts) {
            write(&format!("split/{name}"), &file(part, random.next_u32()));
        }
        let list: String = names.iter().map(|name| format!("    - {name}\n")).collect();
        write("split/metadata.yaml", format!("info:\n  relative_file_paths:\n{list}  duration: 1\n").as_bytes());
        write("split/copy.mcap", &file(&sent, random.next_u32()));
        write("split/bag_0.db3", b"SQLite format 3\0");
        assert_eq!(of_bag(&path("split"), &by_log), truth, "{parts:?}");
        // One of them is missing: the list tells, or the numbers.
        let missing = random.next_u32() as usize % files;
        fs::remove_file(path(&format!("split/{}", names[missing]))).expect("a file");
        let with_list = of_bag(&path("split"), &by_log);
        counts.sure[0] += sure(&with_list, &truth, "a file is missing", &sent);
        if missing + 1 < files {
            for name in ["metadata.yaml", "copy.mcap", "bag_0.db3"] {
                fs::remove_file(path(&format!("split/{name}"))).expect("a file");
            }
            // Without a list, files whose times overlap are not taken for one recording.
            if is_in_order {
                sure(&of_bag(&path("split"), &by_log), &truth, "a number is missing", &sent);
            } else if let Err(error) = Bag::open(&path("split")) {
                assert!(error.to_string().contains("more than one recording"), "{error}");
            }
        }
        // Stamps in any order, and files that are followed.
        counts.sure[1] += sure(&of_bag(&path("permuted.mcap"), &by_stamp), &truth, "stamps", &permuted);
        counts.sure[2] += sure(&followed(&path("permuted.mcap"), &by_log), &truth, "followed", &permuted);
        // Nearly in order.
        let mut nearly = sent.clone();
        for _ in 0..1 + random.next_u32() % 3 {
            let at = random.next_u32() as usize % (nearly.len() - 4);
            let moved = nearly.remove(at);
            nearly.insert(at + 1 + random.next_u32() as usize % 3, moved);
        }
        write("nearly.mcap", &file(&nearly, random.next_u32()));
        assert_eq!(of_bag(&path("nearly.mcap"), &by_log), truth, "{nearly:?}");
        counts.sure[1] += sure(&of_bag(&path("nearly.mcap"), &by_stamp), &truth, "stamps", &nearly);
        counts.sure[2] += sure(&followed(&path("nearly.mcap"), &by_log), &truth, "followed", &nearly);
        // Each message later than it was sent, some of them later than the mapping waits.
        let most_ms = [150, 400, 1600][random.next_u32() as usize % 3];
        let mut late = sent.clone();
        late.iter_mut().for_each(|sent| sent.late_ms = u64::from(random.next_u32()) % most_ms);
        late.sort_by_key(|sent| sent.ms + sent.late_ms);
        write("late.mcap", &file(&late, random.next_u32()));
        counts.sure[3] += sure(&of_bag(&path("late.mcap"), &by_stamp), &truth, "recorded late", &late);
        counts.late += usize::from(late.windows(2).any(|two| two[0].ms > two[1].ms + REORDER_MS));
        counts.recordings += 10;
        counts.verdicts += truth.len();
    }
    counts
}

#[test]
fn a_verdict_is_that_of_the_run_however_it_was_written_or_unsure() {
    let counts = check(60, 1);
    println!("{counts:?}");
    let [missing, stamps, followed, late] = counts.sure;
    assert!(missing > 0 && stamps > counts.verdicts / 2 && followed > counts.verdicts / 2, "{counts:?}");
    assert!(late > counts.verdicts / 2 && counts.late > 5, "{counts:?}");
}

#[test]
#[ignore = "long: RECORDINGS=100000 cargo test --release disorder_on_demand -- --ignored --nocapture"]
fn disorder_on_demand() {
    let recordings = std::env::var("RECORDINGS").ok().and_then(|count| count.parse().ok()).unwrap_or(10_000_u64);
    println!("{:?}", check(recordings.div_ceil(10), 2));
}
