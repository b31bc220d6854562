//! Letters: what a formula can distinguish in a message.

use std::collections::{BTreeMap, BTreeSet};

use channels::{ChannelId, Domain, FieldKind, Message, Topology, Value};

use crate::clause::{EventId, Vocabulary};
use crate::formula::MessageCondition;

/// A state as a formula sees it: a tick, or a message on a channel that satisfies some of the formula's events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Letter {
    /// The events whose channel carries the message; none at a tick.
    pub(crate) channel: u64,
    /// The subset of these events that the message satisfies.
    pub(crate) satisfied: u64,
}

impl Letter {
    /// A tick is generated.
    pub(crate) const TICK: Self = Self { channel: 0, satisfied: 0 };

    pub(crate) fn is_tick(self) -> bool {
        self.channel == 0
    }

    /// The events that the last messages satisfy after this letter, if they satisfied `last` before it.
    pub(crate) fn after(self, last: u64) -> u64 {
        last & !self.channel | self.satisfied
    }
}

/// A formula has at most this many different events.
pub(crate) const MAX_EVENTS: usize = 64;

/// A letter as a column of a table: a tick, the passing of time, or a message on a channel with the events that it
/// satisfies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Symbol(pub(crate) u16);

impl Symbol {
    /// A tick is generated and τ is unchanged: the first tick of a run.
    pub const TICK: Self = Self(0);
    /// τ grows by one, before the tick's state.
    pub const ADVANCE: Self = Self(1);
    /// τ grows by one, and this tick is generated.
    pub const NEXT_TICK: Self = Self(2);
    /// The first symbol of a message.
    pub(crate) const MESSAGES: u16 = 3;
}

/// The letters of a formula, and the mapping of messages to letters.
#[derive(Clone, Debug)]
pub(crate) struct Alphabet {
    /// For each channel of the topology, by index, its index in `readers`; `DEAF` if the formula does not mention it.
    by_channel: Vec<u16>,
    readers: Vec<Reader>,
    /// The number of symbols; `None` if there are too many for tables.
    symbols: Option<u16>,
}

/// Reads the messages of one channel.
#[derive(Clone, Debug)]
struct Reader {
    channel: ChannelId,
    mask: u64,
    /// The position of the channel's events among all events.
    shift: u32,
    conditions: Vec<MessageCondition>,
    /// The possible letters of messages in the channel's domain, each with such a message.
    letters: Vec<(Letter, Message)>,
    /// The symbol of a message that satisfies nothing.
    base: u16,
}

const DEAF: u16 = u16::MAX;

/// A formula with more symbols than this is monitored without tables.
const MAX_SYMBOLS: u32 = 1 << 10;

impl Alphabet {
    /// The alphabet of a vocabulary of at most [`MAX_EVENTS`] events.
    pub(crate) fn new(vocabulary: &Vocabulary, topology: &Topology) -> Self {
        let channels = vocabulary.channels();
        let mut by_channel = vec![DEAF; topology.channels().count()];
        for (place, channel) in channels.iter().enumerate() {
            by_channel[channel.index()] = place as u16;
        }
        let mut readers: Vec<Reader> =
            channels.into_iter().map(|channel| Reader::new(channel, vocabulary, topology)).collect();
        let mut symbols = u32::from(Symbol::MESSAGES);
        for reader in &mut readers {
            reader.base = symbols.min(MAX_SYMBOLS) as u16;
            symbols = symbols.saturating_add(1_u32.checked_shl(reader.mask.count_ones()).unwrap_or(MAX_SYMBOLS));
        }
        let symbols = (symbols <= MAX_SYMBOLS).then_some(symbols as u16);
        Self { by_channel, readers, symbols }
    }

    /// The letter of a message; `None` if the formula does not mention its channel.
    pub(crate) fn read(&self, channel: ChannelId, message: &Message) -> Option<Letter> {
        self.reader(channel).map(|reader| reader.read(message))
    }

    fn reader(&self, channel: ChannelId) -> Option<&Reader> {
        let place = self.by_channel.get(channel.index()).copied().filter(|place| *place != DEAF)?;
        self.readers.get(usize::from(place))
    }

    /// The symbol of a letter of this alphabet; ticks become [`Symbol::TICK`]. Only if there are symbols.
    pub(crate) fn symbol(&self, letter: Letter) -> Symbol {
        let reader = self.readers.iter().find(|reader| reader.mask == letter.channel);
        reader.map_or(Symbol::TICK, |reader| Symbol(reader.base + (letter.satisfied >> reader.shift) as u16))
    }

    /// The letter of a message's symbol.
    pub(crate) fn letter(&self, symbol: Symbol) -> Letter {
        let reader = self.readers.iter().rev().find(|reader| reader.base <= symbol.0);
        reader.map_or(Letter::TICK, |reader| Letter {
            channel: reader.mask,
            satisfied: u64::from(symbol.0 - reader.base) << reader.shift,
        })
    }

    /// The number of symbols; `None` if there are too many for tables.
    pub(crate) fn symbols(&self) -> Option<u16> {
        self.symbols
    }

    /// Every possible letter of messages within the domains, each with such a message, in a fixed order.
    pub(crate) fn letters(&self) -> impl Iterator<Item = (Letter, ChannelId, &Message)> + '_ {
        let of = |reader: &'_ Reader| reader.letters.len();
        self.readers.iter().flat_map(move |reader| {
            (0..of(reader)).map(move |at| (reader.letters[at].0, reader.channel, &reader.letters[at].1))
        })
    }

    /// Whether the samples have every possible letter: true if conditions compare only with constants.
    pub(crate) fn is_exact(&self) -> bool {
        self.readers.iter().flat_map(|reader| &reader.conditions).all(MessageCondition::is_simple)
    }

    /// The events that some message within the domains may satisfy.
    pub(crate) fn possible(&self) -> u64 {
        let known = self.letters().fold(0, |bits, (letter, ..)| bits | letter.satisfied);
        let unknown = self.readers.iter().filter(|reader| !reader.conditions.iter().all(MessageCondition::is_simple));
        unknown.fold(known, |bits, reader| bits | reader.mask)
    }

    /// A bit for each event on a channel.
    pub(crate) fn mask_of(&self, channel: ChannelId) -> u64 {
        self.reader(channel).map_or(0, |reader| reader.mask)
    }
}

impl Reader {
    fn new(channel: ChannelId, vocabulary: &Vocabulary, topology: &Topology) -> Self {
        let events: Vec<EventId> = vocabulary.ids().filter(|event| vocabulary.get(*event).channel == channel).collect();
        let conditions: Vec<MessageCondition> =
            events.iter().map(|event| vocabulary.get(*event).condition.clone()).collect();
        let mask = events.iter().fold(0, |mask, event| mask | 1 << event.0);
        let shift = events.first().map_or(0, |event| event.0);
        let mut reader = Self { channel, mask, shift, conditions, letters: Vec::new(), base: 0 };
        let mut letters = BTreeMap::new();
        for message in samples(&topology.get(channel).domain, reader.conditions.iter()) {
            letters.entry(reader.read(&message)).or_insert(message);
        }
        reader.letters = letters.into_iter().collect();
        reader
    }

    fn read(&self, message: &Message) -> Letter {
        let satisfied =
            self.conditions.iter().rev().fold(0, |bits, condition| bits << 1 | u64::from(condition.holds(message)));
        Letter { channel: self.mask, satisfied: satisfied << self.shift }
    }
}

/// At most this many sample messages are tried. Letters that only other messages have are learned when they occur.
const MAX_SAMPLES: usize = 100_000;

/// Messages of a domain such that every message of the domain satisfies the same conditions as one of them.
///
/// Each field takes one value for each class of values that the comparisons distinguish: every constant it is compared
/// with, and values between, below and above them. A domain without shapes contains all messages.
pub(crate) fn samples<'a>(domain: &Domain, conditions: impl Iterator<Item = &'a MessageCondition>) -> Vec<Message> {
    let mut constants: Vec<(usize, &Value)> = Vec::new();
    for condition in conditions {
        condition.comparisons(&mut |field, _, value| constants.push((field, value)));
    }
    let of_field = |field: usize| -> Vec<&Value> {
        constants.iter().filter(|(compared, _)| *compared == field).map(|(_, value)| *value).collect()
    };
    if domain.shapes().is_empty() {
        return untyped_samples(&constants);
    }
    let shapes = domain.shapes().iter().map(|shape| {
        let fields = shape.fields().iter().enumerate();
        let choices = fields.map(|(index, (_, kind))| field_samples(kind, &of_field(index + 1))).collect::<Vec<_>>();
        product(&choices)
    });
    shapes.flatten().collect()
}

/// Messages of any shape: every field is absent or holds one value for each class that the comparisons distinguish.
fn untyped_samples(constants: &[(usize, &Value)]) -> Vec<Message> {
    let longest = constants.iter().map(|(field, _)| *field).max().unwrap_or(0);
    let choices = |field: usize| {
        let values: Vec<&Value> =
            constants.iter().filter(|(compared, _)| *compared == field).map(|(_, value)| *value).collect();
        // `Unmentioned` represents every value of another type.
        let mut choices = vec![Value::symbol("Unmentioned")];
        choices.extend(field_samples(&FieldKind::Real, &values));
        choices.extend(values.into_iter().filter(|value| value.as_number().is_none()).cloned());
        choices
    };
    (0..=longest).flat_map(|length| product(&(1..=length).map(choices).collect::<Vec<_>>())).collect()
}

fn product(choices: &[Vec<Value>]) -> Vec<Message> {
    let mut messages: Vec<Vec<Value>> = vec![Vec::new()];
    for values in choices {
        let longer = messages
            .iter()
            .flat_map(|message| values.iter().map(|value| message.iter().chain([value]).cloned().collect::<Vec<_>>()));
        messages = longer.take(MAX_SAMPLES).collect();
    }
    messages.into_iter().map(Message::new).collect()
}

/// Values of a kind, one for each class that comparisons with the constants distinguish.
fn field_samples(kind: &FieldKind, constants: &[&Value]) -> Vec<Value> {
    let mut numbers: Vec<f64> = constants.iter().filter_map(|value| value.as_number()).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    match kind {
        FieldKind::Symbol(symbols) => {
            let (mentioned, others): (Vec<Value>, Vec<Value>) =
                symbols.iter().cloned().map(Value::Symbol).partition(|symbol| constants.contains(&symbol));
            mentioned.into_iter().chain(others.into_iter().take(1)).collect()
        }
        FieldKind::Bool if constants.is_empty() => vec![false.into()],
        FieldKind::Bool => vec![false.into(), true.into()],
        FieldKind::Real => reals(&numbers).into_iter().map(Value::Real).collect(),
        FieldKind::Int => {
            let near = |number: &f64| {
                let floor = number.floor() as i64;
                [floor.saturating_sub(1), floor, floor.saturating_add(1), floor.saturating_add(2)]
            };
            let near: BTreeSet<i64> =
                if numbers.is_empty() { BTreeSet::from([0]) } else { numbers.iter().flat_map(near).collect() };
            near.into_iter().map(Value::Int).collect()
        }
        FieldKind::Text => {
            let texts = constants.iter().filter(|value| matches!(value, Value::Text(_))).map(|value| (*value).clone());
            texts.chain([Value::from("\u{1}unmentioned")]).collect()
        }
        FieldKind::Optional(kind) => {
            let none = Value::symbol(FieldKind::NONE);
            std::iter::once(none).chain(field_samples(kind, constants)).collect()
        }
    }
}

/// The numbers, a value between each two neighbors, one below all of them and one above.
fn reals(numbers: &[f64]) -> Vec<f64> {
    let (Some(least), Some(greatest)) = (numbers.first(), numbers.last()) else { return vec![0.0] };
    let beyond = |number: f64, way: f64| number + way * (number.abs() + 1.0);
    let between = numbers.windows(2).map(|pair| pair[0] + (pair[1] - pair[0]) / 2.0);
    numbers.iter().copied().chain(between).chain([beyond(*least, -1.0), beyond(*greatest, 1.0)]).collect()
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, Relation, Shape};

    use super::*;
    use crate::formula::{EventAtom, Formula};

    fn compare(field: usize, relation: Relation, value: impl Into<Value>) -> MessageCondition {
        MessageCondition::Compare { field, relation, value: value.into() }
    }

    /// The number of different letters of the domain's messages under these conditions.
    fn letters(domain: Domain, conditions: &[MessageCondition]) -> Vec<u64> {
        let mut topology = Topology::default();
        let [a, b] = ["a", "b"].map(|name| topology.process(name).unwrap());
        let channel = topology.channel(a, b, Capacity::One, domain).unwrap();
        let event = |condition: &MessageCondition| Formula::Event(EventAtom { channel, condition: condition.clone() });
        let vocabulary = Vocabulary::of(&Formula::Or(conditions.iter().map(event).collect()));
        let alphabet = Alphabet::new(&vocabulary, &topology);
        for (letter, channel, message) in alphabet.letters() {
            assert_eq!(alphabet.read(channel, message), Some(letter));
            assert_eq!(alphabet.letter(alphabet.symbol(letter)), letter);
        }
        alphabet.letters().map(|(letter, ..)| letter.satisfied).collect()
    }

    fn of(kind: FieldKind) -> Domain {
        Domain::new([Shape::new([("field", kind)])])
    }

    #[test]
    fn numeric_conditions_are_told_apart_by_their_constants() {
        let conditions =
            [compare(1, Relation::Less, 20), compare(1, Relation::Greater, 30), compare(1, Relation::Equal, 25)];
        assert_eq!(letters(of(FieldKind::Real), &conditions), [0, 1, 2, 4]);
        assert_eq!(letters(of(FieldKind::Int), &conditions), [0, 1, 2, 4]);
        let between = [compare(1, Relation::Greater, 2), compare(1, Relation::Less, 3)];
        assert_eq!(letters(of(FieldKind::Real), &between), [1, 2, 3]);
        assert_eq!(letters(of(FieldKind::Int), &between), [1, 2]);
        let halves = [compare(1, Relation::Greater, 2.5), compare(1, Relation::Less, 3.5)];
        assert_eq!(letters(of(FieldKind::Int), &halves), [1, 2, 3]);
        let wide = [compare(1, Relation::Greater, 0.1), compare(1, Relation::Less, 5)];
        assert_eq!(letters(of(FieldKind::Real), &wide), [1, 2, 3]);
        let apart = [compare(1, Relation::Less, -5), compare(1, Relation::Greater, 30)];
        assert_eq!(letters(of(FieldKind::Real), &apart), [0, 1, 2]);
        let huge = [compare(1, Relation::Less, 1e17), compare(1, Relation::Greater, 1e17)];
        assert_eq!(letters(of(FieldKind::Real), &huge), [0, 1, 2]);
        let signs = [compare(1, Relation::Less, 0), compare(1, Relation::Greater, 0)];
        assert_eq!(letters(of(FieldKind::Real), &signs), [0, 1, 2]);
        assert_eq!(letters(of(FieldKind::Int), &signs), [0, 1, 2]);
        let tenths = [compare(1, Relation::GreaterOrEqual, -0.1), compare(1, Relation::LessOrEqual, -0.1)];
        assert_eq!(letters(of(FieldKind::Real), &tenths), [1, 2, 3]);
    }

    #[test]
    fn only_messages_of_the_domain_are_letters() {
        let symbols = [
            compare(1, Relation::Equal, channels::Symbol::new("x")),
            compare(1, Relation::Equal, channels::Symbol::new("y")),
        ];
        assert_eq!(letters(of(FieldKind::symbols(["x", "z"])), &symbols), [0, 1]);
        assert_eq!(letters(of(FieldKind::symbols(["x", "y"])), &symbols), [1, 2]);
        assert_eq!(letters(of(FieldKind::Bool), &[compare(1, Relation::Equal, true)]), [0, 1]);
        assert_eq!(letters(of(FieldKind::Bool), &[compare(2, Relation::NotEqual, true)]), [1]);
        let texts = [compare(1, Relation::Equal, "a"), compare(1, Relation::Equal, "b")];
        assert_eq!(letters(of(FieldKind::Text), &texts), [0, 1, 2]);
        // Without shapes, any message may come.
        assert_eq!(letters(Domain::new([]), &symbols), [0, 1, 2]);
        assert_eq!(letters(Domain::new([]), &[compare(2, Relation::Less, 3)]), [0, 1]);
    }

    #[test]
    fn fields_of_one_message_vary_together() {
        let ok = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
        let error = Shape::new([("status", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]);
        let conditions = [compare(1, Relation::Equal, channels::Symbol::new("ok")), compare(2, Relation::Less, 20)];
        assert_eq!(letters(Domain::new([ok, error]), &conditions), [0, 1, 3]);
    }

    #[test]
    fn a_channel_with_too_many_events_has_no_symbols() {
        let conditions: Vec<MessageCondition> = (0..11).map(|n| compare(1, Relation::Equal, n)).collect();
        let mut topology = Topology::default();
        let [a, b] = ["a", "b"].map(|name| topology.process(name).unwrap());
        let channel = topology.channel(a, b, Capacity::One, of(FieldKind::Int)).unwrap();
        let event = |condition: &MessageCondition| Formula::Event(EventAtom { channel, condition: condition.clone() });
        let vocabulary = |n: usize| Vocabulary::of(&Formula::Or(conditions[..n].iter().map(event).collect()));
        assert_eq!(Alphabet::new(&vocabulary(9), &topology).symbols(), Some(3 + 512));
        assert_eq!(Alphabet::new(&vocabulary(11), &topology).symbols(), None);
    }
}
