//! Sessions in which others take part.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Duration;

use channels::{Event, EventKind};
use recording::ros::BatteryState;
use recording::{Detail, Ended, Record, RunView};
use remote::{Call, FromNode};
use robot::{Reading, VelocityCommand};
use ros_messages::{CdrWriter, RosType as _};
use scenarios::scenario::{Scenario, find};

use crate::conduct::conduct;
use crate::others::Others;
use crate::outside::{Delivery, Outside};
use crate::pilot::{Orders, Pilot, Sensed};
use crate::run::Run;
use crate::session::Session;

/// What happens to those who take part, in order.
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

/// Turns on the spot, but knows that only after it has been asked some times more.
struct Slow {
    hesitates: usize,
    asked: usize,
    log: Log,
}

impl Slow {
    fn new(hesitates: usize, log: &Log) -> Self {
        Self { hesitates, asked: 0, log: log.clone() }
    }
}

impl Pilot for Slow {
    fn drive(&mut self, sensed: &Sensed<'_>) -> Option<Orders> {
        self.asked += 1;
        if self.asked <= self.hesitates {
            return None;
        }
        self.asked = 0;
        for reading in sensed.software.readings() {
            if let Reading::Battery(battery) = reading {
                self.log.add(&format!("{:.0} %", battery.charge_pct));
            }
        }
        let velocity = VelocityCommand { linear_mps: 0.0, angular_radps: 0.5 };
        Some(Orders { velocity: Some(velocity), happened: vec!["it turns".to_owned()], ..Orders::default() })
    }

    fn resume(&mut self) {
        self.log.add("resume");
    }

    fn leave(&mut self, _: &[FromNode]) {
        self.log.add("leave");
    }
}

/// Nodes on which it is late enough when they are asked for the second time, and which publish the battery's charge.
struct Late(bool, Log);

impl Outside for Late {
    fn run(&self) -> u64 {
        1
    }

    fn hear(&mut self, now: Duration) -> Option<Delivery> {
        self.0 = !self.0;
        let mut cdr = CdrWriter::reusing(Vec::new());
        BatteryState::of(now, 50.0, false).write(&mut cdr);
        let charge = FromNode::Message { topic: "/battery_state".to_owned(), body: cdr.bytes() };
        let happened = vec!["they are there".to_owned()];
        (!self.0).then(|| Delivery { answers: vec![charge], happened, ..Delivery::default() })
    }

    fn resume(&mut self) {
        self.1.add("resume");
    }

    fn ask(&mut self, _: Vec<Call>) {}

    fn leave(&mut self) {
        self.1.add("leave");
    }
}

fn session(hesitates: usize, log: &Log) -> Session {
    let pilot = Box::new(Slow::new(hesitates, log));
    Session::among(&find::find("nominal").unwrap(), &[], None, |_| Ok(Others::Pilot(pilot))).unwrap()
}

/// Asks for a step this often.
fn ask(session: &mut Session, times: usize) {
    for _ in 0..times {
        session.step(Detail::Full).unwrap();
    }
}

fn act(session: &mut Session, fault: &str) -> usize {
    session.act(toml::from_str(fault).unwrap()).unwrap()
}

#[test]
fn a_step_goes_on_where_it_waits_for_others() {
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
fn acts_take_effect_while_others_drive_and_while_a_step_waits() {
    let log = Log::default();
    let mut session = session(1, &log);
    assert!(session.has_others() && session.view().header().is_piloted);
    assert!(!session.step(Detail::Full).unwrap());
    act(&mut session, "kind = \"battery_level\"\nlevel_pct = 12");
    ask(&mut session, 200);
    assert!(log.take().contains(&"12 %".to_owned()));
    assert!(session.view().robot().battery.unwrap().charge_pct < 12.1);
    let heading = maps::heading(&session.view().robot().truth.unwrap().pose);
    act(&mut session, "kind = \"emergency_stop\"");
    ask(&mut session, 100);
    let then = maps::heading(&session.view().robot().truth.unwrap().pose);
    assert!((then - heading).abs() < 0.1, "it stands still: {heading} {then}");
}

#[test]
fn a_session_ends_while_a_step_waits_and_the_others_leave() {
    let log = Log::default();
    let mut session = session(1, &log);
    let start = session.view().clone();
    ask(&mut session, 9);
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
fn a_saved_session_with_others_claims_no_results() {
    let mut session = session(0, &Log::default());
    ask(&mut session, 50);
    act(&mut session, "kind = \"battery_level\"\nlevel_pct = 12");
    let text = session.saved();
    assert!(text.starts_with("# ") && text.contains("need not be the same"), "{text}");
    assert!(text.contains("battery_level") && text.contains("at_s = 1.0"), "{text}");
    assert!(!text.contains("expect]") && !text.contains("max_time_s"), "{text}");
    let saved = scenarios::scenario::Found { text, ..find::find("nominal").unwrap() };
    assert_eq!(Scenario::load(&saved, &[]).unwrap().file.faults.len(), 1);
    // Alone, it does.
    let alone = Session::new(&find::find("nominal").unwrap(), &[], None).unwrap().saved();
    assert!(alone.contains("[expect]") && alone.contains("max_time_s"), "{alone}");
}

#[test]
fn components_outside_set_the_pace_of_a_session() {
    let log = Log::default();
    let outside = Box::new(Late(false, log.clone()));
    let found = find::find("on_a_robot").unwrap();
    let mut session = Session::among(&found, &[], None, |_| Ok(Others::Components(outside))).unwrap();
    assert!(session.has_others() && Session::new(&found, &[], None).is_err());
    assert!(!session.step(Detail::Full).unwrap() && session.view().time().is_zero());
    session.resume();
    assert!(session.step(Detail::Full).unwrap());
    let words: Vec<String> = session.view().happenings().iter().map(|one| one.words(session.view())).collect();
    assert_eq!(words, ["they are there"]);
    // How often the robot has said something in a second.
    let said = |session: &mut Session| {
        let mut said = 0;
        for _ in 0..100 {
            if session.step(Detail::Full).unwrap() {
                let topology = session.view().topology();
                let is_said = |event: &&Event| match &event.kind {
                    EventKind::Received { channel, .. } => topology.ends(*channel).0 == "Robot",
                    _ => false,
                };
                said += session.view().events().iter().filter(is_said).count();
            }
        }
        said
    };
    assert!(said(&mut session) >= 40);
    let frozen = act(&mut session, "kind = \"component_frozen\"\ncomponent = \"Robot\"");
    assert_eq!(said(&mut session), 0);
    session.release(frozen).unwrap();
    assert!(said(&mut session) >= 40);
    session.end();
    assert_eq!(log.take(), ["resume", "leave"]);
}

#[test]
fn a_run_that_waits_for_others_can_be_stopped() {
    let log = Log::default();
    let scenario = Scenario::load(&find::find("nominal").unwrap(), &[]).unwrap();
    let run = Run::among(scenario.into(), 1, true, Others::Pilot(Box::new(Slow::new(usize::MAX, &log)))).unwrap();
    let mut asked = 0;
    let goes_on = |_: &RunView| {
        asked += 1;
        if asked > 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let begin = |_: &RunView| Ok::<_, Error>(());
    let ((), view) = conduct::<_, Error>(run, Detail::Verdicts, None, begin, goes_on).unwrap();
    assert_eq!(view.end().unwrap().ended, Ended::Interrupted);
    assert_eq!(log.take().last().map(String::as_str), Some("leave"));
}

/// Why a run could not be conducted.
#[derive(Debug)]
pub(super) struct Error;

impl From<scenarios::Error> for Error {
    fn from(error: scenarios::Error) -> Self {
        panic!("{error}")
    }
}

impl From<std::convert::Infallible> for Error {
    fn from(never: std::convert::Infallible) -> Self {
        match never {}
    }
}
