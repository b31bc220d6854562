//! Random formulas and sequences, and the checks on them: shared by the tests and by `tests/tools`.

pub(crate) mod check;
pub(crate) mod classes;
pub(crate) mod definition;
pub(crate) mod exact;
pub(crate) mod named;
pub(crate) mod numbers;
pub(crate) mod proofs;
pub(crate) mod tally;

use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, ChannelId, Domain, Event, EventKind, FieldKind, Message, Relation, Shape, Topology, Value};
use monitors::{Bound, Continuation, Formula, Limits, MessageCondition};

/// Pseudo-random numbers that are the same everywhere (SplitMix64).
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `sides`.
    pub(crate) fn roll(&mut self, sides: u64) -> u64 {
        self.next() % sides
    }

    /// One of the items.
    pub(crate) fn pick<'a, T>(&mut self, things: &'a [T]) -> &'a T {
        &things[self.roll(things.len() as u64) as usize]
    }
}

/// Four channels with small domains.
pub(crate) fn topology() -> Arc<Topology> {
    let mut topology = Topology::default();
    let ends = ["A", "B", "C", "D"].map(|name| topology.process(name).expect("a new process"));
    let shapes = [
        Shape::new([("head", FieldKind::symbols(["x", "y", "z"]))]),
        Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]),
        Shape::new([("on", FieldKind::Bool)]),
        Shape::new([("number", FieldKind::Int)]),
    ];
    for (index, shape) in shapes.into_iter().enumerate() {
        let target = ends[(index + 1) % 4];
        topology.channel(ends[index], target, Capacity::One, Domain::new([shape])).expect("a new channel");
    }
    Arc::new(topology)
}

/// An event on one of the channels.
pub(crate) fn random_event(dice: &mut Dice, topology: &Topology) -> monitors::EventAtom {
    let channels: Vec<ChannelId> = topology.channels().collect();
    let index = dice.roll(4) as usize;
    let compare =
        |field: usize, relation, value: Value| MessageCondition::Compare { field: field.into(), relation, value };
    let relations = [
        Relation::Equal,
        Relation::NotEqual,
        Relation::Less,
        Relation::LessOrEqual,
        Relation::Greater,
        Relation::GreaterOrEqual,
    ];
    let condition = match index {
        0 => compare(1, *dice.pick(&relations[..2]), Value::symbol(["x", "y"][dice.roll(2) as usize])),
        1 => {
            let ok = compare(1, Relation::Equal, Value::symbol("ok"));
            let level = compare(2, *dice.pick(&relations), Value::Real(*dice.pick(&[20.0, 30.0])));
            match dice.roll(3) {
                0 => level,
                1 => MessageCondition::And(vec![ok, level]),
                _ => MessageCondition::Implies(Box::new(ok), Box::new(level)),
            }
        }
        2 => compare(1, Relation::Equal, Value::Bool(dice.roll(2) == 0)),
        _ => compare(1, *dice.pick(&relations), Value::Int(dice.roll(2) as i64)),
    };
    monitors::EventAtom { channel: channels[index], condition }
}

/// A formula of at most this depth, over a few events.
pub(crate) fn random_formula(dice: &mut Dice, topology: &Topology, depth: u32) -> Formula {
    let events: Vec<monitors::EventAtom> = (0..3).map(|_| random_event(dice, topology)).collect();
    formula_over(dice, &events, depth)
}

/// A formula of at most this depth over these events.
pub(crate) fn formula_over(dice: &mut Dice, events: &[monitors::EventAtom], depth: u32) -> Formula {
    formula_with(dice, events, depth, Choose { ahead: true, back: false })
}

/// The operators that a random formula may contain.
#[derive(Clone, Copy)]
pub(crate) struct Choose {
    /// Those that look ahead.
    pub(crate) ahead: bool,
    /// Those that look back.
    pub(crate) back: bool,
}

/// A formula of at most this depth over these events, with these operators.
pub(crate) fn formula_with(dice: &mut Dice, events: &[monitors::EventAtom], depth: u32, choose: Choose) -> Formula {
    let sides = if depth == 0 { 7 } else { 20 };
    let part = |dice: &mut Dice| Box::new(formula_with(dice, events, depth.saturating_sub(1), choose));
    if choose.back && depth > 0 && dice.roll(3) == 0 || !choose.ahead && dice.roll(2) == 0 {
        return looking_back(dice, events, depth);
    }
    match dice.roll(if choose.ahead { sides } else { sides.min(14) }) {
        0..=2 => Formula::Event(dice.pick(events).clone()),
        3 => Formula::Fresh(dice.pick(events).clone()),
        4 | 5 => {
            let event = dice.pick(events).clone();
            let relation = *dice.pick(&RELATIONS);
            let ticks = dice.roll(4);
            if choose.ahead {
                Formula::TimeUntil { event, bound: Bound::new(relation, ticks) }
            } else {
                Formula::Event(event)
            }
        }
        6 => {
            if dice.roll(2) == 0 {
                Formula::True
            } else {
                Formula::False
            }
        }
        7 | 8 => Formula::Not(part(dice)),
        9 | 10 => Formula::And(vec![*part(dice), *part(dice)]),
        11 | 12 => Formula::Or(vec![*part(dice), *part(dice)]),
        13 => Formula::Implies(part(dice), part(dice)),
        14 => Formula::Next(part(dice)),
        15 | 16 => Formula::Always(part(dice)),
        17 => Formula::Eventually(part(dice)),
        _ => Formula::Until(part(dice), part(dice)),
    }
}

pub(crate) const RELATIONS: [Relation; 7] = [
    Relation::Less,
    Relation::Less,
    Relation::LessOrEqual,
    Relation::Equal,
    Relation::NotEqual,
    Relation::Greater,
    Relation::GreaterOrEqual,
];

/// A formula that looks back.
fn looking_back(dice: &mut Dice, events: &[monitors::EventAtom], depth: u32) -> Formula {
    let choose = Choose { ahead: false, back: true };
    let part = |dice: &mut Dice| Box::new(formula_with(dice, events, depth.saturating_sub(1), choose));
    let relation = *dice.pick(&RELATIONS);
    let bound = if dice.roll(3) == 0 { Bound::NONE } else { Bound::new(relation, dice.roll(4)) };
    match dice.roll(if depth == 0 { 1 } else { 9 }) {
        0 | 1 => Formula::Count {
            event: dice.pick(events).clone(),
            is_at_most: dice.roll(2) == 0,
            count: dice.roll(4),
            bound: Bound::new(Relation::Less, dice.roll(4)),
        },
        2 | 3 => Formula::Once(bound, part(dice)),
        4 => Formula::Historically(bound, part(dice)),
        5 | 6 => Formula::Previous(bound, part(dice)),
        _ => Formula::Since(bound, part(dice), part(dice)),
    }
}

/// A message on one of the channels.
pub(crate) fn random_message(dice: &mut Dice, topology: &Topology) -> EventKind {
    let channels: Vec<ChannelId> = topology.channels().collect();
    let index = dice.roll(4) as usize;
    let message = match index {
        0 => Message::symbols([["x", "y", "z"][dice.roll(3) as usize]]),
        1 => Message::new([Value::symbol("ok"), Value::Real(*dice.pick(&[10.0, 20.0, 25.0, 30.0, 40.0]))]),
        2 => Message::new([Value::Bool(dice.roll(2) == 0)]),
        _ => Message::new([Value::Int(dice.roll(3) as i64 - 1)]),
    };
    EventKind::Received { channel: channels[index], message }
}

/// A sequence of this many states. The first tick usually has number 0, and may come after messages.
pub(crate) fn random_sequence(dice: &mut Dice, topology: &Topology, length: usize) -> Vec<Event> {
    let mut ticked = false;
    let mut tick = if dice.roll(10) == 0 { 7 } else { 0 };
    let first_is_tick = dice.roll(3) > 0;
    let mut events = Vec::new();
    for index in 0..length {
        let is_tick = (index == 0 && first_is_tick) || dice.roll(3) == 0;
        tick += u64::from(is_tick && ticked);
        ticked |= is_tick;
        let kind = if is_tick { EventKind::Tick } else { random_message(dice, topology) };
        events.push(event(index as u64, tick, kind));
    }
    events
}

pub(crate) fn event(step: u64, tick: u64, kind: EventKind) -> Event {
    Event { step, tick, time: Duration::from_millis(tick * 1000 + step), kind }
}

/// Each default limit divided by this number.
pub(crate) fn limits_divided_by(by: usize) -> Limits {
    let limits = Limits::default();
    Limits {
        combinations: limits.combinations / by,
        symbols: limits.symbols / by,
        rules: limits.rules / by,
        graph_states: limits.graph_states / by,
        automaton_states: limits.automaton_states / by,
        clauses: limits.clauses / by,
        nodes: limits.nodes / by,
        edges: limits.edges / by,
        ways: limits.ways / by,
        delays: limits.delays / by,
    }
}

/// The sequence and a continuation: states with their distance in ticks from the previous one.
pub(crate) fn continued(sequence: &[Event], continuation: &[(u64, EventKind)]) -> Vec<Event> {
    let mut events = sequence.to_vec();
    for (ticks, kind) in continuation {
        let tick = events.last().map_or(0, |last| last.tick) + ticks;
        events.push(event(events.len() as u64, tick, kind.clone()));
    }
    events
}

/// The possible next letters: τ grows by one at each tick; only the very first tick may leave it unchanged.
pub(crate) fn next_states(sequence: &[Event], alphabet: &[EventKind]) -> Vec<(u64, EventKind)> {
    let has_ticked = sequence.iter().any(|event| event.kind == EventKind::Tick);
    let ticks = |kind: &EventKind| match kind {
        EventKind::Tick if has_ticked => 1..=1,
        EventKind::Tick => 0..=1,
        EventKind::Received { .. } => 0..=0,
    };
    alphabet.iter().flat_map(|kind| ticks(kind).map(|ticks| (ticks, kind.clone()))).collect()
}

/// An endless word that continues a sequence.
pub(crate) fn random_continuation(dice: &mut Dice, sequence: &[Event], alphabet: &[EventKind]) -> Continuation {
    let cycle: Vec<EventKind> = (0..dice.roll(5)).map(|_| dice.pick(alphabet).clone()).collect();
    let mut longer = sequence.to_vec();
    for _ in 0..dice.roll(6) {
        let next = dice.pick(&next_states(&longer, alphabet)).clone();
        longer = continued(&longer, &[next]);
    }
    if !longer.iter().chain(sequence).any(|event| event.kind == EventKind::Tick) {
        longer = continued(&longer, &[(0, EventKind::Tick)]);
    }
    let before = sequence.last().map_or(0, |last| last.tick);
    let stem = longer[sequence.len()..].iter().scan(before, |before, event| {
        let ticks = event.tick - *before;
        *before = event.tick;
        Some((ticks, event.kind.clone()))
    });
    Continuation { stem: stem.collect(), cycle }
}
