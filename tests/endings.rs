//! How a run, a log or a bag ends, and what each way makes of the verdicts: the table in
//! docs/src/explanation/monitors.md.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::steward::{binary, steward};

/// A ban, a condition with an answer, and something that is to come, about a channel `a` to `m`.
const PROPERTIES: &str = "property ban := always not (a, m, m.x > 5)
property answered := always ((a, m, m.x > 3) implies time_until (b, m, true) < 3)
property comes := eventually (a, m, m.x > 7)
";

/// The same about channels of `nominal`.
const OF_NOMINAL: &str = "property ban := always not (BatteryReader, BatteryLevel, m[2] < 5)
property answered := always ((BatteryReader, BatteryLevel, m[2] < 30) implies
    time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation>) < 10)
property comes := eventually (BatteryReader, BatteryLevel, m[2] < 5)
";

const TICK: &str = r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#;

struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    fn new() -> Self {
        let files = Self { folder: tempfile::tempdir().unwrap() };
        files.write("p.scope", PROPERTIES.as_bytes());
        files.write("nominal.scope", OF_NOMINAL.as_bytes());
        let entry = |topic: &str| {
            format!(
                "[[messages]]\ntopic = \"/{topic}\"\ntype = \"std_msgs/msg/Int32\"\nfrom = \"{topic}\"\nto = \"m\"\n\
                 fields = {{ x = \"data\" }}\n"
            )
        };
        files.write("mapping.toml", format!("tick_s = 1\n{}{}", entry("a"), entry("b")).as_bytes());
        files
    }

    fn write(&self, name: &str, contents: &[u8]) -> String {
        fs::write(self.path(name), contents).unwrap();
        self.path(name).to_str().unwrap().to_owned()
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A bag with these topics, and a message with this number on each of the named ones per second.
    fn bag(&self, topics: &[&str], messages: &[(&str, i32)]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = mcap::WriteOptions::new().profile("ros2").use_chunks(false).create(&mut bytes).unwrap();
        let schema = writer.add_schema("std_msgs/msg/Int32", "ros2msg", b"int32 data\n").unwrap();
        let channels: BTreeMap<&str, u16> = topics
            .iter()
            .map(|topic| (*topic, writer.add_channel(schema, &format!("/{topic}"), "cdr", &BTreeMap::new()).unwrap()))
            .collect();
        for ((topic, x), second) in messages.iter().zip(1_700_000_000_u64..) {
            let time = second * 1_000_000_000;
            let header = mcap::records::MessageHeader {
                channel_id: channels[topic],
                sequence: 0,
                log_time: time,
                publish_time: time,
            };
            writer.write_to_known_channel(&header, &[&[0, 1, 0, 0], &x.to_le_bytes()[..]].concat()).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        bytes.into_inner()
    }

    /// The status of a check of this log by the properties, their verdicts, and everything else about each.
    fn verify(&self, log: &str, more: &[&str]) -> (Option<i32>, Vec<String>, Value) {
        judged(&steward(&[&["verify", log, "--json"], more].concat()))
    }

    fn verify_bag(&self, bag: &[u8]) -> (Option<i32>, Vec<String>, Value) {
        let bag = self.write("bag.mcap", bag);
        let [properties, mapping] =
            ["p.scope", "mapping.toml"].map(|name| self.path(name).to_str().unwrap().to_owned());
        self.verify(&bag, &["--property", &properties, "--map-channels", &mapping])
    }

    fn verify_log(&self, lines: &[&str]) -> (Option<i32>, Vec<String>, Value) {
        let log = self.write("log.jsonl", lines.iter().map(|line| format!("{line}\n")).collect::<String>().as_bytes());
        let properties = self.path("nominal.scope").to_str().unwrap().to_owned();
        self.verify(&log, &["--property", &properties, "--scenario", "nominal"])
    }
}

fn judged(output: &std::process::Output) -> (Option<i32>, Vec<String>, Value) {
    let told: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"));
    let verdict = |monitor: &Value| monitor["verdict"].as_str().unwrap().to_owned();
    let verdicts = told["monitors"].as_array().unwrap().iter().map(verdict).collect();
    (output.status.code(), verdicts, told)
}

const NONE: [&str; 3] = ["no verdict"; 3];
const UNSURE: [&str; 3] = ["unsure"; 3];
const SILENT: [&str; 3] = ["satisfied", "satisfied", "inconclusive"];

#[test]
fn a_log_without_events_gives_no_verdict() {
    let files = Files::new();
    for lines in [&[][..], &["{}"], &[r#"{"scenario":"nominal","seed":1}"#]] {
        let (status, verdicts, told) = files.verify_log(lines);
        assert_eq!((status, verdicts), (Some(2), NONE.map(str::to_owned).to_vec()), "{lines:?}");
        assert_eq!(told["monitors"][0]["unsure"], "there are no events");
    }
    // A recorder that cannot be started leaves nothing to read.
    let mut command = Command::new(binary());
    command.args(["verify", "-", "--json", "--scenario", "nominal", "--property"]).arg(files.path("nominal.scope"));
    let (status, verdicts, _) = judged(&command.stdin(Stdio::null()).output().unwrap());
    assert_eq!((status, verdicts), (Some(2), NONE.map(str::to_owned).to_vec()));
}

#[test]
fn silence_in_a_log_is_known_and_said() {
    let files = Files::new();
    let (status, verdicts, told) = files.verify_log(&[r#"{"scenario":"nominal","seed":1}"#, TICK]);
    assert_eq!((status, verdicts), (Some(0), SILENT.map(str::to_owned).to_vec()));
    for monitor in told["monitors"].as_array().unwrap() {
        assert_eq!(monitor["silent"][0], "from BatteryReader to BatteryLevel", "{monitor}");
        assert_eq!(monitor["certainty"], "sure");
    }
    assert_eq!(told["monitors"][1]["vacuous"].as_array().unwrap().len(), 1, "its condition never held");
}

#[test]
fn missing_lines_and_an_incomplete_last_line_leave_verdicts_unsure() {
    let files = Files::new();
    let later =
        r#"{"step":9,"tick":0,"time_s":0.1,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},50.0]}"#;
    let (status, verdicts, _) = files.verify_log(&[TICK, later]);
    assert_eq!((status, verdicts), (Some(1), UNSURE.map(str::to_owned).to_vec()));
    let log = files.write("cut.jsonl", format!("{TICK}\n{}", &later[..40]).as_bytes());
    let properties = files.path("nominal.scope").to_str().unwrap().to_owned();
    let (status, verdicts, _) = files.verify(&log, &["--property", &properties, "--scenario", "nominal"]);
    assert_eq!((status, verdicts), (Some(1), UNSURE.map(str::to_owned).to_vec()));
}

#[test]
fn a_bag_that_lists_a_topic_without_messages_vouches_for_its_silence() {
    let files = Files::new();
    let (status, verdicts, told) = files.verify_bag(&files.bag(&["a", "b"], &[("b", 1), ("b", 2)]));
    assert_eq!((status, verdicts), (Some(0), SILENT.map(str::to_owned).to_vec()));
    assert_eq!(told["monitors"][0]["silent"][0], "from a to m");
    let assumed = "the recorder wrote every message that was sent, once";
    assert_eq!(told["monitors"][0]["assumptions"][0], assumed);
}

#[test]
fn a_topic_that_a_bag_does_not_have_leaves_no_verdict_about_it() {
    let files = Files::new();
    let (status, verdicts, told) = files.verify_bag(&files.bag(&["b"], &[("b", 1), ("b", 2)]));
    assert_eq!((status, verdicts), (Some(2), NONE.map(str::to_owned).to_vec()));
    let why = "nothing is known of messages from a to m: there is no topic /a";
    assert_eq!(told["monitors"][0]["unsure"], why);
    // The topic of the answer is missing: only what is about it has no verdict.
    let (status, verdicts, _) = files.verify_bag(&files.bag(&["a"], &[("a", 1), ("a", 9)]));
    assert_eq!((status, verdicts), (Some(2), ["violated", "no verdict", "satisfied"].map(str::to_owned).to_vec()));
}

#[test]
fn a_bag_without_messages_gives_no_verdict_and_one_that_was_cut_off_leaves_verdicts_unsure() {
    let files = Files::new();
    let (status, verdicts, _) = files.verify_bag(&files.bag(&["a", "b"], &[]));
    assert_eq!((status, verdicts), (Some(2), NONE.map(str::to_owned).to_vec()));
    let whole = files.bag(&["a", "b"], &[("b", 1), ("a", 1), ("b", 1), ("a", 1), ("b", 1)]);
    // In the middle of a message.
    let (status, verdicts, _) = files.verify_bag(&whole[..whole.len() / 4]);
    assert_eq!((status, verdicts), (Some(1), UNSURE.map(str::to_owned).to_vec()));
}

#[test]
fn a_run_vouches_for_the_silence_of_what_it_computes() {
    let files = Files::new();
    let out = files.path("out");
    let properties = format!(
        "properties=[{:?}]",
        files.write(
            "silent.scope",
            b"property ban := always not (GotoRechargingStation, Navigation, m[1] = <stop_navigation>)\n",
        )
    );
    let mut command = Command::new(binary());
    command.args([
        "run",
        "nominal",
        "--quiet",
        "--no-snapshots",
        "--set",
        "execution.max_time_s=0.1",
        "--set",
        "expect={}",
    ]);
    let output = command.args(["--set", &properties, "--out"]).arg(&out).output().unwrap();
    let report: Value =
        serde_json::from_slice(&fs::read(out.join("report.json")).unwrap_or_else(|_| panic!("{output:?}"))).unwrap();
    let monitor = &report["monitors"][0];
    assert_eq!((&monitor["verdict"], &monitor["certainty"]), (&"satisfied".into(), &"sure".into()));
    assert_eq!(monitor["silent"][0], "from GotoRechargingStation to Navigation", "{monitor}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("There was no message from GotoRechargingStation to Navigation."), "the page says so");
}
