//! A session in which others take part, who set its pace.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use cockpit::Cockpit;
use robot::Reading;
use runs::{FromNode, Orders, Others, Pilot, Sensed, Session};
use scenarios::scenario::find;
use serde_json::json;

use crate::browser::{Page, ask, hear, until};
use crate::sessions::seek;

/// What whoever drives the robot has seen, and whether they answer.
#[derive(Clone, Default)]
struct Driver {
    answers: Arc<AtomicBool>,
    log: Arc<Mutex<Vec<String>>>,
}

impl Driver {
    fn add(&self, what: &str) {
        self.log.lock().unwrap().push(what.to_owned());
    }

    fn log(&self) -> Vec<String> {
        self.log.lock().unwrap().clone()
    }

    /// Serves a page with whoever joins as this driver, until `interrupted` is set.
    fn served(&self, interrupted: Arc<AtomicBool>) -> (Page, std::thread::JoinHandle<()>) {
        let (driver, found) = (self.clone(), find::find("nominal").unwrap());
        let start = move || {
            Session::among(&found, &[], None, |_| {
                driver.add("join");
                Ok(Others::Pilot(Box::new(driver.clone())))
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

impl Pilot for Driver {
    fn drive(&mut self, sensed: &Sensed<'_>) -> Option<Orders> {
        // As somebody does who takes a command every 5 ms.
        pause(5);
        if !self.answers.load(Ordering::Relaxed) {
            return None;
        }
        for reading in sensed.software.readings() {
            if let Reading::Battery(battery) = reading {
                self.add(&format!("{:.0} %", battery.charge_pct));
            }
        }
        Some(Orders::default())
    }

    fn resume(&mut self) {
        self.add("resume");
    }

    fn leave(&mut self, _: &[FromNode]) {
        self.add("leave");
    }
}

#[expect(clippy::disallowed_methods, reason = "others have time of their own")]
fn pause(ms: u64) {
    std::thread::sleep(Duration::from_millis(ms));
}

#[test]
fn a_page_answers_while_the_run_waits_for_others() {
    let driver = Driver::default();
    let page = driver.page();
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
    driver.answers.store(true, Ordering::Relaxed);
    let acted = until(&mut pilot, |known| known["battery"]["pct"].as_f64().is_some_and(|pct| pct < 12.1));
    assert!(acted["time"].as_f64() > Some(0.0));
    // A frame has only what has changed.
    until(&mut pilot, |known| known["waits"] != true && known["time"].as_f64() > Some(1.5));
    assert!(driver.log().contains(&"12 %".to_owned()), "{:?}", driver.log());
    // In the past, they set no pace.
    seek(&mut pilot, 0.5);
    assert!(ask(&mut pilot, &json!({ "do": "speed", "times": 2 })).is_null());
}

#[test]
fn time_stands_still_while_the_page_is_paused_and_others_are_told_when_it_goes_on() {
    let driver = Driver::default();
    driver.answers.store(true, Ordering::Relaxed);
    let page = driver.page();
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
    let resumed = driver.log().iter().filter(|what| *what == "resume").count();
    assert_eq!(resumed, 2, "before the step, and before it went on");
}

#[test]
fn others_leave_before_the_run_begins_anew_and_when_it_ends() {
    let driver = Driver::default();
    let interrupted = Arc::<AtomicBool>::default();
    let (page, serving) = driver.served(Arc::clone(&interrupted));
    let mut pilot = page.socket(&page.pilot);
    assert!(ask(&mut pilot, &json!({ "do": "restart" })).is_null());
    assert_eq!(driver.log(), ["join", "leave", "join"]);
    assert!(ask(&mut pilot, &json!({ "do": "end" }))["trace_hash"].is_string());
    assert_eq!(driver.log()[3..], ["leave"]);
    let report = ask(&mut pilot, &json!({ "do": "report" }));
    assert!(report["page"].as_str().unwrap().contains("another run need not be the same"));
    ask(&mut pilot, &json!({ "do": "restart" }));
    interrupted.store(true, Ordering::Relaxed);
    serving.join().unwrap();
    assert_eq!(driver.log()[3..], ["leave", "join", "leave"]);
}
