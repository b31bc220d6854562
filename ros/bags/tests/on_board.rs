//! Bags without definitions, of types whose definitions are on board.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use bags::{Bag, Contents, Defined, Definition, Definitions, Survey, Topic};
use ros_messages::Base;

use crate::reading::nothing;

const RANGE: &str = "sensor_msgs/msg/Range";
/// The hashes of `Range` up to Humble and since Iron, by `rosbags`.
const RANGES: [&str; 2] = [
    "RIHS01_9430b1915b94d4268ff903679e8ecd09b6a67d331bd028738ec1eeb592891ebd",
    "RIHS01_b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
];

fn topic(kind: &str, hash: Option<&str>) -> Topic {
    let (encoding, hash) = ("cdr".to_owned(), hash.map(str::to_owned));
    Topic { name: "/a".to_owned(), kind: kind.to_owned(), encoding, definition: None, hash }
}

/// The number of fields of the type of a topic, and how its definition was chosen; or why there is none.
fn chosen(topic: &Topic, distributions: &[&str]) -> Result<(usize, Option<String>), String> {
    let distributions = distributions.iter().map(|name| (*name).to_owned()).collect();
    let survey = Survey { distributions, ..Survey::default() };
    let defined = Definitions { survey: &survey, folders: &[], read: &nothing }.defined(topic);
    let defined = defined.map_err(|undefined| format!("{undefined} ({})", undefined.help))?;
    Ok((defined.layout.fields.len(), defined.on_board))
}

#[test]
fn a_type_that_is_alike_in_all_distributions_needs_no_distribution() {
    let odometry = topic("nav_msgs/msg/Odometry", None);
    assert_eq!(chosen(&odometry, &[]), Ok((4, Some("as in dashing to lyrical".to_owned()))));
    assert_eq!(chosen(&odometry, &["rolling"]), Ok((4, Some("as in dashing to lyrical".to_owned()))));
    let event = topic("std_srvs/srv/SetBool_Event", None);
    assert_eq!(chosen(&event, &[]), Ok((3, Some("as in iron to lyrical".to_owned()))));
}

#[test]
fn a_type_that_differs_is_that_of_the_bags_distribution_or_refused() {
    let range = topic(RANGE, None);
    assert_eq!(chosen(&range, &["humble"]), Ok((6, Some("as in humble".to_owned()))));
    assert_eq!(chosen(&range, &["jazzy"]), Ok((7, Some("as in jazzy".to_owned()))));
    // Nav2 changed this one within a distribution.
    let result = topic("nav2_msgs/action/NavigateToPose_Result", None);
    let refused = [
        chosen(&range, &[]),
        chosen(&range, &["rolling"]),
        chosen(&range, &["humble", "iron"]),
        chosen(&result, &["iron"]),
        chosen(&topic("geometry_msgs/msg/VelocityStamped", None), &["humble"]),
    ];
    insta::assert_snapshot!(refused.map(|refused| refused.expect_err("its distribution is unknown")).join("\n"));
}

#[test]
fn a_hash_decides_which_form_is_meant_and_one_that_fits_none_is_refused() {
    let chosen = |hash: &str, distributions: &[&str]| chosen(&topic(RANGE, Some(hash)), distributions);
    let fields = RANGES.map(|hash| chosen(hash, &["humble"]));
    assert_eq!(fields, [6, 7].map(|fields| Ok((fields, Some("by its hash".to_owned())))));
    let refused = chosen(&RANGES[0].replace('a', "b"), &["humble"]).expect_err("it fits none");
    assert!(refused.starts_with("the bag's sensor_msgs/Range is none of those on board: its hash is"), "{refused}");
}

#[test]
fn the_bag_and_folders_have_precedence_over_what_is_on_board() {
    let range = |text: &str| {
        let definition = Some(Definition { language: "ros2msg".to_owned(), text: text.to_owned() });
        Topic { definition, ..topic(RANGE, None) }
    };
    assert_eq!(chosen(&range("int8 a\n"), &["humble"]), Ok((1, None)));
    // rosbag2 writes an empty definition if it does not find it.
    assert_eq!(chosen(&range(""), &["humble"]), Ok((6, Some("as in humble".to_owned()))));
    let read = |path: &Path| match path.ends_with("share/geometry_msgs/msg/Point.msg") {
        true => Ok(b"int8 x\n".to_vec()),
        false => nothing(path),
    };
    let survey = Survey::default();
    let definitions = Definitions { survey: &survey, folders: &["share".into()], read: &read };
    let fields = |kind: &str| {
        let Defined { layout, on_board } = definitions.defined(&topic(kind, None)).expect("it is defined");
        (layout.fields.len(), on_board.is_some())
    };
    assert_eq!(fields("geometry_msgs/msg/Point"), (1, false));
    // In nested types, too.
    let layout = definitions.layout(&topic("geometry_msgs/msg/PointStamped", None)).expect("it is defined");
    let Base::Message(point) = &layout.fields[1].kind.base else { panic!("{layout:?}") };
    assert_eq!(point.fields.len(), 1);
}

#[test]
fn a_folders_definition_is_held_against_the_bags_hash() {
    let read = |path: &Path| match path.ends_with("share/sensor_msgs/msg/Range.msg") {
        true => Ok(b"int8 a\n".to_vec()),
        false => nothing(path),
    };
    let survey = Survey::default();
    let definitions = Definitions { survey: &survey, folders: &["share".into()], read: &read };
    let layout = definitions.layout(&topic(RANGE, None)).expect("no hash speaks against it");
    assert!(definitions.layout(&topic(RANGE, Some(&layout.type_hash()))).is_ok());
    let refused = definitions.layout(&topic(RANGE, Some(RANGES[1]))).expect_err("another type was recorded");
    let begin = "the definition of sensor_msgs/Range is not the recorded one: its hash is RIHS01_";
    assert!(refused.to_string().starts_with(begin), "{refused}");
    assert!(refused.to_string().ends_with(&format!("the bag's {}", RANGES[1])), "{refused}");
}

/// An MCAP file with a topic whose definition is empty, as rosbag2 writes it in Humble, or since Iron with a hash.
fn mcap(options: mcap::WriteOptions, distribution: &str, hash: &str) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = options.profile("ros2").create(&mut bytes).expect("a writer");
    let of = |key: &str, value: &str| BTreeMap::from([(key.to_owned(), value.to_owned())]);
    let metadata = mcap::records::Metadata { name: "rosbag2".to_owned(), metadata: of("ROS_DISTRO", distribution) };
    writer.write_metadata(&metadata).expect("room for metadata");
    let schema = writer.add_schema(RANGE, "ros2msg", b"").expect("a schema");
    let channel_id = writer.add_channel(schema, "/a", "cdr", &of("topic_type_hash", hash)).expect("a channel");
    let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, &[0, 1, 0, 0]).expect("room for a message");
    writer.finish().expect("room for the end");
    drop(writer);
    bytes.into_inner()
}

#[test]
fn what_a_file_contains_about_its_types_is_read_with_and_without_a_summary() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.mcap");
    for has_summary in [true, false] {
        let options = || mcap::WriteOptions::new().emit_summary_records(has_summary);
        let surveyed = |bytes: &[u8]| {
            fs::write(&path, bytes).expect("room for a file");
            let Survey { topics, distributions, .. } = Bag::open(&path).expect("a bag").survey().clone();
            (topics[0].hash.clone(), distributions.into_iter().collect::<Vec<_>>())
        };
        assert_eq!(surveyed(&mcap(options(), "humble", "")), (None, vec!["humble".to_owned()]));
        assert_eq!(surveyed(&mcap(options(), "", RANGES[1])), (Some(RANGES[1].to_owned()), vec![]));
    }
    fs::write(folder.path().join("metadata.yaml"), "info:\n  version: 9\n  ros_distro: 'jazzy'\n").expect("room");
    let bag = Bag::open(folder.path()).expect("a bag");
    assert_eq!(bag.survey().distributions.iter().collect::<Vec<_>>(), ["jazzy"]);
    let contents = Contents::of(bag.survey(), &Definitions { survey: bag.survey(), folders: &[], read: &nothing });
    let proposal = contents.proposal().expect("the definition is on board");
    assert!(proposal.contains("type = \"sensor_msgs/msg/Range\" # defined on board, by its hash\n"), "{proposal}");
}
