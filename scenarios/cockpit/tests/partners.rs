//! A session with a partner, which sets its pace.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use cockpit::Cockpit;
use robot::Reading;
use runs::{Controller, ControllerInput, ControllerOutput, NodeMessage, Partners, Session};
use scenarios::scenario::find;
use serde_json::json;

use crate::browser::{Page, ask, hear, until};
use crate::sessions::seek;

/// A controller that is ready once it `answers`, with a log of its calls and of what it receives.
#[derive(Clone, Default)]
struct SlowController {
    answers: Arc<AtomicBool>,
    log: Arc<Mutex<Vec<String>>>,
}

impl SlowController {
    fn add(&self, what: &str) {
        self.log.lock().unwrap().push(what.to_owned());
    }

    fn log(&self) -> Vec<String> {
        self.log.lock().unwrap().clone()
    }

    /// Serves the page of a session with this controller, until `interrupted` is set.
    fn served(&self, interrupted: Arc<AtomicBool>) -> (Page, std::thread::JoinHandle<()>) {
        let (controller, found) = (self.clone(), find::find("nominal").unwrap());
        let start = move || {
            Session::with_partners(&found, &[], None, |_| {
                controller.add("join");
                Ok(Partners::Controller(Box::new(controller.clone())))
            })
        };
        let cockpit = Cockpit::open(start, 0).unwrap();
        let page = Page::new(&cockpit.address(), &cockpit.address_for_viewers());
        (page, std::thread::spawn(move || cockpit.serve_until(&interrupted).unwrap()))
    }

    fn page(&self) -> Page {
        self.served(Arc::default()).0
    }
}

impl Controller for SlowController {
    fn drive(&mut self, input: &ControllerInput<'_>) -> Option<ControllerOutput> {
        // As a controller does that gets a command every 5 ms.
        pause(5);
        if !self.answers.load(Ordering::Relaxed) {
            return None;
        }
        for reading in input.software.readings() {
            if let Reading::Battery(battery) = reading {
                self.add(&format!("{:.0} %", battery.charge_pct));
            }
        }
        Some(ControllerOutput::default())
    }

    fn resume(&mut self) {
        self.add("resume");
    }

    fn leave(&mut self, _: &[NodeMessage]) {
        self.add("leave");
    }
}

#[expect(clippy::disallowed_methods, reason = "partners have a time of their own")]
fn pause(ms: u64) {
    std::thread::sleep(Duration::from_millis(ms));
}

#[test]
fn a_page_answers_while_the_run_waits_for_partners() {
    let controller = SlowController::default();
    let page = controller.page();
    let mut pilot = page.socket(&page.pilot);
    assert_eq!(hear(&mut pilot, "greeting")["paced"], true);
    let waits = until(&mut pilot, |known| known["waits"] == true);
    assert_eq!(waits["time"], 0.0);
    let fault = json!({ "do": "act", "fault": { "kind": "battery_level", "level_pct": 12 } });
    assert!(ask(&mut pilot, &fault)["act"].is_number());
    let saved = ask(&mut pilot, &json!({ "do": "save" }));
    assert!(saved["note"].as_str().unwrap().contains("is not in it"), "{saved}");
    assert!(!saved["scenario"].as_str().unwrap().contains("[expect]"), "{saved}");
    let refused = ask(&mut pilot, &json!({ "do": "speed", "times": 2 }));
    assert!(refused["refused"].as_str().unwrap().contains("pace"), "{refused}");
    controller.answers.store(true, Ordering::Relaxed);
    let acted = until(&mut pilot, |known| known["battery"]["pct"].as_f64().is_some_and(|pct| pct < 12.1));
    assert!(acted["time"].as_f64() > Some(0.0));
    // A frame has only what has changed.
    until(&mut pilot, |known| known["waits"] != true && known["time"].as_f64() > Some(1.5));
    assert!(controller.log().contains(&"12 %".to_owned()), "{:?}", controller.log());
    // In the past, they set no pace.
    seek(&mut pilot, 0.5);
    assert!(ask(&mut pilot, &json!({ "do": "speed", "times": 2 })).is_null());
}

#[test]
fn time_stands_still_while_the_page_is_paused_and_partners_are_notified_when_it_goes_on() {
    let controller = SlowController::default();
    controller.answers.store(true, Ordering::Relaxed);
    let page = controller.page();
    let mut pilot = page.socket(&page.pilot);
    until(&mut pilot, |known| known["time"].as_f64() > Some(0.2));
    assert!(ask(&mut pilot, &json!({ "do": "pause" })).is_null());
    let paused = until(&mut pilot, |known| known["paused"] == true);
    pause(300);
    ask(&mut pilot, &json!({ "do": "step" }));
    let stepped = until(&mut pilot, |known| known["to"].as_f64() > paused["to"].as_f64());
    let passed = stepped["to"].as_f64().unwrap() - paused["to"].as_f64().unwrap();
    assert!((passed - 0.02).abs() < 1e-6, "{passed}");
    assert_eq!(stepped["paused"], true);
    ask(&mut pilot, &json!({ "do": "resume" }));
    until(&mut pilot, |known| known["to"].as_f64() > Some(stepped["to"].as_f64().unwrap() + 0.2));
    let resumed = controller.log().iter().filter(|what| *what == "resume").count();
    assert_eq!(resumed, 2, "before the step, and before it went on");
}

#[test]
fn partners_leave_before_the_run_restarts_and_when_it_ends() {
    let controller = SlowController::default();
    let interrupted = Arc::<AtomicBool>::default();
    let (page, serving) = controller.served(Arc::clone(&interrupted));
    let mut pilot = page.socket(&page.pilot);
    assert!(ask(&mut pilot, &json!({ "do": "restart" })).is_null());
    assert_eq!(controller.log(), ["join", "leave", "join"]);
    assert!(ask(&mut pilot, &json!({ "do": "end" }))["trace_hash"].is_string());
    assert_eq!(controller.log()[3..], ["leave"]);
    let report = ask(&mut pilot, &json!({ "do": "report" }));
    assert!(report["page"].as_str().unwrap().contains("another run need not be the same"));
    ask(&mut pilot, &json!({ "do": "restart" }));
    interrupted.store(true, Ordering::Relaxed);
    serving.join().unwrap();
    assert_eq!(controller.log()[3..], ["leave", "join", "leave"]);
}
