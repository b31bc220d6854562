//! Fields that are called by their names, on channels whose messages have several shapes: at one position, other
//! messages have a field of another name, of the same type or a different one.

use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, Event, EventKind, FieldKind, Message, Shape, Topology, Value};
use monitors::{EventAtom, Formula};

use super::{Choose, Dice, event, formula_with};

/// Sender, receiver, the fields that hold one value, and those that hold lists.
type Known = (&'static str, &'static str, &'static [&'static str], &'static [&'static str]);

const CHANNELS: [Known; 4] = [
    ("A", "B", &["status", "level", "code", "reason"], &[]),
    ("B", "C", &["level", "extra", "note", "flag", "on", "count"], &[]),
    ("C", "D", &["kind", "x", "y", "z"], &[]),
    ("D", "A", &["n", "off", "size"], &["ranges", "levels", "others"]),
];

/// Four channels: whose shapes are told apart by symbols, by the types of the field or of another one, by symbols where
/// a field is at several positions, and by the number of fields where they are lists.
pub(crate) fn topology() -> Arc<Topology> {
    let (int, real, text, bool) = (FieldKind::Int, FieldKind::Real, FieldKind::Text, FieldKind::Bool);
    let symbol = |name| FieldKind::symbols([name]);
    let list = || FieldKind::List(Box::new(FieldKind::Int));
    let one = |fields: Vec<(&'static str, FieldKind)>| Shape::new(fields);
    let domains = [
        vec![
            one(vec![("status", symbol("ok")), ("level", real.clone())]),
            one(vec![("status", symbol("error")), ("code", int.clone())]),
            one(vec![("status", symbol("busy")), ("reason", text.clone())]),
        ],
        vec![
            one(vec![("level", real), ("extra", bool.clone())]),
            one(vec![("note", text)]),
            one(vec![("flag", bool.clone()), ("on", bool.clone()), ("count", int.clone())]),
            one(vec![("count", int.clone())]),
        ],
        vec![
            one(vec![("kind", symbol("a")), ("x", int.clone()), ("y", int.clone())]),
            one(vec![("kind", symbol("b")), ("y", int.clone()), ("x", int.clone())]),
            one(vec![("kind", symbol("c")), ("z", int.clone())]),
        ],
        vec![
            one(vec![("ranges", list()), ("levels", list()), ("n", int.clone())]),
            one(vec![("ranges", list()), ("others", list())]),
            one(vec![("off", bool), ("size", int)]),
        ],
    ];
    let mut topology = Topology::default();
    for ((from, to, ..), shapes) in CHANNELS.into_iter().zip(domains) {
        let ends = [from, to].map(|name| topology.find_process(name).or_else(|| topology.process(name).ok()));
        let [from, to] = ends.map(|end| end.expect("a process"));
        topology.channel(from, to, Capacity::One, Domain::new(shapes)).expect("a new channel");
    }
    Arc::new(topology)
}

/// A formula over a few conditions, in most of which a field is compared with a remembered one.
pub(crate) fn formula(dice: &mut Dice, topology: &Topology, depth: u32) -> Formula {
    let remembers = dice.roll(3) > 0;
    let (first, mut events) = loop {
        if let Some(read) = read(dice, topology, remembers) {
            break read;
        }
    };
    let more: Vec<EventAtom> =
        (0..4).filter_map(|_| read(dice, topology, false)).flat_map(|(_, events)| events).collect();
    events.extend(more.into_iter().take(1));
    let back = dice.roll(2) == 0;
    let inside = formula_with(dice, &events, depth, Choose { ahead: true, back });
    match (first, dice.roll(4)) {
        (None, 0) => inside,
        (None, _) => inside.always(),
        (Some(first), 0) => Formula::Eventually(Box::new(Formula::And(vec![Formula::Event(first), inside]))),
        (Some(first), _) => Formula::Event(first).implies(inside).always(),
    }
}

/// The event that remembers `p`, if one is to, and two others; `None` if one of them is refused.
fn read(dice: &mut Dice, topology: &Topology, remembers: bool) -> Option<(Option<EventAtom>, Vec<EventAtom>)> {
    let (from, to, fields, _) = dice.pick(&CHANNELS);
    let first = if remembers { format!("{} as p", dice.pick(fields)) } else { "true".to_owned() };
    let mut other = || {
        let known @ (from, to, ..) = dice.pick(&CHANNELS);
        format!("({from}, {to}, {})", condition(dice, known, remembers, 2))
    };
    let text = format!("property p := always (({from}, {to}, {first}) implies ({} or {}))", other(), other());
    let formula = monitors::formulas("p.scope", &text, topology, Duration::from_secs(1)).ok()?.remove(0).1;
    let mut events = Vec::new();
    formula.events(&mut |event| events.push(event.clone()));
    let first = events.remove(0);
    Some((remembers.then_some(first), events))
}

fn condition(dice: &mut Dice, known: &Known, remembers: bool, depth: u32) -> String {
    let (_, _, fields, lists) = known;
    let part = |dice: &mut Dice| condition(dice, known, remembers, depth - 1);
    match dice.roll(if depth == 0 { 6 } else { 10 }) {
        0 if !lists.is_empty() => items(dice, known, remembers),
        1 if !lists.is_empty() => items(dice, known, remembers),
        0..=5 => comparison(dice, fields, fields, remembers),
        6 => format!("not ({})", part(dice)),
        7 => format!("({}) and ({})", part(dice), part(dice)),
        8 => format!("({}) or ({})", part(dice), part(dice)),
        _ => format!("({}) implies ({})", part(dice), part(dice)),
    }
}

/// A comparison of one of these fields with a constant, a remembered value, another field or what is calculated.
fn comparison(dice: &mut Dice, left: &[&str], fields: &[&str], remembers: bool) -> String {
    let field = *dice.pick(left);
    let relation = *dice.pick(&["=", "=", "!=", "<", "<=", ">", ">="]);
    let number = dice.roll(3);
    match dice.roll(8) {
        0..=3 if remembers => format!("{field} {relation} p"),
        4 if remembers => format!("{field} {relation} p + {number}"),
        0 | 1 => format!("{field} {relation} {number}"),
        2 => format!("{field} = \"{}\"", ["", "x"][dice.roll(2) as usize]),
        3 => format!("{field} = {}", dice.roll(2) == 0),
        4 => format!("{field} != <{}>", ["ok", "error", "a", "c"][dice.roll(4) as usize]),
        5 => format!("{field} + {number} {relation} {}", dice.roll(4)),
        _ => format!("{field} {relation} {}", dice.pick(fields)),
    }
}

fn items(dice: &mut Dice, known: &Known, remembers: bool) -> String {
    let (_, _, fields, lists) = known;
    let others = if dice.roll(2) == 0 { lists } else { fields };
    let one = comparison(dice, lists, others, remembers);
    let inside = match dice.roll(3) {
        0 => format!("{one} or {}", comparison(dice, lists, fields, remembers)),
        1 => format!("not ({one})"),
        _ => one,
    };
    match dice.roll(4) {
        0 => format!("any({inside})"),
        1 => format!("all({inside})"),
        2 if remembers => format!("count({inside}) <= p"),
        _ => format!("count({inside}) = {}", dice.roll(3)),
    }
}

/// A message of one of the shapes, with few different values.
pub(crate) fn received(dice: &mut Dice, topology: &Topology) -> EventKind {
    let channel = topology.channels().nth(dice.roll(4) as usize).expect("four channels");
    let shape = dice.pick(topology.get(channel).domain.shapes());
    EventKind::Received { channel, message: Message::new(shape.fields().iter().map(|(_, kind)| value(dice, kind))) }
}

fn value(dice: &mut Dice, kind: &FieldKind) -> Value {
    match kind {
        FieldKind::Symbol(symbols) => dice.pick(symbols).clone().into(),
        FieldKind::Bool => (dice.roll(2) == 0).into(),
        FieldKind::Int => (dice.roll(3) as i64).into(),
        FieldKind::Real => [0.0, 0.5, 1.0, 2.0][dice.roll(4) as usize].into(),
        FieldKind::Text => ["", "x"][dice.roll(2) as usize].into(),
        FieldKind::Optional(kind) => value(dice, kind),
        FieldKind::List(kind) => Value::List((0..dice.roll(4)).map(|_| value(dice, kind)).collect()),
    }
}

/// A sequence of this many states.
pub(crate) fn sequence(dice: &mut Dice, topology: &Topology, length: usize) -> Vec<Event> {
    let (mut tick, mut ticked) = (0, false);
    let states = (0..length).map(|index| {
        let is_tick = dice.roll(4) == 0;
        tick += u64::from(is_tick && ticked);
        ticked |= is_tick;
        event(index as u64, tick, if is_tick { EventKind::Tick } else { received(dice, topology) })
    });
    states.collect()
}
