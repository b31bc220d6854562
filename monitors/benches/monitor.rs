//! Throughput of monitors, in events: φ1, φ2 and the classic timed patterns.
//!
//! Sequences have a million events. Every second event is a tick. Every property holds until the end of its sequence,
//! so the whole sequence is processed.

use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, Event, EventKind, FieldKind, Message, Monitor, Shape, Topology, Value, Verdict};
use divan::Bencher;
use divan::counter::ItemsCount;
use monitors::{Choice, ScopeMonitor, scope_monitor};

fn main() {
    divan::main();
}

const EVENTS: usize = 1_000_000;

fn topology() -> Arc<Topology> {
    let mut topology = Topology::default();
    let ok = || ("status", FieldKind::symbols(["ok"]));
    let shapes = [
        ("BatteryReader", "BatteryLevel", Shape::new([ok(), ("level", FieldKind::Real)])),
        ("Navigation", "GoToDestination", Shape::new([ok(), ("state", FieldKind::symbols(["running", "stopped"]))])),
        (
            "GotoRechargingStation",
            "Navigation",
            Shape::new([
                ("request", FieldKind::symbols(["start_navigation", "get_status"])),
                ("place", FieldKind::symbols(["RechargingStation", "Destination"])),
            ]),
        ),
        ("P", "Monitor", Shape::new([("p", FieldKind::Bool)])),
        ("Q", "Monitor", Shape::new([("q", FieldKind::Bool)])),
        ("R", "Monitor", Shape::new([("r", FieldKind::Bool)])),
        ("S", "Monitor", Shape::new([("s", FieldKind::Bool)])),
    ];
    for (source, target, shape) in shapes {
        let ends = [source, target]
            .map(|name| topology.find_process(name).unwrap_or_else(|| topology.process(name).expect("a new process")));
        topology.channel(ends[0], ends[1], Capacity::One, Domain::new([shape])).expect("a new channel");
    }
    Arc::new(topology)
}

/// Generates the message that follows a tick.
type Script = fn(u64, u64) -> (&'static str, Message);

fn boolean(truth: bool) -> Message {
    Message::new([Value::Bool(truth)])
}

/// The patterns by name: the formula with its bound, and the message after each tick.
const PATTERNS: [(&str, &str, Script); 12] = [
    ("phi1", "always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 20)", |tick, _| level(20.0 + (tick % 80) as f64)),
    (
        "phi2",
        "always ((Navigation, GoToDestination, m[1] = <ok> and m[2] = <running>) and
            (BatteryReader, BatteryLevel, m[1] = <ok> and m[2] <= 30) implies
            time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation> and m[2] = <RechargingStation>) < N)",
        |tick, bound| match tick % bound {
            0 => ("GotoRechargingStation", Message::symbols(["start_navigation", "RechargingStation"])),
            n if n % 3 == 0 => ("Navigation", Message::symbols(["ok", "running"])),
            n => level(if n % 3 == 1 { 25.0 } else { 80.0 }),
        },
    ),
    ("absence after", "always ((Q, Monitor, q = true) implies not time_until (P, Monitor, p = true) < N)", |tick, bound| {
        match tick % (4 * bound) {
            0 => ("Q", boolean(true)),
            n if n > 2 * bound => ("P", boolean(n % 2 == 0)),
            n => ("P", boolean(n == 2 * bound)),
        }
    }),
    ("absence before", "always ((P, Monitor, p = true) implies not time_until (R, Monitor, r = true) < N)", |tick, bound| {
        match tick % (4 * bound) {
            0 => ("P", boolean(true)),
            n => ("R", boolean(n == 2 * bound)),
        }
    }),
    (
        "absence between",
        "always ((Q, Monitor, q = true) implies time_until (R, Monitor, r = true) < N and
            not (P, Monitor, p = true) until (R, Monitor, r = true))",
        |tick, bound| match tick % (4 * bound) {
            0 => ("Q", boolean(true)),
            n if n == bound - 1 => ("R", boolean(true)),
            n => ("P", boolean(n > bound && n % 2 == 0)),
        },
    ),
    ("universality after", "always ((Q, Monitor, q = true) implies not time_until (P, Monitor, p = false) < N)", |tick, bound| {
        match tick % (4 * bound) {
            0 => ("Q", boolean(true)),
            n => ("P", boolean(n < 2 * bound)),
        }
    }),
    ("universality before", "always ((P, Monitor, p = false) implies not time_until (R, Monitor, r = true) < N)", |tick, bound| {
        match tick % (4 * bound) {
            0 => ("R", boolean(true)),
            n => ("P", boolean(n > bound)),
        }
    }),
    (
        "universality between",
        "always ((Q, Monitor, q = true) implies time_until (R, Monitor, r = true) < N and
            (P, Monitor, p = true) until (R, Monitor, r = true))",
        |tick, bound| match tick % (4 * bound) {
            0 => ("Q", boolean(true)),
            n if n == bound - 1 => ("R", boolean(true)),
            n => ("P", boolean(n < bound)),
        },
    ),
    ("recurrence globally", "always time_until (P, Monitor, p = true) < N", |tick, bound| ("P", boolean(tick % bound == 0))),
    (
        "recurrence between",
        "always ((Q, Monitor, q = true) implies
            (time_until (P, Monitor, p = true) < N or time_until (R, Monitor, r = true) < N) until (R, Monitor, r = true))",
        |tick, bound| match tick % (4 * bound) {
            0 => ("Q", boolean(true)),
            n if n == 3 * bound => ("R", boolean(true)),
            n => ("P", boolean(n % (bound - 1) == 0)),
        },
    ),
    ("response globally", "always ((S, Monitor, s = true) implies time_until (P, Monitor, p = true) < N)", |tick, bound| {
        match tick % bound {
            0 => ("P", boolean(true)),
            n => ("S", boolean(n % 3 == 1)),
        }
    }),
    (
        "response between",
        "always ((Q, Monitor, q = true) implies
            ((S, Monitor, s = true) implies time_until (P, Monitor, p = true) < N) until (R, Monitor, r = true))",
        |tick, bound| match tick % (4 * bound) {
            0 => ("Q", boolean(true)),
            n if n == 3 * bound => ("R", boolean(true)),
            n if n % bound == bound / 2 => ("P", boolean(true)),
            n => ("S", boolean(n % bound == 1)),
        },
    ),
];

fn level(level: f64) -> (&'static str, Message) {
    ("BatteryReader", Message::new([Value::symbol("ok"), level.into()]))
}

/// A monitor and a million events for it.
fn prepare(pattern: &str, bound: u64) -> (ScopeMonitor, Vec<Event>) {
    let (_, formula, script) = PATTERNS.iter().find(|(name, ..)| *name == pattern).expect("a pattern in the list");
    let topology = topology();
    let text = format!(
        "property p := {}",
        formula.replace('N', &bound.to_string()).replace(&format!("{bound}avigation"), "Navigation")
    );
    let file = monitors::load("bench.scope", &text, &topology, Duration::from_secs(1));
    let file = file.unwrap_or_else(|error| panic!("{:?}", error.problems()));
    let monitor = scope_monitor(file.properties[0].monitor.as_ref()).expect("made from text").clone();
    assert!(monitor.method().anticipates(), "{pattern} {bound}: {:?}", monitor.method());
    let channel = |source: &str| {
        topology.channels().find(|channel| topology.ends(*channel).0 == source).expect("a channel in the list")
    };
    let mut events = Vec::with_capacity(EVENTS);
    for tick in 0..EVENTS as u64 / 2 {
        let event = |kind| Event { step: tick * 2, tick, time: Duration::from_secs(tick), kind };
        events.push(event(EventKind::Tick));
        let (source, message) = script(tick, bound);
        events.push(event(EventKind::Received { channel: channel(source), message }));
    }
    let mut all = monitor.clone();
    events.iter().for_each(|event| all.observe(event));
    assert_eq!(all.verdict(), Verdict::Inconclusive, "{pattern} {bound} is violated");
    (monitor, events)
}

fn on_messages(bencher: Bencher<'_, '_>, pattern: &str, bound: u64) {
    let (monitor, events) = prepare(pattern, bound);
    observe(bencher, &monitor, &events);
}

fn observe(bencher: Bencher<'_, '_>, monitor: &ScopeMonitor, events: &[Event]) {
    bencher.counter(ItemsCount::new(events.len())).with_inputs(|| monitor.clone()).bench_local_values(|mut monitor| {
        for event in divan::black_box(events) {
            monitor.observe(event);
        }
        assert_eq!(monitor.verdict(), Verdict::Inconclusive);
    });
}

#[divan::bench(sample_count = 30, args = [10])]
fn phi1_messages(bencher: Bencher<'_, '_>, bound: u64) {
    on_messages(bencher, "phi1", bound);
}

#[divan::bench(sample_count = 30, args = [10, 100, 1000, 10_000])]
fn phi2_messages(bencher: Bencher<'_, '_>, bound: u64) {
    on_messages(bencher, "phi2", bound);
}

/// The time to make a monitor from text, most of which goes into the automaton.
#[divan::bench(sample_count = 10, args = [10, 100, 1000])]
fn synthesis_of_response_between(bencher: Bencher<'_, '_>, bound: u64) {
    let topology = topology();
    let (_, formula, _) =
        PATTERNS.iter().find(|(name, ..)| *name == "response between").expect("a pattern in the list");
    let text = format!("property p := {}", formula.replace('N', &bound.to_string()));
    bencher.bench_local(|| monitors::load("bench.scope", &text, &topology, Duration::from_secs(1)));
}

/// The same events by progression.
#[divan::bench(sample_count = 10, args = [10, 100, 1000])]
fn progression_messages(bencher: Bencher<'_, '_>, bound: u64) {
    let (monitor, events) = prepare("absence between", bound);
    let monitor = ScopeMonitor::with("p", monitor.formula().clone(), monitor.topology(), Choice::Progression);
    observe(bencher, &monitor.expect("a small formula"), &events);
}

const TIMED: [&str; 10] = [
    "absence after",
    "absence before",
    "absence between",
    "universality after",
    "universality before",
    "universality between",
    "recurrence globally",
    "recurrence between",
    "response globally",
    "response between",
];

#[divan::bench(sample_count = 30, args = TIMED, consts = [10, 100, 1000])]
fn patterns_messages<const BOUND: u64>(bencher: Bencher<'_, '_>, pattern: &str) {
    on_messages(bencher, pattern, BOUND);
}
