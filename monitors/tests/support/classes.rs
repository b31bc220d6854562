//! Classes of pairs of a formula and a sequence.

use std::fmt;
use std::sync::Arc;

use channels::{ChannelId, Event, EventKind, Relation, Topology, Value};
use monitors::{Arithmetic, Bound, EventAtom, Formula, Limits, MessageCondition, Term};

use super::{
    Choose, Dice, RELATIONS, formula_with, limits_divided_by, named, numbers, random_event, random_formula,
    random_sequence, topology,
};

/// What pairs are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// Few events with few values.
    Small,
    /// Many fields with numbers at the limits.
    Numbers,
    /// Operators that look back.
    Back,
    /// Remembered values, and arithmetic with them.
    Values,
    /// The same with numbers at the limits.
    Sums,
    /// Time in nanoseconds.
    Timed,
    /// Deadlines, in ticks or in nanoseconds, that are missed again and again.
    Missed,
    /// Fields called by name, on channels whose messages have several shapes with other fields at the same positions.
    Named,
    /// The first two, with a thirtieth of what a monitor may compute before a run.
    Limited,
}

/// All classes.
pub(crate) const CLASSES: [Class; 9] = [
    Class::Small,
    Class::Numbers,
    Class::Back,
    Class::Values,
    Class::Sums,
    Class::Timed,
    Class::Missed,
    Class::Named,
    Class::Limited,
];

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Small => "small domains",
            Self::Numbers => "many fields, extreme numbers",
            Self::Back => "looking back",
            Self::Values => "remembered values",
            Self::Sums => "remembered extreme numbers",
            Self::Timed => "time in nanoseconds",
            Self::Missed => "missed deadlines",
            Self::Named => "names in several shapes",
            Self::Limited => "limits divided by 30",
        })
    }
}

/// A formula and a sequence.
pub(crate) struct Pair {
    pub(crate) seed: u64,
    pub(crate) formula: Formula,
    pub(crate) sequence: Vec<Event>,
    pub(crate) topology: Arc<Topology>,
    /// Messages for continuations.
    pub(crate) messages: Vec<EventKind>,
    /// Whether the formula may have to remember too much.
    pub(crate) may_be_refused: bool,
    /// Those of the monitor that is checked; the automaton that it is compared with has the default.
    pub(crate) limits: Limits,
}

impl Pair {
    pub(crate) fn new(seed: u64, formula: Formula, sequence: Vec<Event>, topology: &Arc<Topology>) -> Self {
        let (topology, messages, limits) = (Arc::clone(topology), Vec::new(), Limits::default());
        Self { seed, formula, sequence, topology, messages, may_be_refused: false, limits }
    }
}

impl fmt::Display for Pair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, formula, sequence, topology, .. } = self;
        write!(f, "seed {seed}\n{}\n{formula:#?}\n{sequence:#?}", formula.text(topology))
    }
}

/// The topologies of all classes.
pub(crate) struct Topologies {
    small: Arc<Topology>,
    large: Arc<Topology>,
    shapes: Arc<Topology>,
}

impl Topologies {
    pub(crate) fn new() -> Self {
        Self { small: topology(), large: numbers::topology(), shapes: named::topology() }
    }

    /// A formula of this class.
    pub(crate) fn formula(&self, class: Class, dice: &mut Dice, depth: u32) -> Formula {
        let topology = self.of(class);
        match class {
            Class::Small | Class::Limited => random_formula(dice, topology, depth),
            Class::Numbers => numbers::formula(dice, topology, depth),
            Class::Back => looking_back(dice, topology, depth),
            Class::Values => {
                let channels: Vec<ChannelId> = topology.channels().collect();
                let events = [random_event(dice, topology)];
                let numbers = |dice: &mut Dice| Value::Int(1 + dice.roll(2) as i64);
                remembering(dice, &[(channels[1], 2), (channels[3], 1)], &events, numbers, depth.min(2))
            }
            Class::Sums => {
                let fields = numbers::fields(topology);
                let events = numbers::events(dice, topology);
                remembering(dice, &fields, &events[..1], numbers::number, depth.min(2))
            }
            Class::Timed => timed(dice, topology, depth),
            Class::Missed => deadlines(dice, topology),
            Class::Named => named::formula(dice, topology, depth.min(2)),
        }
    }

    /// The topology of the formulas and sequences of this class.
    pub(crate) fn of(&self, class: Class) -> &Arc<Topology> {
        match class {
            Class::Numbers | Class::Sums => &self.large,
            Class::Named => &self.shapes,
            _ => &self.small,
        }
    }

    /// The pair of a class with this seed, with at most this many states.
    pub(crate) fn pair(&self, class: Class, seed: u64, states: u64) -> Pair {
        if class == Class::Limited {
            let class = if seed.is_multiple_of(2) { Class::Small } else { Class::Numbers };
            return Pair { limits: limits_divided_by(30), ..self.pair(class, !seed, states) };
        }
        // Neighboring seeds of different classes have nothing in common.
        let mut dice = Dice(seed.wrapping_mul(0x1000_0001).wrapping_add(class as u64));
        let dice = &mut dice;
        let depth = 1 + (seed % 3) as u32;
        let topology = self.of(class);
        let formula = self.formula(class, dice, depth);
        let length = dice.roll(states) as usize;
        let (sequence, messages) = match class {
            Class::Numbers | Class::Sums => {
                let sequence = numbers::sequence(dice, topology, length);
                (sequence, (0..6).map(|_| numbers::received(dice, topology)).collect())
            }
            Class::Named => {
                let sequence = named::sequence(dice, topology, length);
                (sequence, (0..6).map(|_| named::received(dice, topology)).collect())
            }
            _ => (random_sequence(dice, topology, length), Vec::new()),
        };
        let may_be_refused = matches!(class, Class::Values | Class::Sums | Class::Named);
        Pair { messages, may_be_refused, ..Pair::new(seed, formula, sequence, topology) }
    }
}

fn looking_back(dice: &mut Dice, topology: &Topology, depth: u32) -> Formula {
    let events = [0; 3].map(|_| random_event(dice, topology));
    let ahead = dice.roll(4) > 0;
    let part = formula_with(dice, &events, depth, Choose { ahead, back: true });
    if dice.roll(3) > 0 { part.always() } else { part }
}

/// One or two rules, each of which demands an answer, or a ban beside it; sometimes of the next message.
fn deadlines(dice: &mut Dice, topology: &Topology) -> Formula {
    let events = [0; 3].map(|_| random_event(dice, topology));
    let rule = |dice: &mut Dice| {
        let within = |dice: &mut Dice| {
            let relation = *dice.pick(&[Relation::Less, Relation::Less, Relation::LessOrEqual, Relation::Equal]);
            Formula::TimeUntil { event: dice.pick(&events).clone(), bound: Bound::new(relation, dice.roll(6)) }
        };
        let asked = if dice.roll(4) == 0 { Formula::True } else { Formula::Event(dice.pick(&events).clone()) };
        let owed = match dice.roll(8) {
            0 => Formula::Or(vec![within(dice), within(dice)]),
            1 => Formula::And(vec![within(dice), within(dice).negated()]),
            2 => Formula::Next(Box::new(Formula::Event(dice.pick(&events).clone()))),
            3 => within(dice).negated(),
            _ => within(dice),
        };
        asked.implies(owed).always()
    };
    let first = rule(dice);
    let rules = if dice.roll(3) == 0 { Formula::And(vec![first, rule(dice)]) } else { first };
    match dice.roll(3) {
        0 => Formula::Timed(Box::new(stretched(&rules, *dice.pick(&[500_000_000, 1_000_000_000, 1_001_000_000])))),
        _ => rules,
    }
}

/// Bounds between, at and beyond the times of events.
fn timed(dice: &mut Dice, topology: &Topology, depth: u32) -> Formula {
    let events = [0; 3].map(|_| random_event(dice, topology));
    let back = dice.roll(2) == 0;
    let formula = formula_with(dice, &events, depth, Choose { ahead: true, back });
    let unit = *dice.pick(&[500_000_000, 1_000_000_000, 1_001_000_000]);
    Formula::Timed(Box::new(stretched(&formula.always(), unit)))
}

/// A formula that remembers one of these fields and compares others with it: the same number, a greater one, …
fn remembering(
    dice: &mut Dice,
    fields: &[(ChannelId, usize)],
    others: &[EventAtom],
    number: fn(&mut Dice) -> Value,
    depth: u32,
) -> Formula {
    let remembers = |dice: &mut Dice| {
        let (channel, field) = *dice.pick(fields);
        EventAtom { channel, condition: MessageCondition::Remember { field: field.into(), name: "p".into() } }
    };
    let compares = |dice: &mut Dice| {
        let (channel, field) = *dice.pick(fields);
        let [remembered, more] = [Term::Remembered("p".into()), Term::Value(number(dice))].map(Box::new);
        let operator = *dice.pick(&[Arithmetic::Add, Arithmetic::Subtract, Arithmetic::Multiply, Arithmetic::Divide]);
        let sum = Term::Arithmetic(remembered.clone(), operator, more);
        let right = if dice.roll(3) == 0 { sum } else { *remembered };
        let relation = *dice.pick(&RELATIONS);
        EventAtom { channel, condition: MessageCondition::Relate { left: Term::Field(field.into()), relation, right } }
    };
    let mut events = vec![compares(dice), compares(dice)];
    events.extend_from_slice(others);
    events.extend((dice.roll(4) == 0).then(|| remembers(dice)));
    let back = dice.roll(2) == 0;
    let inside = formula_with(dice, &events, depth, Choose { ahead: true, back });
    let first = remembers(dice);
    match dice.roll(4) {
        0 => Formula::Eventually(Box::new(Formula::And(vec![Formula::Event(first), inside]))),
        _ => Formula::Event(first).implies(inside).always(),
    }
}

/// The formula with all bounds multiplied.
pub(crate) fn stretched(formula: &Formula, factor: u64) -> Formula {
    let of = |part: &Formula| Box::new(stretched(part, factor));
    let all = |parts: &[Formula]| parts.iter().map(|part| stretched(part, factor)).collect();
    let longer = |bound: Bound| Bound::new(bound.relation, bound.ticks * factor);
    match formula {
        Formula::TimeUntil { event, bound } => Formula::TimeUntil { event: event.clone(), bound: longer(*bound) },
        Formula::Not(a) => Formula::Not(of(a)),
        Formula::Next(a) => Formula::Next(of(a)),
        Formula::Always(a) => Formula::Always(of(a)),
        Formula::Eventually(a) => Formula::Eventually(of(a)),
        Formula::And(parts) => Formula::And(all(parts)),
        Formula::Or(parts) => Formula::Or(all(parts)),
        Formula::Implies(a, b) => Formula::Implies(of(a), of(b)),
        Formula::Until(a, b) => Formula::Until(of(a), of(b)),
        Formula::Once(bound, a) => Formula::Once(longer(*bound), of(a)),
        Formula::Historically(bound, a) => Formula::Historically(longer(*bound), of(a)),
        Formula::Previous(bound, a) => Formula::Previous(longer(*bound), of(a)),
        Formula::Since(bound, a, b) => Formula::Since(longer(*bound), of(a), of(b)),
        Formula::Count { event, is_at_most, count, bound } => {
            let (event, bound) = (event.clone(), longer(*bound));
            Formula::Count { event, is_at_most: *is_at_most, count: *count, bound }
        }
        atom => atom.clone(),
    }
}
