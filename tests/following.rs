//! The binary reports verdicts as they are reached, while a log is being written.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use bags::Bag;
use serde_json::Value;

use crate::bags::Recorded;
use crate::steward::{binary, refusal, steward};

/// A command whose standard output is read line by line.
struct Following {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Following {
    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(binary())
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary starts");
        let lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
        Self { child, lines }
    }

    /// The next line, once there is one.
    fn line(&mut self) -> Value {
        let line = self.lines.next().expect("the command goes on").expect("text");
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"))
    }

    /// What it says at the end: its last line, its status, and its notes.
    fn end(mut self) -> (Value, Option<i32>, String) {
        drop(self.child.stdin.take());
        let last = self.line();
        assert!(self.lines.next().is_none(), "nothing follows the verdicts");
        let output = self.child.wait_with_output().expect("it ends");
        (last, output.status.code(), String::from_utf8(output.stderr).expect("text"))
    }
}

/// Writes the messages of a bag to a growing file, each in a record of its own, and what `rosbag2` leaves behind at
/// the end.
fn rewrite(bag: &Path, growing: File, mut before: impl FnMut(u64)) {
    let bag = Bag::open(bag).expect("a bag");
    let topics = &bag.survey().topics;
    let all: Vec<usize> = (0..topics.len()).collect();
    let mut writer = mcap::WriteOptions::new().use_chunks(false).create(growing).expect("a writer");
    let (mut messages, mut body, mut channels) = (bag.messages(&all), Vec::new(), BTreeMap::new());
    let mut first_ns = None;
    while let Some(head) = messages.next_into(&mut body) {
        let channel_id = *channels.entry(head.topic).or_insert_with(|| {
            let topic = &topics[head.topic];
            let text = topic.definition.as_ref().map_or("", |definition| &definition.text);
            let schema = writer.add_schema(&topic.kind, "ros2msg", text.as_bytes()).expect("a schema");
            writer.add_channel(schema, &topic.name, &topic.encoding, &BTreeMap::new()).expect("a channel")
        });
        let log_time = head.log_ns.unsigned_abs();
        let since = log_time - *first_ns.get_or_insert(log_time);
        writer.flush().expect("room for a message");
        before(since / 1_000_000);
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &body).expect("room for a message");
    }
    writer.finish().expect("room for the end");
}

#[test]
fn verdicts_on_a_bag_fall_while_it_is_being_recorded() {
    let recorded = Recorded::new();
    let (growing, out) = (recorded.path("growing.mcap"), recorded.path("out"));
    let (properties, mapping) = (recorded.path("nav2.scope"), recorded.path("mapping.toml"));
    for report in [&["--out", &out][..], &[]] {
        let file = File::create(&growing).expect("a file");
        let arguments = ["verify", &growing, "--property", &properties, "--map-channels", &mapping, "--json"];
        let mut following = Following::start(&[&arguments[..], &["--follow"], report].concat());
        let mut said = Vec::new();
        rewrite(Path::new(&recorded.path("nav2.mcap")), file, |ms| {
            // The rest is written only when what is known of the violation has been said: a second later, because
            // messages may be late.
            if ms > 43_600 && said.is_empty() {
                said.push(following.line());
            }
            if ms > 54_000 && said.len() == 1 {
                said.push(following.line());
            }
        });
        let (mut last, status, notes) = following.end();
        // It may look before a topic is there.
        let others: Vec<&str> = notes.lines().filter(|note| !note.starts_with("note: waiting for the topic")).collect();
        assert_eq!((status, others), (Some(1), vec![]));
        let what = |line: &Value| (line["property"].clone(), line["verdict"].clone(), line["time_s"].clone());
        assert_eq!(what(&said[0]), ("slow_when_low".into(), "violated".into(), 42.01.into()));
        assert!(said[0]["witness"]["words"].as_str().expect("words").contains("DISCHARGING"), "{}", said[0]);
        assert_eq!(what(&said[1]), ("slow_when_low".into(), "holds again".into(), 52.0.into()));
        let again = steward(&arguments);
        let mut again: Value = serde_json::from_slice(&again.stdout).expect("JSON");
        // A file that still grows has no hash.
        for verdicts in [&mut again, &mut last] {
            verdicts["provenance"]["inputs"] = Value::Null;
        }
        assert_eq!(again, last, "of the finished bag");
    }
}

#[test]
fn a_bag_whose_topics_have_not_all_appeared_is_waited_for() {
    let recorded = Recorded::new();
    let growing = recorded.path("growing.mcap");
    let mapping = recorded.write(
        "never.toml",
        b"[[messages]]\ntopic = \"/battery_state\"\nfrom = \"battery\"\nto = \"base\"\n\
          fields = { level = \"percentage\" }\n[[messages]]\ntopic = \"/stop\"\nfrom = \"a\"\nto = \"b\"\n\
          fields = { is_on = \"data\" }\n",
    );
    let properties = recorded.write("some.scope", b"property some := always (battery, base, m.level >= 0)\n");
    let arguments = ["verify", &growing, "--property", &properties, "--map-channels", &mapping, "--json", "--follow"];
    rewrite(Path::new(&recorded.path("nav2.mcap")), File::create(&growing).expect("a file"), |_| {});
    let refused = refusal(&arguments);
    assert!(refused.contains("there is no topic `/stop`"), "it is over: {refused}");
    // If the mapping says what the topic carries, it need not appear.
    let text = std::fs::read_to_string(&mapping).expect("a mapping");
    let text = text.replace("topic = \"/stop\"", "topic = \"/stop\"\ntype = \"std_msgs/msg/Bool\"");
    std::fs::write(&mapping, text).expect("room for a mapping");
    let (last, status, notes) = Following::start(&arguments).end();
    assert_eq!((status, &last["monitors"][0]["verdict"]), (Some(0), &"satisfied".into()));
    assert_eq!(notes, "note: there is no topic /stop, so none of its messages is judged\n");
}

/// A log of a battery whose level falls below 10 %, in lines.
fn log() -> Vec<String> {
    let level = |step: u64, tick: u64, level: f64| {
        format!(
            r#"{{"step":{step},"tick":{tick},"time_s":{tick}.5,"from":"BatteryReader","to":"BatteryLevel","message":[{{"sym":"ok"}},{level}]}}"#
        )
    };
    let tick = |step: u64, tick: u64| format!(r#"{{"step":{step},"tick":{tick},"time_s":{tick},"generated":"tick"}}"#);
    let first = r#"{"scenario":"nominal","tick_s":1.0}"#.to_owned();
    vec![first, tick(0, 0), level(1, 0, 50.0), tick(1, 1), level(2, 1, 9.0), tick(2, 2), level(3, 2, 8.0)]
}

#[test]
fn verdicts_on_an_event_log_fall_while_lines_arrive() {
    let mut following = Following::start(&["verify", "-", "--property", "phi1", "--json", "--follow"]);
    let mut input = following.child.stdin.take().expect("a pipe");
    let lines = log();
    for line in &lines[..4] {
        writeln!(input, "{line}").expect("it reads");
    }
    // Half a line is none.
    let (half, rest) = lines[4].split_at(40);
    write!(input, "{half}").and_then(|()| input.flush()).expect("it reads");
    writeln!(input, "{rest}").expect("it reads");
    let said = following.line();
    assert_eq!(
        (&said["property"], &said["verdict"], &said["time_s"]),
        (&"phi1".into(), &"violated".into(), &1.5.into())
    );
    write!(input, "{}\n{}", lines[5], lines[6]).expect("it reads");
    drop(input);
    let (last, status, notes) = following.end();
    assert_eq!((status, notes.as_str()), (Some(1), ""));
    assert_eq!(last["monitors"][0]["verdict"], "violated");
}

#[cfg(unix)]
#[test]
fn an_event_log_is_followed_until_the_program_is_asked_to_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.jsonl");
    let mut file = File::create(&path).expect("a file");
    let path = path.to_str().expect("a path in UTF-8");
    let mut following = Following::start(&["verify", path, "--property", "phi1", "--json", "--follow"]);
    for line in &log()[..5] {
        writeln!(file, "{line}").expect("room for a line");
    }
    assert_eq!(following.line()["verdict"], "violated");
    // What is not a whole line is not part of the log.
    write!(file, "{{\"step\":").expect("room for a part");
    let asked = Command::new("kill").args(["-INT", &following.child.id().to_string()]).status().expect("`kill` starts");
    assert!(asked.success());
    let (last, status, notes) = following.end();
    assert_eq!((status, notes.as_str()), (Some(1), "note: it was still being written: what follows is not judged\n"));
    assert_eq!(last["monitors"][0]["verdict"], "violated");
}

#[test]
fn an_event_log_is_followed_until_the_end_of_its_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.jsonl");
    let first = r#"{"scenario":"nominal","tick_s":1.0,"has_end":true}"#.to_owned();
    let end = r#"{"end":"stopped","step":3,"tick":2,"time_s":3.0}"#.to_owned();
    let lines = [vec![first], log()[1..].to_vec(), vec![end]].concat();
    std::fs::write(&path, lines.join("\n") + "\n").expect("room for a log");
    let path = path.to_str().expect("a path in UTF-8");
    let mut following = Following::start(&["verify", path, "--property", "phi1", "--json", "--follow"]);
    assert_eq!(following.line()["verdict"], "violated");
    let (last, status, notes) = following.end();
    assert_eq!((status, notes.as_str()), (Some(1), ""));
    assert_eq!(last["monitors"][0]["verdict"], "violated");
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("run.mcap");
    let recording = recording.to_str().expect("a path in UTF-8");
    assert!(steward(&["run", "corridor", "--quiet", "--no-snapshots", "--record", recording]).status.success());
    let refused = refusal(&["verify", recording, "--follow"]);
    assert!(refused.contains("a recording by steward, which cannot be followed"), "{refused}");
    let refused = refusal(&["verify", "a.jsonl", "b.jsonl", "--property", "phi1", "--follow"]);
    assert!(refused.contains("several logs cannot be followed at once"), "{refused}");
    let refused = refusal(&["verify", "no-such-log.jsonl", "--property", "phi1", "--follow"]);
    assert!(refused.contains("cannot read the log no-such-log.jsonl"), "{refused}");
}
