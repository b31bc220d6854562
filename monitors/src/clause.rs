//! The clause form of a formula: its operators, each with the parts that it checks.
//!
//! `not` is pushed to the atoms. The operand of `always` and the left of `until` become a set of clauses (each an `or`
//! of literals; all clauses must hold). The operand of `eventually` and the right of `until` become a set of products
//! (each an `and` of literals; one product must hold). A part that contains another part is subsumed and dropped.
//! Formulas that are equal by the laws of a distributive lattice and by De Morgan's laws have the same form.

use std::collections::{BTreeSet, HashSet};

use channels::{ChannelId, Relation};

use crate::formula::{EventAtom, Formula};

/// An event of a [`Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct EventId(pub(crate) u32);

/// The different events that a formula mentions; those of one channel are adjacent.
#[derive(Clone, Debug, Default)]
pub(crate) struct Vocabulary {
    events: Vec<EventAtom>,
}

impl Vocabulary {
    /// The events of a formula.
    pub(crate) fn of(formula: &Formula) -> Self {
        let (mut known, mut events) = (HashSet::new(), Vec::new());
        formula.events(&mut |event| {
            if known.insert(event) {
                events.push(event.clone());
            }
        });
        let mut channels: Vec<ChannelId> = Vec::new();
        events.iter().map(|event| event.channel).for_each(|channel| {
            if !channels.contains(&channel) {
                channels.push(channel);
            }
        });
        events.sort_by_key(|event| channels.iter().position(|channel| *channel == event.channel));
        Self { events }
    }

    /// The number of an event of the formula.
    fn id(&self, event: &EventAtom) -> EventId {
        let position = self.events.iter().position(|known| known == event);
        EventId(position.expect("a vocabulary has all events of its formula") as u32)
    }

    pub(crate) fn get(&self, event: EventId) -> &EventAtom {
        &self.events[event.0 as usize]
    }

    pub(crate) fn ids(&self) -> impl Iterator<Item = EventId> + use<> {
        (0..self.events.len() as u32).map(EventId)
    }

    pub(crate) fn len(&self) -> usize {
        self.events.len()
    }

    /// The channels of the events, each once, in the order in which the formula mentions them.
    pub(crate) fn channels(&self) -> Vec<ChannelId> {
        let mut channels: Vec<ChannelId> = self.events.iter().map(|event| event.channel).collect();
        channels.dedup();
        channels
    }
}

/// Ticks from now, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) first: u64,
    /// `u64::MAX` if there is no end.
    pub(crate) last: u64,
}

/// The bound of a `time_until`, as the formula has it: `⋈ ticks`.
///
/// A bound that no number of ticks can meet, `< 0`, is not special: the part that contains it is checked all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Bound {
    pub(crate) relation: Relation,
    pub(crate) ticks: u64,
}

impl Bound {
    /// The windows in which an event makes it true, in order: none, one, or two for `!=`.
    pub(crate) fn windows(self) -> impl DoubleEndedIterator<Item = Window> {
        let Self { relation, ticks } = self;
        let before = ticks.checked_sub(1).map(|last| Window { first: 0, last });
        let after = ticks.checked_add(1).map(|first| Window { first, last: u64::MAX });
        let windows = match relation {
            Relation::Less => [before, None],
            Relation::LessOrEqual => [Some(Window { first: 0, last: ticks }), None],
            Relation::Equal => [Some(Window { first: ticks, last: ticks }), None],
            Relation::GreaterOrEqual => [Some(Window { first: ticks, last: u64::MAX }), None],
            Relation::Greater => [None, after],
            Relation::NotEqual => [before, after],
        };
        windows.into_iter().flatten()
    }

    /// The last tick from now at which an event makes it true; `u64::MAX` if there is no end.
    pub(crate) fn end(self) -> Option<u64> {
        self.windows().next_back().map(|window| window.last)
    }
}

/// An atom or an operator, as a part of a clause or a product; the negations of both are literals too.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Literal {
    /// The event's last message satisfies it (or does not).
    Event { event: EventId, holds: bool },
    /// The event passes in time (or does not).
    Time { event: EventId, bound: Bound, holds: bool },
    /// At the next state with a message on one of its own channels, the clauses hold. `strong` requires that there is
    /// such a state.
    Next { clauses: Form, strong: bool },
    /// A product of `goal` holds at some state, and all clauses of `hold` hold whenever they are checked before it.
    Until { hold: Form, goal: Form },
    /// All clauses of `hold` hold whenever they are checked, until a product of `escape` has held.
    Release { escape: Form, hold: Form },
}

/// A set of literals: a clause, or a product.
pub(crate) type Part = BTreeSet<Literal>;

/// A set of parts: clauses, all of which must hold, or products, one of which must hold.
pub(crate) type Form = BTreeSet<Part>;

/// How the parts of a form are combined.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    Clauses,
    Products,
}

/// A formula is refused if a set in its clause form has more parts than this.
const MAX_PARTS: usize = 2_000;

/// The clause form of a formula is too large to work with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooManyParts;

/// The clauses of a formula.
pub(crate) fn clauses(formula: &Formula, vocabulary: &Vocabulary) -> Result<Form, TooManyParts> {
    form(formula, true, Shape::Clauses, vocabulary)
}

/// The form of a formula, or of its negation.
fn form(formula: &Formula, holds: bool, shape: Shape, words: &Vocabulary) -> Result<Form, TooManyParts> {
    let of = |part: &Formula, holds, shape| form(part, holds, shape, words);
    match formula {
        Formula::True => Ok(constant(holds, shape)),
        Formula::False => Ok(constant(!holds, shape)),
        Formula::Event(event) => Ok(single(Literal::Event { event: words.id(event), holds })),
        Formula::TimeUntil { event, relation, ticks } => {
            let bound = Bound { relation: *relation, ticks: *ticks };
            Ok(single(Literal::Time { event: words.id(event), bound, holds }))
        }
        Formula::Not(part) => of(part, !holds, shape),
        Formula::And(parts) => combine(parts.iter().map(|part| of(part, holds, shape)), holds, shape),
        Formula::Or(parts) => combine(parts.iter().map(|part| of(part, holds, shape)), !holds, shape),
        Formula::Implies(a, b) => combine([of(a, !holds, shape), of(b, holds, shape)].into_iter(), !holds, shape),
        Formula::Next(part) => Ok(single(Literal::Next { clauses: of(part, holds, Shape::Clauses)?, strong: holds })),
        Formula::Always(part) => Ok(single(if holds {
            Literal::Release { escape: Form::new(), hold: of(part, true, Shape::Clauses)? }
        } else {
            Literal::Until { hold: Form::new(), goal: of(part, false, Shape::Products)? }
        })),
        Formula::Eventually(part) => Ok(single(if holds {
            Literal::Until { hold: Form::new(), goal: of(part, true, Shape::Products)? }
        } else {
            Literal::Release { escape: Form::new(), hold: of(part, false, Shape::Clauses)? }
        })),
        Formula::Until(a, b) => Ok(single(if holds {
            Literal::Until { hold: of(a, true, Shape::Clauses)?, goal: of(b, true, Shape::Products)? }
        } else {
            Literal::Release { escape: of(a, false, Shape::Products)?, hold: of(b, false, Shape::Clauses)? }
        })),
    }
}

/// True is no clause, or the empty product; false is the empty clause, or no product.
fn constant(truth: bool, shape: Shape) -> Form {
    if truth == (shape == Shape::Clauses) { Form::new() } else { Form::from([Part::new()]) }
}

fn single(literal: Literal) -> Form {
    Form::from([Part::from([literal])])
}

/// The `and` of forms (or their `or`).
fn combine(
    mut forms: impl Iterator<Item = Result<Form, TooManyParts>>,
    and: bool,
    shape: Shape,
) -> Result<Form, TooManyParts> {
    let start: Vec<Part> = constant(and, shape).into_iter().collect();
    let unite = and == (shape == Shape::Clauses);
    let parts = forms.try_fold(start, |mut all, form| {
        let form = form?;
        let count = if unite { all.len() + form.len() } else { all.len() * form.len() };
        if count > MAX_PARTS {
            return Err(TooManyParts);
        }
        if unite {
            form.into_iter().for_each(|part| add(&mut all, part));
            return Ok(all);
        }
        let mut combined = Vec::new();
        for part in &all {
            form.iter().for_each(|other| add(&mut combined, part.union(other).cloned().collect()));
        }
        Ok(combined)
    })?;
    Ok(parts.into_iter().collect())
}

/// Adds a part and keeps the set free of parts that contain another.
fn add(parts: &mut Vec<Part>, part: Part) {
    if parts.iter().any(|smaller| smaller.is_subset(&part)) {
        return;
    }
    parts.retain(|larger| !part.is_subset(larger));
    parts.push(part);
}

/// The channels of a part's own atoms: the part is checked at each message on one of them. If there are none, it is
/// checked at every tick.
pub(crate) fn own_channels(part: &Part, vocabulary: &Vocabulary) -> BTreeSet<ChannelId> {
    let own = part.iter().filter_map(|literal| match literal {
        Literal::Event { event, .. } => Some(vocabulary.get(*event).channel),
        _ => None,
    });
    own.collect()
}

/// The channels of the own atoms of all parts together: they determine when the operand of a `next` is checked.
pub(crate) fn own_channels_of_all(form: &Form, vocabulary: &Vocabulary) -> BTreeSet<ChannelId> {
    form.iter().flat_map(|part| own_channels(part, vocabulary)).collect()
}

/// The bounds of all `time_until`s of a form that wait for the event.
pub(crate) fn bounds(form: &Form, of: EventId) -> BTreeSet<Bound> {
    let mut bounds = BTreeSet::new();
    for literal in form.iter().flatten() {
        match literal {
            Literal::Event { .. } => {}
            Literal::Time { event, bound, .. } => bounds.extend(Some(*bound).filter(|_| *event == of)),
            Literal::Next { clauses, .. } => bounds.extend(self::bounds(clauses, of)),
            Literal::Until { hold: one, goal: other } | Literal::Release { escape: one, hold: other } => {
                bounds.extend(self::bounds(one, of));
                bounds.extend(self::bounds(other, of));
            }
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::MessageCondition;

    fn event(channel: usize, field: usize) -> Formula {
        let mut topology = channels::Topology::default();
        let ends: Vec<_> = (0..5).map(|n| topology.process(&n.to_string()).unwrap()).collect();
        for pair in ends.windows(2) {
            topology.channel(pair[0], pair[1], channels::Capacity::One, channels::Domain::new([])).unwrap();
        }
        let channel = topology.channels().nth(channel).unwrap();
        let condition = MessageCondition::Compare { field, relation: Relation::Equal, value: true.into() };
        Formula::Event(EventAtom { channel, condition })
    }

    #[test]
    fn a_clause_form_drops_subsumed_parts() {
        let [a, b, c] = [event(0, 1), event(1, 1), event(2, 1)];
        let formula = Formula::And(vec![
            Formula::Or(vec![a.clone(), b.clone()]),
            a.clone(),
            Formula::Or(vec![b.clone(), Formula::And(vec![b, c.clone()])]),
            Formula::Or(vec![a, c]),
        ]);
        let words = Vocabulary::of(&formula);
        let parts: Vec<usize> = clauses(&formula, &words).unwrap().iter().map(Part::len).collect();
        assert_eq!(parts, [1, 1]);
    }

    #[test]
    fn windows_match_their_relations() {
        let of = |relation, ticks| -> Vec<(u64, u64)> {
            Bound { relation, ticks }.windows().map(|window| (window.first, window.last)).collect()
        };
        let windows = |relation| of(relation, 3);
        assert_eq!(windows(Relation::Less), [(0, 2)]);
        assert_eq!(windows(Relation::LessOrEqual), [(0, 3)]);
        assert_eq!(windows(Relation::Equal), [(3, 3)]);
        assert_eq!(windows(Relation::NotEqual), [(0, 2), (4, u64::MAX)]);
        assert_eq!(windows(Relation::GreaterOrEqual), [(3, u64::MAX)]);
        assert_eq!(windows(Relation::Greater), [(4, u64::MAX)]);
        assert!(of(Relation::Less, 0).is_empty() && of(Relation::Greater, u64::MAX).is_empty());
    }

    #[test]
    fn events_of_one_channel_are_adjacent() {
        let formula = Formula::Or(vec![event(2, 1), event(0, 1), event(2, 2), event(0, 2), event(2, 1)]);
        let words = Vocabulary::of(&formula);
        let channels: Vec<usize> = words.ids().map(|id| words.get(id).channel.index()).collect();
        assert_eq!(channels, [2, 2, 0, 0]);
        assert_eq!((words.len(), words.channels().len()), (4, 2));
    }

    #[test]
    fn a_form_that_grows_without_bound_is_refused() {
        let pair = |n| Formula::And(vec![event(0, n), event(1, n)]);
        let grown = |n| Formula::Or((1..=n).map(pair).collect());
        assert_eq!(clauses(&grown(8), &Vocabulary::of(&grown(8))).unwrap().len(), 256);
        assert_eq!(clauses(&grown(11), &Vocabulary::of(&grown(11))), Err(TooManyParts));
        // 2 · 2 · 2 · 2 · 5 · 5 · 5 clauses are the maximum.
        let all = |(first, last)| Formula::And((first..=last).map(|field| event(0, field)).collect());
        let largest = [(1, 2), (3, 4), (5, 6), (7, 8), (9, 13), (14, 18), (19, 23)];
        let largest = Formula::Or(largest.into_iter().map(all).collect());
        assert_eq!(clauses(&largest, &Vocabulary::of(&largest)).unwrap().len(), MAX_PARTS);
    }
}
