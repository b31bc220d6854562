//! Tests with bags that are made here, byte by byte; `tests/bags/foreign.py` tests those of other programs.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use channels::{Capacity, Domain, Event, EventKind, FieldKind, Shape, Topology};
use mcap::records::MessageHeader;
use proptest::prelude::*;
use ros_messages::{Decoder, Want};

use super::*;

const TWIST: (&str, &str) = (
    "geometry_msgs/msg/Twist",
    "Vector3 linear\nVector3 angular\n===\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
);
const ODD: (&str, &str) = (
    "odd_msgs/msg/Odd",
    "uint8 MODE_IDLE=0\nuint8 MODE_BUSY=1\nstd_msgs/Header header\nuint8 mode\nuint64 count\nuint8[4] id\nItem[] items\n\
     wstring wide\nbool[<=2] flags\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
     MSG: odd_msgs/Item\nstring name\nfloat32 weight\n",
);

/// Writes CDR, little- or big-endian.
#[derive(Default)]
struct Encoder {
    is_big: bool,
    bytes: Vec<u8>,
}

impl Encoder {
    fn put(&mut self, little: &[u8]) -> &mut Self {
        self.bytes.resize(self.bytes.len().next_multiple_of(little.len()), 0);
        let mut bytes = little.to_vec();
        if self.is_big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
        self
    }

    fn text(&mut self, text: &str) -> &mut Self {
        self.put(&(text.len() as u32 + 1).to_le_bytes());
        self.bytes.extend(text.bytes().chain([0]));
        self
    }

    fn message(&self) -> Vec<u8> {
        [&[0, u8::from(!self.is_big), 0, 0], self.bytes.as_slice()].concat()
    }
}

fn twist(x: f64) -> Vec<u8> {
    let mut encoder = Encoder::default();
    for number in [x, 0.0, 0.0, 0.0, 0.0, -x] {
        encoder.put(&number.to_le_bytes());
    }
    encoder.message()
}

/// One more than what a real number can be exactly.
const COUNT: u64 = (1 << 53) + 1;

/// An odd message with a stamp in milliseconds.
fn odd(is_big: bool, ms: u32, mode: u8, items: &[(&str, f32)]) -> Vec<u8> {
    let mut encoder = Encoder { is_big, ..Encoder::default() };
    encoder.put(&(ms / 1000).to_le_bytes()).put(&(ms % 1000 * 1_000_000).to_le_bytes()).text("map");
    encoder.put(&[mode]).put(&COUNT.to_le_bytes()).put(&[0xab]).put(&[0]).put(&[1]).put(&[0xff]);
    encoder.put(&(items.len() as u32).to_le_bytes());
    for (name, weight) in items {
        encoder.text(name).put(&weight.to_le_bytes());
    }
    let wide: Vec<u16> = "aß😀".encode_utf16().collect();
    encoder.put(&(wide.len() as u32).to_le_bytes());
    for unit in wide {
        encoder.put(&u32::from(unit).to_le_bytes());
    }
    encoder.put(&2_u32.to_le_bytes()).put(&[1]).put(&[0]);
    encoder.message()
}

/// A message: topic, type with definition, milliseconds when it was recorded, bytes.
type Written<'w> = (&'w str, (&'w str, &'w str), u64, Vec<u8>);

fn written(messages: &[Written<'_>], options: mcap::WriteOptions) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = options.compression(None).profile("ros2").create(&mut bytes).expect("a writer");
    let mut channels = BTreeMap::new();
    for (sequence, (topic, (kind, definition), ms, data)) in messages.iter().enumerate() {
        let channel_id = *channels.entry(topic).or_insert_with(|| {
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

fn bag_of(folder: &Path, messages: &[Written<'_>]) -> Bag {
    let path = folder.join("bag.mcap");
    fs::write(&path, written(messages, mcap::WriteOptions::new().chunk_size(Some(100)))).expect("room for a bag");
    Bag::open(&path).expect("a bag")
}

fn mapping(text: &str) -> Mapping {
    match Mapping::load(Path::new("mapping.toml"), &|_| Ok(text.as_bytes().to_vec())) {
        Ok(mapping) => mapping,
        Err(diagnostics::Error::Problems(problems)) => panic!("{}", problems.plain()),
        Err(error) => panic!("{error}"),
    }
}

fn nothing(_: &Path) -> std::io::Result<Vec<u8>> {
    Err(std::io::ErrorKind::NotFound.into())
}

/// The events as lines, and the notes.
fn read_with(bag: &Bag, text: &str) -> (Vec<String>, Vec<String>) {
    let mapping = mapping(text);
    let compiled = mapping.compile(bag.survey(), None, &nothing);
    let compiled = compiled.unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let topology = compiled.topology.clone();
    let mut events = Events::new(bag, &mapping, compiled);
    let line = |Event { step, tick, time, kind }: Event| match kind {
        EventKind::Tick => format!("{} ms: {step}, tick {tick}", time.as_millis()),
        EventKind::Received { channel, message } => {
            format!("{} ms: {step}, tick {tick}: {} {message}", time.as_millis(), topology.describe(channel))
        }
    };
    let lines = events.by_ref().map(|found| match found {
        Found::Event(event) => line(event),
        Found::LeftOut(gap) => gap.why,
    });
    (lines.collect(), events.notes())
}

const MAPPING: &str = r#"
[[messages]]
topic = "/cmd_vel"
from = "controller"
to = "base"
fields = { x = "linear.x", turn = { path = "angular.z", scale = 10 } }
[[messages]]
topic = "/odd"
from = "odd"
to = "base"
where = { mode = [1, 2], "header.frame_id" = "map" }
[messages.fields]
kind = { symbol = "odd" }
mode = { path = "mode", symbols = { 1 = "busy" } }
count = "count"
id = "id"
last = "items[-1].name"
weight = "items[1].weight"
wide = "wide"
flag = "flags[1]"
"#;

#[test]
fn messages_become_events_with_ticks_between_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let bag = bag_of(
        folder.path(),
        &[
            ("/cmd_vel", TWIST, 5000, twist(0.5)),
            ("/odd", ODD, 5200, odd(false, 1, 1, &[("a", 1.0), ("b", f32::NAN)])),
            ("/odd", ODD, 5300, odd(false, 1, 0, &[])),
            ("/odd", ODD, 5400, odd(true, 1, 1, &[("c", 1.0), ("d", 0.1)])),
            // This one was recorded too late and is put in order.
            ("/cmd_vel", TWIST, 5100, twist(f64::NAN)),
            ("/odd", ODD, 5500, odd(false, 1, 2, &[])),
            ("/cmd_vel", TWIST, 7000, twist(1.0)),
            ("/cmd_vel", TWIST, 7500, twist(2.0)[..20].to_vec()),
        ],
    );
    let (events, notes) = read_with(&bag, MAPPING);
    let expected = [
        // It is noticed as soon as it is read.
        "messages on /odd are left out: the mapping has no symbol for the value; the first: `mode` is 2",
        "0 ms: 0, tick 0",
        "0 ms: 1, tick 0: controller → base [0.5, -5.0]",
        "100 ms: 2, tick 0: controller → base [<none>, <none>]",
        "200 ms: 3, tick 0: odd → base [<odd>, <busy>, 9007199254740993, \"ab0001ff\", \"b\", <none>, \"aß😀\", false]",
        "400 ms: 4, tick 0: odd → base [<odd>, <busy>, 9007199254740993, \"ab0001ff\", \"d\", 0.10000000149011612, \"aß😀\", false]",
        "messages on /cmd_vel are left out: the bytes do not fit the definition: they end before their definition does; \
         the first: 2.500 s after the first message of the bag",
        "1000 ms: 4, tick 1",
        "2000 ms: 4, tick 2",
        "2000 ms: 5, tick 2: controller → base [1.0, -10.0]",
    ];
    assert_eq!(events, expected);
    let expected = [
        "1 message on /cmd_vel is left out: the bytes do not fit the definition: they end before their definition does; \
         the first: 2.500 s after the first message of the bag",
        "1 message on /odd is left out: the mapping has no symbol for the value; the first: `mode` is 2",
    ];
    assert_eq!(notes, expected);
}

#[test]
fn a_clock_that_does_not_count_from_1970_has_no_dates() {
    let moments = [0, 5_250_000_000, 1_760_000_000_030_000_000].map(moment);
    assert_eq!(moments, ["0.000 s", "5.250 s", "2025-10-09 08:53:20.030 UTC"]);
}

#[test]
fn stamps_in_messages_can_be_their_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |ms: u32| ("/odd", ODD, 9000, odd(false, ms, 1, &[]));
    let bag = bag_of(folder.path(), &[at(3000), at(0), at(3900), at(3700), at(5500), at(4000), at(u32::MAX), at(5600)]);
    let text = "time = \"header.stamp\"\nreorder_s = 0.5\ntick_s = 0.1\n[[messages]]\ntopic = \"/odd\"\nfrom = \"a\"\nto = \"b\"\n\
                fields = { mode = \"mode\" }\n";
    let (events, notes) = read_with(&bag, text);
    let messages = events.iter().filter(|line| line.contains('→'));
    let times: Vec<&str> = messages.map(|line| line.split(':').next().unwrap_or_default()).collect();
    assert_eq!(times, ["0 ms", "700 ms", "900 ms", "1000 ms", "2500 ms", "2600 ms"]);
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].starts_with("2 messages on /odd are left out: the stamp is 0, or far from"), "{notes:?}");
}

#[test]
fn what_does_not_fit_the_bag_is_refused_at_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let undefined = ("odd_msgs/action/Go_FeedbackMessage", "");
    let bag = bag_of(
        folder.path(),
        &[("/cmd_vel", TWIST, 1, twist(1.0)), ("/odd", ODD, 1, odd(false, 1, 1, &[])), ("/go", undefined, 1, vec![])],
    );
    let problems = |topic: &str, fields: &str| {
        let ends = "from = \"a\"\nto = \"b\"";
        let text = format!("[[messages]]\ntopic = \"{topic}\"\n{ends}\nfields.x = {fields}\n");
        mapping(&text).compile(bag.survey(), None, &nothing).err().map(|problems| problems.plain()).unwrap_or_default()
    };
    let all = [
        problems("/cmd_val", "\"linear.x\""),
        problems("/cmd_vel", "\"linear.w\""),
        problems("/cmd_vel", "\"linear\""),
        problems("/cmd_vel", "\"linear[0].x\""),
        problems("/cmd_vel", "\"linear.x.y\""),
        problems("/odd", "\"items.name\""),
        problems("/odd", "\"items[last].name\""),
        problems("/odd", "{ path = \"wide\", scale = 2 }"),
        problems("/odd", "\"mode\"\ntime = \"mode\""),
        problems("/go", "\"goal_id.uuid\""),
    ];
    insta::assert_snapshot!(all.concat());
    // It is defined if the right folder is given.
    let action = "int8 to\n---\nbool done\n---\nfloat32 left\n";
    let read = |path: &Path| match path.ends_with("share/odd_msgs/action/Go.action") {
        true => Ok(action.as_bytes().to_vec()),
        false => nothing(path),
    };
    let text = "definitions = [\"share\"]\n[[messages]]\ntopic = \"/go\"\nfrom = \"a\"\nto = \"b\"\nfields = { x = \"feedback.left\" }\n";
    assert!(mapping(text).compile(bag.survey(), None, &read).is_ok());
}

#[test]
fn a_scenario_says_what_its_channels_carry() {
    let folder = tempfile::tempdir().expect("a folder");
    let bag = bag_of(folder.path(), &[("/cmd_vel", TWIST, 1, twist(0.5))]);
    let mut topology = Topology::default();
    let [reader, skill] = ["Reader", "Skill"].map(|name| topology.process(name).expect("a new process"));
    let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
    topology.channel(reader, skill, Capacity::One, Domain::new([level])).expect("a new channel");
    let topology = std::sync::Arc::new(topology);
    let compiled = |ends: &str, fields: &str| {
        let text = format!("[[messages]]\ntopic = \"/cmd_vel\"\n{ends}\nfields = {{ {fields} }}\n");
        mapping(&text).compile(bag.survey(), Some(&topology), &nothing).map_err(|problems| problems.plain())
    };
    let ends = "from = \"Reader\"\nto = \"Skill\"";
    assert!(compiled(ends, "status = { symbol = \"ok\" }, level = \"linear.x\"").is_ok());
    let refused = [
        compiled("from = \"Skill\"\nto = \"Reader\"", "level = \"linear.x\""),
        compiled(ends, "level = \"linear.x\""),
        compiled(ends, "status = { symbol = \"bad\" }, level = \"linear.x\""),
    ];
    insta::assert_snapshot!(refused.map(|refused| refused.expect_err("it does not fit")).concat());
}

#[test]
fn the_proposed_mapping_works_as_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let bag =
        bag_of(folder.path(), &[("/cmd_vel", TWIST, 1, twist(0.5)), ("/1/odd", ODD, 1001, odd(false, 1, 1, &[]))]);
    let contents = Contents::of(&bag, &Definitions { topics: &[], folders: &[], read: &nothing });
    let proposal = contents.proposal().expect("there are fields");
    insta::assert_snapshot!(proposal);
    let (events, notes) = read_with(&bag, &proposal);
    assert_eq!((events.len(), notes.len()), (4, 0), "{events:?}");
}

/// Such a type has 2⁴⁰ fields.
#[test]
fn of_a_type_with_endlessly_many_fields_the_first_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let pair = |depth: usize| format!("T{depth} a\nT{depth} b\n===\nMSG: p/T{depth}\n");
    let definition = (1..=40).map(pair).collect::<String>() + "uint8 x\n";
    let bag = bag_of(folder.path(), &[("/deep", ("p/msg/T0", definition.as_str()), 1, Vec::new())]);
    let contents = Contents::of(&bag, &Definitions { topics: &[], folders: &[], read: &nothing });
    let fields = contents.topics[0].fields.as_ref().expect("its definition is known");
    assert!((1_000..10_000).contains(&fields.len()), "{}", fields.len());
}

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
            let (mut messages, mut body, mut times) =
                (Bag::open(&path).expect("a bag").messages(&[0, 1]), vec![], vec![]);
            while let Some(head) = messages.next_into(&mut body) {
                times.push(head.log_ns / 1_000_000);
            }
            (times, messages.lost().concat())
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
fn a_folder_is_read_in_the_order_of_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let part = |name: &str, ms| {
        let bytes = written(&[("/cmd_vel", TWIST, ms, twist(1.0))], mcap::WriteOptions::new());
        fs::write(folder.path().join(name), bytes).expect("room for a file");
    };
    part("bag_10.mcap", 10);
    part("bag_9.mcap", 9);
    let times = || {
        let bag = Bag::open(folder.path()).expect("a bag");
        let (mut reader, mut body, mut times) = (bag.messages(&[0]), Vec::new(), Vec::new());
        while let Some(head) = reader.next_into(&mut body) {
            times.push(head.log_ns / 1_000_000);
        }
        (times, bag.survey().lost.clone())
    };
    assert_eq!(times(), (vec![9, 10], vec![]));
    let metadata = "info:\n  relative_file_paths:\n    - bag_10.mcap\n    - \"bag_11.mcap\"\n  duration: 1\n";
    fs::write(folder.path().join("metadata.yaml"), metadata).expect("room for a file");
    assert_eq!(times(), (vec![10, 9], vec!["bag_11.mcap is missing, although metadata.yaml lists it".to_owned()]));
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
    let error = Bag::open(&PathBuf::from("there is none.mcap")).expect_err("no bag");
    assert_eq!(error.to_string(), "cannot read there is none.mcap: No such file or directory (os error 2)");
    fs::write(folder.path().join("d.mcap.zstd"), b"").expect("room for a file");
    assert!(matches!(Bag::open(folder.path()), Err(Error::Packed(_))));
}

const PLAIN: (&str, &str) = ("p/msg/P", "int64 whole\nuint64 natural\nuint8[] codes\n");

fn plain(whole: i64, natural: u64, codes: &[u8]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.put(&whole.to_le_bytes()).put(&natural.to_le_bytes()).put(&(codes.len() as u32).to_le_bytes());
    encoder.bytes.extend(codes);
    encoder.message()
}

#[test]
fn integers_are_exact_or_left_out_and_a_missing_item_is_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let most = i64::MAX as u64;
    let bag = bag_of(
        folder.path(),
        &[
            ("/p", PLAIN, 1, plain(i64::MIN, (1 << 53) + 1, &[7])),
            ("/p", PLAIN, 2, plain(i64::MAX, most, &[])),
            ("/p", PLAIN, 3, plain(0, most + 1, &[7])),
        ],
    );
    let entry = |fields: &str| format!("[[messages]]\ntopic = \"/p\"\nfrom = \"a\"\nto = \"b\"\n{fields}");
    let text = entry(
        "fields = { whole = \"whole\", natural = \"natural\", code = { path = \"codes[0]\", symbols = { 7 = \"seven\" } } }",
    );
    let (events, notes) = read_with(&bag, &text);
    let why = "left out: the integer does not fit into 64 bits, or not exactly into a real number; the first: `natural` \
         is 9223372036854775808";
    let expected = [
        &format!("messages on /p are {why}"),
        "0 ms: 0, tick 0",
        "0 ms: 1, tick 0: a → b [-9223372036854775808, 9007199254740993, <seven>]",
        "1 ms: 2, tick 0: a → b [9223372036854775807, 9223372036854775807, <none>]",
    ];
    assert_eq!(events, expected);
    assert_eq!(notes, [format!("1 message on /p is {why}")]);
    let only = |wanted: &str| {
        let (events, _) =
            read_with(&bag, &entry(&format!("where = {{ natural = {wanted} }}\nfields = {{ whole = \"whole\" }}\n")));
        events.iter().filter(|line| line.contains('→')).count()
    };
    assert_eq!(["9007199254740992", "9007199254740993", "9007199254740992.0"].map(only), [0, 1, 0]);
}

proptest! {
    #[test]
    fn any_bytes_are_a_message_or_a_mismatch(bytes in prop::collection::vec(any::<u8>(), 0..200), is_big: bool) {
        let topic = |(kind, text): (&str, &str)| Topic {
            name: String::new(),
            kind: kind.to_owned(),
            encoding: "cdr".to_owned(),
            definition: Some(Definition { language: "ros2msg".to_owned(), text: text.to_owned() }),
        };
        let definitions = Definitions { topics: &[], folders: &[], read: &nothing };
        for kind in [TWIST, ODD] {
            let layout = definitions.layout(&topic(kind)).expect("a definition");
            let bytes = [&[0, u8::from(!is_big), 0, 0], bytes.as_slice()].concat();
            // Whether bytes are a message does not depend on which parts are wanted.
            let decoded = |want| Decoder::new(&layout, &want).decode(&bytes).map(drop);
            prop_assert_eq!(decoded(Want::All), decoded(Want::Nothing));
        }
    }
}
