//! What a bag contains: its topics, their types, and times.

use std::fs;
use std::path::{Path, PathBuf};

use bags::{Bag, Contents, Definition, Definitions, Survey, Topic, moment, seconds};
use proptest::prelude::*;
use ros_messages::{Decoder, Want};

use crate::messages::{ODD, PLAIN, TWIST, odd, plain, twist};
use crate::reading::nothing;
use crate::writer::{Written, bag_of, written};

fn contents(bag: &Bag) -> Contents {
    Contents::of(bag.survey(), &Definitions { survey: bag.survey(), folders: &[], read: &nothing })
}

#[test]
fn topics_are_listed_by_name_with_their_types_rates_and_fields() {
    let folder = tempfile::tempdir().expect("a folder");
    let undefined = ("odd_msgs/action/Go_FeedbackMessage", "");
    let messages: [Written<'_>; 5] = [
        ("/turn", PLAIN, 1_000, plain(1, 2, &[])),
        ("/cmd_vel", TWIST, 1_500, twist(0.5)),
        ("/cmd_vel", TWIST, 2_500, twist(0.5)),
        ("/unknown", undefined, 2_600, vec![0, 1, 0, 0]),
        ("/cmd_vel", TWIST, 3_000, twist(0.5)),
    ];
    let contents = contents(&bag_of(folder.path(), &messages));
    assert_eq!((contents.start_ns, contents.duration_s), (Some(1_000_000_000), 2.0));
    assert!(contents.lost.is_empty(), "{:?}", contents.lost);
    let listed = contents.topics.iter().map(|topic| (&*topic.name, &*topic.kind, topic.messages, topic.rate_hz));
    let expected = [
        // The topic's own time counts: a slow one need not come as soon as the recording begins.
        ("/cmd_vel", "geometry_msgs/msg/Twist", 3, Some(2.0 / 1.5)),
        ("/turn", "p/msg/P", 1, None),
        ("/unknown", "odd_msgs/action/Go_FeedbackMessage", 1, None),
    ];
    assert_eq!(listed.collect::<Vec<_>>(), expected);
    let fields = |topic: usize| {
        let fields = contents.topics[topic].fields.as_ref();
        fields.map(|fields| fields.iter().map(|(path, what)| format!("{path}: {what}")).collect::<Vec<_>>())
    };
    assert_eq!(fields(1), Ok(vec!["whole: an integer".into(), "natural: an integer".into()]));
    assert_eq!(fields(0).map(|fields| fields.len()), Ok(6));
    let missing = fields(2).expect_err("the bag does not define it");
    assert!(missing.starts_with("there is no definition of odd_msgs/Go_FeedbackMessage"), "{missing}");
    // What cannot be mapped is not proposed.
    let proposal = contents.proposal().expect("the other topics can be mapped");
    assert!(proposal.contains("/cmd_vel") && !proposal.contains("/unknown"), "{proposal}");
}

#[test]
fn a_type_that_cannot_be_decoded_says_why() {
    let topic = |kind: &str, encoding: &str, definition: Option<(&str, &str)>| Topic {
        name: "/a".to_owned(),
        kind: kind.to_owned(),
        encoding: encoding.to_owned(),
        definition: definition.map(|(language, text)| Definition { language: language.into(), text: text.into() }),
        hash: None,
    };
    let refused = |topic: Topic| {
        let definitions = Definitions { survey: &Survey::default(), folders: &[], read: &nothing };
        definitions.layout(&topic).expect_err("it cannot be decoded").to_string()
    };
    let all = [
        topic("p/msg/P", "json", None),
        topic("p/msg", "cdr", None),
        topic("p/msg/P", "cdr", None),
        topic("p/msg/P", "cdr", Some(("protobuf", "message P {}"))),
        topic("p/msg/P", "cdr", Some(("ros2msg", "float65 x\n"))),
        topic("p/msg/P", "cdr", Some(("ros2msg", "Other x\n"))),
    ]
    .map(refused);
    insta::assert_snapshot!(all.join("\n"));
}

#[test]
fn a_type_is_defined_in_the_bag_by_another_topic_or_in_a_folder() {
    let known = Topic {
        name: "/odd".to_owned(),
        kind: ODD.0.to_owned(),
        encoding: "cdr".to_owned(),
        definition: Some(Definition { language: "ros2msg".to_owned(), text: ODD.1.to_owned() }),
        hash: None,
    };
    let item = Topic { kind: "odd_msgs/msg/Item".to_owned(), definition: None, ..known.clone() };
    let layout = |topics: &[Topic], folders: &[PathBuf]| {
        let read = |path: &Path| match path.ends_with("share/odd_msgs/msg/Item.msg") {
            true => Ok(b"string name\nfloat32 weight\n".to_vec()),
            false => nothing(path),
        };
        let survey = Survey { topics: topics.to_vec(), ..Survey::default() };
        Definitions { survey: &survey, folders, read: &read }.layout(&item).map(|layout| layout.fields.len())
    };
    assert!(layout(&[], &[]).is_err());
    assert_eq!(layout(&[known], &[]).ok(), Some(2));
    assert_eq!(layout(&[], &["share".into()]).ok(), Some(2));
}

#[test]
fn a_type_may_be_defined_in_idl() {
    let text = "================================================================================\nIDL: p/msg/P\n\
                module p {\n  module msg {\n    struct P {\n      double x;\n    };\n  };\n};\n";
    let topic = Topic {
        name: "/p".to_owned(),
        kind: "p/msg/P".to_owned(),
        encoding: "cdr".to_owned(),
        definition: Some(Definition { language: "ros2idl".to_owned(), text: text.to_owned() }),
        hash: None,
    };
    let definitions = Definitions { survey: &Survey::default(), folders: &[], read: &nothing };
    let layout = definitions.layout(&topic).unwrap();
    assert_eq!(layout.fields.iter().map(|field| &*field.name).collect::<Vec<_>>(), ["x"]);
}

/// Without a summary, the whole file is read.
#[test]
fn the_contents_do_not_depend_on_whether_a_file_has_a_summary() {
    let folder = tempfile::tempdir().expect("a folder");
    let messages = [("/cmd_vel", TWIST, 4_000, twist(1.0)), ("/odd", ODD, 3_000, odd(true, 1, 1, &[]))];
    let surveyed = |options: mcap::WriteOptions| {
        let path = folder.path().join("bag.mcap");
        fs::write(&path, written(&messages, options)).expect("room for a file");
        let survey = Bag::open(&path).expect("a bag").survey().clone();
        (survey.topics, survey.counts, survey.span_ns)
    };
    let (topics, counts, span_ns) = surveyed(mcap::WriteOptions::new());
    assert_eq!(surveyed(mcap::WriteOptions::new().emit_summary_records(false)), (topics.clone(), counts, span_ns));
    assert_eq!(topics.iter().map(|topic| &*topic.name).collect::<Vec<_>>(), ["/cmd_vel", "/odd"]);
    assert_eq!(span_ns, Some((3_000_000_000, 4_000_000_000)));
}

#[test]
fn only_the_wanted_messages_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let topic = |ms: u64| {
        if ms.is_multiple_of(3) { ("/cmd_vel", TWIST, ms, twist(1.0)) } else { ("/p", PLAIN, ms, plain(1, 1, &[])) }
    };
    let bag = bag_of(folder.path(), &(0..30).map(topic).collect::<Vec<_>>());
    for (index, name) in ["/cmd_vel", "/p"].iter().enumerate() {
        assert_eq!(bag.survey().topics[index].name, *name);
        let (mut messages, mut body, mut count) = (bag.messages(&[index]), Vec::new(), 0);
        while let Some(head) = messages.next_into(&mut body) {
            assert_eq!((head.topic, head.publish_ns), (index, head.log_ns + 1));
            count += 1;
        }
        assert_eq!((count, bag.survey().counts[index]), ([10, 20][index], [10, 20][index]));
    }
}

#[test]
fn times_in_seconds_are_exact() {
    let exact = [0, 1, -1, 1_760_000_000_030_000_000, i64::MAX, i64::MIN].map(seconds);
    let expected = ["0.000000000", "0.000000001", "-0.000000001", "1760000000.030000000"];
    assert_eq!(exact[..4], expected);
    assert_eq!(exact[4..], ["9223372036.854775807", "-9223372036.854775808"]);
}

#[test]
fn a_clock_that_does_not_count_from_1970_has_no_dates() {
    let moments = [0, 5_250_000_000, 1_760_000_000_030_000_000].map(moment);
    assert_eq!(moments, ["0.000 s", "5.250 s", "2025-10-09 08:53:20.030 UTC"]);
}

/// Such a type has 2⁴⁰ fields.
#[test]
fn of_a_type_with_endlessly_many_fields_the_first_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let pair = |depth: usize| format!("T{depth} a\nT{depth} b\n===\nMSG: p/T{depth}\n");
    let definition = (1..=40).map(pair).collect::<String>() + "uint8 x\n";
    let bag = bag_of(folder.path(), &[("/deep", ("p/msg/T0", definition.as_str()), 1, Vec::new())]);
    let contents =
        Contents::of(bag.survey(), &Definitions { survey: &Survey::default(), folders: &[], read: &nothing });
    let fields = contents.topics[0].fields.as_ref().expect("its definition is known");
    assert!((1_000..10_000).contains(&fields.len()), "{}", fields.len());
}

proptest! {
    #[test]
    fn any_bytes_are_a_message_or_a_mismatch(bytes in prop::collection::vec(any::<u8>(), 0..200), is_big: bool) {
        let topic = |(kind, text): (&str, &str)| Topic {
            name: String::new(),
            kind: kind.to_owned(),
            encoding: "cdr".to_owned(),
            definition: Some(Definition { language: "ros2msg".to_owned(), text: text.to_owned() }),
            hash: None,
        };
        let definitions = Definitions { survey: &Survey::default(), folders: &[], read: &nothing };
        for kind in [TWIST, ODD] {
            let layout = definitions.layout(&topic(kind)).expect("a definition");
            let bytes = [&[0, u8::from(!is_big), 0, 0], bytes.as_slice()].concat();
            // Whether bytes are a message does not depend on which parts are wanted.
            let decoded = |want| Decoder::new(&layout, &want).decode(&bytes).map(drop);
            prop_assert_eq!(decoded(Want::All), decoded(Want::Nothing));
        }
    }
}
