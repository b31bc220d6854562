//! The two hand-built monitors of the paper and the synthesized ones on the same random sequences: they agree, or their
//! difference is a named class.

use std::time::Duration;

use channels::{Event, EventKind, Message, Monitor, Topology, Value, Verdict};
use monitors::{PhiTwo, Property, SHIPPED, holds, phi1, phi2, scope_monitor};

use crate::cases::cases;
use crate::robot::topology;
use crate::support::{Dice, event};

fn shipped(name: &str, topology: &std::sync::Arc<Topology>, theta: u64) -> Property {
    let (_, text) = SHIPPED.into_iter().find(|(known, _)| *known == name).expect("shipped");
    let text = text.replace("theta := 10", &format!("theta := {theta}"));
    monitors::load(name, &text, topology, Duration::from_secs(1)).expect("it loads").properties.remove(0)
}

/// Roughly a run of the robot: messages, and ticks that BT takes at once or, sometimes, not at all.
fn run(dice: &mut Dice, topology: &Topology, length: usize) -> Vec<Event> {
    let channel = |from, to| topology.find_channel(from, to).expect("a channel of the robot");
    let mut events: Vec<Event> = Vec::new();
    let mut tick = 0;
    let push = |events: &mut Vec<Event>, tick, kind| events.push(event(events.len() as u64, tick, kind));
    for index in 0..length {
        let level = Value::Real([10.0, 19.9, 20.0, 25.0, 30.0, 30.1, 80.0][dice.roll(7) as usize]);
        let (from, to, message) = match dice.roll(14) {
            0..=3 => {
                tick += u64::from(index > 0);
                push(&mut events, tick, EventKind::Tick);
                if dice.roll(8) == 0 {
                    continue;
                }
                ("TickGenerator", "BT", Message::new([Value::symbol("tick"), Value::Int(tick as i64)]))
            }
            4..=6 => ("BatteryReader", "BatteryLevel", Message::new([Value::symbol("ok"), level])),
            7 => ("BatteryReader", "BatteryLevel", Message::new([Value::symbol("error"), "no sensor".into()])),
            8..=10 => ("Navigation", "GoToDestination", Message::symbols(["ok", "running"])),
            11 => ("Navigation", "GoToDestination", Message::symbols(["ok", "stopped"])),
            12 => ("GotoRechargingStation", "Navigation", Message::symbols(["start_navigation", "RechargingStation"])),
            _ => ("GotoRechargingStation", "Navigation", Message::symbols(["get_status", "RechargingStation"])),
        };
        push(&mut events, tick, EventKind::Received { channel: channel(from, to), message });
    }
    events
}

/// The tick of the event with this index: the same whether a tick is generated or, a step later, taken.
fn tick_of(events: &[Event], index: Option<usize>) -> Option<u64> {
    index.map(|index| events[index].tick)
}

/// The event at which the monitor reported a violation.
fn violation(monitor: &mut dyn Monitor, events: &[Event]) -> Option<usize> {
    events.iter().position(|event| {
        monitor.observe(event);
        monitor.verdict() == Verdict::False
    })
}

#[test]
fn the_monitors_of_phi1_agree() {
    let topology = topology();
    let mut violated: u64 = 0;
    for seed in 0..cases(10_000) {
        let events = run(&mut Dice(seed), &topology, 40);
        let by_hand = violation(phi1(&topology, 20).expect("wired").monitor.as_mut(), &events);
        let mut synthesised = shipped_phi1(&topology);
        let from_text = violation(synthesised.monitor.as_mut(), &events);
        assert_eq!(by_hand, from_text, "seed {seed}");
        violated += u64::from(from_text.is_some());
    }
    assert!(violated > cases(5_000));
}

fn shipped_phi1(topology: &std::sync::Arc<Topology>) -> Property {
    shipped("phi1", topology, 10)
}

/// Why the two monitors of φ2 may fail at different events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Difference {
    /// They do not.
    None,
    /// The figure's timer starts at θ and fails on the tick that finds it at 0: one tick late.
    OneTickLate,
    /// The figure counts the ticks that BT takes, the formula those generated.
    TicksNotTaken,
    /// The figure remembers a `<running>` after a `<stopped>`, and blames a robot that stopped long ago.
    RunningRemembered,
    /// The figure checks levels only after a `<running>`. A low level just before it counts for the formula, whose
    /// atoms refer to the last message.
    LevelBeforeRunning,
    /// The figure forgets the `<running>` once it is answered, and waits for another.
    RunningForgotten,
}

/// The figure, repaired step by step; each repair is one class of difference.
#[derive(Clone, Copy, Default)]
struct Figure {
    theta: i64,
    exact_timer: bool,
    generated_ticks: bool,
    forgets_stopped: bool,
    either_order: bool,
    keeps_running: bool,
}

impl Figure {
    fn violation(self, events: &[Event], topology: &Topology) -> Option<usize> {
        let name = |event: &Event| match &event.kind {
            EventKind::Tick => ("", None),
            EventKind::Received { channel, message } => {
                (topology.ends(*channel).0, Some((topology.ends(*channel).1, message.clone())))
            }
        };
        let (mut running, mut low, mut timer) = (false, false, None::<i64>);
        for (index, event) in events.iter().enumerate() {
            let ticked = match (name(event), self.generated_ticks) {
                (("", _), generated) => generated,
                (("TickGenerator", _), generated) => !generated,
                _ => false,
            };
            let mut asked = false;
            match name(event) {
                ("Navigation", Some((_, message))) => {
                    let runs = message == Message::symbols(["ok", "running"]);
                    let counts = timer.is_none() || self.keeps_running;
                    running = if self.forgets_stopped && counts { runs } else { running || runs && counts };
                    asked = self.either_order;
                }
                ("BatteryReader", Some((_, message))) => {
                    let level = message.field(2).and_then(Value::as_number).filter(|_| message.head() == Some("ok"));
                    low = level.is_some_and(|level| level <= 30.0);
                    asked = true;
                }
                ("GotoRechargingStation", Some((_, message)))
                    if timer.is_some() && message == Message::symbols(["start_navigation", "RechargingStation"]) =>
                {
                    timer = None;
                    running &= self.keeps_running;
                }
                _ => {}
            }
            if ticked && let Some(left) = &mut timer {
                *left -= 1;
                if *left < 0 || self.exact_timer && *left == 0 {
                    return Some(index);
                }
            }
            if asked && running && low && timer.is_none() {
                timer = Some(self.theta);
            }
        }
        None
    }
}

#[test]
fn the_monitors_of_phi2_differ_only_in_named_classes() {
    let topology = topology();
    let theta = 4;
    let mut counts = std::collections::BTreeMap::<Difference, u64>::new();
    for seed in 0..cases(10_000) {
        let events = run(&mut Dice(seed + 5_000_000), &topology, 60);
        let deadline = PhiTwo { low_pct: 30, deadline_ticks: theta };
        let by_hand = violation(phi2(&topology, deadline).expect("wired").monitor.as_mut(), &events);
        let mut synthesised = shipped("phi2", &topology, theta.into());
        let from_text = violation(synthesised.monitor.as_mut(), &events);
        // Without repairs, the model matches the figure; with all of them, it matches the formula.
        let figure = Figure { theta: theta.into(), ..Figure::default() };
        assert_eq!(figure.violation(&events, &topology), by_hand, "seed {seed}");
        let steps = [(Difference::None, figure), (Difference::OneTickLate, Figure { exact_timer: true, ..figure })];
        let steps = steps.into_iter().chain([
            (Difference::TicksNotTaken, Figure { exact_timer: true, generated_ticks: true, ..figure }),
            (
                Difference::RunningRemembered,
                Figure { exact_timer: true, generated_ticks: true, forgets_stopped: true, ..figure },
            ),
            (
                Difference::LevelBeforeRunning,
                Figure {
                    exact_timer: true,
                    generated_ticks: true,
                    forgets_stopped: true,
                    either_order: true,
                    ..figure
                },
            ),
            (
                Difference::RunningForgotten,
                Figure {
                    theta: theta.into(),
                    exact_timer: true,
                    generated_ticks: true,
                    forgets_stopped: true,
                    either_order: true,
                    keeps_running: true,
                },
            ),
        ]);
        let class = steps
            .map(|(class, figure)| (class, figure.violation(&events, &topology)))
            .find(|(_, at)| tick_of(&events, *at) == tick_of(&events, from_text));
        let (class, _) =
            class.unwrap_or_else(|| panic!("seed {seed}: no class; hand-built {by_hand:?}, from text {from_text:?}"));
        *counts.entry(class).or_default() += 1;
        let same = tick_of(&events, by_hand) == tick_of(&events, from_text);
        assert_eq!(class == Difference::None, same, "seed {seed}");
    }
    for class in [
        Difference::None,
        Difference::OneTickLate,
        Difference::TicksNotTaken,
        Difference::RunningRemembered,
        Difference::LevelBeforeRunning,
        Difference::RunningForgotten,
    ] {
        assert!(counts.get(&class).is_some_and(|count| count * 500 > cases(10_000)), "{class:?}: {counts:?}");
    }
}

#[test]
fn the_synthesized_monitor_of_phi2_agrees_with_the_oracle() {
    let topology = topology();
    for seed in 0..cases(1_000) {
        let events = run(&mut Dice(seed + 8_000_000), &topology, 30);
        let mut phi2 = shipped("phi2", &topology, 3);
        let fails = violation(phi2.monitor.as_mut(), &events);
        let formula = scope_monitor(phi2.monitor.as_ref()).expect("made from text").formula().clone();
        let first = (0..=events.len()).find(|length| {
            // If a prefix fails, and still fails when only an answer follows, it has failed for good.
            let mut answered = events[..*length].to_vec();
            let channel = topology.find_channel("GotoRechargingStation", "Navigation").expect("a channel");
            let message = Message::symbols(["start_navigation", "RechargingStation"]);
            let tick = answered.last().map_or(0, |last| last.tick);
            answered.push(event(*length as u64, tick, EventKind::Received { channel, message }));
            !holds(&formula, &answered).expect("small")
        });
        assert_eq!(fails.map(|index| index + 1), first, "seed {seed}");
    }
}

#[test]
fn the_locations_are_those_of_the_papers_figure() {
    let topology = topology();
    let phi1 = shipped_phi1(&topology);
    let (graph, _) = phi1.monitor.graph().expect("a program graph");
    assert_eq!(graph.locations(), ["idle", "get", "failure"]);
    let phi2 = shipped("phi2", &topology, 10);
    let (graph, _) = phi2.monitor.graph().expect("a program graph");
    assert_eq!(graph.locations(), ["I", "C1", "S", "C2", "A", "T", "Err"]);
}

/// Time that passes without ticks of its own does not change earlier verdicts.
#[test]
fn verdicts_outlast_time_that_passes_without_ticks() {
    let topology = topology();
    let property = shipped("phi2", &topology, 10);
    let received = |from, to, message| {
        let channel = topology.find_channel(from, to).expect("a channel of the robot");
        EventKind::Received { channel, message }
    };
    let running = received("Navigation", "GoToDestination", Message::symbols(["ok", "running"]));
    let low = Message::new([Value::symbol("ok"), Value::Real(25.0)]);
    let low = received("BatteryReader", "BatteryLevel", low);
    let verdict = |first: EventKind| {
        let mut monitor = property.scope_monitor().expect("a synthesized monitor").clone();
        for (step, (tick, kind)) in [(0, first), (1, low.clone()), (11, EventKind::Tick)].into_iter().enumerate() {
            monitor.observe(&event(step as u64, tick, kind));
        }
        monitor.verdict()
    };
    assert_eq!(verdict(running), Verdict::False, "under way, and nothing came for ten ticks");
    assert_eq!(verdict(EventKind::Tick), Verdict::Inconclusive, "never under way");
}
