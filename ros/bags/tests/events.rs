//! Messages become events on channels, with ticks between them.

use std::fs;

use bags::Bag;

use crate::messages::{Encoder, ODD, PLAIN, TWIST, odd, plain, twist};
use crate::reading::read_with;
use crate::writer::{Written, bag_of};

pub(crate) const MAPPING: &str = r#"
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

#[test]
fn an_array_is_one_item_or_a_list_of_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let odd = |ms, items: &[(&str, f32)]| ("/odd", ODD, ms, odd(false, 1, 1, items));
    let bag = bag_of(
        folder.path(),
        &[odd(1, &[("a", 1.0), ("b", f32::NAN), ("c", f32::INFINITY)]), odd(2, &[]), odd(3, &[("d", 2.0)])],
    );
    let text = "[[messages]]\ntopic = \"/odd\"\nfrom = \"a\"\nto = \"b\"\n[messages.fields]\nweights = \"items[].weight\"\n\
                names = { path = \"items[].name\", symbols = { a = \"x\", b = \"y\", c = \"z\" } }\nids = \"id[]\"\n";
    let (events, notes) = read_with(&bag, text);
    let messages: Vec<&str> = events.iter().filter_map(|line| line.split_once("→ b ")).map(|(_, rest)| rest).collect();
    assert_eq!(
        messages,
        ["[[1.0, <none>, inf], [<x>, <y>, <z>], [171, 0, 1, 255]]", "[[], [], [171, 0, 1, 255]]"],
        "{events:?}"
    );
    // The third message has a name without a symbol.
    assert_eq!(notes.len(), 1, "{notes:?}");
}

#[test]
fn each_item_of_an_array_is_a_message_at_the_time_of_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let odd = |log_ms, ms, items: &[(&str, f32)]| ("/odd", ODD, log_ms, odd(false, ms, 1, items));
    let bag = bag_of(
        folder.path(),
        &[
            odd(1, 3000, &[("a", 1.0), ("b", 2.0), ("a", f32::NAN)]),
            odd(2, 3200, &[]),
            // This one was recorded too late; one of its items is unknown.
            odd(3, 3100, &[("b", 0.5), ("c", 1.0), ("a", 0.25)]),
            ("/odd", ODD, 4, odd(4, 3300, &[("a", 3.0)]).3[..60].to_vec()),
        ],
    );
    let entry = "[[messages]]\ntopic = \"/odd\"\nfrom = \"a\"\nto = \"b\"\n";
    let text = format!(
        "time = \"header.stamp\"\n{entry}each = \"items\"\nwhere = {{ \"/mode\" = 1, name = [\"a\", \"c\"] }}\n\
         fields = {{ name = {{ path = \"name\", symbols = {{ a = \"x\" }} }}, weight = \"weight\", frame = \"/header.frame_id\", \
         all = \"/items[].weight\" }}\n"
    );
    let (events, notes) = read_with(&bag, &text);
    let expected = [
        "items of `items` in messages on /odd are left out: the mapping has no symbol for the value; the first: `name` is c",
        "0 ms: 0, tick 0",
        "0 ms: 1, tick 0: a → b [<x>, 1.0, \"map\", [1.0, 2.0, <none>]]",
        "0 ms: 2, tick 0: a → b [<x>, <none>, \"map\", [1.0, 2.0, <none>]]",
        "100 ms: 3, tick 0: a → b [<x>, 0.25, \"map\", [0.5, 1.0, 0.25]]",
    ];
    assert_eq!(events, expected);
    let expected = [
        "1 message on /odd is left out: the bytes do not fit the definition: they end before their definition does; the \
         first: 0.003 s after the first message of the bag",
        "1 item of `items` in messages on /odd is left out: the mapping has no symbol for the value; the first: `name` is c",
    ];
    assert_eq!(notes, expected);
    // Constants alone count the items.
    let (events, notes) = read_with(&bag, &format!("{entry}each = \"items\"\nfields = {{ x = {{ value = 1 }} }}\n"));
    assert_eq!((events.iter().filter(|line| line.contains('→')).count(), notes.len()), (6, 1), "{events:?}");
}

#[test]
fn messages_that_do_not_fit_their_definition_are_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let wrong = ("std_msgs/msg/String", "float64[10] x\n");
    let messages: Vec<Written<'_>> = (0..100).map(|ms| ("/b", wrong, ms, vec![0, 1, 0, 0, 1, 0, 0, 0, 0])).collect();
    let text = "[[messages]]\ntopic = \"/b\"\nfrom = \"b\"\nto = \"m\"\nfields = { x = \"x[0]\" }\n";
    let (events, notes) = read_with(&bag_of(folder.path(), &messages), text);
    let why = "are left out: the bytes do not fit the definition: they end before their definition does; the first: \
               0.000 s after the first message of the bag";
    assert_eq!(events, [format!("messages on /b {why}")]);
    assert_eq!(notes, [format!("100 messages on /b {why}")]);
}

/// Messages of a bag are in the order in which they were recorded, but stamps need not be.
#[test]
fn what_a_message_could_change_that_comes_too_late_is_unsure() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "tick_s = 10\nreorder_s = 0.5\ntime = \"header.stamp\"\n[[messages]]\ntopic = \"/odd\"\nfrom = \"a\"\n\
                to = \"b\"\nfields = { mode = \"mode\" }\n";
    let read = |stamps: &[u32]| {
        let messages = stamps.iter().zip(0..).map(|(ms, at)| ("/odd", ODD, at, odd(false, *ms, 1, &[])));
        let (events, notes) = read_with(&bag_of(folder.path(), &messages.collect::<Vec<_>>()), text);
        let lines = events.iter().map(|line| line.split(": ").next().unwrap_or_default().to_owned());
        (lines.collect::<Vec<_>>(), notes)
    };
    let late = "up to 4.000 s too late and gets the time of what has come before; what this could change is unsure; \
                `reorder_s` sets how long to wait";
    let (lines, notes) = read(&[1000, 6000, 7000, 2000, 8000]);
    let since = "a message a → b comes 4.000 s too late to be put in order since Some(1.000000001s)";
    assert_eq!(lines, ["0 ms", "0 ms", "5000 ms", since, "5000 ms", "a → b goes on", "6000 ms", "7000 ms"]);
    assert_eq!(notes, [format!("1 message comes {late}")]);
    // The run began with a message that is judged after others.
    let (lines, notes) = read(&[5000, 6000, 1000, 8000]);
    let since = "a message a → b comes 4.000 s too late to be put in order";
    assert_eq!(lines, ["0 ms", "0 ms", since, "0 ms", "1000 ms", "3000 ms"]);
    assert_eq!(notes, [format!("1 message comes {late}")]);
}

#[test]
fn one_message_with_a_wrong_time_is_left_out_and_not_the_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let mapping = "[[messages]]\ntopic = \"/cmd_vel\"\nfrom = \"a\"\nto = \"b\"\nfields = { x = \"linear.x\" }\n";
    let since_1970 = 1_700_000_000_000;
    let wrong = |count: u64| (0..count).map(|at| ("/cmd_vel", TWIST, at, twist(9.0)));
    let right = (0..3).map(|at| ("/cmd_vel", TWIST, since_1970 + at * 100, twist(at as f64)));
    let messages: Vec<_> = wrong(2).chain(right).collect();
    let (events, notes) = read_with(&bag_of(folder.path(), &messages), mapping);
    let expected = [
        "messages on /cmd_vel are left out: the stamp is 0, or far from those of other messages; the first: 0.000 s",
        "0 ms: 0, tick 0",
        "0 ms: 1, tick 0: a → b [0.0]",
        "100 ms: 2, tick 0: a → b [1.0]",
        "200 ms: 3, tick 0: a → b [2.0]",
    ];
    assert_eq!(events, expected);
    assert_eq!(notes, [format!("2 {}", expected[0])]);
}

#[test]
fn ticks_end_with_the_last_time_that_there_is_and_messages_from_then_on_are_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let mapping = "tick_s = 1\n[[messages]]\ntopic = \"/cmd_vel\"\nfrom = \"a\"\nto = \"b\"\n\
                   fields = { x = \"linear.x\" }\n";
    let read = |times: &[u64]| {
        let messages: Vec<Written<'_>> = times.iter().map(|ms| ("/cmd_vel", TWIST, *ms, twist(1.0))).collect();
        read_with(&bag_of(folder.path(), &messages), mapping)
    };
    let (last, latest) = (i64::MAX.unsigned_abs() / 1_000_000, u64::MAX / 1_000_000);
    let why = "left out: the time is the first or the last that fits into 64 bits, or later; the first: 2262-04-11 23:47:16.854 UTC";
    let (mut events, notes) = read(&[last - 2000, last, last + 1, latest]);
    events.retain(|line| line.contains("tick"));
    let expected = [
        "0 ms: 0, tick 0",
        "0 ms: 1, tick 0: a → b [1.0]",
        "1000 ms: 1, tick 1",
        "2000 ms: 1, tick 2",
        "2000 ms: 2, tick 2: a → b [1.0]",
    ];
    assert_eq!(events, expected);
    assert_eq!(notes, [format!("2 messages on /cmd_vel are {why}")]);
    for time in [last + 1, latest] {
        let (events, notes) = read(&[time]);
        assert_eq!(events, [format!("messages on /cmd_vel are {why}")]);
        assert_eq!(notes, [format!("1 message on /cmd_vel is {why}")]);
    }
}

/// In ROS, each character has four bytes; other programs write two.
#[test]
fn the_distribution_that_a_bag_names_decides_how_wide_strings_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    // Two characters, the first of which is 0, fit with both widths, and what follows them differs.
    let mut encoder = Encoder::default();
    for number in [2_i32, 0, 97, 5, 6] {
        encoder.put(&number.to_le_bytes());
    }
    let wide = ("p/msg/Wide", "wstring text\nint32 x\nint32 y\n");
    let unnamed = bag_of(folder.path(), &[("/wide", wide, 1, encoder.message())]);
    let mapping = "[[messages]]\ntopic = \"/wide\"\nfrom = \"a\"\nto = \"b\"\nfields = { x = \"x\", y = \"y\" }\n";
    let (events, notes) = read_with(&unnamed, mapping);
    assert!(events.iter().all(|line| !line.contains('→')), "{events:?}");
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].contains("it is not known how wide the characters of their wide strings are"), "{notes:?}");
    let metadata = "info:\n  ros_distro: jazzy\n  relative_file_paths:\n  - bag.mcap\n  duration: 1\n";
    fs::write(folder.path().join("metadata.yaml"), metadata).expect("room for a file");
    let named = Bag::open(folder.path()).expect("a bag");
    let (events, notes) = read_with(&named, mapping);
    assert_eq!(events, ["0 ms: 0, tick 0", "0 ms: 1, tick 0: a → b [5, 6]"]);
    assert!(notes.is_empty(), "{notes:?}");
}
