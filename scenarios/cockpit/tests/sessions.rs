//! A session with a person in it.

use runs::Session;
use scenarios::scenario::find;
use serde_json::{Value, json};

use crate::browser::{Socket, ask, hear, until};
use crate::session;

/// Whether a value is a time.
pub(crate) fn is_at(value: &Value, time: f64) -> bool {
    value.as_f64().is_some_and(|at| (at - time).abs() < 1e-6)
}

/// Goes to a time; returns what is shown there.
pub(crate) fn seek(socket: &mut Socket, time: f64) -> Value {
    ask(socket, &json!({ "do": "seek", "time": time }));
    until(socket, |known| is_at(&known["at"], time) && known["anew"] == true && known["verdicts"].is_string())
}

/// The trace hash of a run of a scenario that was saved.
fn hash_of(scenario: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.toml");
    std::fs::write(&file, scenario).unwrap();
    let mut session = Session::new(&find::find(file.to_str().unwrap()).unwrap(), &[], None).unwrap();
    while session.view().end().is_none() {
        session.step(recording::Detail::Verdicts).unwrap();
    }
    session.view().end().unwrap().trace_hash.clone()
}

#[test]
fn the_past_is_shown_while_a_session_goes_on() {
    let page = session("nominal", None);
    let mut pilot = page.socket(&page.pilot);
    ask(&mut pilot, &json!({ "do": "pause" }));
    while hear(&mut pilot, "ticks").as_u64().unwrap() < 9 {
        ask(&mut pilot, &json!({ "do": "tick" }));
    }
    ask(&mut pilot, &json!({ "do": "pause" }));
    let was = seek(&mut pilot, 3.0);
    assert_eq!((&was["time"], &was["past"]), (&json!(3.0), &json!(true)));
    let now = was["to"].as_f64().unwrap();
    assert!(now > 7.0, "{now}");
    let fault = json!({ "do": "act", "fault": { "kind": "battery_level", "level_pct": 12 } });
    assert_eq!(ask(&mut pilot, &fault)["refused"], "the past cannot be changed; go back to now");
    // Steps and ticks move through the past; the session stays where it is.
    ask(&mut pilot, &json!({ "do": "step" }));
    assert!(is_at(&until(&mut pilot, |known| is_at(&known["time"], 3.02))["to"], now));
    ask(&mut pilot, &json!({ "do": "tick" }));
    let later = until(&mut pilot, |known| known["ticks"] != was["ticks"] && known["ticks"].is_number());
    assert!(later["past"] == true && is_at(&later["to"], now), "{later}");
    ask(&mut pilot, &json!({ "do": "now" }));
    let back = until(&mut pilot, |known| known["past"] == false && known["pose"].is_array());
    assert!(is_at(&back["time"], now) && back["pose"] != was["pose"], "{back}");
    assert!(ask(&mut pilot, &fault)["act"].is_number());
    let end = ask(&mut pilot, &json!({ "do": "end" }));
    let saved = ask(&mut pilot, &json!({ "do": "save" }));
    assert_eq!(hash_of(saved["scenario"].as_str().unwrap()), end["trace_hash"].as_str().unwrap());
}

#[test]
fn a_session_has_a_report_once_it_has_ended_and_begins_anew() {
    let page = session("nominal", None);
    let mut pilot = page.socket(&page.pilot);
    until(&mut pilot, |known| known["time"].as_f64() > Some(0.5));
    assert_eq!(ask(&mut pilot, &json!({ "do": "report" }))["refused"], "there is a report once the run has ended");
    let fault = json!({ "do": "act", "fault": { "kind": "battery_level", "level_pct": 12 } });
    assert!(ask(&mut pilot, &fault)["act"].is_number());
    until(&mut pilot, |known| known["battery"]["pct"].as_f64().is_some_and(|pct| pct < 13.0));
    ask(&mut pilot, &json!({ "do": "end" }));
    let report = ask(&mut pilot, &json!({ "do": "report" }));
    let page = report["page"].as_str().unwrap();
    assert!(page.contains("12 %"), "what was done by hand is in it");
    assert!(page.contains("Without what was done by hand") && !page.contains("the same run to the last bit"));
    ask(&mut pilot, &json!({ "do": "restart" }));
    // Everybody is greeted again, since the scenario's files may have changed.
    hear(&mut pilot, "greeting");
    let again = until(&mut pilot, |known| known["end"].is_null() && known["battery"].is_object());
    assert!(again["time"].as_f64() < Some(20.0) && again["battery"]["pct"].as_f64() > Some(20.0), "{again}");
}
