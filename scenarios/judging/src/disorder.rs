//! Recordings of one run, written in different ways: in any order, in one file or in several that overlap, with copies
//! beside them, cut off, or at the ends of the times that there are. The verdicts are those of the run; where a file or
//! the rest of one is missing, or where messages come too late to be put in order, each is the run's or unsure. Of a
//! file that is followed until it is interrupted, the run is as much as has been written of it.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use bags::{Bag, Events, Following, Mapping, Received, Source, Survey, Through};
use mcap::WriteOptions;
use mcap::records::{MessageHeader, op};
use monitors::Outcome;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use recording::{Doubts, Evidence};
use rusqlite::Connection;

use crate::judge::judge_without_records;
use crate::log_context::LogContext;

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

/// How long a mapping waits by default.
const REORDER_MS: u64 = 1000;

/// How many messages a run has.
const MESSAGES: usize = 30;

/// A message: its time, how much later it was recorded, its topic, and its number.
#[derive(Clone, Copy, Debug)]
struct Sent {
    ms: u64,
    late_ms: u64,
    /// By how much the time of its record is moved. Its stamp is not: it cannot hold every time.
    moved_ns: i128,
    topic: usize,
    x: i32,
}

impl Sent {
    /// The time of its record, which may be one that no file can hold.
    fn log_ns(&self) -> i128 {
        i128::from(self.ms + self.late_ms) * 1_000_000 + self.moved_ns
    }
}

/// A run; no two messages have the same time.
fn run(random: &mut ChaCha8Rng) -> Vec<Sent> {
    let mut ms = 1_700_000_000_000;
    let message = |_| {
        ms += 1 + u64::from(random.next_u32() % 900);
        // Numbers that violate hardly ever come: most runs satisfy something.
        let rare = random.next_u32().is_multiple_of(8);
        let x = random.next_u32() % if rare { 12 } else { 5 } + if rare { 0 } else { 3 };
        Sent { ms, late_ms: 0, moved_ns: 0, topic: random.next_u32() as usize % 3, x: x.cast_signed() }
    };
    (0..MESSAGES).map(message).collect()
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
            let time = i64::try_from(sent.log_ns()).expect("a time of SQLite");
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
        let time = u64::try_from(sent.log_ns()).expect("a time of MCAP");
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

/// The name of a property, and its outcome, unless it is unsure.
type Verdict = (String, Option<Outcome>);

/// The verdicts of all properties; none if the mapping does not fit, since a topic is missing.
fn outcomes(survey: &Survey, source: Box<dyn Source>, mapping: &Mapping) -> Option<Vec<Verdict>> {
    let compiled = mapping.compile(survey, None, &diagnostics::from_disk).ok()?;
    let topology = compiled.topology.clone();
    let mut properties = monitors::load("p.scope", PROPERTIES, &topology, mapping.tick).expect("correct").properties;
    let doubts = match source.counts_losses() {
        true => Doubts::about_losses(&properties, &topology),
        false => Doubts::about_any_messages(&properties, &topology),
    };
    let found = Events::new(source, mapping, compiled, &diagnostics::from_disk).map(Ok);
    let Ok(monitoring) = judge_without_records(found, &mut properties, doubts, &LogContext::default(), None) else {
        panic!("no event is an error")
    };
    let all = properties.iter().zip(&monitoring.evidence);
    let sure = |(property, evidence): (&monitors::Property, &Evidence)| {
        (property.name.clone(), evidence.has_verdict().then(|| Outcome::of(property.monitor.as_ref())))
    };
    Some(all.map(sure).collect())
}

fn of_bag(path: &Path, mapping: &Mapping) -> Vec<Verdict> {
    let bag = Bag::open(path).expect("a bag");
    of_messages(&bag, mapping).expect("it fits")
}

fn of_messages(bag: &Bag, mapping: &Mapping) -> Option<Vec<Verdict>> {
    outcomes(bag.survey(), Box::new(bag.messages_on(mapping.topics())), mapping)
}

fn followed(path: &Path, mapping: &Mapping) -> Vec<Verdict> {
    let mut ahead = Following::open(path, mapping.topics()).expect("a file");
    while matches!(ahead.receive(&mut Vec::new()), Received::Message(_)) {}
    let survey = ahead.survey().clone();
    outcomes(&survey, Box::new(ahead.restart().expect("the same file")), mapping).expect("it fits")
}

/// Follows a file as the command does, which is interrupted once nothing more comes, or after the first `most`
/// messages. No verdicts if it was still waiting for a topic then.
fn interrupted(path: &Path, mapping: &Mapping, most: usize) -> Option<Vec<Verdict>> {
    let mut ahead = Following::open(path, mapping.topics()).expect("a file");
    while mapping.awaited(ahead.survey()).is_some() && matches!(ahead.receive(&mut Vec::new()), Received::Message(_)) {}
    let survey = ahead.survey().clone();
    let following = ahead.restart().expect("the same file");
    let (mut messages, mut is_idle) = (0, false);
    let source = Through::new(following, move |source: &mut Following, body: &mut Vec<u8>| {
        if is_idle || messages == most {
            source.end();
            return Received::Over;
        }
        let received = source.receive(body);
        messages += usize::from(matches!(received, Received::Message(_)));
        is_idle = received == Received::Idle;
        received
    });
    outcomes(&survey, Box::new(source), mapping)
}

/// Whether messages are recorded in the order of their times.
fn is_sorted(sent: &[Sent]) -> bool {
    sent.is_sorted_by_key(Sent::log_ns)
}

/// A record of a file, and how many messages are in it.
struct RecordPlace {
    kind: u8,
    begin: usize,
    end: usize,
    messages: usize,
}

/// The records of a file from a place on, apart from those in chunks.
fn records(bytes: &[u8], mut begin: usize) -> Vec<RecordPlace> {
    /// The kind and the length of a chunk, and its fields before its own records if it is not compressed.
    const CHUNK_HEAD: usize = 9 + 40;
    let mut all = Vec::new();
    while let Some((kind, length)) = bytes.get(begin..begin + 9).and_then(<[u8]>::split_first) {
        let length = u64::from_le_bytes(length.try_into().expect("eight bytes"));
        let end = begin + 9 + length as usize;
        let messages: usize = match *kind {
            op::MESSAGE => 1,
            op::CHUNK => records(&bytes[..end], begin + CHUNK_HEAD).iter().map(|inner| inner.messages).sum(),
            _ => 0,
        };
        all.push(RecordPlace { kind: *kind, begin, end, messages });
        begin = end;
    }
    all
}

/// What the first part of a file contains.
#[derive(Default)]
struct Cut {
    /// How many messages are there with the whole of their records or chunks, and of how many there is anything.
    there: usize,
    begun: usize,
    /// Whether only a part of its last record is there, and whether all of its data is.
    is_torn: bool,
    has_data: bool,
}

impl Cut {
    fn of(records: &[RecordPlace], length: usize) -> Self {
        let mut cut = Self::default();
        for record in records.iter().filter(|record| record.begin < length) {
            let is_whole = record.end <= length;
            cut.begun += record.messages;
            cut.there += if is_whole { record.messages } else { 0 };
            cut.is_torn |= !is_whole;
            cut.has_data |= is_whole && record.kind == op::DATA_END;
        }
        cut
    }
}

/// Whether each verdict is that of the run or unsure; and how many are sure.
fn sure(found: &[Verdict], truth: &[Verdict], what: &str, sent: &[Sent]) -> usize {
    for ((name, found), (_, truth)) in found.iter().zip(truth) {
        assert!(found.is_none() || found == truth, "{what}: {name} is {found:?} and not {truth:?}: {sent:?}");
    }
    found.iter().filter(|(_, found)| found.is_some()).count()
}

/// How many recordings of a class were checked, and how many of their verdicts are sure.
#[derive(Debug, Default)]
struct Share {
    recordings: u64,
    verdicts: usize,
    sure: usize,
}

impl Share {
    /// Adds a recording: each verdict is the truth or unsure, and none is unsure if the recording is complete.
    fn add(&mut self, found: &[Verdict], truth: &[Verdict], is_complete: bool, what: &str, sent: &[Sent]) {
        self.recordings += 1;
        self.verdicts += truth.len();
        self.sure += sure(found, truth, what, sent);
        assert!(!is_complete || found == truth, "{what}: {found:?} and not {truth:?}: {sent:?}");
    }
}

/// A run, and a place for files with parts of it.
struct Checked<'r> {
    folder: &'r Path,
    /// By the times of records.
    mapping: &'r Mapping,
    truth: &'r [Verdict],
}

impl Checked<'_> {
    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.join(name);
        fs::write(&path, bytes).expect("room for a file");
        path
    }

    /// The verdicts of the run that consists of some of its messages.
    fn truth_of(&self, part: &[Sent]) -> Vec<Verdict> {
        match part.len() {
            MESSAGES => self.truth.to_vec(),
            _ => of_bag(&self.write("part.mcap", &file(part, 0)), self.mapping),
        }
    }

    /// Cuts a file with the messages in this order anywhere, follows it until it is interrupted, and opens it as a bag.
    fn check_cut(&self, order: &[Sent], random: &mut ChaCha8Rng, counts: &mut Counts) {
        // Every fourth file goes on after its end: with another one that has the rest of the run.
        let goes_on = random.next_u32().is_multiple_of(4);
        let count = if goes_on { 10 + random.next_u32() as usize % 20 } else { order.len() };
        let (first, rest) = order.split_at(count);
        let written = file(first, random.next_u32());
        let after_end = if goes_on { file(rest, random.next_u32()) } else { Vec::new() };
        let records = records(&written, mcap::MAGIC.len());
        // Hardly any byte is the last of a record, so such a cut is drawn as often as any other.
        let length = match random.next_u32() % 2 {
            0 => records[random.next_u32() as usize % records.len()].end,
            _ => random.next_u32() as usize % (written.len() + after_end.len() + 1),
        };
        let path = self.write("cut.mcap", &[&written[..], &after_end[..]].concat()[..length]);
        let (cut, goes_on) = (Cut::of(&records, length), length > written.len());
        // Interrupted while there is more to read, or when there is not.
        let most = if random.next_u32().is_multiple_of(4) { random.next_u32() as usize % MESSAGES } else { usize::MAX };
        let what = format!("cut after {length} bytes of {}, interrupted by message {most}", written.len());
        match interrupted(&path, self.mapping, most) {
            None => {
                let lacks = |topic: usize| first[..cut.there].iter().all(|sent| sent.topic != topic);
                assert!(!cut.has_data && (0..TOPICS.len()).any(lacks), "{what}, is refused: {order:?}");
                counts.refused += 1;
            }
            Some(found) => {
                let there = &first[..cut.there.min(most)];
                let is_whole = most <= cut.there || !goes_on && (cut.has_data || !cut.is_torn);
                let share = if is_whole { &mut counts.whole } else { &mut counts.torn };
                // The interrupt ends the run, although its writer goes on.
                share.add(&found, &self.truth_of(there), is_whole && is_sorted(there), &what, there);
                // What has been begun belongs to the run, too: it is known to be there. Only where everything so far
                // came in order is it taken to be later.
                let begun = if goes_on { order } else { &first[..cut.begun] };
                let is_more = !is_whole && begun.len() > there.len();
                if is_more && (is_sorted(begun) || !is_sorted(there)) {
                    sure(&found, &self.truth_of(begun), &format!("{what}, with what is begun"), begun);
                }
            }
        }
        match Bag::open(&path).ok().and_then(|bag| of_messages(&bag, self.mapping)) {
            None => {
                assert_eq!(cut.there, 0, "{what}, is refused as a bag: {order:?}");
                counts.refused += 1;
            }
            Some(found) => {
                let run = if goes_on { order } else { first };
                let is_complete = cut.has_data && !goes_on;
                counts.cut_off.add(&found, &self.truth_of(run), is_complete, &format!("{what}, as a bag"), run);
            }
        }
    }

    /// Moves the run, with its messages in this order, to an end of the times that fit into 64 bits, without a sign in
    /// MCAP and with one in SQLite.
    fn check_moved(&self, order: &[Sent], random: &mut ChaCha8Rng, counts: &mut Counts) {
        let [least, most] = [i64::MIN, i64::MAX].map(i128::from);
        let moved = |by_ns: i128| -> Vec<Sent> { order.iter().map(|sent| Sent { moved_ns: by_ns, ..*sent }).collect() };
        // Messages of the last time, or of later ones, are left out. One of the first time may be, too.
        let fit = |sent: &[Sent]| sent.iter().all(|sent| (least + 1..most).contains(&sent.log_ns()));
        let times = || order.iter().map(Sent::log_ns);
        let (first, last) = times().min().zip(times().max()).expect("a run has messages");
        let near = near_an_end(random);
        let places = [most - near - last, most + near - last, i128::from(u64::MAX) - near - last, near - first];
        let sent = moved(places[random.next_u32() as usize % places.len()]);
        let path = self.write("moved.mcap", &file(&sent, random.next_u32()));
        let is_complete = fit(&sent);
        let share = if is_complete { &mut counts.moved } else { &mut counts.beyond };
        share.add(&of_bag(&path, self.mapping), self.truth, is_complete, "moved", &sent);
        let found = followed(&path, self.mapping);
        share.add(&found, self.truth, is_complete && is_sorted(&sent), "moved and followed", &sent);
        // Times of SQLite may also be before 1970, and a run on both sides of it.
        let near = near_an_end(random);
        let places = [most - near - last, least + near - first, near - last];
        let sent = moved(places[random.next_u32() as usize % places.len()]);
        let path = self.folder.join("moved.db3");
        database(&sent, &path, random.next_u32());
        let is_complete = fit(&sent);
        let share = if is_complete { &mut counts.moved } else { &mut counts.beyond };
        share.add(&of_bag(&path, self.mapping), self.truth, is_complete, "moved, as a database", &sent);
    }
}

/// How far from an end of the times a run is: by single nanoseconds, by ticks, or by about its own length.
fn near_an_end(random: &mut ChaCha8Rng) -> i128 {
    let most_ns: u64 = [3, 2_000_000_000, 20_000_000_000][random.next_u32() as usize % 3];
    i128::from(random.next_u64() % most_ns)
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
    /// Followed to an interrupt: what ends with a whole record, and what has been begun and not been read.
    whole: Share,
    torn: Share,
    /// The same files, opened as bags.
    cut_off: Share,
    /// How many of these could not be judged: they lack a topic.
    refused: u64,
    /// At an end of the times that there are: all messages before the end, and the others.
    moved: Share,
    beyond: Share,
}

fn check(runs: u64, seed: u64) -> Counts {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // What is cut or moved is drawn apart, so that it does not change what else is drawn.
    let mut apart = ChaCha8Rng::seed_from_u64(seed + 1000);
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
            let part = if is_in_order { index * files / MESSAGES } else { random.next_u32() as usize % files };
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
        // One of them is missing: this shows in the list, or in the numbers.
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
        // Cut off, and at other times.
        let checked = Checked { folder: folder.path(), mapping: &by_log, truth: &truth };
        checked.check_cut(&sent, &mut apart, &mut counts);
        checked.check_cut(&permuted, &mut apart, &mut counts);
        let order = if apart.next_u32().is_multiple_of(2) { &sent } else { &permuted };
        checked.check_moved(order, &mut apart, &mut counts);
        counts.recordings += 10;
        counts.verdicts += truth.len();
    }
    let Counts { whole, torn, cut_off, moved, beyond, .. } = &counts;
    let shares = [whole, torn, cut_off, moved, beyond];
    let recordings: u64 = shares.iter().map(|share| share.recordings).sum();
    counts.recordings += recordings;
    counts
}

#[test]
fn a_verdict_is_that_of_the_run_however_it_was_written_or_unsure() {
    let counts = check(60, 1);
    println!("{counts:?}");
    let [missing, stamps, followed, late] = counts.sure;
    assert!(missing > 0 && stamps > counts.verdicts / 2 && followed > counts.verdicts / 2, "{counts:?}");
    assert!(late > counts.verdicts / 2 && counts.late > 5, "{counts:?}");
    let Counts { whole, torn, cut_off, moved, beyond, .. } = &counts;
    let classes = [whole.recordings + torn.recordings, cut_off.recordings, moved.recordings + beyond.recordings];
    assert!(classes.iter().all(|class| class * 20 >= counts.recordings), "{counts:?}");
    assert!(torn.recordings > 10 && beyond.recordings > 10, "{counts:?}");
    // Where nothing is missing, all are sure: if the file is in order, or opened as a bag.
    assert!(whole.sure > whole.verdicts / 3 && moved.sure > moved.verdicts / 3 * 2, "{counts:?}");
    assert!(cut_off.sure > cut_off.verdicts / 10 && torn.sure > 0 && beyond.sure > 0, "{counts:?}");
}

#[test]
#[ignore = "long: RECORDINGS=100000 cargo test --release disorder_on_demand -- --ignored --nocapture"]
fn disorder_on_demand() {
    let recordings = std::env::var("RECORDINGS").ok().and_then(|count| count.parse().ok()).unwrap_or(10_000_u64);
    // About so many are checked of each run.
    println!("{:?}", check(recordings.div_ceil(16), 2));
}
