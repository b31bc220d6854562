//! `steward skill`: machines checked, shown and run without a robot.

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, steward};

/// Opens after three knocks, and shuts again on its own.
const DOOR: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Door">
  <datamodel> <data id="knocks" expr="0"/> </datamodel>
  <state id="shut">
    <onentry> <log label="door" expr="'shut after ' + knocks"/> </onentry>
    <transition event="knock" cond="knocks == 2" target="open"> <assign location="knocks" expr="3"/> </transition>
    <transition event="knock"> <assign location="knocks" expr="knocks + 1"/> </transition>
    <transition event="leave" target="gone"> <log expr="_event.data.why"/> </transition>
  </state>
  <state id="open" initial="ajar">
    <state id="ajar"> <transition event="push" target="wide"/> </state>
    <state id="wide"/>
    <onentry> <send event="shut" delay="2.5s"/> </onentry>
    <transition event="shut" target="shut"/>
  </state>
  <final id="gone"> <donedata> <param name="knocks" expr="knocks"/> </donedata> </final>
</scxml>"#;

const EVENTS: &str = r#"
# Two knocks at once, and a third a second later.
{"event": "knock", "time_s": 1}
{"event": "knock"}
{"event": "knock", "time_s": 2}
{"event": "push", "time_s": 2.5}
{"event": "leave", "time_s": 10, "data": {"why": "nobody is in"}}
"#;

/// A machine and its events in their own folder.
struct Files {
    folder: TempDir,
    machine: PathBuf,
    events: PathBuf,
}

fn files(machine: &str, events: &str) -> Files {
    let folder = tempdir().unwrap();
    let (machine_file, events_file) = (folder.path().join("Door.scxml"), folder.path().join("events.jsonl"));
    std::fs::write(&machine_file, machine).unwrap();
    std::fs::write(&events_file, events).unwrap();
    Files { folder, machine: machine_file, events: events_file }
}

/// Calls `steward skill run` on these files.
fn run(files: &Files, further: &[&str]) -> Output {
    let mut arguments = vec!["skill", "run", text(&files.machine), "--events", text(&files.events)];
    arguments.extend(further);
    steward(&arguments)
}

/// The output of a call, which must end with that status.
fn said(output: Output, status: i32) -> String {
    assert_eq!(output.status.code(), Some(status), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A machine with this content.
fn machine(content: &str) -> String {
    let head = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">"#;
    format!("{head}\n{content}\n</scxml>")
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_correct_machine_is_accepted() {
    let files = files(DOOR, "");
    let machine = text(&files.machine);
    let fine = format!(
        "{machine}: 5 states, 5 transitions, not compared with the messages of a scenario; no problems found\n"
    );
    assert_eq!(said(steward(&["skill", "check", machine]), 0), fine);
    let output = steward(&["skill", "check", machine, "nowhere.scxml", machine]);
    let end = "nowhere.scxml: 1 problem\n".to_owned() + &fine + "3 files checked, 1 with problems\n";
    assert_eq!(said(output, 2), fine + &end);
}

#[test]
fn an_incorrect_machine_is_refused_with_the_locations_of_all_errors() {
    let wrong = DOOR
        .replace("target=\"wide\"", "target=\"wid\"")
        .replace("<assign location=\"knocks\" expr=\"3\"/>", "<asign/>");
    let wrong = wrong.replace("delay=\"2.5s\"", "delay=\"soon\"");
    let files = files(&wrong, "");
    let said = refusal(&["skill", "check", text(&files.machine)]);
    for part in ["`wide`", "Door.scxml:10:56", "<asign>", "Door.scxml:5:66", "soon", "Door.scxml:12:41"] {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
}

#[test]
fn suspicious_constructs_in_a_valid_machine_give_warnings() {
    let odd = DOOR.replace("<state id=\"wide\"/>", "<state id=\"wide\"/><state id=\"never\"/>");
    let files = files(&odd, "");
    let output = steward(&["skill", "check", text(&files.machine)]);
    let warned = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(warned.contains("never") && warned.contains("Door.scxml:11"), "{warned}");
    assert!(
        said(output, 0).ends_with(
            "Door.scxml: 6 states, 5 transitions, not compared with the messages of a scenario; 1 warning\n"
        )
    );
}

#[test]
#[cfg(feature = "ecmascript")]
fn a_date_that_would_become_data_gives_a_warning_where_it_is_written() {
    let dated =
        DOOR.replace("<assign location=\"knocks\" expr=\"3\"/>", "<assign location=\"knocks\" expr=\"new Date()\"/>");
    let files = files(&dated, "");
    let output = steward(&["skill", "check", text(&files.machine)]);
    let warned = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(warned.contains("a `Date` cannot be kept in data") && warned.contains("Door.scxml:5"), "{warned}");
    assert!(said(output, 0).ends_with("not compared with the messages of a scenario; 1 warning\n"), "{warned}");
}

#[test]
fn a_missing_file_is_bad_input() {
    assert!(refusal(&["skill", "check", "nowhere/Door.scxml"]).contains("nowhere/Door.scxml"));
    assert!(refusal(&["skill", "run", "nowhere/Door.scxml"]).contains("nowhere/Door.scxml"));
}

#[test]
fn a_machine_is_shown_in_three_ways() {
    let files = files(DOOR, "");
    let show = |further: &[&str]| said(steward(&[&["skill", "show", text(&files.machine)], further].concat()), 0);
    let outline = show(&[]);
    assert!(outline.contains("  open") && outline.contains("    wide"), "{outline}");
    assert!(show(&["--format", "dot"]).starts_with("digraph \"Door\" {"));
    let drawing = show(&["--format", "svg"]);
    assert!(drawing.starts_with("<svg ") && drawing.contains(">ajar<"), "{drawing}");
}

#[test]
fn a_run_prints_log_lines_the_configurations_entered_and_the_final_one() {
    let files = files(DOOR, EVENTS);
    let lines = [
        "0.000 s  log door: shut after 0",
        "0.000 s  in shut",
        "2.000 s  in ajar",
        "2.500 s  in wide",
        "4.500 s  log door: shut after 3",
        "4.500 s  in shut",
        "10.000 s  log nobody is in",
        "10.000 s  in gone",
        "10.000 s  final configuration: gone (done) {\"knocks\": 3}",
    ];
    assert_eq!(said(run(&files, &[]), 0).lines().collect::<Vec<_>>(), lines);
}

#[test]
fn json_has_one_object_per_line() {
    let files = files(DOOR, EVENTS);
    let printed = said(run(&files, &["--json"]), 0);
    let lines: Vec<Value> = printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 9, "{printed}");
    assert_eq!(lines[0], json!({"time_s": 0, "log": {"label": "door", "text": "shut after 0"}}));
    assert_eq!(lines[2], json!({"time_s": 2, "configuration": ["open", "ajar"], "active": ["ajar"]}));
    let last = json!({"time_s": 10, "final": ["gone"], "active": ["gone"], "status": "done", "result": {"knocks": 3}});
    assert_eq!(lines[8], last);
}

#[test]
fn a_machine_without_further_events_ends_successfully() {
    let files = files(DOOR, r#"{"event": "knock"}"#);
    let printed = said(run(&files, &[]), 0);
    assert!(printed.ends_with("0.000 s  final configuration: shut (waiting)\n"), "{printed}");
}

#[test]
fn unhandled_error_events_give_exit_status_1() {
    let fails = r#"<state id="s"><onentry><assign location="missing" expr="1"/></onentry>"#;
    let files_of = |rest: &str| files(&machine(&format!("{fails}{rest}</state><final id=\"end\"/>")), "");
    let printed = said(run(&files_of(""), &[]), 1);
    assert!(
        printed.contains("error.execution at 2:25") && printed.contains("error.execution is not handled"),
        "{printed}"
    );
    let printed = said(run(&files_of(""), &["--json"]), 1);
    let lines: Vec<Value> = printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((&lines[0]["error"]["line"], &lines[0]["error"]["column"]), (&json!(2), &json!(25)), "{printed}");
    assert!(lines.iter().any(|line| line["unhandled"] == "error.execution"), "{printed}");
    said(run(&files_of("<transition event=\"error.*\" target=\"end\"/>"), &[]), 0);
}

#[test]
fn a_livelocked_machine_is_stopped_with_exit_status_1() {
    let files = files(
        &machine(r#"<state id="a"><transition target="b"/></state><state id="b"><transition target="a"/></state>"#),
        "",
    );
    let printed = said(run(&files, &[]), 1);
    assert!(printed.contains("did not come to rest") && printed.contains("(stuck)"), "{printed}");
}

#[test]
fn delays_take_no_real_time_and_end_with_simulated_time() {
    let clock = r#"<state id="s"><onentry><send event="tick" delay="100s"/></onentry><transition event="tick" target="s"/></state>"#;
    let files = files(&machine(clock), "");
    let entered = |printed: String| printed.lines().filter(|line| line.ends_with("in s")).count();
    assert_eq!(entered(said(run(&files, &[]), 0)), 37, "once at the start, and 36 times in an hour");
    assert_eq!(entered(said(run(&files, &["--until", "250"]), 0)), 3);
    assert!(refusal(&["skill", "run", text(&files.machine), "--until=-1"]).contains("is not a time"));
}

#[test]
fn invalid_events_are_refused_with_all_errors() {
    let files = files(
        DOOR,
        "{\"event\": \"knock\", \"tim_s\": 1}\n{\"data\": 1}\nknock\n{\"event\": \"knock\", \"time_s\": -1}\n",
    );
    let said = refusal(&["skill", "run", text(&files.machine), "--events", text(&files.events)]);
    let parts = [
        "events.jsonl:1",
        "did you mean `time_s`?",
        "the event has no name",
        "not a JSON object",
        "-1 s is not a time",
    ];
    for part in parts {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
    let missing = refusal(&["skill", "run", text(&files.machine), "--events", "nowhere.jsonl"]);
    assert!(missing.contains("nowhere.jsonl"), "{missing}");
}

#[test]
fn a_machine_invokes_the_file_beside_it() {
    let parent = machine(
        r#"<state id="calls"><invoke id="inner" src="inner.scxml"/>
        <transition event="done.invoke.inner" cond="_event.data == 42" target="end"/></state><final id="end"/>"#,
    );
    let files = files(&parent, "");
    let inner = r#"<final id="f"><donedata><content expr="42"/></donedata></final>"#;
    std::fs::write(files.folder.path().join("inner.scxml"), machine(inner)).unwrap();
    assert!(said(run(&files, &[]), 0).ends_with("final configuration: end (done)\n"));
}

#[test]
fn outgoing_events_are_printed() {
    let sends = r#"<state id="s"><onentry><send type="channel" target="Speaker" event="say"><param name="text" expr="'hi'"/></send></onentry></state>"#;
    let files = files(&machine(sends), "");
    let printed = said(run(&files, &[]), 0);
    assert!(printed.contains("0.000 s  sends say to Speaker {\"text\": \"hi\"}"), "{printed}");
}

/// The leaf asks an arm, and has no file of its own.
#[test]
fn the_machine_of_a_leaf_that_asks_is_shown_and_is_correct_in_its_scenario() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).unwrap();
        folder.path().join(name)
    };
    let tree = "<BehaviorTree ID=\"T\"><Do/></BehaviorTree>\
                <TreeNodesModel><Action ID=\"Do\"><input_port name=\"what\"/></Action></TreeNodesModel>";
    write("tree.xml", &format!("<root BTCPP_format=\"4\">{tree}</root>"));
    write("arm.toml", "[services.weigh]\nrequest = { what = \"text\" }\nreply = { grams = \"real\" }\n");
    let answers = r#"<state id="here"><transition event="weigh">
        <send type="channel" targetexpr="_event.origin" event="ok"><param name="grams" expr="3"/></send>
        </transition></state>"#;
    write("Arm.scxml", &machine(answers));
    std::fs::create_dir(folder.path().join("skills")).unwrap();
    let lines = "tree = \"tree.xml\"\nskills = \"skills\"\nexecution.max_time_s = 12\n\
                 components.Arm.machine = \"Arm.scxml\"\ncomponents.Arm.interface = \"arm.toml\"\n\
                 leaves.Do = { request = \"Arm.weigh\", arguments.what = \"a < 'b'\" }\n";
    let scenario = write("own.toml", lines);
    let checked = steward(&["check", text(&scenario)]);
    let warned = String::from_utf8_lossy(&checked.stderr).into_owned();
    assert!(!warned.contains("is never entered"), "{warned}");
    said(checked, 0);
    let shown = said(steward(&["skill", "show", "Do", "--scenario", text(&scenario), "--format", "scxml"]), 0);
    let file = write("skills/Do.scxml", &shown);
    said(steward(&["skill", "check", text(&file), "--scenario", text(&scenario)]), 0);
}

/// A machine that answers the tree and asks a process that exists in no shipped system.
const ASKS_A_SPEAKER: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Charge">
  <state id="asked">
    <transition event="BT.tick"> <send type="channel" target="Speaker" event="say"/> <send type="channel" target="BT" event="running"/> </transition>
    <transition event="BT.halt"> <send type="channel" target="BT" event="halted"/> </transition>
  </state>
</scxml>"#;

#[test]
fn a_process_that_no_shipped_scenario_has_is_only_a_hint() {
    let folder = tempdir().unwrap();
    let machine = folder.path().join("Charge.scxml");
    std::fs::write(&machine, ASKS_A_SPEAKER).unwrap();
    let checked = steward(&["skill", "check", machine.to_str().unwrap()]);
    assert!(checked.status.success(), "it is only a hint");
    let said = String::from_utf8(checked.stderr).unwrap();
    assert!(said.contains("the machine sends to the process `Speaker`"), "{said}");
}

#[test]
fn an_undeliverable_answer_is_visible_in_a_rehearsal() {
    let folder = tempdir().unwrap();
    let (machine, events) = (folder.path().join("Level.scxml"), folder.path().join("events.jsonl"));
    let text = ASKS_A_SPEAKER.replace("type=\"channel\" target=\"BT\" event=\"running\"", "event=\"TICK_RESPONSE\"");
    std::fs::write(&machine, text).unwrap();
    std::fs::write(&events, "{\"event\": \"BT.tick\", \"time_s\": 1}\n").unwrap();
    let run = steward(&["skill", "run", machine.to_str().unwrap(), "--events", events.to_str().unwrap()]);
    let said = String::from_utf8(run.stdout).unwrap();
    assert!(said.contains("1.000 s  sends TICK_RESPONSE to itself, but no transition handles it"), "{said}");
}
