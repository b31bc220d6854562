//! Runs whose robot is driven from outside.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use channels::{EventKind, Verdict};
use recording::{Detail, Ended, Happening};
use robot::{Reading, VelocityCommand};
use runs::{Orders, Others, Pilot, Run, Sensed};
use scenarios::scenario::{Scenario, find};

/// Turns on the spot, and says so once a second.
struct Turning(Rc<RefCell<Vec<Reading>>>);

impl Pilot for Turning {
    fn drive(&mut self, sensed: &Sensed<'_>) -> Option<Orders> {
        self.0.borrow_mut().extend_from_slice(sensed.software.readings());
        let is_full = sensed.now.subsec_nanos() == 0;
        Some(Orders {
            velocity: Some(VelocityCommand { linear_mps: 0.0, angular_radps: 0.5 }),
            happened: is_full.then(|| "it turns".to_owned()).into_iter().collect(),
            ..Orders::default()
        })
    }
}

fn scenario(name: &str) -> Arc<Scenario> {
    Arc::new(Scenario::load(&find::find(name).unwrap(), &[]).unwrap())
}

#[test]
fn a_robot_obeys_who_drives_it_while_its_tree_stands_still() {
    let readings = Rc::default();
    let others = Others::Pilot(Box::new(Turning(Rc::clone(&readings))));
    let mut run = Run::among(scenario("nominal"), 1, true, others).unwrap();
    let (mut ticks, mut said) = (0, 0);
    for _ in 0..150 {
        run.step().unwrap();
        for event in run.events() {
            assert!(matches!(event.kind, EventKind::Tick), "{event:?}");
            ticks += 1;
        }
        let record = run.record(Detail::Full);
        said += record.happenings.iter().filter(|what| matches!(what, Happening::Moved { .. })).count();
    }
    assert_eq!((run.time(), ticks, said), (Duration::from_secs(3), 3, 3));
    let readings = readings.borrow();
    let scans = readings.iter().filter(|reading| matches!(reading, Reading::Scan(_))).count();
    let turned = readings.iter().rev().find_map(|reading| match reading {
        Reading::Odometry(odometry) => Some(odometry.angular_radps),
        _ => None,
    });
    assert_eq!(scans, 62);
    assert!((turned.unwrap() - 0.5).abs() < 0.05, "{turned:?}");
    let end = run.end(Ended::Interrupted, Detail::Full);
    assert!(end.monitors.iter().all(|monitor| monitor.state.verdict == Verdict::Inconclusive));
}

#[test]
fn without_a_robot_nobody_can_drive() {
    let others = Others::Pilot(Box::new(Turning(Rc::default())));
    let refused = Run::among(scenario("pick"), 1, true, others).err().unwrap();
    assert!(refused.to_string().contains("has no robot"), "{refused}");
}
