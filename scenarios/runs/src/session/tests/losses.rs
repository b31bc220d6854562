//! Runs in which DDS loses messages of components.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use channels::{Flaw, Gap};
use monitors::Outcome;
use recording::ros::battery_state;
use recording::{Detail, Ended, Happening, RunView, conduct};
use remote::{Loss, Lost, NodeMessage, ServiceRequest};
use ros_messages::RosType as _;
use scenarios::Error;
use scenarios::scenario::{Scenario, find};

use crate::partners::Partners;
use crate::remote_components::{Delivery, RemoteComponents};
use crate::run::Run;

/// Properties of the charge that the robot reports, of what another component makes of it, and of the robot's replies.
const PROPERTIES: &str = "
property never_low := always not (Robot, BatteryReader, share < 0.2)
property once_full := eventually (Robot, BatteryReader, share > 0.9)
property recovers := always ((Robot, BatteryReader, share < 0.4) implies
    time_until (Robot, BatteryReader, share > 0.5) < 3 s)
property told := always not (BatteryReader, BatteryLevel, level < 1)
property accepts := eventually (Robot, Navigation, m[1] = <navigate_to_pose.accepted>)
property never_aborts := always not (Robot, Navigation, m[1] = <navigate_to_pose.aborted>)
";

/// The time of a step.
fn step(number: u64) -> Duration {
    Duration::from_millis(20 * number)
}

/// Nodes whose messages and losses `delivers` returns, for the number of a step and the open requests.
struct Nodes<F> {
    delivers: F,
    open: Vec<ServiceRequest>,
}

impl<F: FnMut(u64, &mut Vec<ServiceRequest>) -> Delivery> RemoteComponents for Nodes<F> {
    fn run(&self) -> u64 {
        1
    }

    fn receive(&mut self, now: Duration) -> Option<Delivery> {
        let number = now.as_millis() / step(1).as_millis();
        Some((self.delivers)(u64::try_from(number).unwrap(), &mut self.open))
    }

    fn resume(&mut self) {}

    fn send(&mut self, requests: Vec<ServiceRequest>) {
        self.open.extend(requests);
    }

    fn leave(&mut self) {}
}

fn charge(number: u64, charge_pct: f64) -> Delivery {
    let body = battery_state(step(number), charge_pct, false).encode();
    let messages = vec![NodeMessage::Message { topic: "/battery_state".to_owned(), body }];
    Delivery { messages, ..Delivery::default() }
}

fn lost(what: &Lost, flaw: Flaw, since: u64) -> Loss {
    Loss { what: what.clone(), flaw, since: step(since), why: format!("lost after step {since}") }
}

fn battery() -> Lost {
    Lost::Topic("/battery_state".to_owned())
}

/// The same with a loss before it, after the step of this number.
fn after_a_loss(since: u64, delivery: Delivery) -> Delivery {
    Delivery { losses: vec![lost(&battery(), Flaw::Missing, since)], resumed: vec![battery()], ..delivery }
}

/// A run of the paper's tree for some seconds, beside nodes. Returns its end, and when gaps began and ended.
fn ran(
    seconds: u64,
    set: &[&str],
    delivers: impl FnMut(u64, &mut Vec<ServiceRequest>) -> Delivery + 'static,
) -> (RunView, Vec<Happening>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.scope");
    std::fs::write(&path, PROPERTIES).unwrap();
    let limit = format!("execution.max_time_s={seconds}");
    let properties = format!("properties=[{path:?}]");
    let set = [properties.as_str(), limit.as_str(), "expect={}", "stop={}"].into_iter().chain(set.iter().copied());
    let set: Vec<String> = set.map(str::to_owned).collect();
    let scenario = Arc::new(Scenario::load(&find::find("on_a_robot").unwrap(), &set).unwrap());
    let nodes = Partners::Components(Box::new(Nodes { delivers, open: Vec::new() }));
    let run = Run::with_partners(scenario, 1, true, nodes).unwrap();
    let gaps = Rc::new(RefCell::new(Vec::new()));
    let follow = |view: &RunView| {
        let gap = |happening: &&Happening| matches!(happening, Happening::Lost(_) | Happening::Resumed(_));
        gaps.borrow_mut().extend(view.happenings().iter().filter(gap).cloned());
        ControlFlow::Continue(())
    };
    let begin = |_: &RunView| Ok::<_, Error>(());
    let ((), view) = conduct::<_, _, Error>(run, Detail::Verdicts, None, begin, follow).unwrap();
    let gaps = gaps.take();
    (view, gaps)
}

/// How sure the verdict of a property is, and its outcome.
fn verdict(view: &RunView, name: &str) -> (&'static str, Outcome) {
    let monitor = view.monitors().find(|monitor| monitor.name() == name).unwrap();
    (monitor.ending().evidence.certainty().name(), monitor.outcome())
}

#[test]
fn a_verdict_that_a_lost_message_could_change_is_unsure() {
    let (view, gaps) = ran(10, &[], |number, _| match number {
        100 => after_a_loss(90, charge(number, 50.0)),
        _ => charge(number, 50.0),
    });
    assert_eq!(verdict(&view, "never_low"), ("unsure", Outcome::Inconclusive));
    assert_eq!(verdict(&view, "once_full"), ("unsure", Outcome::Inconclusive));
    // The messages of other processes are computed.
    assert_eq!(verdict(&view, "told"), ("sure", Outcome::Satisfied));
    let why = view.monitors().next().unwrap().ending().evidence.certainty().why().map(str::to_owned);
    assert_eq!((why.as_deref(), view.lost()), (Some("lost after step 90"), &["lost after step 90".to_owned()][..]));
    let [Happening::Lost(gap), Happening::Resumed(resumed)] = &gaps[..] else { panic!("{gaps:?}") };
    assert_eq!(view.topology().ends(*resumed), ("Robot", "BatteryReader"));
    let (why, channel, since) = (gap.why.clone(), Some(*resumed), Some(step(90)));
    assert_eq!(*gap, Gap { flaw: Flaw::Missing, why, channel, since, ends: true });
}

#[test]
fn without_losses_verdicts_are_sure() {
    let (view, gaps) = ran(10, &[], |number, _| charge(number, 50.0));
    assert_eq!(verdict(&view, "never_low"), ("sure", Outcome::Satisfied));
    assert_eq!(verdict(&view, "once_full"), ("sure", Outcome::Inconclusive));
    assert!(gaps.is_empty());
    let assumed = "DDS delivers every message of the nodes of Robot";
    assert_eq!(view.monitors().next().unwrap().ending().evidence.assumptions(), [assumed]);
}

#[test]
fn a_violation_by_a_message_that_came_stays_sure_and_so_does_what_is_fulfilled_by_one() {
    for low in [50, 150] {
        let (view, _) = ran(10, &[], move |number, _| match number {
            100 => after_a_loss(90, charge(number, 50.0)),
            200 => charge(number, 95.0),
            _ if number == low => charge(number, 10.0),
            _ => charge(number, 50.0),
        });
        assert_eq!(verdict(&view, "never_low"), ("sure", Outcome::Violated), "at step {low}");
        assert_eq!(verdict(&view, "once_full"), ("sure", Outcome::Satisfied));
    }
}

#[test]
fn a_deadline_that_passes_while_messages_are_lost_is_unsure_and_one_that_passes_later_is_missed() {
    let lossy = |again: u64| {
        move |number: u64, _: &mut Vec<ServiceRequest>| match number {
            0..50 => charge(number, 50.0),
            50 => charge(number, 30.0),
            // The charge is lost for some steps.
            100 => Delivery { losses: vec![lost(&battery(), Flaw::Missing, 50)], ..Delivery::default() },
            300 => Delivery { resumed: vec![battery()], ..charge(number, 60.0) },
            _ if number == again => charge(number, 30.0),
            _ => Delivery::default(),
        }
    };
    let (view, gaps) = ran(12, &[], lossy(0));
    assert_eq!((verdict(&view, "recovers").0, gaps.len()), ("unsure", 2));
    let stops = ["stop.on_violation=['recovers']"];
    let (view, _) = ran(12, &stops, lossy(400));
    assert_eq!(verdict(&view, "recovers"), ("sure", Outcome::Violated));
    // Nothing ends the run before that.
    assert_eq!(view.end().unwrap().ended, Ended::Violation("recovers".to_owned()));
    assert!(view.time() > step(500), "{:?}", view.time());
}

#[test]
fn a_gap_ends_when_what_waited_for_its_channel_has_been_received() {
    let frozen = r#"faults=[{ kind = "component_frozen", at_s = 1, component = "Robot", lasts_s = 4 }]"#;
    let (view, gaps) = ran(6, &[frozen], |number, _| match number {
        100 => after_a_loss(90, charge(number, 50.0)),
        101.. => Delivery::default(),
        _ => charge(number, 50.0),
    });
    assert_eq!((verdict(&view, "never_low").0, gaps.len()), ("unsure", 2));
    let (view, gaps) = ran(4, &[frozen], |number, _| match number {
        100 => after_a_loss(90, charge(number, 50.0)),
        _ => charge(number, 50.0),
    });
    assert_eq!((verdict(&view, "never_low").0, gaps.len()), ("unsure", 1), "it is still frozen");
}

/// The response to the goal is lost, so the goal counts as accepted. Then its server is gone, so it is aborted.
#[test]
fn a_presumed_response_proves_nothing_and_one_that_came_does() {
    let nodes = |aborts: bool| {
        let mut is_sent = false;
        move |number: u64, open: &mut Vec<ServiceRequest>| {
            let of = |open: &mut Vec<ServiceRequest>, part: &str| {
                let place = open.iter().position(|request| request.service.ends_with(part))?;
                Some(open.remove(place))
            };
            if let Some(request) = of(open, "send_goal") {
                let what = Lost::Response(request.number);
                let messages = vec![request.presumed()];
                is_sent = true;
                return Delivery {
                    messages,
                    losses: vec![lost(&what, Flaw::Mixed, number - 1)],
                    resumed: vec![what],
                    ..Delivery::default()
                };
            }
            let result = (aborts && is_sent && number.is_multiple_of(50)).then(|| of(open, "get_result")).flatten();
            let Some(request) = result else { return charge(number, 50.0) };
            // An empty body: the server is gone, so no response will come.
            let messages = vec![NodeMessage::Response { number: request.number, body: Vec::new() }];
            Delivery { messages, ..Delivery::default() }
        }
    };
    let (view, gaps) = ran(10, &[], nodes(false));
    assert!(!gaps.is_empty(), "a goal was sent");
    assert_eq!(verdict(&view, "accepts").0, "unsure");
    assert_eq!(verdict(&view, "never_aborts").0, "unsure");
    assert_eq!(verdict(&view, "never_low"), ("sure", Outcome::Satisfied), "another channel of the same nodes");
    let (view, _) = ran(20, &[], nodes(true));
    assert_eq!(verdict(&view, "never_aborts"), ("sure", Outcome::Violated));
}
