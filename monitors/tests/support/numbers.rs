//! Messages of many numbers, compared with constants at the limits of 64-bit integers and of reals.

use std::sync::Arc;

use channels::{
    Capacity, ChannelId, Domain, Event, EventKind, FieldKind, Message, Relation, Shape, TickGenerator, Topology, Value,
};
use monitors::{Arithmetic, EventAtom, Formula, MessageCondition, Term};

use super::{Choose, Dice, event, formula_with};

const INTEGERS: [i64; 14] = [
    i64::MIN,
    i64::MIN + 1,
    -9_007_199_254_740_993,
    -1,
    0,
    1,
    9_007_199_254_740_991,
    9_007_199_254_740_992,
    9_007_199_254_740_993,
    1_700_000_000_000_000_001,
    1_700_000_000_000_000_002,
    9_000_000_000_000_000_000,
    i64::MAX - 1,
    i64::MAX,
];

const REALS: [f64; 18] = [
    f64::NEG_INFINITY,
    -f64::MAX,
    -1e308,
    -9_223_372_036_854_775_808.0,
    -2.9,
    -1.0,
    -5e-324,
    -0.0,
    0.0,
    0.5,
    2.9,
    9_007_199_254_740_992.0,
    1.7e18,
    9_223_372_036_854_774_784.0,
    9_223_372_036_854_775_808.0,
    1e308,
    f64::MAX,
    f64::INFINITY,
];

const JOINTS: usize = 8;

/// The indexes of the channels that carry messages of their own, not ticks, and that of the channel with lists.
const TALKATIVE: [usize; 5] = [0, 1, 2, 3, LISTS];
const LISTS: usize = 5;

/// Channels with eight reals, with integers of which one may be missing, with two forms of messages, there and back,
/// and with lists. `A` also receives ticks.
pub(crate) fn topology() -> Arc<Topology> {
    let mut topology = Topology::default();
    let [a, b, c, d, ticks] = ["A", "B", "C", "D", "Ticks"].map(|name| topology.process(name).expect("a new process"));
    let item = FieldKind::Optional(Box::new(FieldKind::Int));
    let forms = Domain::new([
        Shape::new([("status", FieldKind::symbols(["ok"])), ("n", FieldKind::Int), ("x", FieldKind::Real)]),
        Shape::new([("status", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]),
    ]);
    let list = |kind| FieldKind::List(Box::new(kind));
    let real = FieldKind::Optional(Box::new(FieldKind::Real));
    let lists = Domain::new([
        Shape::new([("ranges", list(real)), ("levels", list(FieldKind::Int)), ("n", FieldKind::Int)]),
        Shape::new([("off", FieldKind::Bool)]),
    ]);
    for (from, to, domain) in [
        (a, b, Domain::new([Shape::new((1..=JOINTS).map(|joint| (format!("j{joint}"), FieldKind::Real)))])),
        (b, c, Domain::new([Shape::new([("stamp", FieldKind::Int), ("id", FieldKind::Int), ("item", item)])])),
        (c, d, forms.clone()),
        (d, a, forms),
        (ticks, a, Domain::new([TickGenerator::shape()])),
        (a, c, lists),
    ] {
        topology.channel(from, to, Capacity::One, domain).expect("a new channel");
    }
    Arc::new(topology)
}

/// A constant.
pub(crate) fn number(dice: &mut Dice) -> Value {
    if dice.roll(2) == 0 { Value::Int(*dice.pick(&INTEGERS)) } else { Value::Real(*dice.pick(&REALS)) }
}

fn relation(dice: &mut Dice) -> Relation {
    *dice.pick(&[
        Relation::Equal,
        Relation::NotEqual,
        Relation::Less,
        Relation::LessOrEqual,
        Relation::Greater,
        Relation::GreaterOrEqual,
    ])
}

/// The condition that these fields are, or are not, all in an interval.
fn box_of(dice: &mut Dice, fields: usize) -> MessageCondition {
    let bound = |field: usize, relation, value: f64| MessageCondition::Compare {
        field: field.into(),
        relation,
        value: value.into(),
    };
    let side = *dice.pick(&[0.5, 2.9, 1e308]);
    let inside =
        (1..=fields).flat_map(|field| [bound(field, Relation::Greater, -side), bound(field, Relation::Less, side)]);
    let inside = MessageCondition::And(inside.collect());
    if dice.roll(3) == 0 { MessageCondition::Not(Box::new(inside)) } else { inside }
}

/// A condition on messages with this many fields.
fn condition(dice: &mut Dice, fields: usize, depth: u32) -> MessageCondition {
    let part = |dice: &mut Dice| condition(dice, fields, depth.saturating_sub(1));
    match dice.roll(if depth == 0 { 5 } else { 10 }) {
        0..=3 => {
            let (field, relation) = (1 + dice.roll(fields as u64) as usize, relation(dice));
            let value = match dice.roll(8) {
                0 => Value::symbol(["ok", "error", FieldKind::NONE][dice.roll(3) as usize]),
                1 => Value::from("reason"),
                _ => number(dice),
            };
            MessageCondition::Compare { field: field.into(), relation, value }
        }
        4 => MessageCondition::True,
        5 => MessageCondition::Not(Box::new(part(dice))),
        6 => MessageCondition::And((0..dice.roll(4)).map(|_| part(dice)).collect()),
        7 => MessageCondition::Or((0..dice.roll(4)).map(|_| part(dice)).collect()),
        8 => MessageCondition::Implies(Box::new(part(dice)), Box::new(part(dice))),
        _ => box_of(dice, fields),
    }
}

/// A condition on two fields, or one that calculates.
fn relation_of_fields(dice: &mut Dice, fields: usize) -> MessageCondition {
    let field = |dice: &mut Dice| Term::Field((1 + dice.roll(fields as u64) as usize).into());
    let (left, relation, other) = (field(dice), relation(dice), field(dice));
    let operator = *dice.pick(&[Arithmetic::Add, Arithmetic::Subtract, Arithmetic::Multiply, Arithmetic::Divide]);
    let sum = Term::Arithmetic(Box::new(other.clone()), operator, Box::new(Term::Value(number(dice))));
    let right = if dice.roll(2) == 0 { other } else { sum };
    MessageCondition::Relate { left, relation, right }
}

/// `any(…)`, `all(…)` or `count(…)`, sometimes with a condition on the whole message.
fn condition_on_lists(dice: &mut Dice) -> MessageCondition {
    let inside = if dice.roll(4) == 0 { relation_of_fields(dice, 3) } else { condition(dice, 3, 1) };
    let denied = MessageCondition::Not(Box::new(inside.clone()));
    let (counted, relation, number) = match dice.roll(3) {
        0 => (inside, Relation::GreaterOrEqual, 1.into()),
        1 => (denied, Relation::Equal, 0.into()),
        _ => (inside, relation(dice), (dice.roll(4) as i64).into()),
    };
    let right = if dice.roll(6) == 0 { Term::Field(3.into()) } else { Term::Value(number) };
    let items = MessageCondition::Relate { left: Term::Count(Box::new(counted)), relation, right };
    match dice.roll(4) {
        0 => MessageCondition::And(vec![items, condition(dice, 3, 1)]),
        1 => MessageCondition::Not(Box::new(items)),
        _ => items,
    }
}

/// The fields with numbers, and one of another kind.
pub(crate) fn fields(topology: &Topology) -> Vec<(ChannelId, usize)> {
    let channels: Vec<ChannelId> = topology.channels().collect();
    [(0, 1), (0, 2), (1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (3, 2), (3, 3)]
        .map(|(at, field)| (channels[at], field))
        .to_vec()
}

/// Three events.
pub(crate) fn events(dice: &mut Dice, topology: &Topology) -> Vec<EventAtom> {
    let channels: Vec<ChannelId> = topology.channels().collect();
    let event = |_| {
        let index = *dice.pick(&TALKATIVE);
        let fields = if index == 0 { JOINTS } else { 3 };
        let condition = match dice.roll(12) {
            _ if index == LISTS => condition_on_lists(dice),
            0 => relation_of_fields(dice, fields),
            _ => condition(dice, fields, 2),
        };
        EventAtom { channel: channels[index], condition }
    };
    (0..3).map(event).collect()
}

/// A formula over a few such events, some of whose parts are trivially true or false.
pub(crate) fn formula(dice: &mut Dice, topology: &Topology, depth: u32) -> Formula {
    let events = events(dice, topology);
    let back = dice.roll(4) == 0;
    let inside = formula_with(dice, &events, depth, Choose { ahead: true, back });
    match dice.roll(6) {
        0 => Formula::Event(events[0].clone()).implies(Formula::Or(vec![inside, Formula::True])).always(),
        1 => Formula::Event(events[0].clone()).negated().always(),
        2 => {
            let gone = Formula::And(vec![Formula::Event(events[1].clone()), Formula::False]);
            Formula::Until(Box::new(Formula::Or(vec![inside, gone])), Box::new(Formula::Event(events[0].clone())))
        }
        _ => inside,
    }
}

/// A message on one of the channels.
pub(crate) fn received(dice: &mut Dice, topology: &Topology) -> EventKind {
    let index = *dice.pick(&TALKATIVE);
    let channel = topology.channels().nth(index).expect("a channel");
    EventKind::Received { channel, message: message(dice, index) }
}

/// A message on the channel with this index.
pub(crate) fn message(dice: &mut Dice, index: usize) -> Message {
    let int = |dice: &mut Dice| {
        let near = [-1, 0, 0, 0, 1][dice.roll(5) as usize];
        Value::Int(dice.pick(&INTEGERS).saturating_add(near))
    };
    let real = |dice: &mut Dice| {
        let real = *dice.pick(&REALS);
        Value::Real([real.next_down(), real, real, real.next_up(), 0.25][dice.roll(5) as usize])
    };
    match index {
        0 => {
            let same = real(dice);
            let all = dice.roll(2) == 0;
            Message::new((0..JOINTS).map(|_| if all { same.clone() } else { real(dice) }))
        }
        1 => {
            let item = if dice.roll(3) == 0 { Value::symbol(FieldKind::NONE) } else { int(dice) };
            Message::new([int(dice), int(dice), item])
        }
        LISTS if dice.roll(5) == 0 => Message::new([true.into()]),
        LISTS => {
            let ranges: Vec<Value> = (0..dice.roll(4))
                .map(|_| if dice.roll(4) == 0 { Value::symbol(FieldKind::NONE) } else { real(dice) })
                .collect();
            let levels: Vec<Value> = (0..dice.roll(4)).map(|_| int(dice)).collect();
            let number = if dice.roll(2) == 0 { Value::Int(dice.roll(4) as i64) } else { int(dice) };
            Message::new([Value::List(ranges.into()), Value::List(levels.into()), number])
        }
        _ if dice.roll(3) == 0 => Message::new([Value::symbol("error"), "reason".into()]),
        _ => Message::new([Value::symbol("ok"), int(dice), real(dice)]),
    }
}

/// A sequence of this many states; its first need not be a tick.
pub(crate) fn sequence(dice: &mut Dice, topology: &Topology, length: usize) -> Vec<Event> {
    let (mut tick, mut ticked) = (0, false);
    let states = (0..length).map(|index| {
        let is_tick = dice.roll(3) == 0;
        tick += u64::from(is_tick && ticked);
        ticked |= is_tick;
        event(index as u64, tick, if is_tick { EventKind::Tick } else { received(dice, topology) })
    });
    states.collect()
}
