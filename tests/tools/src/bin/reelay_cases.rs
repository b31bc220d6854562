//! Writes formulas that look back as reelay patterns, each with a run and the step where it first fails, so that reelay
//! can confirm them: `cargo run --release -p tools --bin reelay_cases -- 100000 > cases.jsonl`, then, with the package
//! `reelay` from PyPI installed, `python3 tests/tools/reelay_cases.py cases.jsonl`.
//!
//! reelay samples at 0, 1, 2, …: a run has one message after each tick, on one channel, and every operand has an event
//! of that channel, so it is checked only at messages.

#[path = "../../../../monitors/tests/support/mod.rs"]
#[expect(dead_code, reason = "shared with the tests of monitors")]
mod support;

use std::sync::Arc;

use channels::{
    Capacity, ChannelId, Domain, EventKind, FieldKind, Message, Monitor, Relation, Shape, Topology, Value, Verdict,
};
use monitors::{Bound, EventAtom, Formula, MessageCondition, ScopeMonitor};

use support::{Dice, event};

const NAMES: [&str; 3] = ["p", "q", "r"];

/// A formula on one channel, and the same formula as a pattern.
struct Pair(Formula, String);

fn any(channel: ChannelId) -> Formula {
    Formula::Event(EventAtom { channel, condition: MessageCondition::True })
}

fn pair(dice: &mut Dice, channel: ChannelId, depth: u32) -> Pair {
    let part = |dice: &mut Dice| pair(dice, channel, depth.saturating_sub(1));
    let asked = |formula: Formula| Box::new(Formula::And(vec![any(channel), formula]));
    let whenever = |formula: Formula| Box::new(any(channel).implies(formula));
    match dice.roll(if depth == 0 { 1 } else { 9 }) {
        0 => {
            let field = dice.roll(3) as usize;
            let value = Value::Bool(true);
            let condition = MessageCondition::Compare { field: (field + 1).into(), relation: Relation::Equal, value };
            Pair(Formula::Event(EventAtom { channel, condition }), format!("{{{}}}", NAMES[field]))
        }
        1 => {
            let Pair(a, text) = part(dice);
            Pair(a.negated(), format!("(not {text})"))
        }
        2 => {
            let (Pair(a, left), Pair(b, right)) = (part(dice), part(dice));
            Pair(Formula::And(vec![a, b]), format!("({left} and {right})"))
        }
        3 => {
            let (Pair(a, left), Pair(b, right)) = (part(dice), part(dice));
            Pair(a.implies(b), format!("({left} -> {right})"))
        }
        4 => {
            let Pair(a, text) = part(dice);
            Pair(Formula::Previous(Bound::NONE, asked(a)), format!("(pre {text})"))
        }
        5 => {
            let ((bound, ago), Pair(a, text)) = (within(dice), part(dice));
            Pair(Formula::Once(bound, asked(a)), format!("(once{ago} {text})"))
        }
        6 => {
            let ((bound, ago), Pair(a, text)) = (within(dice), part(dice));
            Pair(Formula::Historically(bound, whenever(a)), format!("(historically{ago} {text})"))
        }
        _ => {
            let ((bound, ago), Pair(a, left), Pair(b, right)) = (within(dice), part(dice), part(dice));
            Pair(Formula::Since(bound, whenever(a), asked(b)), format!("({left} since{ago} {right})"))
        }
    }
}

/// A bound, and the same bound as an interval.
fn within(dice: &mut Dice) -> (Bound, String) {
    // To reelay, an end of 0 means no end.
    let ticks = 1 + dice.roll(4);
    let bound = |relation| Bound::new(relation, ticks);
    match dice.roll(5) {
        0 => (Bound::NONE, String::new()),
        1 => (bound(Relation::LessOrEqual), format!("[:{ticks}]")),
        2 => (bound(Relation::GreaterOrEqual), format!("[{ticks}:]")),
        3 => (bound(Relation::Equal), format!("[{ticks}:{ticks}]")),
        _ => (bound(Relation::Greater), format!("[{}:]", ticks + 1)),
    }
}

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() {
    let cases = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(1_000_u64);
    let mut topology = Topology::default();
    let ends = ["A", "B"].map(|name| topology.process(name).expect("a new process"));
    let domain = Domain::new([Shape::new(NAMES.map(|name| (name, FieldKind::Bool)))]);
    let channel = topology.channel(ends[0], ends[1], Capacity::One, domain).expect("a new channel");
    let topology = Arc::new(topology);
    for seed in 0..cases {
        let mut dice = Dice(seed);
        let Pair(formula, pattern) = pair(&mut dice, channel, 1 + seed as u32 % 3);
        let formula = any(channel).implies(formula).always();
        let mut monitor = ScopeMonitor::new("p", formula, &topology).expect("small");
        let (mut run, mut fails) = (Vec::new(), None);
        for step in 0..20 {
            let values = NAMES.map(|_| dice.roll(2) == 0);
            monitor.observe(&event(2 * step, step, EventKind::Tick));
            let message = Message::new(values.map(Value::Bool));
            monitor.observe(&event(2 * step + 1, step, EventKind::Received { channel, message }));
            run.push(format!("[{}, {}, {}]", values[0], values[1], values[2]));
            fails = fails.or((monitor.verdict() == Verdict::False).then_some(step));
        }
        let fails = fails.map_or("null".to_owned(), |step| step.to_string());
        println!("{{\"pattern\": \"{pattern}\", \"run\": [{}], \"fails\": {fails}}}", run.join(", "));
    }
}
