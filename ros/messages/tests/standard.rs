//! The types of ROS's common packages that are Rust types.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use ros_messages::standard::{
    BatteryState, CancelRequest, CancelResponse, Clock, CompressedImage, Contacts, Entity, GoalResponse, GoalStatuses,
    Image, JointState, JointWrench, LaserScan, LifecycleState, Log, Marker, Markers, NavigateToPoseFeedbackMessage,
    NavigateToPoseGoal, NavigateToPoseResultResponse, OccupancyGrid, Odometry, Particles, Path, PointCloud,
    PoseStamped, PoseWithCovarianceStamped, Statuses, Text, Time, Transforms, TwistStamped,
};
use ros_messages::{Bundle, CdrReader, CdrWriter, Layout, Message, Mismatch, RosMessage, RosType, TypeName, Undefined};

use crate::encoding;

/// The type by its own definition.
fn layout<T: RosMessage>() -> Arc<Layout> {
    let Bundle { message, types } = T::definition();
    let types: BTreeMap<_, _> = types.into_iter().chain([(T::name(), message)]).collect();
    Layout::resolve(&T::name(), &mut |name| Ok(types[name].clone())).expect("all types are defined")
}

/// The type as a distribution has it.
fn of_edition(name: &TypeName, edition: &str) -> Arc<Layout> {
    let undefined = || Undefined::new("it is not on board".to_owned(), "");
    Layout::resolve(name, &mut |name| Message::known(name, Some(edition)).ok_or_else(undefined)).expect("a type")
}

/// Checks the type against its definition in a distribution, and both directions of its encoding against those that
/// are made from the definition.
fn check<T: RosMessage + Debug + PartialEq>(edition: Option<&str>) {
    let layout = layout::<T>();
    if let Some(edition) = edition {
        assert_eq!(layout.type_hash(), of_edition(&T::name(), edition).type_hash(), "{}", T::name());
    }
    let messages = encoding::value(&layout);
    let mut runner = TestRunner::new(ProptestConfig { cases: 8, ..ProptestConfig::default() });
    let checked = runner.run(&messages, |message| {
        let bytes = layout.encode(&message).expect("it is a message of that type");
        let decoded = T::decode(&bytes).expect("it is one");
        prop_assert_eq!(decoded.encode(), &bytes[..]);
        // What follows is ignored, and what is cut off is refused.
        let longer = T::decode(&[&bytes[..], &[7; 9]].concat()).expect("it begins with one");
        prop_assert_eq!(longer.encode(), &bytes[..]);
        for length in 4..bytes.len() {
            prop_assert_eq!(T::decode(&bytes[..length]), Err(Mismatch::Short));
        }
        Ok(())
    });
    checked.unwrap_or_else(|failure| panic!("{}: {failure}", T::name()));
}

/// A recording states that it comes from Humble.
#[test]
fn the_types_are_those_of_humble_in_both_directions() {
    let humble = Some("humble");
    check::<Text>(humble);
    check::<PoseStamped>(humble);
    check::<Transforms>(humble);
    check::<TwistStamped>(humble);
    check::<LaserScan>(humble);
    check::<PointCloud>(humble);
    check::<Image>(humble);
    check::<CompressedImage>(humble);
    check::<BatteryState>(humble);
    check::<JointState>(humble);
    check::<OccupancyGrid>(humble);
    check::<Path>(humble);
    check::<Odometry>(humble);
    check::<PoseWithCovarianceStamped>(humble);
    check::<Clock>(humble);
    check::<Markers>(humble);
    check::<Statuses>(humble);
    check::<Log>(humble);
    check::<LifecycleState>(humble);
    check::<GoalStatuses>(humble);
    check::<CancelRequest>(humble);
    check::<CancelResponse>(humble);
    check::<Particles>(humble);
}

#[test]
fn the_action_of_nav2_is_that_of_jazzy_in_both_directions() {
    let jazzy = Some("jazzy");
    check::<GoalResponse>(jazzy);
    check::<NavigateToPoseGoal>(jazzy);
    check::<NavigateToPoseResultResponse>(jazzy);
    check::<NavigateToPoseFeedbackMessage>(jazzy);
}

/// The definitions of Gazebo are not on board: these are those of `gazebosim/ros_gz`, without comments.
#[test]
fn contacts_are_those_of_gazebo_in_both_directions() {
    check::<Contacts>(None);
    let fields = |message: &Message| message.fields.clone();
    let definition = |text: &str| fields(&Message::parse("Test.msg", text).expect("a definition"));
    let entity = "uint64 id\nstring name\nuint8 type\n";
    assert_eq!(fields(&Entity::definition().message), definition(entity));
    let wrench = "std_msgs/Header header\nstd_msgs/String body_1_name\nstd_msgs/UInt32 body_1_id\n\
                  std_msgs/String body_2_name\nstd_msgs/UInt32 body_2_id\ngeometry_msgs/Wrench body_1_wrench\n\
                  geometry_msgs/Wrench body_2_wrench\n";
    assert_eq!(fields(&JointWrench::definition().message), definition(wrench));
}

#[test]
fn a_definition_has_each_nested_type_once() {
    let rule = "=".repeat(80);
    let expected = format!(
        "std_msgs/Header header\ngeometry_msgs/Pose pose\n{rule}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n\
         string frame_id\n{rule}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n{rule}\nMSG: \
         geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n{rule}\nMSG: \
         geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n{rule}\nMSG: geometry_msgs/Quaternion\nfloat64 x\n\
         float64 y\nfloat64 z\nfloat64 w\n"
    );
    assert_eq!(PoseStamped::definition().to_string(), expected);
    assert!(Marker::definition().to_string().contains("int32 type\n"));
}

#[test]
fn numbers_are_aligned_to_their_size_after_the_encoding() {
    let log = Log { level: 7, name: "a".to_owned(), line: 9, ..Log::default() };
    let text = [1, 0, 0, 0, 0, 0, 0, 0];
    let expected =
        [&[0, 1, 0, 0][..], &[0; 8], &[7, 0, 0, 0], &[2, 0, 0, 0, b'a', 0, 0, 0], &text, &text, &text, &[9, 0, 0, 0]];
    assert_eq!(log.encode(), expected.concat());
    let mut cdr = CdrWriter::reusing(Vec::new());
    1_u8.write(&mut cdr);
    2.0_f64.write(&mut cdr);
    assert_eq!(cdr.bytes(), [&[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0][..], &2.0_f64.to_le_bytes()].concat());
}

#[test]
fn messages_are_also_read_big_endian() {
    assert_eq!(Time::decode(&[0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 1, 2]), Ok(Time { sec: 5, nanosec: 258 }));
    let list = [0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 2];
    assert_eq!(Vec::<u16>::decode(&list), Ok(vec![1, 2]));
    assert_eq!(<[u16; 2]>::decode(&[0, 0, 0, 0, 0, 1, 0, 2]), Ok([1, 2]));
    assert_eq!(Vec::<u16>::decode(&[0, 7, 0, 0, 0, 0, 0, 0]), Err(Mismatch::Encoding));
}

#[test]
fn no_memory_is_reserved_for_what_a_message_only_claims_to_have() {
    let claims = [&[0, 1, 0, 0][..], &u32::MAX.to_le_bytes(), &[0; 8]].concat();
    assert_eq!(Vec::<f64>::decode(&claims), Err(Mismatch::Short));
    assert_eq!(Transforms::decode(&claims), Err(Mismatch::Short));
    // After a failure, there is nothing more to read, not even an empty array.
    let mut cdr = CdrReader::new(&[0, 1, 0, 0, 1]).expect("CDR");
    assert_eq!((u8::read(&mut cdr), f64::read(&mut cdr)), (Ok(1), Err(Mismatch::Short)));
    assert_eq!(Vec::<f64>::read(&mut cdr), Err(Mismatch::Short));
    assert_eq!(f64::read_all(0, &mut cdr), Ok(vec![]));
}

#[test]
fn times_count_from_1970() {
    for (ns, sec, nanosec) in [(1_500_000_000, 1, 500_000_000), (-1, -1, 999_999_999)] {
        assert_eq!((Time::of_ns(ns), Time { sec, nanosec }.ns()), (Time { sec, nanosec }, ns));
    }
    assert_eq!(Time::of_ns(i64::MAX).sec, i32::MAX);
}
