//! Runs whose robot is driven by a controller outside the program.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use channels::{EventKind, Verdict};
use recording::{Detail, Ended, Happening};
use robot::{Reading, VelocityCommand};
use runs::{Controller, ControllerInput, ControllerOutput, Partners, Run};

use crate::load;

/// Turns on the spot, with a note once per second. Keeps all readings.
struct Turning(Rc<RefCell<Vec<Reading>>>);

impl Controller for Turning {
    fn drive(&mut self, input: &ControllerInput<'_>) -> Option<ControllerOutput> {
        self.0.borrow_mut().extend_from_slice(input.software.readings());
        let is_full = input.now.subsec_nanos() == 0;
        Some(ControllerOutput {
            velocity: Some(VelocityCommand { linear_mps: 0.0, angular_radps: 0.5 }),
            notes: is_full.then(|| "it turns".to_owned()).into_iter().collect(),
            ..ControllerOutput::default()
        })
    }
}

#[test]
fn a_robot_obeys_its_controller_while_its_tree_stands_still() {
    let readings = Rc::default();
    let partners = Partners::Controller(Box::new(Turning(Rc::clone(&readings))));
    let mut run = Run::with_partners(load("nominal", &[]).unwrap(), 1, true, partners).unwrap();
    let (mut ticks, mut notes) = (0, 0);
    for _ in 0..150 {
        run.step().unwrap();
        for event in run.events() {
            assert!(matches!(event.kind, EventKind::Tick), "{event:?}");
            ticks += 1;
        }
        let record = run.record(Detail::Full);
        notes += record.happenings.iter().filter(|what| matches!(what, Happening::Moved { .. })).count();
    }
    assert_eq!((run.time(), ticks, notes), (Duration::from_secs(3), 3, 3));
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
fn a_run_without_a_robot_refuses_a_controller() {
    let partners = Partners::Controller(Box::new(Turning(Rc::default())));
    let refused = Run::with_partners(load("pick", &[]).unwrap(), 1, true, partners).err().unwrap();
    assert!(refused.to_string().contains("has no robot"), "{refused}");
}
