//! The binary checks recordings of real robots.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::steward::{refusal, steward};

/// A folder with the shipped recording, and the paths of its files.
pub(crate) struct Recorded {
    _folder: tempfile::TempDir,
    root: PathBuf,
}

impl Recorded {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("robot");
        assert!(steward(&["init", root.to_str().unwrap(), "--template", "recording"]).status.success());
        Self { _folder: folder, root }
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.root.join(name).to_str().unwrap().to_owned()
    }

    pub(crate) fn write(&self, name: &str, contents: &[u8]) -> String {
        fs::write(self.root.join(name), contents).unwrap();
        self.path(name)
    }

    /// Status, stdout and stderr of a check of the bags.
    fn verify(&self, bags: &[&str], more: &[&str]) -> (Option<i32>, String, String) {
        let (properties, mapping) = (self.path("nav2.scope"), self.path("mapping.toml"));
        let mut arguments = vec!["verify"];
        arguments.extend(bags);
        arguments.extend(["--property", &properties, "--map-channels", &mapping]);
        arguments.extend(more);
        let output = steward(&arguments);
        let [said, noted] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code(), said, noted)
    }
}

/// A message without its line breaks.
fn unwrapped(said: &str) -> String {
    said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ")
}

#[test]
fn a_recorded_robot_gets_verdicts_and_a_page() {
    let recorded = Recorded::new();
    let (bag, out) = (recorded.path("nav2.mcap"), recorded.path("out"));
    let (status, said, noted) = recorded.verify(&[&bag], &["--json", "--out", &out]);
    assert_eq!((status, noted.as_str()), (Some(1), ""));
    let told: Value = serde_json::from_str(&said).unwrap();
    let violated: Vec<&str> = told["monitors"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|monitor| monitor["verdict"] == "violated")
        .map(|monitor| monitor["name"].as_str().unwrap())
        .collect();
    assert_eq!(violated, ["slow_when_low"]);
    assert_eq!(told["start_s"], "1760000000.030000000");
    let report: Value = serde_json::from_slice(&fs::read(Path::new(&out).join("report.json")).unwrap()).unwrap();
    assert_eq!((&report["ended"], &report["scenario"]), (&"recorded".into(), &"nav2".into()));
    assert_eq!(report["monitors"][4]["tick"], told["monitors"][4]["witness"]["tick"]);
    let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(page.contains("Check it again") && page.contains("--map-channels"), "how to check it again");
    assert!(page.contains("Settings of the mapping") && page.contains("battery_state"), "the mapping");
    for absent in ["seed", "Where the robot went", "What the tree", "simulated", "what the scenario expects"] {
        assert!(!page.contains(absent), "{absent}");
    }
    // Its chart shows the messages that led to the violation.
    assert!(page.contains("id=\"violations\"") && page.contains("DISCHARGING"));
    assert!([">battery<", ">controller<", ">base<"].iter().all(|lifeline| page.contains(lifeline)));
    assert!(page.contains("\"title\":\"battery → base, level_pct\""), "a plot of what is compared with a number");
    // The violation begins 42.01 s after the first message, and ends; both are in a file for other tools.
    let file = Path::new(&out).join("violations.mcap");
    let listed = String::from_utf8(steward(&["verify", "--list", file.to_str().unwrap()]).stdout).unwrap();
    assert!(listed.starts_with("# 9.990 s, since 2025-10-09 08:54:02.040 UTC\n"), "{listed}");
    let topic = listed.lines().find(|line| line.starts_with("# /steward/violations")).unwrap();
    assert!(topic.contains("rcl_interfaces/msg/Log") && topic.contains(" 2 "), "{listed}");
}

#[test]
fn a_bag_is_checked_against_the_channels_of_a_scenario() {
    let recorded = Recorded::new();
    let mapping = "[[messages]]\ntopic = \"/battery_state\"\nfrom = \"BatteryReader\"\nto = \"BatteryLevel\"\n\
                   [messages.fields]\nstatus = { symbol = \"ok\" }\nlevel = { path = \"percentage\", scale = 100 }\n";
    let (bag, mapping) = (recorded.path("nav2.mcap"), recorded.write("nominal.toml", mapping.as_bytes()));
    let command = ["verify", &bag, "--property", "phi1", "--map-channels", &mapping, "--scenario", "nominal"];
    let said = String::from_utf8(steward(&command).stdout).unwrap();
    assert!(
        said.starts_with("30 messages, 59 ticks since 2025-10-09 08:53:20.040 UTC\n")
            && said.contains("phi1         violated"),
        "{said}"
    );
    let foreign =
        recorded.write("foreign.toml", fs::read_to_string(&mapping).unwrap().replace("Level", "Levle").as_bytes());
    let said = refusal(&["verify", &bag, "--property", "phi1", "--map-channels", &foreign, "--scenario", "nominal"]);
    assert!(said.contains("the scenario has no channel BatteryReader → BatteryLevle"), "{said}");
}

/// Writes the metadata of a recording in a folder that consists of these files.
fn list_files(folder: &Path, names: &[&str]) {
    let list: String = names.iter().map(|name| format!("- {name}\n")).collect();
    fs::write(folder.join("metadata.yaml"), format!("relative_file_paths:\n{list}duration: 1\n")).unwrap();
}

#[test]
fn messages_before_the_damage_are_checked() {
    let recorded = Recorded::new();
    let whole = fs::read(recorded.root.join("nav2.mcap")).unwrap();
    let copies = recorded.root.join("several");
    fs::create_dir(&copies).unwrap();
    fs::write(copies.join("bag_0.mcap"), &whole).unwrap();
    fs::write(copies.join("bag_1.mcap"), &whole[..whole.len() / 2]).unwrap();
    let (_, _, said) = recorded.verify(&[copies.to_str().unwrap()], &[]);
    assert!(unwrapped(&said).contains("bag_0.mcap and bag_1.mcap have the same messages"), "{said}");
    list_files(&copies, &["bag_0.mcap", "bag_1.mcap"]);
    let (status, said, noted) = recorded.verify(&[copies.to_str().unwrap()], &[]);
    assert_eq!(status, Some(1));
    assert!(said.contains("slow_when_low unsure"), "{said}");
    assert!(noted.contains("bag_1.mcap breaks off"), "{noted}");
    let cut = copies.join("bag_1.mcap");
    let listed = String::from_utf8(steward(&["verify", "--list", cut.to_str().unwrap()]).stdout).unwrap();
    assert!(listed.contains("bag_1.mcap breaks off"), "{listed}");
    fs::write(&cut, &whole[..1500]).unwrap();
    let mapping = fs::read_to_string(recorded.path("mapping.toml")).unwrap();
    let untyped: String =
        mapping.lines().filter(|line| !line.starts_with("type")).map(|line| format!("{line}\n")).collect();
    let (untyped, property) = (recorded.write("untyped.toml", untyped.as_bytes()), recorded.path("nav2.scope"));
    let noted = refusal(&["verify", cut.to_str().unwrap(), "--property", &property, "--map-channels", &untyped]);
    let noted = unwrapped(&noted);
    assert!(
        noted.contains("there is no topic `/goal_pose`") && noted.contains("breaks off before its first"),
        "{noted}"
    );
    let empty = recorded.write("empty.mcap", b"");
    let (status, _, noted) = recorded.verify(&[&empty, &recorded.path("nav2.mcap")], &[]);
    assert!(status == Some(2) && noted.contains("empty.mcap is empty"), "{noted}");
}

#[test]
fn parts_of_a_bag_that_are_named_one_by_one_are_noted_once() {
    let recorded = Recorded::new();
    let whole = fs::read(recorded.root.join("nav2.mcap")).unwrap();
    let folder = recorded.root.join("drive");
    fs::create_dir(&folder).unwrap();
    let parts = ["drive_0.mcap", "drive_1.mcap"].map(|name| {
        fs::write(folder.join(name), &whole).unwrap();
        folder.join(name).to_str().unwrap().to_owned()
    });
    let of_each = || recorded.verify(&[&parts[0], &parts[1]], &[]).2;
    assert_eq!(of_each(), "", "two recordings");
    list_files(&folder, &["drive_0.mcap", "drive_1.mcap"]);
    let what = "is one of the 2 files of a recording; to check it as a whole, name the folder:";
    let expected = format!("note: {} {what} {}", parts[0], folder.display());
    assert_eq!(unwrapped(&of_each()), expected);
    // The only file of a recording is the whole.
    list_files(&folder, &["drive_0.mcap"]);
    assert_eq!(of_each(), "");
}

#[test]
fn a_bag_that_cannot_be_checked_is_refused() {
    let recorded = Recorded::new();
    let (scope, mapping) = (recorded.path("nav2.scope"), recorded.path("mapping.toml"));
    let said = refusal(&["verify", &recorded.path("nav2.mcap"), "--property", &scope]);
    assert!(said.contains("there is no mapping from the messages") && said.contains("verify --list"), "{said}");
    let log = recorded.write("run.jsonl", b"{}\n");
    let said = refusal(&["verify", &log, "--property", &scope, "--map-channels", &mapping]);
    assert!(said.contains("is not a ROS 2 bag, so it needs no mapping"), "{said}");
    let (slip, ros_1) = (recorded.path("nav3.mcap"), recorded.write("old.bag", b"#ROSBAG V2.0\n"));
    let said = refusal(&["verify", &slip, "--property", &scope, "--map-channels", &mapping]);
    assert!(said.contains("cannot read") && said.contains("nav3.mcap: No such file"), "{said}");
    for more in [&["--property", &scope, "--map-channels", &mapping][..], &["--property", &scope], &["--list"]] {
        let said = refusal(&[&["verify", &ros_1], more].concat());
        assert!(said.contains("old.bag is a bag of ROS 1") && said.contains("rosbags-convert --src"), "{said}");
    }
    for (name, bytes, why) in [
        ("empty.btlog", &b""[..], "empty.btlog: it is empty"),
        ("text.btlog", b"{}\n", "text.btlog: it does not begin as `FileLogger2`"),
        ("old.fbl", b"\x10\0\0\0", "old.fbl: it is a log of `FileLogger`"),
    ] {
        let said = refusal(&["verify", &recorded.write(name, bytes), "--property", "phi1", "--scenario", "nominal"]);
        assert!(unwrapped(&said).contains(why), "{said}");
    }
    let said = refusal(&["verify", "--list", &log]);
    assert!(said.contains("run.jsonl is not a bag"), "{said}");
}

#[test]
fn the_list_is_a_valid_mapping() {
    let recorded = Recorded::new();
    let bag = recorded.path("nav2.mcap");
    let listed = steward(&["verify", "--list", &bag]);
    assert!(listed.status.success());
    let mapping = recorded.write("listed.toml", &listed.stdout);
    let scope = recorded.write("low.scope", b"property low := always (battery_state, monitor, m.percentage >= 0.2)\n");
    let said = steward(&["verify", &bag, "--property", &scope, "--map-channels", &mapping]);
    assert_eq!(said.status.code(), Some(1), "{}", String::from_utf8_lossy(&said.stderr));
    let json = steward(&["verify", "--list", &bag, "--json"]).stdout;
    let listed: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((&listed["topics"][1]["name"], &listed["topics"][1]["messages"]), (&"/cmd_vel".into(), &120.into()));
    assert!(listed["topics"][3]["missing"].as_str().unwrap().contains("differs between distributions"), "{listed}");
}

#[test]
fn messages_that_the_mapping_leaves_out_make_the_verdicts_that_they_could_change_unsure() {
    let recorded = Recorded::new();
    let (bag, out) = (recorded.path("nav2.mcap"), recorded.path("out"));
    let scope = recorded.write(
        "calm.scope",
        b"property calm := always not (base, m, m.speed = <fast>)\n\
property starts := eventually (base, m, m.speed = <still>)\n\
property known := always (base, m, m.speed = <still> or m.speed = <fast>)\n",
    );
    let verify = |symbols: &str, more: &[&str]| {
        let mapping = format!(
            "[[messages]]\ntopic = \"/cmd_vel\"\nfrom = \"base\"\nto = \"m\"\n\
             fields = {{ speed = {{ path = \"linear.x\", symbols = {{ {symbols} }} }} }}\n"
        );
        let mapping = recorded.write("symbols.toml", mapping.as_bytes());
        let command = ["verify", &bag, "--property", &scope, "--map-channels", &mapping];
        let output = steward(&[command.as_slice(), more].concat());
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (status, said) = verify("\"0.0\" = \"still\", \"9.5\" = \"fast\"", &["--out", &out]);
    assert_eq!(status, Some(1), "{said}");
    assert!(
        said.contains("calm         unsure\n  messages on /cmd_vel are left out: the mapping has no symbol"),
        "{said}"
    );
    assert!(said.contains("without what is missing: satisfied"), "{said}");
    // The mapping has no other symbols, but the messages that it leaves out have other values.
    assert!(said.contains("known        unsure\n"), "{said}");
    let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(page.contains("It is unsure: something is missing"), "the page says so");
    let report: Value = serde_json::from_slice(&fs::read(Path::new(&out).join("report.json")).unwrap()).unwrap();
    assert_eq!(report["monitors"][0]["verdict"], "inconclusive");
    assert!(report["monitors"][0]["unsure"].as_str().unwrap().contains("no symbol"), "{report}");
    let (status, told) = verify("\"0.0\" = \"still\", \"9.5\" = \"fast\"", &["--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert_eq!((status, &told["monitors"][0]["verdict"]), (Some(1), &"unsure".into()));
    assert!(told["monitors"][0]["unsure"].as_str().unwrap().contains("no symbol"), "{told}");
    // Whatever is left out, a message that violates a property by itself does so.
    for more in [&["--json"][..], &["--json", "--out", &out]] {
        let (status, told) = verify("\"0.4\" = \"fast\", \"9.5\" = \"still\"", more);
        let told: Value = serde_json::from_str(&told).unwrap();
        let verdicts = [0, 1].map(|index| told["monitors"][index]["verdict"].as_str().unwrap());
        assert_eq!((status, verdicts), (Some(1), ["violated", "unsure"]), "{told}");
    }
}

#[test]
fn messages_that_do_not_fit_their_definition_make_verdicts_unsure() {
    let recorded = Recorded::new();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().profile("ros2").create(&mut bytes).unwrap();
    let schema = writer.add_schema("std_msgs/msg/String", "ros2msg", b"float64[10] x\n").unwrap();
    let channel_id = writer.add_channel(schema, "/b", "cdr", &BTreeMap::new()).unwrap();
    for time in 0..100 {
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &[0, 1, 0, 0, 1, 0, 0, 0, 0]).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    let bag = recorded.write("wrong.mcap", &bytes.into_inner());
    let mapping = b"[[messages]]\ntopic = \"/b\"\nfrom = \"b\"\nto = \"m\"\nfields = { x = \"x[0]\" }\n";
    let mapping = recorded.write("wrong.toml", mapping);
    let scope = recorded.write("p.scope", b"property p := always (b, m, m.x < 1)\n");
    let output = steward(&["verify", &bag, "--property", &scope, "--map-channels", &mapping]);
    let [said, noted] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(output.status.code() == Some(1) && said.contains("unsure"), "{said}");
    assert!(noted.contains("100 messages on /b are left out"), "{noted}");
}

/// A bag whose fourth message belongs before the second one, 4 s earlier. Its stamps say so; if `is_stamped`, it was
/// recorded in the order of the file, and otherwise at the times of the stamps.
fn disordered(is_stamped: bool) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().profile("ros2").use_chunks(false).create(&mut bytes).unwrap();
    let schema = writer.add_schema("p/msg/P", "ros2msg", b"builtin_interfaces/Time stamp\nint32 x\n").unwrap();
    let topics = ["/a", "/b"].map(|topic| writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap());
    let sent = [(0, 1, 1), (1, 6, 1), (1, 8, 1), (0, 2, 9), (1, 9, 1)];
    for ((topic, second, x), recorded) in sent.into_iter().zip(10_u64..) {
        let stamp_s = 1_700_000_000_u32 + second;
        let log_s = if is_stamped { 1_700_000_000 + recorded } else { u64::from(stamp_s) };
        let header = mcap::records::MessageHeader {
            channel_id: topics[topic],
            sequence: 0,
            log_time: log_s * 1_000_000_000,
            publish_time: log_s * 1_000_000_000,
        };
        let body = [[0, 1, 0, 0], stamp_s.to_le_bytes(), [0; 4], i32::to_le_bytes(x)].concat();
        writer.write_to_known_channel(&header, &body).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

#[test]
fn every_result_says_that_a_message_that_comes_too_late_makes_a_verdict_unsure() {
    let recorded = Recorded::new();
    // In the order of the file, `first` is satisfied for good; in that of the times, it is violated.
    let scope = recorded.write(
        "order.scope",
        b"property first := (not (a, m, m.x > 5)) until (b, m, true)\nproperty calm := always not (b, m, m.x > 5)\n",
    );
    let entry = |topic: &str| {
        format!("[[messages]]\ntopic = \"/{topic}\"\nfrom = \"{topic}\"\nto = \"m\"\nfields = {{ x = \"x\" }}\n")
    };
    for (name, time, more) in [("followed", "log", &["--follow"][..]), ("stamped", "stamp", &[][..])] {
        let text = format!("time = {time:?}\n{}{}", entry("a"), entry("b"));
        let mapping = recorded.write(&format!("{name}.toml"), text.as_bytes());
        let bag = recorded.write(&format!("{name}.mcap"), &disordered(time == "stamp"));
        let (out, junit) = (recorded.path(name), recorded.path(&format!("{name}.xml")));
        let command = ["verify", &bag, "--property", &scope, "--map-channels", &mapping, "--json"];
        let results = ["--out", &out, "--results", &junit];
        let output = steward(&[&command[..], &results, more].concat());
        let [said, noted] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert_eq!(output.status.code(), Some(1), "{name}: {said}{noted}");
        let late = "4.000 s too late";
        assert!(unwrapped(&noted).contains(late), "{name}: {noted}");
        let is_about_it = |monitor: &Value| monitor["unsure"].as_str().is_some_and(|why| why.contains(late));
        // One that is followed is told of in lines, the last of which has the verdicts.
        let told = if more.is_empty() { said.as_str() } else { said.lines().last().unwrap() };
        let told: Value = serde_json::from_str(told).unwrap();
        let [first, calm] = [0, 1].map(|index| &told["monitors"][index]);
        assert_eq!((&first["verdict"], &calm["verdict"]), (&"unsure".into(), &"satisfied".into()), "{name}: {told}");
        assert!(is_about_it(first), "{name}: {first}");
        let report: Value = serde_json::from_slice(&fs::read(Path::new(&out).join("report.json")).unwrap()).unwrap();
        let first = &report["monitors"][0];
        assert!(first["verdict"] == "inconclusive" && is_about_it(first), "{name}: {first}");
        let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
        assert!(page.contains("It is unsure: something is missing") && page.contains(late), "{name}: the page");
        let junit = fs::read_to_string(junit).unwrap();
        let failure = junit.split_once("<failure message=\"first is unsure\">").map(|(_, rest)| rest);
        assert!(failure.is_some_and(|rest| rest.contains(late)), "{name}: {junit}");
    }
}

#[test]
fn each_of_several_robots_is_judged_by_its_own_messages() {
    let recorded = Recorded::new();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().profile("ros2").create(&mut bytes).unwrap();
    let schema = writer.add_schema("std_msgs/msg/Int32", "ros2msg", b"int32 data\n").unwrap();
    for (topic, levels) in [("/r1/level", [9, 8]), ("/fleet/r2/level", [9, 1]), ("/limit", [2, 2])] {
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
        for (second, level) in (1_u64..).zip(levels) {
            let time = second * 1_000_000_000;
            let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, &[0, 1, 0, 0, level, 0, 0, 0]).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    let bag = recorded.write("fleet.mcap", &bytes.into_inner());
    let entry = |topic: &str, from: &str| {
        format!("[[messages]]\ntopic = {topic:?}\nfrom = {from:?}\nto = \"base\"\nfields = {{ x = \"data\" }}\n")
    };
    // The limit is the same for all.
    let mapping = recorded.write("fleet.toml", (entry("level", "battery") + &entry("/limit", "fleet")).as_bytes());
    let text = "property charged := always (battery, base, m.x >= 2)
        property anything := always not (*, base, m.x < 2)
        property limited := eventually (fleet, base, m.x = 2)\n";
    let scope = recorded.write("fleet.scope", text.as_bytes());
    let out = recorded.path("out");
    let mut command = vec!["verify", &bag, "--property", &scope, "--map-channels", &mapping];
    command.extend(["--robot", "/r1", "--robot", "fleet/r2", "--json", "--out", &out]);
    let output = steward(&command);
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    let verdict = |monitor: &Value| (monitor["name"].as_str().unwrap().to_owned(), monitor["verdict"].clone());
    let verdicts: Vec<_> = told["monitors"].as_array().unwrap().iter().map(verdict).collect();
    let expected = [
        ("r1/charged", "satisfied"),
        ("r1/anything", "satisfied"),
        ("r1/limited", "satisfied"),
        ("fleet/r2/charged", "violated"),
        ("fleet/r2/anything", "violated"),
        ("fleet/r2/limited", "satisfied"),
    ];
    assert_eq!(verdicts, expected.map(|(name, verdict)| (name.to_owned(), verdict.into())), "{output:?}");
    let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(page.contains("fleet/r2/charged") && page.contains("--robot /fleet/r2"));
    // Without robots, its topics are those of the root.
    let said = refusal(&["verify", &bag, "--property", &scope, "--map-channels", &mapping]);
    assert!(said.contains("there is no topic `/level`"), "{said}");
    let said = refusal(&["verify", &bag, "--property", &scope, "--map-channels", &mapping, "--robot", "1/r"]);
    assert!(said.contains("such as `/r1`"), "{said}");
    let command = ["verify", &bag, "--property", &scope, "--map-channels", &mapping];
    let moved = ["--robot", "/r1", "--remap", "level:=/fleet/r2/level", "--remap", "/r1/limit:=/limit"];
    let said = refusal(&[&command[..], &moved].concat());
    assert!(said.contains("fleet.toml names no topic `/r1/limit`"), "{said}");
    let told: Value =
        serde_json::from_slice(&steward(&[&command[..], &moved[..4], &["--json"]].concat()).stdout).unwrap();
    assert_eq!(told["monitors"][0]["verdict"], "violated", "{told}");
    let said = refusal(&[&command[..], &["--remap", "level=/r1/level"]].concat());
    assert!(said.contains("such as `/battery:=/base/battery`"), "{said}");
    let twice = ["--robot", "/r1", "--robot", "r1"];
    let said = refusal(&[&command[..], &twice].concat());
    assert!(said.contains("the robot /r1 is named twice"), "{said}");
}

#[test]
fn no_file_with_violations_gets_into_the_folder_of_a_bag() {
    let recorded = Recorded::new();
    let bag = recorded.root.join("nav2.mcap");
    for name in ["n1", "n2"] {
        fs::create_dir_all(recorded.root.join("bags").join(name)).unwrap();
        fs::copy(&bag, recorded.root.join("bags").join(name).join("part_0.mcap")).unwrap();
    }
    let names = || {
        let names = fs::read_dir(recorded.root.join("bags/n1")).unwrap();
        names.map(|entry| entry.unwrap().file_name()).collect::<Vec<_>>()
    };
    let [n1, n2, file, bags] = ["bags/n1", "bags/n2", "bags/n1/part_0.mcap", "bags"].map(|name| recorded.path(name));
    let inner = recorded.path("bags/n2/../n1/new/report");
    for (logs, out) in
        [(&[&*n1, &*n2][..], &bags), (&[&n2, &n1], &bags), (&[&n1], &n1), (&[&n1], &inner), (&[&file], &n1)]
    {
        let (status, said, noted) = recorded.verify(logs, &["--out", out]);
        assert_eq!((status, said.as_str(), names().len()), (Some(2), "", 1), "{logs:?} {out}: {noted}");
        assert!(unwrapped(&noted).contains("into the folder of the bag"), "{noted}");
    }
    let (status, _, noted) = recorded.verify(&[&n1, &n2], &["--out", &recorded.path("out")]);
    assert_eq!((status, names().len()), (Some(1), 1), "{noted}");
}

#[test]
fn no_file_with_violations_gets_into_the_folder_of_a_bag_that_is_not_judged() {
    let recorded = Recorded::new();
    let bag = recorded.path("nav2.mcap");
    for name in ["b_0.mcap", "b_0.db3", "b_0.mcap.zstd", "metadata.yaml"] {
        let folder = recorded.root.join(format!("of_{name}"));
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join(name), "another bag").unwrap();
        let (status, said, noted) = recorded.verify(&[&bag], &["--out", folder.to_str().unwrap()]);
        assert_eq!((status, said.as_str()), (Some(2), ""), "{name}: {noted}");
        assert!(unwrapped(&noted).contains("into the folder of a bag"), "{name}: {noted}");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "{name}");
    }
}

#[test]
fn only_violations_by_steward_are_replaced() {
    let recorded = Recorded::new();
    let (bag, out) = (recorded.path("nav2.mcap"), recorded.path("out"));
    let file = recorded.root.join("out/violations.mcap");
    let (status, _, noted) = recorded.verify(&[&bag], &["--out", &out]);
    let own = fs::read(&file).unwrap();
    assert_eq!((status, recorded.verify(&[&bag], &["--out", &out]).0), (Some(1), Some(1)), "{noted}");
    assert_eq!(fs::read(&file).unwrap(), own);
    let run = recorded.path("run.mcap");
    let of_run =
        ["run", "nominal", "-q", "--set", "execution.max_time_s=1", "--record", &run, "--out", &recorded.path("r")];
    assert!(matches!(steward(&of_run).status.code(), Some(0 | 1)));
    for foreign in [fs::read(&bag).unwrap(), fs::read(run).unwrap(), own[..own.len() / 2].to_vec(), b"notes".to_vec()] {
        fs::write(&file, &foreign).unwrap();
        let (status, said, noted) = recorded.verify(&[&bag], &["--out", &out]);
        assert_eq!((status, said.as_str()), (Some(2), ""), "{noted}");
        assert!(unwrapped(&noted).contains("contains no violations by steward"), "{noted}");
        assert!(fs::read(&file).unwrap() == foreign, "it is kept");
    }
}
