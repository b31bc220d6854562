//! Logs of BehaviorTree.CPP as recordings: what is said of them, and what is refused.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use ros_messages::{RosMessage as _, RosType as _, messages};
use serde_json::Value;
use tempfile::tempdir;
use tree_logs::{Log, LogEntry, NodeStatus, StatusChange};

use crate::steward::{refusal, steward};

/// A log that BehaviorTree.CPP wrote.
fn captured(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("bt/logs/tests/captured").join(name).display().to_string()
}

/// What `verify` says of a property and a log, as JSON, with its notes and its exit status.
fn verified(log: &str, property: &str) -> (Value, String, Option<i32>) {
    let folder = tempdir().unwrap();
    let file = folder.path().join("p.scope");
    fs::write(&file, property).unwrap();
    let out = folder.path().join("out");
    let [file, out] = [file, out].map(|path| path.display().to_string());
    let words = steward(&["verify", log, "--property", &file, "--out", &out]);
    if words.status.code().is_some_and(|status| status < 2) {
        // Such a log knows no ticks, so neither what is printed nor the report names one.
        let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
        let (page, told) = (in_words(&page), String::from_utf8(words.stdout).unwrap());
        for text in [page, told] {
            assert!(!text.contains("tick ") && !text.contains("Tick ") && !text.contains(" ticks"), "{text}");
        }
    }
    let output = steward(&["verify", log, "--json", "--property", &file]);
    let notes = String::from_utf8(output.stderr).unwrap();
    (serde_json::from_slice(&output.stdout).unwrap_or_default(), notes, output.status.code())
}

/// The text of a page, without markup, scripts and styles.
fn in_words(page: &str) -> String {
    let mut page = page.to_owned();
    for element in ["script", "style"] {
        let [begin, end] = [format!("<{element}"), format!("</{element}>")];
        page = page.split(&begin).filter_map(|part| part.rsplit(&end).next()).collect();
    }
    page.split('<').filter_map(|part| Some(part.split_once('>')?.1)).collect()
}

#[test]
fn properties_of_nodes_have_verdicts_and_what_they_leave_open_is_said() {
    let property = "timed property lifted := always ((deliver, BT, reply = <running>)
                        implies time_until (Lift, BT, reply = <success>) < 1 s)
                    timed property slow := always ((deliver, BT, reply = <running>)
                        implies time_until (Lift, BT, reply = <success>) < 60 ms)
                    property arrives := eventually (dock, BT, reply = <success>)";
    // The end of the first session is lost: it ends while something is being lifted.
    for (log, lifted) in [("fetch.btlog", "satisfied"), ("fetch.db3", "satisfied"), ("fetch.db3#1", "inconclusive")] {
        if log.contains("db3") && cfg!(not(feature = "sqlite")) {
            continue;
        }
        let (report, notes, status) = verified(&captured(log), property);
        let verdict = |name: &str| {
            let all = report["monitors"].as_array().unwrap();
            all.iter().find(|property| property["name"] == name).unwrap()["verdict"].clone()
        };
        assert_eq!((verdict("lifted"), verdict("arrives")), (lifted.into(), "satisfied".into()), "{log}: {report}");
        assert_eq!((verdict("slow"), status), ("violated".into(), Some(1)), "{log}: {report}");
        assert!(notes.contains("not the answers that repeat the one before"), "{notes}");
        let slow = report["monitors"].as_array().unwrap().iter().find(|property| property["name"] == "slow").unwrap();
        let (witness, null) = (&slow["witness"], Value::Null);
        assert!(slow["timed"] == true && !witness["words"].as_str().unwrap().contains("tick"), "{slow}");
        assert_eq!([&witness["tick"], &witness["deadline_tick"], &witness["since_tick"]], [&null; 3], "{slow}");
        assert!(witness["messages"].as_array().unwrap().iter().all(|message| message["tick"].is_null()), "{slow}");
    }
}

#[test]
fn a_node_is_called_by_its_path_its_name_or_its_id_and_what_several_are_called_is_refused() {
    let log = captured("fetch.btlog");
    let succeeds = |node: &str| verified(&log, &format!("property p := eventually ({node}, BT, reply = <success>)"));
    for [path, name, other] in [
        ["\"GoTo::10/Drive\"", "Drive_2", "Drive_2"],
        ["deliver", "deliver", "deliver"],
        ["\"Parallel::14\"", "Parallel", "Parallel"],
        ["main", "main", "ReactiveFallback"],
    ] {
        let [by_path, by_name, by_other] = [path, name, other].map(|node| succeeds(node).0["monitors"].clone());
        assert!(by_path[0]["verdict"].is_string(), "{path}: {by_path}");
        assert_eq!([&by_path[0]["verdict"]; 2], [&by_name[0]["verdict"], &by_other[0]["verdict"]], "{path}");
    }
    let any = verified(
        &log,
        "property p := eventually (*, BT, reply = <success>) and eventually (\"dock\", *, reply = <success>)",
    );
    assert_eq!(any.0["monitors"][0]["verdict"], "satisfied");
    for (name, paths) in
        [("Drive", "\"dock/Drive\", \"GoTo::10/Drive\""), ("Scripted", "\"Scripted::17\", \"Scripted::18\"")]
    {
        let (_, notes, status) = succeeds(name);
        assert!(status == Some(2) && notes.contains(&format!("2 processes are called `{name}`")), "{notes}");
        assert!(notes.contains(paths), "{notes}");
    }
    assert!(succeeds("GoTo_3").1.contains("unknown process `GoTo_3`"));
}

#[test]
fn a_tree_is_named_only_for_a_bag() {
    let tree = Path::new(env!("CARGO_MANIFEST_DIR")).join("bt/trees/recharge.xml").display().to_string();
    let log = captured("fetch.btlog");
    let folder = tempdir().unwrap();
    let bag = folder.path().join("bag.mcap");
    fs::write(&bag, [mcap::MAGIC, &[0xff]].concat()).unwrap();
    let bag = bag.display().to_string();
    for (command, log, reason) in [
        ("report", &log, "`--tree` is for a ROS 2 bag"),
        ("live", &log, "`--tree` is for a ROS 2 bag"),
        ("verify", &log, "`--tree` is for a ROS 2 bag"),
        ("report", &tree, "a bag is a file `.mcap`"),
        ("report", &bag, "nav2_msgs/msg/BehaviorTreeLog"),
        ("verify", &bag, "nav2_msgs/msg/BehaviorTreeLog"),
        ("live", &bag, "nav2_msgs/msg/BehaviorTreeLog"),
    ] {
        let refused = refusal(&[command, log, "--tree", &tree]);
        assert!(refused.contains(reason), "{command} {log}: {refused}");
    }
}

messages! {
    Time = "builtin_interfaces/Time" { sec: i32, nanosec: u32 }
    Change = "nav2_msgs/BehaviorTreeStatusChange" {
        timestamp: Time,
        node_name: String,
        uid: u16,
        previous_status: String,
        current_status: String,
    }
    Changes = "nav2_msgs/BehaviorTreeLog" { timestamp: Time, event_log: Vec<Change> }
}

/// Writes a bag in which the nodes with these names and numbers begin to run.
fn write_bag(path: &Path, nodes: &[(&str, u16)]) {
    let timestamp = || Time { sec: 1_000_000_000, nanosec: 0 };
    let change = |&(name, uid): &(&str, u16)| Change {
        timestamp: timestamp(),
        node_name: name.to_owned(),
        uid,
        previous_status: "IDLE".to_owned(),
        current_status: "RUNNING".to_owned(),
    };
    let changes = Changes { timestamp: timestamp(), event_log: nodes.iter().map(change).collect() };
    let mut writer = mcap::WriteOptions::new().compression(None).create(fs::File::create(path).unwrap()).unwrap();
    let definition = Changes::definition().to_string();
    let schema = writer.add_schema("nav2_msgs/msg/BehaviorTreeLog", "ros2msg", definition.as_bytes()).unwrap();
    let channel_id = writer.add_channel(schema, "/behavior_tree_log", "cdr", &BTreeMap::new()).unwrap();
    let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, &changes.encode()).unwrap();
    writer.finish().unwrap();
}

#[test]
fn the_steps_of_a_bag_are_at_the_nodes_of_the_tree_that_is_named() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    write_bag(Path::new(&path("bag.mcap")), &[("Navigate", 1), ("FollowPath", 2)]);
    let tree = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">\n<Sequence name=\"Navigate\">\n<FollowPath/>\n\
                </Sequence></BehaviorTree></root>";
    fs::write(path("tree.xml"), tree).unwrap();
    fs::write(path("p.scope"), "property stays := always not (FollowPath, BT, reply = <running>)").unwrap();
    let [bag, tree, property, sarif] = ["bag.mcap", "tree.xml", "p.scope", "ci.sarif"].map(path);
    let verified = steward(&["verify", &bag, "--tree", &tree, "--property", &property, "--results", &sarif]);
    assert_eq!(verified.status.code(), Some(1), "{}", String::from_utf8_lossy(&verified.stderr));
    let sarif: Value = serde_json::from_str(&fs::read_to_string(&sarif).unwrap()).unwrap();
    let steps = sarif["runs"][0]["results"][0]["codeFlows"][0]["threadFlows"][0]["locations"].as_array().unwrap();
    let place = |step: &Value| {
        let place = &step["location"]["physicalLocation"];
        (place["artifactLocation"]["uri"].as_str().unwrap().to_owned(), place["region"]["startLine"].as_u64())
    };
    let at = |file: &str, line| (format!("file://{file}"), Some(line));
    assert_eq!(steps.iter().map(place).collect::<Vec<_>>(), [at(&tree, 3), at(&property, 1)]);
}

#[test]
fn what_a_log_cannot_know_is_refused_with_the_reason() {
    let lift = "(Lift, BT, reply = <success>)";
    for (formula, reason) in [
        (format!("time_until {lift} < 3"), "counts ticks"),
        (format!("time_until {lift} < 3 s"), "cannot be counted in ticks"),
        (format!("always next {lift}"), "depends on each message"),
        (format!("always (becomes {lift} implies true)"), "depends on each message"),
        (format!("always at most 3 {lift} in 10 s"), "cannot be counted in ticks"),
        (format!("always (fresh {lift} implies true)"), "depends on each message"),
        (format!("always once[<= 10 s] {lift}"), "cannot be counted in ticks"),
        ("eventually (BT, Lift, request = <tick>)".to_owned(), "no channel from BT to Lift"),
        ("eventually (World, Monitors, level_pct < 3)".to_owned(), "World"),
    ] {
        let (_, notes, status) = verified(&captured("fetch.btlog"), &format!("property p := {formula}"));
        assert!(status == Some(2) && notes.contains(reason), "{formula}: {notes}");
    }
}

#[test]
fn a_report_of_a_log_does_not_claim_what_the_log_does_not_know() {
    let out = tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let whole = captured("fetch.btlog");
    let output = steward(&["report", &whole, "--out", folder]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && said.starts_with("fetch: a recording\n"), "{said}");
    let page = fs::read_to_string(out.path().join("report.html")).unwrap();
    assert!(page.contains("no answer is known") && page.contains("Drive_2"));
    for claim in ["never ticked", "not ticked", "0 ticks", "seed", "A tick is"] {
        assert!(!said.contains(claim) && !page.contains(claim), "{claim}");
    }
    let outline = |page: &str| {
        page.split_once("The tree at the end: ").map(|(_, rest)| rest.split_once("</section>").unwrap().0.to_owned())
    };
    assert!(outline(&page).is_some_and(|outline| outline.contains("Drive_2")));
    let (file, judged) = (out.path().join("p.scope"), out.path().join("judged"));
    fs::write(&file, "property p := eventually (Lift, BT, reply = <failure>)").unwrap();
    steward(&["verify", &whole, "--property", file.to_str().unwrap(), "--out", judged.to_str().unwrap()]);
    assert_eq!(outline(&fs::read_to_string(judged.join("report.html")).unwrap()), outline(&page));
    let cut = out.path().join("cut.btlog");
    let bytes = fs::read(&whole).unwrap();
    fs::write(&cut, &bytes[..bytes.len() - 5]).unwrap();
    let output = steward(&["report", cut.to_str().unwrap(), "--out", folder]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("was cut off here: its last transition is not whole"), "{said}");
    let (report, notes, status) =
        verified(cut.to_str().unwrap(), "property p := eventually (Lift, BT, reply = <failure>)");
    assert!(status == Some(1) && report.to_string().contains("unsure"), "{report}");
    assert!(notes.contains("its last transition is not whole"), "{notes}");
    // One second before the log began: nothing is violated, and the report says it nevertheless.
    let mut back = bytes.clone();
    let start = back.len() - 9 * 76;
    back[start + 9 * 40..][..6].copy_from_slice(&(-1_000_000_i64).to_le_bytes()[..6]);
    fs::write(&cut, back).unwrap();
    let output = steward(&["report", cut.to_str().unwrap(), "--out", folder]);
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("the clock of the log went back by 1."), "{told}");
    let page = fs::read_to_string(out.path().join("report.html")).unwrap();
    assert!(in_words(&page).contains("the clock of the log went back by 1."));
    fs::write(&cut, &bytes[..200]).unwrap();
    assert!(refusal(&["report", cut.to_str().unwrap()]).contains("it ends within its tree"));
    assert!(refusal(&["report", &(whole + "#2")]).contains("it has no sessions"));
}

/// Our own log of a run: the answers of its leaves, from its event log, are the changes of status in it, except those
/// that repeat the one before.
#[test]
fn a_recorded_run_has_the_changes_of_status_of_its_tree_and_is_read_back() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let out = path("out");
    for file in ["run.btlog", "again.btlog", "run.rec", "run.jsonl"] {
        let output = steward(&["run", "battery_fault", "--quiet", "--out", &out, "--record", &path(file)]);
        assert!(output.status.code().is_some_and(|status| status < 2), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let output = steward(&["report", &path("run.rec"), "--quiet", "--out", &out, "--record", &path("later.btlog")]);
    assert!(output.status.code().is_some_and(|status| status < 2), "{}", String::from_utf8_lossy(&output.stderr));
    let [log, again, later] = ["run.btlog", "again.btlog", "later.btlog"].map(|name| fs::read(path(name)).unwrap());
    assert!(log == again && log == later);

    let mut log = Log::open(Path::new(&path("run.btlog"))).unwrap();
    let mut answered = Vec::new();
    while let Some(entry) = log.next_entry().unwrap() {
        let LogEntry::Changed(StatusChange { at_us, node, status, .. }) = entry else { panic!("{entry:?}") };
        let node = &log.tree().nodes()[node];
        if let (true, NodeStatus::Answered(answer)) = (node.is_leaf, status) {
            answered.push((at_us, node.name.clone(), answer.name().to_owned()));
        }
    }
    let events = fs::read_to_string(path("run.jsonl")).unwrap();
    let events = events.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let answers = events.filter(|event| event["to"] == "BT" && event["message"][0]["sym"].is_string());
    let mut expected = answered.iter();
    let mut repeated = 0;
    let mut last = std::collections::BTreeMap::new();
    let mut next = expected.next();
    for event in answers {
        let at_us = (event["time_s"].as_f64().unwrap() * 1e6).round() as i64;
        let [name, answer] =
            [&event["from"], &event["message"][0]["sym"]].map(|text| text.as_str().unwrap().to_owned());
        if answer == "tick" || answer == "halted" {
            continue;
        }
        if next == Some(&(at_us, name.clone(), answer.clone())) {
            next = expected.next();
        } else {
            assert_eq!(last.get(&name), Some(&answer), "{name} at {at_us} µs");
            repeated += 1;
        }
        last.insert(name, answer);
    }
    assert!(next.is_none() && answered.len() > 20 && repeated > 20, "{next:?}, {repeated} repeated");

    let (report, _, _) = verified(&path("run.btlog"), "property p := eventually (BatteryLevel, BT, reply = <failure>)");
    assert_eq!(report["monitors"][0]["verdict"], "satisfied", "{report}");
    let output = steward(&["report", &path("run.btlog"), "--out", &out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_run_without_changes_of_status_is_not_recorded_as_such_a_log() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (log, nodes) = (path("run.btlog"), "execution.tree=nodes");
    let unwritten = |arguments: &[&str], why: &str| {
        let output = steward(&[arguments, &["--out", &path("out"), "--record", &log]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(3) && said.contains(why) && !Path::new(&log).exists(), "{said}");
    };
    unwritten(&["run", "nominal", "--set", nodes], "`tree = \"nodes\"`");
    let said = refusal(&["run", "nominal", "--set", nodes, "--out", &path("out"), "--serve-groot", "16690"]);
    assert!(said.contains("Groot2 cannot see the tree"), "{said}");
    unwritten(&["report", &captured("fetch.btlog")], "it was not run here");
}
