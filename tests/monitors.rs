//! The monitors that are made from text against those built by hand, on recorded runs.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use ::monitors::{Channels, EventLog, PhiTwo, SHIPPED, load, phi1, phi2};
use ::steward::live::Live;
use ::steward::scenario::{Scenario, find};
use channels::{Event, Monitor, Topology, Verdict};
use tempfile::tempdir;

use crate::steward::report;

/// The channels of a scenario that comes with the program.
fn topology(scenario: &str) -> Arc<Topology> {
    let found = find::find(scenario).unwrap();
    let live = Live::new(Arc::new(Scenario::load(&found, &[]).unwrap()), 1, false).unwrap();
    Arc::clone(live.system().topology())
}

/// The event at which a monitor finds the recorded run to violate its property.
fn violation(monitor: &mut dyn Monitor, log: &Path, topology: &Topology) -> Option<Event> {
    let mut events = EventLog::new(BufReader::new(File::open(log).unwrap()), topology, Channels::Known);
    while let Some(event) = events.next_event().unwrap() {
        monitor.observe(&event);
        if monitor.verdict() == Verdict::False {
            return Some(event);
        }
    }
    None
}

#[test]
fn monitors_from_text_say_of_recorded_runs_what_those_built_by_hand_say() {
    for (scenario, is_unsafe) in [("nominal", false), ("battery_fault", true)] {
        let out = tempdir().unwrap();
        let log = out.path().join("log.jsonl");
        report(scenario, out.path(), &["--no-snapshots", "--record", log.to_str().unwrap()]);
        let topology = topology(scenario);
        let by_hand = [phi1(&topology, 20).unwrap(), phi2(&topology, PhiTwo::default()).unwrap()];
        for mut by_hand in by_hand {
            let (_, text) = SHIPPED.iter().find(|(name, _)| *name == by_hand.name).unwrap();
            let file = load(&by_hand.name, text, &topology, Duration::from_secs(1)).unwrap();
            let mut from_text = file.properties.into_iter().next().unwrap();
            let found = violation(by_hand.monitor.as_mut(), &log, &topology);
            assert_eq!(found, violation(from_text.monitor.as_mut(), &log, &topology), "{}", by_hand.name);
            assert_eq!(found.is_some(), is_unsafe && by_hand.name == "phi1", "{scenario} {}", by_hand.name);
        }
    }
}
