//! Random formulas and sequences, and the checks on them: shared by the tests and the example `agree`.

pub(crate) mod numbers;

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, ChannelId, Domain, Event, EventKind, FieldKind, Message, Monitor, Relation, Shape, Topology, Value,
    Verdict,
};
use monitors::{Bound, Choice, Continuation, Formula, MessageCondition, ScopeMonitor, Symbol, holds, holds_endlessly};

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
    let compare = |field, relation, value: Value| MessageCondition::Compare { field, relation, value };
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
        0..=3 => Formula::Event(dice.pick(events).clone()),
        4 | 5 => {
            let event = dice.pick(events).clone();
            let relation = *dice.pick(&RELATIONS);
            let ticks = dice.roll(4);
            if choose.ahead { Formula::TimeUntil { event, relation, ticks } } else { Formula::Event(event) }
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
    let bound = if dice.roll(3) == 0 { Bound::NONE } else { Bound { relation, ticks: dice.roll(4) } };
    match dice.roll(if depth == 0 { 1 } else { 9 }) {
        0 | 1 => Formula::Count {
            event: dice.pick(events).clone(),
            is_at_most: dice.roll(2) == 0,
            count: dice.roll(4),
            ticks: dice.roll(4),
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
fn next_states(sequence: &[Event], alphabet: &[EventKind]) -> Vec<(u64, EventKind)> {
    let has_ticked = sequence.iter().any(|event| event.kind == EventKind::Tick);
    let ticks = |kind: &EventKind| match kind {
        EventKind::Tick if has_ticked => 1..=1,
        EventKind::Tick => 0..=1,
        EventKind::Received { .. } => 0..=0,
    };
    alphabet.iter().flat_map(|kind| ticks(kind).map(|ticks| (ticks, kind.clone()))).collect()
}

/// Whether all continuations of up to `depth` states have this outcome.
pub(crate) fn all_continuations(
    formula: &Formula,
    sequence: &[Event],
    alphabet: &[EventKind],
    depth: u32,
    outcome: bool,
) -> bool {
    holds(formula, sequence).expect("small") == outcome
        && (depth == 0
            || next_states(sequence, alphabet)
                .into_iter()
                .all(|next| all_continuations(formula, &continued(sequence, &[next]), alphabet, depth - 1, outcome)))
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

/// Whether the formula holds on the endless word that continues the sequence in this way.
pub(crate) fn holds_on(formula: &Formula, sequence: &[Event], Continuation { stem, cycle }: &Continuation) -> bool {
    holds_endlessly(formula, &continued(sequence, stem), cycle).expect("small")
}

/// The results for one pair of a formula and a sequence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tally {
    /// Prefixes checked.
    pub(crate) prefixes: u64,
    /// Verdicts reached.
    pub(crate) settled: u64,
    /// Pairs monitored by program graphs, automata and progression alone.
    pub(crate) graphs: u64,
    pub(crate) automata: u64,
    pub(crate) progressions: u64,
    /// Prefixes at which only the automaton had a verdict, not progression.
    pub(crate) late: u64,
    /// Outcomes that were still open because of an endless word, but of no finite one.
    pub(crate) endless: u64,
    /// Outcomes that an automaton considered open although no endless word leads to them.
    pub(crate) delayed: u64,
    /// The number of random endless words on which each verdict is checked.
    pub(crate) words: u64,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            prefixes: 0,
            settled: 0,
            graphs: 0,
            automata: 0,
            progressions: 0,
            late: 0,
            endless: 0,
            delayed: 0,
            words: 30,
        }
    }
}

/// Checks all machines for a formula against the oracle at every prefix of a sequence.
///
/// # Errors
/// What is wrong.
pub(crate) fn check(
    formula: &Formula,
    sequence: &[Event],
    topology: &Arc<Topology>,
    tally: &mut Tally,
) -> Result<(), String> {
    check_with(formula, sequence, topology, &[], tally)
}

/// As [`check`]; verdicts are also checked on continuations with these messages, which no monitor has chosen.
///
/// # Errors
/// What is wrong.
pub(crate) fn check_with(
    formula: &Formula,
    sequence: &[Event],
    topology: &Arc<Topology>,
    messages: &[EventKind],
    tally: &mut Tally,
) -> Result<(), String> {
    let make =
        |choice| ScopeMonitor::with("random", formula.clone(), topology, choice).map_err(|error| error.to_string());
    let mut best = make(Choice::Best)?;
    let mut automaton = make(Choice::Automaton)?;
    let mut progression = make(Choice::Progression)?;
    // Exporting a large automaton takes longer than everything else.
    let small = !matches!(best.method(), monitors::Method::Automaton { states } if states > 30);
    let mut graph = small.then(|| best.to_graph_monitor()).flatten();
    let mut alphabet: Vec<EventKind> = automaton.samples().chain(messages.iter().cloned()).collect();
    alphabet.push(EventKind::Tick);
    match best.method() {
        monitors::Method::Graph | monitors::Method::Graphs | monitors::Method::Rules => tally.graphs += 1,
        monitors::Method::Automaton { .. } => tally.automata += 1,
        monitors::Method::Progression => tally.progressions += 1,
    }
    if best.symbol(&EventKind::Tick).is_some() {
        check_letters(&best, sequence)?;
    }
    let mut before = [Verdict::Inconclusive; 3];
    for length in 0..=sequence.len() {
        let prefix = &sequence[..length];
        if let Some(event) = prefix.last() {
            for monitor in [&mut best as &mut dyn Monitor, &mut automaton, &mut progression] {
                monitor.observe(event);
            }
            if let Some(graph) = &mut graph {
                graph.observe(event);
            }
        }
        tally.prefixes += 1;
        let now = [best.verdict(), automaton.verdict(), progression.verdict()];
        let place = |what: &str| Err(format!("{what} after {length} states: {now:?}"));
        if before.iter().zip(&now).any(|(before, now)| *before != Verdict::Inconclusive && before != now) {
            return place("a verdict changed");
        }
        let truth = holds(formula, prefix).map_err(|error| error.to_string())?;
        for monitor in [&best, &automaton, &progression] {
            let settled = monitor.verdict() != Verdict::Inconclusive;
            let says = if settled { monitor.verdict() == Verdict::True } else { monitor.holds_so_far() };
            if says != truth {
                return place(&format!("{:?} says {says} of the run so far, the oracle {truth}", monitor.method()));
            }
        }
        if best.method().anticipates() && automaton.method().anticipates() && now[0] != now[1] {
            return place("graph and automaton differ");
        }
        if now[2] != Verdict::Inconclusive && automaton.method().anticipates() && now[2] != now[1] {
            return place("progression and automaton differ");
        }
        tally.late += u64::from(now[2] == Verdict::Inconclusive && now[1] != Verdict::Inconclusive);
        if let Some(graph) = &graph {
            // A graph cannot know that a message of the first kind can never come again.
            let same =
                graph.verdict() == now[0] || (now[0] == Verdict::True && graph.verdict() == Verdict::Inconclusive);
            let open = graph.is_open() == best.is_open();
            let from_0 = prefix.first().is_none_or(|first| first.tick == 0);
            if from_0 && (!same || !open) {
                return place(&format!("the program graph says {:?}, open: {}", graph.verdict(), graph.is_open()));
            }
        }
        check_verdict(formula, prefix, &automaton, before[1], &alphabet, tally).or_else(|what| place(&what))?;
        before = now;
    }
    Ok(())
}

/// Letters read in advance give the same verdict as the events if no tick is missing.
///
/// # Errors
/// The verdicts, if they differ.
pub(crate) fn check_letters(fresh: &ScopeMonitor, sequence: &[Event]) -> Result<(), String> {
    let mut by_event = fresh.clone();
    let mut symbols = Vec::new();
    let (mut now, mut seen) = (0, false);
    for event in sequence {
        by_event.observe(event);
        let Some(symbol) = fresh.symbol(&event.kind) else { continue };
        now = if seen { now } else { event.tick };
        // A tick that does not advance time, or advances it by more than one.
        match (event.tick - now, &event.kind) {
            (0, EventKind::Tick) => symbols.push(Symbol::TICK),
            (0, _) => symbols.push(symbol),
            (ticks, kind) => {
                let is_tick = *kind == EventKind::Tick;
                symbols.extend((u64::from(is_tick)..ticks).map(|_| Symbol::ADVANCE));
                symbols.push(symbol);
            }
        }
        (now, seen) = (event.tick, true);
    }
    let mut by_letter = fresh.clone();
    let (first, rest) = symbols.split_at(symbols.len() / 2);
    by_letter.run_symbols(first);
    by_letter.run_symbols(rest);
    if by_letter.verdict() == by_event.verdict() {
        return Ok(());
    }
    Err(format!("letters give {:?}, events {:?}", by_letter.verdict(), by_event.verdict()))
}

/// A new verdict must hold on all continuations; without a verdict there must be an endless word for either outcome.
fn check_verdict(
    formula: &Formula,
    prefix: &[Event],
    automaton: &ScopeMonitor,
    before: Verdict,
    alphabet: &[EventKind],
    tally: &mut Tally,
) -> Result<(), String> {
    let verdict = automaton.verdict();
    if verdict == Verdict::Inconclusive {
        for outcome in [true, false].into_iter().filter(|_| automaton.method().anticipates()) {
            let Some(continuation) = automaton.continuation(outcome) else {
                tally.delayed += 1;
                continue;
            };
            if holds_on(formula, prefix, &continuation) != outcome {
                return Err(format!("the continuation {continuation:?} does not lead to {outcome}"));
            }
            tally.endless += u64::from(!continuation.cycle.is_empty());
        }
    } else if before == Verdict::Inconclusive {
        tally.settled += 1;
        let outcome = verdict == Verdict::True;
        if !all_continuations(formula, prefix, alphabet, 2, outcome) {
            return Err(format!("a continuation does not give {outcome}"));
        }
        let mut dice = Dice(prefix.len() as u64 + tally.prefixes);
        for _ in 0..tally.words {
            let word = random_continuation(&mut dice, prefix, alphabet);
            if holds_on(formula, prefix, &word) != outcome {
                return Err(format!("{outcome} is too early for {word:?}"));
            }
        }
    }
    Ok(())
}

/// Checks a random pair with many extreme numbers.
///
/// # Errors
/// What is wrong.
pub(crate) fn check_numbers(seed: u64, topology: &Arc<Topology>, tally: &mut Tally) -> Result<(), String> {
    let mut dice = Dice(seed);
    let formula = numbers::formula(&mut dice, topology, 1 + seed as u32 % 3);
    let length = dice.roll(10) as usize;
    let sequence = numbers::sequence(&mut dice, topology, length);
    let messages: Vec<EventKind> = (0..6).map(|_| numbers::message(&mut dice, topology)).collect();
    let agrees = check_with(&formula, &sequence, topology, &messages, tally);
    agrees.map_err(|what| format!("pair {seed}: {what}\n{}\n{sequence:#?}", formula.text(topology)))
}
