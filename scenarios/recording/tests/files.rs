//! Files of runs: what they keep, in each format, and why one is refused.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use recording::{Archive, EventLogWriter, FORMAT, Follower, Recording, RecordingError, RunView};

use crate::drive::{end, record, start, steps};

/// The bytes of the run in a file of this name.
fn recorded(folder: &Path, name: &str) -> Vec<u8> {
    let path = folder.join(name);
    record(&path);
    fs::read(path).unwrap()
}

/// The run in a file, up to its end.
fn played(path: &Path) -> Result<RunView, RecordingError> {
    let mut recording = Recording::open(path)?;
    let mut view = recording.begin()?;
    while view.end().is_none() {
        recording.advance(&mut view)?;
    }
    Ok(view)
}

/// Writes a recording again, in another format or the same.
fn copy(from: &Path, to: &Path) {
    let mut recording = Recording::open(from).unwrap();
    let mut view = recording.begin().unwrap();
    let mut archive = Archive::begin(to, &view).unwrap();
    while view.end().is_none() {
        recording.advance(&mut view).unwrap();
        archive.follow(&view).unwrap();
    }
    archive.finish().unwrap();
}

#[test]
fn each_format_gives_back_the_run_and_can_be_written_as_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let [own, mcap] = ["run.rec", "run.MCAP"].map(|name| recorded(folder.path(), name));
    assert!(own == recorded(folder.path(), "again.rec") && mcap == recorded(folder.path(), "again.mcap"));
    for name in ["run.rec", "run.MCAP"] {
        let view = played(&at(name)).unwrap();
        assert_eq!(view.header().scenario, "drive");
        assert_eq!((view.time(), view.end().unwrap().trace_hash.as_str()), (steps().last().unwrap().time, "abc"));
        assert_eq!(view.scene(), &**steps()[260].details.as_ref().unwrap().scene.as_ref().unwrap(), "{name}");
        copy(&at(name), &at("copy.rec"));
        assert!(fs::read(at("copy.rec")).unwrap() == own, "{name}");
        copy(&at(name), &at("copy.mcap"));
        assert!(fs::read(at("copy.mcap")).unwrap() == mcap, "{name}");
    }
}

#[test]
fn an_archive_that_is_not_finished_leaves_no_file_of_its_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.rec", "run.mcap", "run.jsonl"] {
        let path = folder.path().join(name);
        let mut archive = Archive::begin(&path, &start()).unwrap();
        archive.follow(&start()).unwrap();
        drop(archive);
        assert!(!path.exists(), "{name}");
    }
}

/// An MCAP file that is not a recording.
fn of_another_program() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut file).unwrap();
    let topic = writer.add_channel(0, "/camera", "json", &BTreeMap::new()).unwrap();
    let header = mcap::records::MessageHeader { channel_id: topic, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, b"{}").unwrap();
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

#[test]
fn an_incomplete_a_damaged_and_a_foreign_file_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let message = |bytes: &[u8]| {
        let path = folder.path().join("bad.rec");
        fs::write(&path, bytes).unwrap();
        played(&path).unwrap_err().to_string()
    };
    let whole = recorded(folder.path(), "run.rec");
    let changed = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x40;
        bytes
    };
    for (bytes, reason) in [
        (&whole[..whole.len() - 1], "ends before its run does, "),
        (&whole[..15], "ends before its run does, and contains no step of it"),
        (b"", "is not a recording of a run"),
        (b"{\"scenario\":\"nominal\"}\n", "is not a recording of a run"),
        (&changed(8), "of the format; this program reads version"),
        (&changed(whole.len() / 2), "is damaged"),
    ] {
        assert!(message(bytes).contains(reason), "{}", message(bytes));
    }
    assert!(message(&changed(8)).ends_with(&format!("this program reads version {FORMAT}")));
    let whole = recorded(folder.path(), "run.mcap");
    let ends = message(&whole[..whole.len() / 2]);
    assert!(ends.contains("ends before its run does, at "), "{ends}");
    assert!(message(&whole[..8]).contains("is not a recording of a run"));
    // In the records: a damaged index or another topic does not matter.
    let mut damaged = whole.clone();
    let name = damaged.windows(5).position(|bytes| bytes == b"drive").unwrap();
    damaged[name] ^= 0x40;
    assert!(message(&damaged).contains("is damaged"));
    assert!(message(&of_another_program()).contains("is not a recording of a run"));
    let missing = played(&folder.path().join("none.rec")).unwrap_err();
    assert!(matches!(missing, RecordingError::Read { .. }), "{missing}");
}

#[test]
fn an_event_log_has_the_events_and_the_changes_of_the_tree() {
    let mut view = start();
    let mut log = EventLogWriter::begin(Vec::new(), &view).unwrap();
    for step in steps().drain(1..=130) {
        view.apply(step).unwrap();
        log.follow(&view).unwrap();
    }
    let text = String::from_utf8(log.finish().unwrap()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let provenance = r#"{"commit":null,"inputs":[],"scenario":"","set":[]}"#;
    let channels = r#"{"BatteryLevel → BT":["failure()","success()"],"BatteryReader → BatteryLevel":["ok(level)"]}"#;
    let run = r#""scenario":"drive","seed":7,"tick_s":1.0,"version":"""#;
    assert_eq!(lines[0], format!(r#"{{"channels":{channels},"has_end":true,"provenance":{provenance},{run}}}"#));
    assert_eq!(lines[1], r#"{"generated":"tick","step":0,"tick":0,"time_s":0.2}"#);
    let level =
        r#"{"from":"BatteryReader","message":[{"sym":"ok"},79.8],"step":1,"tick":0,"time_s":0.2,"to":"BatteryLevel"}"#;
    assert_eq!(lines[2], level);
    assert_eq!(lines[3], r#"{"tick":0,"time_s":0.2,"tree":{"0 root":null,"1 BatteryLevel":"running"}}"#);
    // The tree's line is not repeated while nothing changes in it.
    assert_eq!(lines.len(), 4 + 2 + 2);
    let mut log = EventLogWriter::begin(Vec::new(), &view).unwrap();
    view.finish(end()).unwrap();
    log.follow(&view).unwrap();
    let text = String::from_utf8(log.finish().unwrap()).unwrap();
    let last: serde_json::Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    let time_s = view.time().as_secs_f64();
    // This log begins with the end, so it has no tick before it.
    assert_eq!(last, serde_json::json!({ "end": "time_limit", "step": 0, "time_s": time_s }));
}
