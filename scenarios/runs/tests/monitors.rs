//! The monitors that are made from text, compared with hand-built ones on recorded runs, and with their own export to
//! SCXML.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use ::monitors::{Channels, EventLog, Format, Method, PhiTwo, SHIPPED, ScopeMonitor, load, phi1, phi2, scope_monitor};
use channels::{Event, EventKind, Monitor, Topology, Verdict};
use runs::Run;
use serde_json::json;
use skills::{Chart, Cues, Machine, Transcript};
use tempfile::tempdir;

use crate::recorded;

/// The channels of a scenario that comes with the program.
fn topology(scenario: &str) -> Arc<Topology> {
    Run::new(crate::load(scenario, &[]).unwrap(), 1, false).unwrap().header().topology
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
fn parsed_and_hand_built_monitors_agree_on_recorded_runs() {
    for (scenario, is_unsafe) in [("nominal", false), ("battery_fault", true)] {
        let out = tempdir().unwrap();
        let log = out.path().join("log.jsonl");
        recorded(scenario, &[], &log);
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

/// Properties that become graphs as in the paper, bans, or automata.
const OF_ALL_KINDS: &str = "
    property ban := always ((BatteryReader, BatteryLevel, level < 20)
        implies not time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation>) <= 2)
    property way := (BatteryReader, BatteryLevel, m[1] = <ok> and m[2] > 20)
        until (Localization, AtDestination, m[1] = <ok> and m[2] = true)
    property step := always ((Navigation, GoToDestination, m[2] = <running>)
        implies next (Navigation, GoToDestination, m[2] != <idle>))
    property both := always ((BatteryReader, BatteryLevel, m[2] <= 30)
            implies time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation>) < 3)
        and always ((Navigation, GoToDestination, m[2] = <running>)
            implies time_until (BatteryReader, BatteryLevel, true) <= 2)
    property sense := always not (BatteryReader, BatteryLevel, m[1] = <error> and m[2] = \"no \\\"sensor\\\"\")";

/// A run of ticks and messages, of each kind that the monitor distinguishes, in a pseudorandom order.
fn made_up_run(monitor: &ScopeMonitor, mut seed: u64) -> Vec<Event> {
    let samples: Vec<EventKind> = monitor.samples().collect();
    let mut ticks = 0_u64;
    let events = (0..80).map(|step| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let roll = (seed >> 33) as usize;
        let kind = if step == 0 || !roll.is_multiple_of(4) {
            EventKind::Tick
        } else {
            samples[roll / 4 % samples.len()].clone()
        };
        ticks += u64::from(kind == EventKind::Tick);
        Event { step, tick: ticks - 1, time: Duration::from_millis(ticks * 1000 + step), kind }
    });
    events.collect()
}

/// An event in the form in which an exported machine gets it.
fn cue(event: &Event, topology: &Topology) -> String {
    let (name, data) = match &event.kind {
        EventKind::Tick => ("tick".to_owned(), json!(event.tick)),
        EventKind::Received { channel, message } => {
            let (from, to) = topology.ends(*channel);
            (format!("message.{from}.{to}"), recording::message_json(message))
        }
    };
    json!({ "event": name, "data": data }).to_string() + "\n"
}

/// The index of the event at which the machine enters a state that means a violation.
fn violation_in_scxml(chart: &Arc<Chart>, events: &[Event], topology: &Topology) -> Option<usize> {
    let text: String = events.iter().map(|event| cue(event, topology)).collect();
    let cues = Cues::parse("run.jsonl", &text).unwrap();
    let mut host = Transcript::default();
    let mut machine = Machine::new(Arc::clone(chart));
    machine.start(Duration::ZERO, &mut host);
    cues.iter().position(|cue| {
        machine.handle(cue.event.clone(), Duration::ZERO, &mut host);
        ["failure", "Err", "violated"].iter().any(|state| machine.is_in(state))
    })
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn exported_scxml_gives_the_same_verdicts_in_the_engine_of_the_skills() {
    let topology = topology("nominal");
    // Two minutes would be longer than the runs.
    let shipped = SHIPPED.map(|(name, text)| (name, text.replace("theta2 := 120", "theta2 := 12")));
    let texts = shipped.into_iter().chain([("of all kinds", OF_ALL_KINDS.to_owned())]);
    let files = texts.map(|(name, text)| load(name, &text, &topology, Duration::from_secs(1)).unwrap());
    let properties: Vec<_> = files.flat_map(|file| file.properties).collect();
    let mut automata = 0;
    for property in &properties {
        let fresh = scope_monitor(property.monitor.as_ref()).unwrap();
        automata += u32::from(matches!(fresh.method(), Method::Automaton { .. }));
        let scxml = fresh.export(Format::Scxml).unwrap();
        let chart = Chart::load(&property.name, &scxml).unwrap();
        let mut violated = 0;
        for seed in 0..60 {
            let events = made_up_run(fresh, seed);
            let mut monitor = fresh.clone();
            let expected = events.iter().position(|event| {
                monitor.observe(event);
                monitor.verdict() == Verdict::False
            });
            assert_eq!(violation_in_scxml(&chart, &events, &topology), expected, "{}, seed {seed}", property.name);
            violated += u32::from(expected.is_some());
        }
        assert!(violated > 5, "{}: only {violated} runs are violated", property.name);
    }
    assert!(automata >= 3 && properties.len() - automata as usize >= 4);
}
