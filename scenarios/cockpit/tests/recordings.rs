//! Recordings: as they were at any time, while they grow, and side by side.

use std::io::Write;
use std::path::{Path, PathBuf};

use cockpit::Cockpit;
use recording::{Archive, Detail, Follower, Recording, RunView};
use runs::Session;
use scenarios::scenario::find;
use serde_json::{Value, json};

use crate::browser::{Page, ask, hear, until};
use crate::served;
use crate::sessions::{is_at, seek};

/// Records a run of the first experiment that ends at 24 s; returns it.
fn record(path: &Path, seed: u64, overrides: &[&str]) -> RunView {
    let overrides = overrides.iter().chain(&["execution.max_time_s=24"]).map(|&set| set.to_owned());
    let found = find::find("battery_fault").unwrap();
    let mut session = Session::new(&found, &overrides.collect::<Vec<_>>(), Some(seed)).unwrap();
    let mut archive = Archive::begin(path, session.view()).unwrap();
    while session.view().end().is_none() {
        session.step(Detail::Full).unwrap();
        archive.follow(session.view()).unwrap();
    }
    archive.finish().unwrap();
    session.view().clone()
}

fn shown(recordings: &[PathBuf]) -> Page {
    served(Cockpit::replay(recordings, Recording::open, 0).unwrap())
}

fn hash(run: &RunView) -> Value {
    run.end().unwrap().trace_hash.as_str().into()
}

#[test]
fn a_recording_shows_what_the_run_was_like_at_any_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let run = record(&path, 1, &[]);
    let page = shown(&[path]);
    let mut pilot = page.socket(&page.pilot);
    let greeting = hear(&mut pilot, "greeting");
    assert_eq!((&greeting["scenario"], &greeting["file"]), (&json!("battery_fault"), &json!("run.mcap")));
    ask(&mut pilot, &json!({ "do": "pause" }));
    let end = run.time().as_secs_f64();
    until(&mut pilot, |known| known["to"] == end && known["grows"] == false);
    let phi1 = run.monitors().find(|monitor| monitor.name() == "phi1").unwrap();
    let violated = phi1.violation().unwrap().event.time.as_secs_f64();
    let happened = |shown: &Value| shown["happenings"].as_array().unwrap().iter().any(|it| it["kind"] == "violated");
    let card = |shown: &Value| shown["verdicts"].as_str().unwrap().contains("pill violated");
    for (time, is_violated) in [(violated, true), (violated - 0.02, false), (1.0, false), (violated + 1.0, true)] {
        let shown = seek(&mut pilot, time);
        assert!(is_at(&shown["time"], time), "{} instead of {time}", shown["time"]);
        assert_eq!((happened(&shown), card(&shown)), (is_violated, is_violated), "at {time} s");
        assert!(shown["end"].is_null());
    }
    let shown = seek(&mut pilot, end);
    assert_eq!(shown["end"]["trace_hash"], hash(&run));
    let act = json!({ "do": "act", "fault": { "kind": "joypad" } });
    for request in [act, json!({ "do": "save" }), json!({ "do": "end" })] {
        assert_eq!(ask(&mut pilot, &request)["refused"], "a recording cannot be changed");
    }
    for time in [-1.0, 1e300] {
        assert!(ask(&mut pilot, &json!({ "do": "seek", "time": time }))["refused"].is_string());
    }
    // Playing on at the end starts over.
    ask(&mut pilot, &json!({ "do": "resume" }));
    until(&mut pilot, |known| known["at"].as_f64().is_some_and(|at| at < end));
}

#[test]
fn a_recording_is_followed_while_it_grows() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.rec", "run.mcap"] {
        let whole = folder.path().join(name);
        let run = record(&whole, 1, &[]);
        let bytes = std::fs::read(&whole).unwrap();
        // Like a program that is still recording, and gives the file its final name at the end.
        let path = folder.path().join(format!("growing-{name}"));
        let mut file = diagnostics::Unfinished::create(&path).unwrap();
        let (begun, rest) = bytes.split_at(bytes.len() * 3 / 5);
        file.write_all(begun).unwrap();
        let page = shown(&[path]);
        let mut pilot = page.socket(&page.pilot);
        let known = until(&mut pilot, |known| known["past"] == false && known["time"].is_number());
        assert_eq!((&known["grows"], &known["at"], &known["end"]), (&json!(true), &known["to"], &Value::Null));
        assert!((1.0..24.0).contains(&known["to"].as_f64().unwrap()), "{name}: {}", known["to"]);
        file.write_all(rest).unwrap();
        file.finish().unwrap();
        let known = until(&mut pilot, |known| known["end"].is_object());
        assert_eq!((&known["end"]["trace_hash"], &known["grows"]), (&hash(&run), &json!(false)));
    }
}

#[test]
fn two_recordings_are_shown_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let paths = [folder.path().join("with.rec"), folder.path().join("without.rec")];
    let runs = [record(&paths[0], 1, &[]), record(&paths[1], 2, &["faults=[]"])];
    let page = shown(&paths);
    let mut pilot = page.socket(&page.pilot);
    assert_eq!(hear(&mut pilot, "greeting")["sides"], 2);
    ask(&mut pilot, &json!({ "do": "pause" }));
    until(&mut pilot, |known| known["to"] == 24.0 && known["grows"] == false);
    // The sides show the runs; they have no controls.
    let mut sides = [0, 1].map(|side| page.socket(&format!("{}&side={side}", page.pilot)));
    for (side, run) in sides.iter_mut().zip(&runs) {
        assert_eq!(hear(side, "greeting")["seed"], run.header().seed);
        assert_eq!(hear(side, "pilot"), false);
    }
    ask(&mut pilot, &json!({ "do": "seek", "time": 22.0 }));
    let shown = |side: &mut _| until(side, |known| known["time"] == 22.0 && known["verdicts"].is_string());
    let is_violated = |shown: Value| shown["verdicts"].as_str().unwrap().contains("pill violated");
    assert_eq!(sides.each_mut().map(|side| is_violated(shown(side))), [true, false]);
    let third = page.try_socket(&format!("{}&side=2", page.viewer), Some(&format!("http://{}", page.host)));
    assert!(matches!(third, Err(tungstenite::Error::Http(_))));
}

#[test]
fn a_file_that_is_not_a_recording_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("some.rec");
    std::fs::write(&path, "some text").unwrap();
    let replay = || Cockpit::replay(std::slice::from_ref(&path), Recording::open, 0);
    assert!(replay().is_err_and(|error| error.to_string().contains("is not a recording")));
    record(&path, 1, &[]);
    assert!(replay().is_ok());
}
