//! Writes exported SCXML monitors with random runs and the expected verdicts, so that an ECMAScript SCXML engine can
//! confirm them: `cargo run --release -p tools --bin scxml_traces -- 300 > traces.jsonl`, then, with the package
//! `@scion-scxml/scxml` from npm installed, `node tests/tools/scxml_traces.mjs traces.jsonl`.

#[path = "../../../../monitors/tests/support/mod.rs"]
#[expect(dead_code, reason = "shared with the tests of monitors")]
mod support;

use channels::{Event, EventKind, Monitor, Topology, Value, Verdict};
use monitors::{Format, Method, ScopeMonitor};

use support::{Dice, random_formula, random_sequence, topology};

/// A string as JSON.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for char in text.chars() {
        match char {
            '"' | '\\' => quoted.extend(['\\', char]),
            '\n' => quoted.push_str("\\n"),
            char => quoted.push(char),
        }
    }
    quoted + "\""
}

/// An event as it is sent to the machine: its name and its data.
fn delivered(event: &Event, topology: &Topology) -> String {
    match &event.kind {
        EventKind::Tick => format!("[\"tick\", {}]", event.tick),
        EventKind::Received { channel, message } => {
            let (from, to) = topology.ends(*channel);
            let value = |value: &Value| match value {
                Value::Symbol(symbol) => format!("{{\"sym\": {}}}", quoted(symbol.name())),
                Value::Text(text) => quoted(text),
                other => other.to_string(),
            };
            let fields: Vec<String> = message.fields().iter().map(value).collect();
            format!("[\"message.{from}.{to}\", [{}]]", fields.join(", "))
        }
    }
}

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() {
    let machines = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(100_u64);
    let topology = topology();
    let mut written = 0;
    for seed in 0_u64.. {
        let mut dice = Dice(seed);
        let formula = random_formula(&mut dice, &topology, 3);
        let Ok(monitor) = ScopeMonitor::new("p", formula, &topology) else { continue };
        // Every second machine is an automaton, and all are small.
        let is_automaton = matches!(monitor.method(), Method::Automaton { .. });
        if matches!(monitor.method(), Method::Automaton { states } if states > 60) || is_automaton != (written % 2 == 1)
        {
            continue;
        }
        let Some(scxml) = monitor.export(Format::Scxml) else { continue };
        let runs: Vec<String> = (0..10)
            .map(|_| {
                let mut sequence = random_sequence(&mut dice, &topology, 30);
                // The machines count ticks from 0 and without gaps.
                let mut ticks = 0_u64;
                for event in &mut sequence {
                    ticks += u64::from(event.kind == EventKind::Tick);
                    event.tick = ticks.saturating_sub(1);
                }
                let mut monitor = monitor.clone();
                let violated = sequence.iter().position(|event| {
                    monitor.observe(event);
                    monitor.verdict() == Verdict::False
                });
                let events: Vec<String> = sequence.iter().map(|event| delivered(event, &topology)).collect();
                format!(
                    "{{\"events\": [{}], \"violated\": {}}}",
                    events.join(", "),
                    violated.map_or(-1, |at| at as i64)
                )
            })
            .collect();
        println!("{{\"seed\": {seed}, \"scxml\": {}, \"runs\": [{}]}}", quoted(&scxml), runs.join(", "));
        written += 1;
        if written >= machines {
            return;
        }
    }
}
