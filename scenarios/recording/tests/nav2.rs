//! The records of a tree whose statuses Nav2 wrote into a bag.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use bt::{Status, Tree};
use channels::{EventKind, Flaw, Gap};
use mcap::records::MessageHeader;
use recording::{BagTree, Happening, LogError, Recording, RecordingError, RunView};
use ros_messages::{RosMessage, messages};
use tree_logs::{Log as TreeLog, LogEntry, NodeStatus};

messages! {
    Time = "builtin_interfaces/Time" { sec: i32, nanosec: u32 }
    Change = "nav2_msgs/BehaviorTreeStatusChange" {
        timestamp: Time,
        node_name: String,
        uid: u16,
        previous_status: String,
        current_status: String,
    }
    Log = "nav2_msgs/BehaviorTreeLog" { timestamp: Time, event_log: Vec<Change> }
    OldChange = "nav2_msgs/BehaviorTreeStatusChange" {
        timestamp: Time,
        node_name: String,
        previous_status: String,
        current_status: String,
    }
    OldLog = "nav2_msgs/BehaviorTreeLog" { timestamp: Time, event_log: Vec<OldChange> }
}

const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
<BehaviorTree ID="Main"><Sequence name="Navigate"><ComputePathToPose/><SubTree ID="Drive"/></Sequence></BehaviorTree>
<BehaviorTree ID="Drive"><FollowPath/></BehaviorTree></root>"#;

/// Seconds after the first message, and the changes then: node, number, status before and after.
type Tick<'t> = (f64, &'t [(&'t str, u16, &'t str, &'t str)]);

/// A goal of three ticks: what the last one changed waits for the next goal.
const BEGIN: Tick<'_> = (0.0, &[("Navigate", 1, "IDLE", "RUNNING"), ("ComputePathToPose", 2, "IDLE", "RUNNING")]);
const GO: Tick<'_> = (
    1.0,
    &[
        ("ComputePathToPose", 2, "RUNNING", "SUCCESS"),
        ("Drive", 3, "IDLE", "RUNNING"),
        ("FollowPath", 4, "IDLE", "RUNNING"),
    ],
);
const AGAIN: Tick<'_> = (
    9.0,
    &[
        ("FollowPath", 4, "RUNNING", "SUCCESS"),
        ("FollowPath", 4, "SUCCESS", "IDLE"),
        ("Drive", 3, "RUNNING", "SUCCESS"),
        ("Drive", 3, "SUCCESS", "IDLE"),
        ("ComputePathToPose", 2, "SUCCESS", "IDLE"),
        ("Navigate", 1, "RUNNING", "SUCCESS"),
        ("Navigate", 1, "SUCCESS", "IDLE"),
        ("Navigate", 1, "IDLE", "RUNNING"),
        ("ComputePathToPose", 2, "IDLE", "RUNNING"),
    ],
);

fn time(at_s: f64) -> Time {
    Time { sec: at_s as i32, nanosec: (at_s.fract() * 1e9) as u32 }
}

/// A bag with these messages. Changes are stamped by a clock that is so far ahead of the messages'; those of an earlier
/// tick, six seconds before the others.
fn bag(folder: &Path, ahead_s: f64, ticks: &[Tick<'_>]) -> PathBuf {
    let made = ticks.iter().map(|(at_s, changes)| {
        let late = changes.iter().rposition(|change| change.1 == 1 && change.2 == "IDLE").unwrap_or(0);
        let change = |(index, &(node, uid, before, after)): (usize, &(&str, u16, &str, &str))| Change {
            timestamp: time(1e9 + at_s + ahead_s - if index < late { 6.0 } else { 0.0 }),
            node_name: node.to_owned(),
            uid,
            previous_status: before.to_owned(),
            current_status: after.to_owned(),
        };
        Log { timestamp: time(1e9 + at_s), event_log: changes.iter().enumerate().map(change).collect() }
    });
    written(folder, &[("/behavior_tree_log", made.collect())])
}

fn written<M: RosMessage>(folder: &Path, topics: &[(&str, Vec<M>)]) -> PathBuf {
    let path = folder.join("bag.mcap");
    let mut writer =
        mcap::WriteOptions::new().compression(None).profile("ros2").create(fs::File::create(&path).unwrap()).unwrap();
    for (topic, messages) in topics {
        let definition = M::definition().to_string();
        let schema = writer.add_schema("nav2_msgs/msg/BehaviorTreeLog", "ros2msg", definition.as_bytes()).unwrap();
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
        for (message, log_time) in messages.iter().zip(1..) {
            let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &message.encode()).unwrap();
        }
    }
    writer.finish().unwrap();
    path
}

fn tree() -> BagTree {
    Tree::from_xml("tree.xml", TREE).unwrap().into()
}

/// What the nodes reported, and the gaps, as lines; and the run at its end.
fn played(path: &Path) -> (Vec<String>, Vec<Gap>, RunView) {
    let mut recording = Recording::of_bag(path, &tree()).unwrap();
    let (mut view, mut told, mut gaps) = (recording.begin().unwrap(), Vec::new(), Vec::new());
    while view.end().is_none() {
        recording.advance(&mut view).unwrap();
        for event in view.events() {
            let EventKind::Received { channel, message } = &event.kind else { continue };
            let node = view.topology().ends(*channel).0;
            told.push(format!("{} {node} {}", event.time.as_secs_f64(), message.head().unwrap_or_default()));
        }
        gaps.extend(view.happenings().iter().filter_map(|happening| match happening {
            Happening::Lost(gap) => Some(gap.clone()),
            _ => None,
        }));
    }
    (told, gaps, view)
}

fn refused(path: &Path, tree: &BagTree) -> String {
    match Recording::of_bag(path, tree) {
        Err(RecordingError::TreeLog(LogError::Unfit { problem, .. })) => problem,
        other => panic!("{other:?}"),
    }
}

#[test]
fn each_change_is_an_answer_at_the_time_of_its_tick() {
    let folder = tempfile::tempdir().unwrap();
    let (told, gaps, view) = played(&bag(folder.path(), -0.01, &[BEGIN, GO, AGAIN]));
    let expected = [
        "0 Navigate running",
        "0 ComputePathToPose running",
        "1 ComputePathToPose success",
        "1 Drive running",
        "1 FollowPath running",
        // By their own stamps, since these are by the same clock.
        "2.99 FollowPath success",
        "2.99 Drive success",
        "2.99 Navigate success",
        "9 Navigate running",
        "9 ComputePathToPose running",
    ];
    assert_eq!((told, gaps), (expected.map(str::to_owned).to_vec(), vec![]));
    let parents: Vec<Option<usize>> = view.header().tree.iter().map(|node| node.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(0), Some(2)]);
    assert!(!view.header().knows_ticks());
}

#[test]
fn simulated_time_does_not_tell_when_a_goal_ended() {
    let folder = tempfile::tempdir().unwrap();
    let (told, gaps, _) = played(&bag(folder.path(), 5e8, &[BEGIN, GO, AGAIN]));
    assert!(told.contains(&"9 FollowPath success".to_owned()), "{told:?}");
    let [gap] = &gaps[..] else { panic!("{gaps:?}") };
    assert_eq!((gap.flaw, gap.since.map(|since| since.as_secs())), (Flaw::Late, Some(1)));
}

#[test]
fn a_status_that_does_not_follow_from_the_one_before_is_a_loss() {
    let folder = tempfile::tempdir().unwrap();
    let (told, gaps, view) = played(&bag(folder.path(), -0.01, &[BEGIN, AGAIN]));
    let [gap] = &gaps[..] else { panic!("{gaps:?}") };
    assert_eq!((gap.flaw, gap.since.map(|since| since.as_secs())), (Flaw::Missing, Some(0)));
    let why = "at 2.99 s, ComputePathToPose was success before, and the last that is known of it is running: messages are \
               missing, or the tree is another one";
    assert_eq!((gap.why.as_str(), view.lost()), (why, &[why.to_owned()][..]));
    assert_eq!(told.last().map(String::as_str), Some("9 ComputePathToPose running"));
}

#[test]
fn each_loss_is_told_once_and_as_early_as_it_may_have_been() {
    let folder = tempfile::tempdir().unwrap();
    let path: Tick<'_> = (2.0, &[("ComputePathToPose", 2, "IDLE", "RUNNING"), ("FollowPath", 4, "IDLE", "RUNNING")]);
    // What node 4 was before may have been lost earlier than what node 1 was; that of node 2 is the same loss as one.
    let later: Tick<'_> = (5.0, &[("Navigate", 1, "RUNNING", "IDLE"), ("Navigate", 1, "IDLE", "RUNNING")]);
    let lost: Tick<'_> = (7.0, &[("Navigate", 1, "FAILURE", "IDLE"), ("FollowPath", 4, "IDLE", "RUNNING")]);
    let rest: Tick<'_> =
        (8.0, &[("ComputePathToPose", 2, "SUCCESS", "IDLE"), ("ComputePathToPose", 2, "RUNNING", "IDLE")]);
    let begin: Tick<'_> = (0.0, &[("Navigate", 1, "IDLE", "RUNNING")]);
    let (_, gaps, _) = played(&bag(folder.path(), -0.01, &[begin, path, later, lost, rest]));
    let since: Vec<f64> = gaps.iter().filter_map(|gap| Some(gap.since?.as_secs_f64())).collect();
    // The last one is a status that was known again.
    assert_eq!(since, [5.0, 2.0, 8.0], "{gaps:?}");
}

#[test]
fn messages_of_another_tree_are_told_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let other: Tick<'_> = (5.0, &[("Navigate", 1, "RUNNING", "IDLE"), ("Spin", 2, "IDLE", "RUNNING")]);
    let far: Tick<'_> = (6.0, &[("Back", 9, "IDLE", "RUNNING")]);
    let (told, gaps, _) = played(&bag(folder.path(), -0.01, &[BEGIN, GO, other, far]));
    assert_eq!(told.len(), 5, "{told:?}");
    let why = "2 messages of 4 on /behavior_tree_log cannot be of this tree; the first: node 2 is `Spin`, and that of the \
               tree is `ComputePathToPose`";
    assert_eq!(gaps, [Gap { flaw: Flaw::Mixed, ..Gap::of_anything(why) }]);
    let problem = refused(&bag(folder.path(), -0.01, &[far]), &tree());
    assert_eq!(
        problem,
        "no message on /behavior_tree_log is about the tree; the first: the tree has no node 9, `Back`"
    );
}

#[test]
fn without_numbers_every_name_must_be_that_of_one_node() {
    let folder = tempfile::tempdir().unwrap();
    let change = |node: &str, before: &str, after: &str| OldChange {
        timestamp: time(1e9),
        node_name: node.to_owned(),
        previous_status: before.to_owned(),
        current_status: after.to_owned(),
    };
    let changes = vec![change("Navigate", "IDLE", "RUNNING"), change("FollowPath", "IDLE", "RUNNING")];
    let log = OldLog { timestamp: time(1e9), event_log: changes };
    let path = written(folder.path(), &[("/behavior_tree_log", vec![log.clone()])]);
    let (told, gaps, _) = played(&path);
    assert_eq!((&told[..], gaps.len()), (&["0 Navigate running", "0 FollowPath running"].map(str::to_owned)[..], 0));
    let twice = Tree::from_xml("tree.xml", &TREE.replace("<FollowPath/>", "<FollowPath name=\"Navigate\"/>")).unwrap();
    let problem = refused(&path, &twice.into());
    assert!(problem.ends_with("and several nodes of the tree are called `Navigate`"), "{problem}");
}

#[test]
fn of_several_topics_the_named_one_is_the_tree_s() {
    let folder = tempfile::tempdir().unwrap();
    let told = |status: &str| OldLog {
        timestamp: time(1e9),
        event_log: vec![OldChange {
            timestamp: time(1e9),
            node_name: "Navigate".to_owned(),
            previous_status: "IDLE".to_owned(),
            current_status: status.to_owned(),
        }],
    };
    let path = written(folder.path(), &[("/a/log", vec![told("RUNNING")]), ("/b/log", vec![told("FAILURE")])]);
    let of = |topic: &str| BagTree { topic: Some(topic.to_owned()), ..tree() };
    for (topic, status) in
        [("/a/log", NodeStatus::Answered(Status::Running)), ("/b/log", NodeStatus::Answered(Status::Failure))]
    {
        let mut log = TreeLog::of_bag(&path, &of(topic)).unwrap();
        let Some(LogEntry::Changed(change)) = log.next_entry().unwrap() else { panic!("{topic}") };
        assert_eq!((log.topic(), change.status), (Some(topic), status));
    }
    let kind = "of type nav2_msgs/msg/BehaviorTreeLog";
    assert_eq!(refused(&path, &tree()), format!("it has several topics {kind}: /a/log, /b/log"));
    assert_eq!(refused(&path, &of("/c/log")), format!("it has no topic /c/log {kind}"));
}
