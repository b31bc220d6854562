//! Letters: what a formula can distinguish in a message.

use std::collections::{BTreeMap, BTreeSet};

use channels::{ChannelId, Message, Topology};

use crate::clause::{EventId, Vocabulary};
use crate::engine::combinations::combinations;
use crate::engine::limits::Limits;
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

/// A formula has at most this many different events: a letter has a bit for each.
pub(crate) const MAX_EVENTS: usize = 64;

/// A letter as a column of a table: a tick, the passing of time, or a message on a channel with the events that it
/// satisfies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Symbol(pub(crate) u16);

impl Symbol {
    /// A tick is generated and τ is unchanged: the first tick of a run.
    pub(crate) const TICK: Self = Self(0);
    /// τ grows by one, before the tick's state.
    pub(crate) const ADVANCE: Self = Self(1);
    /// τ grows by one, and this tick is generated.
    pub(crate) const NEXT_TICK: Self = Self(2);
    /// The first symbol of a message.
    pub(crate) const MESSAGES: u16 = 3;
}

/// The letters of a formula, and the mapping of messages to letters.
#[derive(Clone, Debug)]
pub(crate) struct Alphabet {
    /// For each channel of the topology, by index, its index in `readers`; `DEAF` if the formula does not mention it.
    by_channel: Vec<u16>,
    readers: Vec<ChannelAlphabet>,
    /// For each event, the first symbol of its channel.
    bases: Vec<u16>,
    /// The number of symbols; `None` if there are too many for tables.
    pub(crate) symbols: Option<u16>,
    pub(crate) limits: Limits,
}

/// Reads the messages of one channel.
#[derive(Clone, Debug)]
struct ChannelAlphabet {
    channel: ChannelId,
    mask: u64,
    /// The position of the channel's events among all events.
    shift: u32,
    conditions: Vec<MessageCondition>,
    /// The possible letters of messages in the channel's domain, each with such a message; `None` if there are too many
    /// to find them.
    letters: Option<Vec<(Letter, Message)>>,
    /// The symbol of a message that satisfies nothing.
    base: u16,
}

const DEAF: u16 = u16::MAX;

impl Alphabet {
    /// The alphabet of a vocabulary of at most [`MAX_EVENTS`] events.
    pub(crate) fn new(vocabulary: &Vocabulary, topology: &Topology, limits: Limits) -> Self {
        let channels = vocabulary.channels();
        let mut by_channel = vec![DEAF; topology.channels().count()];
        for (place, channel) in channels.iter().enumerate() {
            by_channel[channel.index()] = place as u16;
        }
        let mut readers: Vec<ChannelAlphabet> =
            channels.into_iter().map(|channel| ChannelAlphabet::new(channel, vocabulary, topology, limits)).collect();
        let most = limits.symbols.min(usize::from(u16::MAX));
        let mut symbols = usize::from(Symbol::MESSAGES);
        let mut bases = Vec::with_capacity(vocabulary.len());
        for reader in &mut readers {
            reader.base = symbols.min(most) as u16;
            bases.extend(reader.conditions.iter().map(|_| reader.base));
            symbols = symbols.saturating_add(1_usize.checked_shl(reader.mask.count_ones()).unwrap_or(most));
        }
        let symbols = (symbols <= most).then_some(symbols as u16);
        Self { by_channel, readers, bases, symbols, limits }
    }

    /// The letter of a message; `None` if the formula does not mention its channel.
    pub(crate) fn read(&self, channel: ChannelId, message: &Message) -> Option<Letter> {
        self.reader(channel).map(|reader| reader.read(message))
    }

    fn reader(&self, channel: ChannelId) -> Option<&ChannelAlphabet> {
        let place = self.by_channel.get(channel.index()).copied().filter(|place| *place != DEAF)?;
        self.readers.get(usize::from(place))
    }

    /// The symbol of a letter of this alphabet; ticks become [`Symbol::TICK`]. Only if there are symbols.
    pub(crate) fn symbol(&self, letter: Letter) -> Symbol {
        // A tick has no event.
        let first = letter.channel.trailing_zeros();
        let base = self.bases.get(first as usize);
        base.map_or(Symbol::TICK, |base| Symbol(base + (letter.satisfied >> first) as u16))
    }

    /// The letter of a message's symbol.
    pub(crate) fn letter(&self, symbol: Symbol) -> Letter {
        let reader = self.readers.iter().rev().find(|reader| reader.base <= symbol.0);
        reader.map_or(Letter::TICK, |reader| Letter {
            channel: reader.mask,
            satisfied: u64::from(symbol.0 - reader.base) << reader.shift,
        })
    }

    /// The letters of messages within the domains that were found, each with such a message, in a fixed order: all
    /// that there are if the alphabet [is exact](Self::is_exact).
    pub(crate) fn letters(&self) -> impl Iterator<Item = (Letter, ChannelId, &Message)> + '_ {
        self.readers.iter().flat_map(|reader| {
            reader.letters.iter().flatten().map(|(letter, message)| (*letter, reader.channel, message))
        })
    }

    /// Whether every possible letter is known: conditions compare with constants only, and their combinations could be
    /// found.
    pub(crate) fn is_exact(&self) -> bool {
        self.readers.iter().all(ChannelAlphabet::is_exact)
    }

    /// Whether every possible letter is known here and there, and they are the same.
    pub(crate) fn foresees_as(&self, other: &Self) -> bool {
        let all = |alphabet: &Self| alphabet.letters().map(|(letter, ..)| letter).collect::<BTreeSet<_>>();
        self.is_exact() && other.is_exact() && all(self) == all(other)
    }

    /// Whether a channel has too many combinations of conditions to find all its letters.
    pub(crate) fn is_cut_off(&self) -> bool {
        self.readers.iter().any(|reader| reader.letters.is_none())
    }

    /// The events that some message within the domains may satisfy.
    pub(crate) fn possible(&self) -> u64 {
        let known = self.letters().fold(0, |bits, (letter, ..)| bits | letter.satisfied);
        self.readers.iter().filter(|reader| !reader.is_exact()).fold(known, |bits, reader| bits | reader.mask)
    }

    /// A bit for each event on a channel.
    pub(crate) fn mask_of(&self, channel: ChannelId) -> u64 {
        self.reader(channel).map_or(0, |reader| reader.mask)
    }
}

impl ChannelAlphabet {
    fn new(channel: ChannelId, vocabulary: &Vocabulary, topology: &Topology, limits: Limits) -> Self {
        let events: Vec<EventId> = vocabulary.ids().filter(|event| vocabulary.get(*event).channel == channel).collect();
        let conditions: Vec<MessageCondition> =
            events.iter().map(|event| vocabulary.get(*event).condition.clone()).collect();
        let mask = events.iter().fold(0, |mask, event| mask | 1 << event.0);
        let shift = events.first().map_or(0, |event| event.0);
        let mut reader = Self { channel, mask, shift, conditions, letters: None, base: 0 };
        let messages = combinations(&topology.get(channel).domain, &reader.conditions, limits.combinations);
        reader.letters = messages.map(|messages| {
            let mut letters = BTreeMap::new();
            messages.into_iter().for_each(|message| {
                letters.entry(reader.read(&message)).or_insert(message);
            });
            letters.into_iter().collect()
        });
        reader
    }

    fn is_exact(&self) -> bool {
        self.letters.is_some() && self.conditions.iter().all(MessageCondition::is_simple)
    }

    fn read(&self, message: &Message) -> Letter {
        let satisfied =
            self.conditions.iter().rev().fold(0, |bits, condition| bits << 1 | u64::from(condition.holds(message)));
        Letter { channel: self.mask, satisfied: satisfied << self.shift }
    }
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, FieldKind, Relation, Shape, Value};

    use super::*;
    use crate::formula::{EventAtom, Formula};

    fn compare(field: usize, relation: Relation, value: impl Into<Value>) -> MessageCondition {
        MessageCondition::Compare { field: field.into(), relation, value: value.into() }
    }

    /// The number of different letters of the domain's messages under these conditions.
    fn letters(domain: Domain, conditions: &[MessageCondition]) -> Vec<u64> {
        let mut topology = Topology::default();
        let [a, b] = ["a", "b"].map(|name| topology.process(name).unwrap());
        let channel = topology.channel(a, b, Capacity::One, domain).unwrap();
        let event = |condition: &MessageCondition| Formula::Event(EventAtom { channel, condition: condition.clone() });
        let vocabulary = Vocabulary::of(&Formula::Or(conditions.iter().map(event).collect()));
        let alphabet = Alphabet::new(&vocabulary, &topology, Limits::default());
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
        assert_eq!(Alphabet::new(&vocabulary(9), &topology, Limits::default()).symbols, Some(3 + 512));
        assert_eq!(Alphabet::new(&vocabulary(11), &topology, Limits::default()).symbols, None);
    }
}
