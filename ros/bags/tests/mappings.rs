//! Mappings: those that do not fit, and those that are proposed.

use std::path::Path;

use bags::{Contents, Definitions, Survey};
use channels::{Capacity, Domain, FieldKind, Shape, Topology};

use crate::messages::{BEHAVIOR_TREE_LOG, ODD, TWIST, behavior_tree_log, odd, twist};
use crate::reading::{mapping, nothing, read_with};
use crate::writer::bag_of;

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
    let each = |each: &str| problems("/odd", &format!("\"name\"\neach = \"{each}\""));
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
        problems("/odd", "\"mode[]\""),
        problems("/odd", "\"mode\"\nwhere = { \"items[].name\" = \"a\" }"),
        problems("/go", "\"goal_id.uuid\""),
        each("items"),
        each("item"),
        each("mode"),
        each("items[0]"),
        each("items[]"),
        each("id"),
        problems("/odd", "\"mode\"\neach = \"items\""),
        problems("/odd", "\"/mod\"\neach = \"items\""),
        problems("/odd", "\"name\"\neach = \"items\"\ntime = \"name\""),
    ];
    insta::assert_snapshot!(all.concat());
    let text = "[[messages]]\ntopic = \"/a\"\ntype = \"foo\"\nfrom = \"a\"\nto = \"b\"\nfields = { x = \"y\" }\n";
    let problem = mapping(text).compile(bag.survey(), None, &nothing).expect_err("no type").plain();
    assert!(problem.starts_with("mapping.toml:3:8: `foo` is not the name of a type"), "{problem}");
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
    let contents =
        Contents::of(bag.survey(), &Definitions { survey: &Survey::default(), folders: &[], read: &nothing });
    let proposal = contents.proposal().expect("there are fields");
    insta::assert_snapshot!(proposal);
    let (events, notes) = read_with(&bag, &proposal);
    assert_eq!((events.len(), notes.len()), (4, 0), "{events:?}");
}

/// Of an array, the last item alone would be judged.
#[test]
fn the_proposed_mapping_covers_every_item_of_every_array() {
    let folder = tempfile::tempdir().expect("a folder");
    let definition = "uint8 level\nStatus[] status\nMotor[2] motors\n===\nMSG: p/Status\nbyte ERROR=2\nstring name\n\
                      KeyValue[] values\n===\nMSG: p/KeyValue\nstring key\n===\nMSG: p/Motor\nuint8 id\nuint8[] codes\n";
    let text = |text: &str| [&(text.len() as u32 + 1).to_le_bytes()[..], text.as_bytes(), &[0]].concat();
    let count = |count: u32| count.to_le_bytes().to_vec();
    let status = [text("abc"), count(2), text("abc"), text("xyz"), text("def"), count(1), text("ghi")].concat();
    let motors = [[&[1, 0, 0, 0][..], &count(0)].concat(), [&[2, 0, 0, 0][..], &count(0)].concat()].concat();
    let body = [&[0, 1, 0, 0][..], &[5, 0, 0, 0], &count(2), &status, &motors].concat();
    let bag = bag_of(folder.path(), &[("/diagnostics", ("p/msg/D", definition), 1, body)]);
    let contents =
        Contents::of(bag.survey(), &Definitions { survey: &Survey::default(), folders: &[], read: &nothing });
    let proposal = contents.proposal().expect("there are fields");
    insta::assert_snapshot!(proposal);
    let (events, notes) = read_with(&bag, &proposal);
    assert_eq!(notes, [""; 0]);
    let messages: Vec<&str> =
        events.iter().filter_map(|line| line.split_once(": ")?.1.split_once(": ")).map(|(_, rest)| rest).collect();
    let expected = [
        "diagnostics → monitor [5]",
        "diagnostics_status → monitor [\"abc\", [\"abc\", \"xyz\"]]",
        "diagnostics_status → monitor [\"def\", [\"ghi\"]]",
        "diagnostics_motors → monitor [1]",
        "diagnostics_motors → monitor [2]",
    ];
    assert_eq!(messages, expected);
}

#[test]
fn what_each_item_contains_is_proposed_as_a_message_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = ("nav2_msgs/msg/BehaviorTreeLog", BEHAVIOR_TREE_LOG);
    let bag = bag_of(folder.path(), &[("/behavior_tree_log", log, 1, behavior_tree_log(&["a", "b"]))]);
    let contents =
        Contents::of(bag.survey(), &Definitions { survey: &Survey::default(), folders: &[], read: &nothing });
    let proposal = contents.proposal().expect("there are fields");
    assert!(proposal.contains("each = \"event_log\"\n[messages.fields]\nnode_name = \"node_name\"\n"), "{proposal}");
    let (events, notes) = read_with(&bag, &proposal);
    assert_eq!((events.len(), notes.len()), (3, 0), "{events:?}");
}

#[test]
fn a_condition_on_a_value_that_a_field_never_has_is_refused() {
    const ALL: (&str, &str) = (
        "odd_msgs/msg/All",
        "bool b\nint64 v\nuint8 mode\nfloat32 narrow\nfloat64 wide\nstring<=3 short\nstring s\nuint8[2] id\n\
         builtin_interfaces/Time stamp\n",
    );
    let folder = tempfile::tempdir().expect("a folder");
    let bag = bag_of(folder.path(), &[("/all", ALL, 1, vec![])]);
    let problems = |test: &str| {
        let text = format!(
            "[[messages]]\ntopic = \"/all\"\nfrom = \"a\"\nto = \"b\"\nwhere = {{ {test} }}\nfields.x = \"v\"\n"
        );
        mapping(&text).compile(bag.survey(), None, &nothing).err().map(|problems| problems.plain()).unwrap_or_default()
    };
    let possible =
        ["b = true", "v = -8", "v = 8.0", "v = [1, 2]", "mode = 255", "narrow = 0.5", "narrow = 3", "wide = 0.1"];
    let texts = ["short = 'abc'", "s = 'long enough'", "s = ''", "id = '0aff'", "stamp = 1.5"];
    for test in possible.into_iter().chain(texts) {
        assert_eq!(problems(test), "", "{test}");
    }
    let never = ["b = 1", "b = 'true'", "v = '8'", "v = 8.5", "v = true", "v = []", "v = [1, 2.5, 'a']", "mode = 256"];
    let others =
        ["narrow = 0.1", "narrow = 'a'", "wide = '1'", "short = 'abcd'", "s = 8", "id = '0AFF'", "stamp = 'now'"];
    let all: Vec<String> = never.into_iter().chain(others).map(problems).collect();
    insta::assert_snapshot!(all.concat());
}

#[test]
fn of_a_topic_with_several_types_an_entry_with_a_type_is_for_the_messages_of_that_type() {
    let folder = tempfile::tempdir().expect("a folder");
    let other = ("p/msg/Other", "float64 x\n");
    let messages = [("/a", TWIST, 0, twist(0.5)), ("/a", other, 1, [vec![0, 1, 0, 0], vec![0; 8]].concat())];
    let bag = bag_of(folder.path(), &messages);
    let entry = |kind: &str, to: &str, path: &str| {
        format!("[[messages]]\ntopic = \"/a\"\ntype = \"{kind}\"\nfrom = \"a\"\nto = \"{to}\"\nfields.x = \"{path}\"\n")
    };
    let twists = entry(TWIST.0, "b", "linear.x");
    let (lines, notes) = read_with(&bag, &twists);
    assert_eq!(lines[1..], ["0 ms: 0, tick 0", "0 ms: 1, tick 0: a → b [0.5]"], "{lines:?}");
    let left_out =
        "1 message on /a is left out: the mapping does not fit the topic; the first: the messages on /a are of";
    assert_eq!(notes, [format!("{left_out} p/msg/Other")]);
    // Both can be mapped.
    let (lines, notes) = read_with(&bag, &(twists + &entry("p/msg/Other", "c", "x")));
    assert_eq!(lines.last().map(String::as_str), Some("1 ms: 2, tick 0: a → c [0.0]"), "{lines:?}");
    assert_eq!(notes, [""; 0]);
}
