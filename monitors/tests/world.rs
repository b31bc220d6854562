//! What a property sees of the world does not depend on what others mention.

use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, Event, EventKind, FieldKind, Message, Monitor, Shape, Topology, Value};
use monitors::{MONITORS, ScopeMonitor, WORLD};

use crate::cases::cases;
use crate::support::{Dice, event};

/// The fields of the world that a property mentions, and the property.
const PROPERTIES: [(&[usize], &str); 9] = [
    (&[0], "property p := always at most 2 (World, Monitors, a = 1) in 3"),
    (&[0], "property p := always at least 1 (World, Monitors, a = 1) in 4"),
    (&[0], "property p := always ((World, Monitors, a as x) implies next (World, Monitors, a != x))"),
    (&[1], "property p := always ((World, Monitors, b = 1) implies previous (World, Monitors, b = 0))"),
    (&[0], "property p := always (fresh (World, Monitors, a = 1) implies (A, B, on = true))"),
    (
        &[0, 2],
        "property p := always ((World, Monitors, a = 1 and c = true) implies time_until (World, Monitors, a = 0) < 2)",
    ),
    (&[1], "timed property p := always (becomes (World, Monitors, b = 1) implies time_until (A, B, on = true) < 1 s)"),
    (&[1, 2], "property p := (World, Monitors, b >= 0) until (World, Monitors, c = true and b = 1)"),
    (&[], "property p := always (fresh (World, Monitors, true) implies once (A, B, on = true))"),
];

fn topology(fields: &[usize]) -> Arc<Topology> {
    let mut topology = Topology::default();
    let [a, b, world, monitors] = ["A", "B", WORLD, MONITORS].map(|name| topology.process(name).expect("a new name"));
    let all = [("a", FieldKind::Int), ("b", FieldKind::Int), ("c", FieldKind::Bool)];
    let shape = Shape::new(fields.iter().map(|field| all[*field].clone()));
    topology.channel(world, monitors, Capacity::Zero, Domain::new([shape])).expect("a new channel");
    let on = Shape::new([("on", FieldKind::Bool)]);
    topology.channel(a, b, Capacity::One, Domain::new([on])).expect("a new channel");
    Arc::new(topology)
}

fn monitor(text: &str, fields: &[usize]) -> ScopeMonitor {
    let file = monitors::load("p.scope", text, &topology(fields), Duration::from_secs(1));
    let file = file.unwrap_or_else(|error| panic!("{text}: {:?}", error.problems()));
    file.properties[0].scope_monitor().expect("made from a formula").clone()
}

/// The states of a run: what the world shows if these fields are mentioned is shown where one of them has changed.
fn run(states: &[(u64, Option<bool>, [i64; 3])], fields: &[usize]) -> Vec<Event> {
    let topology = topology(fields);
    let [world, other] = [(WORLD, MONITORS), ("A", "B")].map(|(a, b)| topology.find_channel(a, b).expect("it exists"));
    let (mut shown, mut events) = (None, Vec::new());
    for (index, (tick, told, values)) in states.iter().enumerate() {
        let step = index as u64 * 2;
        let own: Vec<Value> = fields
            .iter()
            .map(|field| if *field == 2 { Value::Bool(values[2] == 1) } else { Value::Int(values[*field]) })
            .collect();
        if shown.as_ref() != Some(&own) {
            shown = Some(own.clone());
            events.push(event(step, *tick, EventKind::Received { channel: world, message: Message::new(own) }));
        }
        let kind = match told {
            Some(on) => EventKind::Received { channel: other, message: Message::new([Value::Bool(*on)]) },
            None => EventKind::Tick,
        };
        events.push(event(step + 1, *tick, kind));
    }
    events
}

#[test]
fn a_property_about_the_world_does_not_depend_on_what_others_mention() {
    let mut violated = 0;
    for seed in 0..cases(3_000) {
        let mut dice = Dice(seed + 70_000_000);
        let (own, text) = PROPERTIES[seed as usize % PROPERTIES.len()];
        let (mut tick, mut values) = (0, [0; 3]);
        let states: Vec<_> = (0..20)
            .map(|_| {
                let told = (dice.roll(2) == 0).then(|| dice.roll(2) == 0);
                tick += u64::from(told.is_none());
                let changed = dice.roll(3) as usize;
                values[changed] = dice.roll(2) as i64;
                (tick, told, values)
            })
            .collect();
        let [alone, beside] = [own, &[0, 1, 2]].map(|fields| {
            let mut monitor = monitor(text, fields);
            run(&states, fields).iter().for_each(|event| monitor.observe(event));
            (monitor.outcome(), monitor.violations().cloned())
        });
        assert_eq!(alone, beside, "seed {seed}: {text}\n{states:?}");
        violated += u64::from(alone.1.is_some());
    }
    assert!(violated * 4 > cases(3_000), "{violated} violated");
}
