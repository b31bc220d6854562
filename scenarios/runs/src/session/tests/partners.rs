//! Sessions in which partners take part.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Duration;

use channels::{Event, EventKind};
use recording::ros::battery_state;
use recording::{Detail, Ended, Record, RunView, conduct};
use remote::{NodeMessage, ServiceRequest};
use robot::{Reading, VelocityCommand};
use ros_messages::RosType as _;
use scenarios::Error;
use scenarios::scenario::{Scenario, find};

use crate::controller::{Controller, ControllerInput, ControllerOutput};
use crate::partners::Partners;
use crate::remote_components::{Delivery, RemoteComponents};
use crate::run::Run;
use crate::session::Session;

/// The calls to partners and what they receive, in order.
#[derive(Clone, Default)]
struct Log(Rc<RefCell<Vec<String>>>);

impl Log {
    fn add(&self, what: &str) {
        self.0.borrow_mut().push(what.to_owned());
    }

    fn take(&self) -> Vec<String> {
        self.0.take()
    }
}

/// Turns on the spot, but is not ready for the first calls of each step.
struct Slow {
    hesitates: usize,
    calls: usize,
    log: Log,
}

impl Slow {
    fn new(hesitates: usize, log: &Log) -> Self {
        Self { hesitates, calls: 0, log: log.clone() }
    }
}

impl Controller for Slow {
    fn drive(&mut self, input: &ControllerInput<'_>) -> Option<ControllerOutput> {
        self.calls += 1;
        if self.calls <= self.hesitates {
            return None;
        }
        self.calls = 0;
        for reading in input.software.readings() {
            if let Reading::Battery(battery) = reading {
                self.log.add(&format!("{:.0} %", battery.charge_pct));
            }
        }
        let velocity = VelocityCommand { linear_mps: 0.0, angular_radps: 0.5 };
        Some(ControllerOutput {
            velocity: Some(velocity),
            notes: vec!["it turns".to_owned()],
            ..ControllerOutput::default()
        })
    }

    fn resume(&mut self) {
        self.log.add("resume");
    }

    fn leave(&mut self, _: &[NodeMessage]) {
        self.log.add("leave");
    }
}

/// Nodes that publish the battery's charge, and whose time has come at the second call of each step.
struct Late(bool, Log);

impl RemoteComponents for Late {
    fn run(&self) -> u64 {
        1
    }

    fn receive(&mut self, now: Duration) -> Option<Delivery> {
        self.0 = !self.0;
        let body = battery_state(now, 50.0, false).encode();
        let charge = NodeMessage::Message { topic: "/battery_state".to_owned(), body };
        let notes = vec!["they are there".to_owned()];
        (!self.0).then(|| Delivery { messages: vec![charge], notes, ..Delivery::default() })
    }

    fn resume(&mut self) {
        self.1.add("resume");
    }

    fn send(&mut self, _: Vec<ServiceRequest>) {}

    fn leave(&mut self) {
        self.1.add("leave");
    }
}

fn session(hesitates: usize, log: &Log) -> Session {
    let controller = Box::new(Slow::new(hesitates, log));
    Session::with_partners(&find::find("nominal").unwrap(), &[], None, |_| Ok(Partners::Controller(controller)))
        .unwrap()
}

/// Calls `step` this often.
fn step(session: &mut Session, times: usize) {
    for _ in 0..times {
        session.step(Detail::Full).unwrap();
    }
}

fn act(session: &mut Session, fault: &str) -> usize {
    session.act(toml::from_str(fault).unwrap()).unwrap()
}

#[test]
fn a_step_continues_where_it_waited_for_partners() {
    let hash = |hesitates: usize| {
        let mut session = session(hesitates, &Log::default());
        for step in 0..100 {
            for _ in 0..hesitates {
                assert!(!session.step(Detail::Full).unwrap());
                assert_eq!(session.view().time(), step * session.step_length());
            }
            assert!(session.step(Detail::Full).unwrap());
            let happenings = session.view().happenings().len();
            assert!(happenings >= 1, "{happenings}");
        }
        session.end();
        assert_eq!(session.view().time(), 100 * session.step_length());
        session.view().end().unwrap().trace_hash.clone()
    };
    assert_eq!(hash(0), hash(3));
}

#[test]
fn acts_take_effect_while_a_controller_drives_and_while_a_step_waits() {
    let log = Log::default();
    let mut session = session(1, &log);
    assert!(session.has_partners() && session.view().header().is_piloted);
    assert!(!session.step(Detail::Full).unwrap());
    act(&mut session, "kind = \"battery_level\"\nlevel_pct = 12");
    step(&mut session, 200);
    assert!(log.take().contains(&"12 %".to_owned()));
    assert!(session.view().robot().battery.unwrap().charge_pct < 12.1);
    let heading = maps::heading(&session.view().robot().truth.unwrap().pose);
    act(&mut session, "kind = \"emergency_stop\"");
    step(&mut session, 100);
    let then = maps::heading(&session.view().robot().truth.unwrap().pose);
    assert!((then - heading).abs() < 0.1, "it stands still: {heading} {then}");
}

#[test]
fn a_session_ends_while_a_step_waits_and_the_partners_leave() {
    let log = Log::default();
    let mut session = session(1, &log);
    let start = session.view().clone();
    step(&mut session, 9);
    act(&mut session, "kind = \"battery_level\"\nlevel_pct = 12");
    assert!(session.step(Detail::Full).unwrap());
    act(&mut session, "kind = \"battery_level\"\nlevel_pct = 11");
    assert!(!session.step(Detail::Full).unwrap(), "it waits with a fault that is not yet recorded");
    act(&mut session, "kind = \"battery_level\"\nlevel_pct = 10");
    session.end();
    assert_eq!(session.view().end().unwrap().ended, Ended::Interrupted);
    assert_eq!(log.take().iter().filter(|what| *what == "leave").count(), 1);
    // The records fit each other.
    let mut view: RunView = start;
    for record in session.take_records() {
        match record {
            Record::Header(_) => panic!("it is known"),
            Record::Step(step) => view.apply(step).unwrap(),
            Record::End(end) => view.finish(*end).unwrap(),
        }
    }
    assert_eq!(view.end().map(|end| &end.trace_hash), session.view().end().map(|end| &end.trace_hash));
}

#[test]
fn a_saved_session_with_partners_claims_no_results() {
    let mut session = session(0, &Log::default());
    step(&mut session, 50);
    act(&mut session, "kind = \"battery_level\"\nlevel_pct = 12");
    let text = session.saved();
    assert!(text.starts_with("# ") && text.contains("need not be the same"), "{text}");
    assert!(text.contains("battery_level") && text.contains("at_s = 1.0"), "{text}");
    assert!(!text.contains("expect]") && !text.contains("max_time_s"), "{text}");
    let saved = scenarios::scenario::Found { text, ..find::find("nominal").unwrap() };
    assert_eq!(Scenario::load(&saved, &[]).unwrap().file.faults.len(), 1);
    // Without partners, it does.
    let alone = Session::new(&find::find("nominal").unwrap(), &[], None).unwrap().saved();
    assert!(alone.contains("[expect]") && alone.contains("max_time_s"), "{alone}");
}

#[test]
fn remote_components_set_the_pace_of_a_session() {
    let log = Log::default();
    let components = Box::new(Late(false, log.clone()));
    let found = find::find("on_a_robot").unwrap();
    let mut session = Session::with_partners(&found, &[], None, |_| Ok(Partners::Components(components))).unwrap();
    assert!(session.has_partners() && Session::new(&found, &[], None).is_err());
    assert!(!session.step(Detail::Full).unwrap() && session.view().time().is_zero());
    session.resume();
    assert!(session.step(Detail::Full).unwrap());
    let words: Vec<String> = session.view().happenings().iter().map(|one| one.words(session.view())).collect();
    assert_eq!(words, ["they are there"]);
    // The number of messages that the robot sends in a second.
    let sent = |session: &mut Session| {
        let mut sent = 0;
        for _ in 0..100 {
            if session.step(Detail::Full).unwrap() {
                let topology = session.view().topology();
                let is_sent = |event: &&Event| match &event.kind {
                    EventKind::Received { channel, .. } => topology.ends(*channel).0 == "Robot",
                    _ => false,
                };
                sent += session.view().events().iter().filter(is_sent).count();
            }
        }
        sent
    };
    assert!(sent(&mut session) >= 40);
    let frozen = act(&mut session, "kind = \"component_frozen\"\ncomponent = \"Robot\"");
    assert_eq!(sent(&mut session), 0);
    session.release(frozen).unwrap();
    assert!(sent(&mut session) >= 40);
    session.end();
    assert_eq!(log.take(), ["resume", "leave"]);
}

#[test]
fn a_run_that_waits_for_partners_can_be_stopped() {
    let log = Log::default();
    let scenario = Scenario::load(&find::find("nominal").unwrap(), &[]).unwrap();
    let run = Run::with_partners(scenario.into(), 1, true, Partners::Controller(Box::new(Slow::new(usize::MAX, &log))))
        .unwrap();
    let mut calls = 0;
    let goes_on = |_: &RunView| {
        calls += 1;
        if calls > 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let begin = |_: &RunView| Ok::<_, Error>(());
    let ((), view) = conduct::<_, _, Error>(run, Detail::Verdicts, None, begin, goes_on).unwrap();
    assert_eq!(view.end().unwrap().ended, Ended::Interrupted);
    assert_eq!(log.take().last().map(String::as_str), Some("leave"));
}
