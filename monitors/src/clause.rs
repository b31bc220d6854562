//! The clause form of a formula: its operators, each with the parts that it checks.
//!
//! `not` is pushed to the atoms. The operand of `always` and the left of `until` become a set of clauses (each an `or`
//! of literals; all clauses must hold). The operand of `eventually` and the right of `until` become a set of products
//! (each an `and` of literals; one product must hold). A part that contains another part is subsumed and dropped.
//! Formulas that are equal by the laws of a distributive lattice and by De Morgan's laws have the same form.

use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

use channels::{ChannelId, Event, EventKind, Relation};

use crate::data::Remembered;
use crate::formula::{Bound, EventAtom, Formula, FormulaError};

/// An event of a [`Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct EventId(pub(crate) u32);

/// The different events that a formula mentions; those of one channel are adjacent.
#[derive(Clone, Debug, Default)]
pub(crate) struct Vocabulary {
    events: Vec<EventAtom>,
    /// Whether τ is time, in nanoseconds.
    pub(crate) is_timed: bool,
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
        Self { events, is_timed: matches!(formula, Formula::Timed(_)) }
    }

    /// Whether values are remembered.
    pub(crate) fn has_data(&self) -> bool {
        self.events.iter().any(|event| !remembered_by(event).is_empty())
    }

    /// These events, followed by the formula's others.
    pub(crate) fn with_all_of(&self, formula: &Formula) -> Self {
        let mut all = self.clone();
        formula.events(&mut |event| {
            if !all.events.contains(event) {
                all.events.push(event.clone());
            }
        });
        all
    }

    /// The names that an event compares with.
    pub(crate) fn names(&self, event: EventId) -> Vec<Arc<str>> {
        let mut names = Vec::new();
        self.get(event).condition.names(&mut |name| names.push(Arc::clone(name)));
        names
    }

    /// What the events of a part remember when it is checked.
    pub(crate) fn remembered(&self, part: &LiteralSet) -> Vec<Remembered> {
        let events = part.iter().filter_map(|literal| match literal {
            Literal::Event { event, .. } | Literal::Fresh { event, .. } => Some(self.get(*event)),
            _ => None,
        });
        let mut remembered: Vec<Remembered> = events.flat_map(remembered_by).collect();
        remembered.sort_by(|(a, p, x), (b, q, y)| (a, p, x.number).cmp(&(b, q, y.number)));
        remembered.dedup();
        remembered
    }

    /// The names that a literal compares with and that are remembered outside it.
    pub(crate) fn free(&self, literal: &Literal) -> Vec<Arc<str>> {
        let mut free = match literal {
            Literal::Event { event, .. }
            | Literal::Fresh { event, .. }
            | Literal::Time { event, .. }
            | Literal::Count { event, .. } => self.names(*event),
            operator => operator.forms().into_iter().flatten().flat_map(|part| self.free_of(part)).collect(),
        };
        free.sort();
        free.dedup();
        free
    }

    /// The names that a part compares with and that are remembered outside it.
    fn free_of(&self, part: &LiteralSet) -> Vec<Arc<str>> {
        let own = self.remembered(part);
        let is_own = |name: &Arc<str>| own.iter().any(|(known, ..)| known == name);
        part.iter().flat_map(|literal| self.free(literal)).filter(|name| !is_own(name)).collect()
    }

    /// Whether bits are not enough for a literal about the past, because it compares or remembers values.
    pub(crate) fn looks_back_at_values(&self, literal: &Literal) -> bool {
        match literal {
            Literal::Event { event, .. } | Literal::Fresh { event, .. } | Literal::Count { event, .. } => {
                !self.names(*event).is_empty() || !remembered_by(self.get(*event)).is_empty()
            }
            operator => {
                operator.forms().into_iter().flatten().flatten().any(|inside| self.looks_back_at_values(inside))
            }
        }
    }

    /// Checks that every name is remembered where it is used, and that the past needs no unbounded memory.
    fn check(&self, form: &Form, known: &[Arc<str>], in_past: bool) -> Result<(), FormulaError> {
        for part in form {
            let own = self.remembered(part);
            // Negation divides parts: which of two values a name has must not depend on it.
            let again = own.windows(2).find(|pair| pair[0].0 == pair[1].0).map(|pair| &pair[0]);
            if let Some((name, ..)) = again.or_else(|| own.iter().find(|(name, ..)| known.contains(name))) {
                return Err(FormulaError::RememberedTwice(Arc::clone(name)));
            }
            let known: Vec<Arc<str>> = known.iter().cloned().chain(own.into_iter().map(|(name, ..)| name)).collect();
            for literal in part {
                if let Some(name) = self.free(literal).into_iter().find(|name| !known.contains(name)) {
                    return Err(FormulaError::NotRemembered(name));
                }
                let is_past = literal.past().is_some() && self.looks_back_at_values(literal);
                let endless = match literal {
                    Literal::Since { bound, .. } => bound.end() == Some(u64::MAX),
                    Literal::Previous { bound, .. } => in_past && bound.end() == Some(u64::MAX),
                    _ => false,
                };
                if is_past && endless {
                    return Err(FormulaError::Endless);
                }
                for inside in literal.forms() {
                    self.check(inside, &known, in_past || is_past)?;
                }
            }
        }
        Ok(())
    }

    /// τ of an event.
    pub(crate) fn tau(&self, event: &Event) -> u64 {
        if self.is_timed { u64::try_from(event.time.as_nanos()).unwrap_or(u64::MAX) } else { event.tick }
    }

    /// The number of one of the formula's events.
    fn id(&self, event: &EventAtom) -> EventId {
        let position = self.events.iter().position(|known| known == event);
        EventId(position.expect("a vocabulary contains all events of its formula") as u32)
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

fn remembered_by(event: &EventAtom) -> Vec<Remembered> {
    let mut remembered = Vec::new();
    event.condition.remembers(&mut |name, field| remembered.push((Arc::clone(name), event.channel, field.clone())));
    remembered
}

/// Ticks from now, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) first: u64,
    /// `u64::MAX` if there is no end.
    pub(crate) last: u64,
}

impl Bound {
    /// The windows in which an event satisfies the bound, in order: none, one, or two for `!=`.
    pub(crate) fn windows(self) -> impl DoubleEndedIterator<Item = Window> {
        let Self { relation, ticks, .. } = self;
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

    /// The last tick, counted from now, at which an event satisfies the bound; `u64::MAX` if there is no end.
    pub(crate) fn end(self) -> Option<u64> {
        self.windows().next_back().map(|window| window.last)
    }
}

/// An atom or an operator, as a part of a clause or a product; the negations of both are literals too.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Literal {
    /// The event's last message satisfies it (or does not).
    Event { event: EventId, holds: bool },
    /// The message of this state satisfies the event (or there is none, or it does not).
    Fresh { event: EventId, holds: bool },
    /// The event occurs within the bound (or does not).
    Time { event: EventId, bound: Bound, holds: bool },
    /// At the next state with a message on one of its own channels, the clauses hold. `strong` requires that there is
    /// such a state.
    Next { clauses: Form, strong: bool },
    /// A product of `goal` holds at some state, and all clauses of `hold` hold whenever they are checked before it.
    Until { hold: Form, goal: Form },
    /// All clauses of `hold` hold whenever they are checked, until a product of `escape` has held.
    Release { escape: Form, hold: Form },
    /// A product of `goal` held at some earlier state within the bound, and all clauses of `hold` held whenever they
    /// were checked after it (or not).
    Since { hold: Form, goal: Form, bound: Bound, holds: bool },
    /// The last earlier state with a message on one of the clauses' own channels lies within the bound, and the clauses
    /// held there (or not).
    Previous { clauses: Form, bound: Bound, holds: bool },
    /// At least `count` messages that satisfy the event have passed within the bound (or not).
    Count { event: EventId, count: u64, bound: Bound, holds: bool },
}

impl Literal {
    /// The forms that make up an operator.
    pub(crate) fn forms(&self) -> Vec<&Form> {
        match self {
            Self::Event { .. } | Self::Fresh { .. } | Self::Time { .. } | Self::Count { .. } => Vec::new(),
            Self::Next { clauses, .. } | Self::Previous { clauses, .. } => vec![clauses],
            Self::Until { hold: one, goal: other }
            | Self::Release { escape: one, hold: other }
            | Self::Since { hold: one, goal: other, .. } => vec![one, other],
        }
    }

    /// A literal about what has been without its negation, and whether it must hold; `None` for other literals.
    /// Whether a message is fresh depends on more than the last messages, as the past does.
    pub(crate) fn past(&self) -> Option<(Self, bool)> {
        let mut positive = self.clone();
        match &mut positive {
            Self::Since { holds, .. }
            | Self::Previous { holds, .. }
            | Self::Count { holds, .. }
            | Self::Fresh { holds, .. } => {
                let held = std::mem::replace(holds, true);
                Some((positive, held))
            }
            _ => None,
        }
    }
}

/// A set of literals: a clause, or a product.
pub(crate) type LiteralSet = BTreeSet<Literal>;

/// A set of parts: clauses, all of which must hold, or products, one of which must hold.
pub(crate) type Form = BTreeSet<LiteralSet>;

/// How the parts of a form are combined.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    Clauses,
    Products,
}

/// A formula is refused if a set in its clause form has more parts than this: the form of n alternatives with two parts
/// each has 2ⁿ clauses. Chosen, not measured.
const MAX_PARTS: usize = 2_000;

/// The clauses of a formula, and the events in them. An event that the clauses no longer contain, such as E in `E
/// implies true`, is not one of the formula's: formulas that are equal by the laws of the clause form see the same
/// states.
pub(crate) fn normal_form(formula: &Formula) -> Result<(Form, Vocabulary), FormulaError> {
    let mut words = Vocabulary::of(formula);
    let mut form = clauses(formula, &words)?;
    let mut used = BTreeSet::new();
    events(&form, &mut used);
    if used.len() < words.len() {
        let (mut kept, dropped): (Vec<_>, Vec<_>) = words.ids().partition(|event| used.contains(event));
        kept.extend(dropped);
        words.events = kept.into_iter().map(|event| words.get(event).clone()).collect();
        form = clauses(formula, &words)?;
        words.events.truncate(used.len());
    }
    Ok((form, words))
}

pub(crate) fn events(form: &Form, all: &mut BTreeSet<EventId>) {
    for literal in form.iter().flatten() {
        match literal {
            Literal::Event { event, .. }
            | Literal::Fresh { event, .. }
            | Literal::Time { event, .. }
            | Literal::Count { event, .. } => {
                all.insert(*event);
            }
            operator => operator.forms().into_iter().for_each(|form| events(form, all)),
        }
    }
}

pub(crate) fn clauses(formula: &Formula, vocabulary: &Vocabulary) -> Result<Form, FormulaError> {
    if formula.looks_ahead_of_the_past() {
        return Err(FormulaError::LooksAhead);
    }
    let form = form(formula, true, Shape::Clauses, vocabulary)?;
    vocabulary.check(&form, &[], false)?;
    Ok(form)
}

/// The products of a formula: it holds if all literals of one of them do.
pub(crate) fn products(formula: &Formula, vocabulary: &Vocabulary) -> Result<Form, FormulaError> {
    form(formula, true, Shape::Products, vocabulary)
}

fn form(formula: &Formula, holds: bool, shape: Shape, words: &Vocabulary) -> Result<Form, FormulaError> {
    let of = |part: &Formula, holds, shape| form(part, holds, shape, words);
    match formula {
        Formula::True => Ok(constant(holds, shape)),
        Formula::False => Ok(constant(!holds, shape)),
        Formula::Event(event) => Ok(single(Literal::Event { event: words.id(event), holds })),
        Formula::Fresh(event) => Ok(single(Literal::Fresh { event: words.id(event), holds })),
        Formula::TimeUntil { event, bound } => {
            Ok(single(Literal::Time { event: words.id(event), bound: *bound, holds }))
        }
        Formula::Timed(part) => of(part, holds, shape),
        Formula::Not(part) => of(part, !holds, shape),
        Formula::And(parts) => combine(parts.iter().map(|part| of(part, holds, shape)), holds, shape),
        Formula::Or(parts) => combine(parts.iter().map(|part| of(part, holds, shape)), !holds, shape),
        Formula::Implies(a, b) => combine([of(a, !holds, shape), of(b, holds, shape)].into_iter(), !holds, shape),
        Formula::Next(part) => Ok(single(Literal::Next { clauses: of(part, holds, Shape::Clauses)?, strong: holds })),
        // □ and ◇, `until` and release, and their operands' forms are dual: a negation exchanges them.
        Formula::Always(part) if holds => Ok(release(Form::new(), of(part, true, Shape::Clauses)?)),
        Formula::Always(part) => Ok(until(Form::new(), of(part, false, Shape::Products)?)),
        Formula::Eventually(part) if holds => Ok(until(Form::new(), of(part, true, Shape::Products)?)),
        Formula::Eventually(part) => Ok(release(Form::new(), of(part, false, Shape::Clauses)?)),
        Formula::Until(a, b) if holds => Ok(until(of(a, true, Shape::Clauses)?, of(b, true, Shape::Products)?)),
        Formula::Until(a, b) => Ok(release(of(a, false, Shape::Products)?, of(b, false, Shape::Clauses)?)),
        // What looks back keeps its operands, since it only depends on what has been: its value is negated.
        Formula::Once(bound, part) => Ok(since(Form::new(), of(part, true, Shape::Products)?, *bound, holds)),
        Formula::Historically(bound, part) => Ok(since(Form::new(), of(part, false, Shape::Products)?, *bound, !holds)),
        Formula::Since(bound, a, b) => {
            Ok(since(of(a, true, Shape::Clauses)?, of(b, true, Shape::Products)?, *bound, holds))
        }
        Formula::Previous(bound, part) => Ok(previous(of(part, true, Shape::Clauses)?, *bound, holds)),
        Formula::Count { is_at_most: false, count: 0, .. } => Ok(constant(holds, shape)),
        Formula::Count { event, is_at_most, count, bound } => {
            // "At most n" is "not at least n + 1".
            let count = count.saturating_add(u64::from(*is_at_most));
            let event = words.id(event);
            Ok(single(Literal::Count { event, count, bound: *bound, holds: holds != *is_at_most }))
        }
    }
}

fn until(hold: Form, goal: Form) -> Form {
    single(Literal::Until { hold, goal })
}

fn release(escape: Form, hold: Form) -> Form {
    single(Literal::Release { escape, hold })
}

fn since(hold: Form, goal: Form, bound: Bound, holds: bool) -> Form {
    single(Literal::Since { hold, goal, bound, holds })
}

fn previous(clauses: Form, bound: Bound, holds: bool) -> Form {
    single(Literal::Previous { clauses, bound, holds })
}

/// True has no clauses, or an empty product; false has an empty clause, or no products.
fn constant(truth: bool, shape: Shape) -> Form {
    if truth == (shape == Shape::Clauses) { Form::new() } else { Form::from([LiteralSet::new()]) }
}

fn single(literal: Literal) -> Form {
    Form::from([LiteralSet::from([literal])])
}

/// The `and` of forms (or their `or`).
fn combine(
    mut forms: impl Iterator<Item = Result<Form, FormulaError>>,
    and: bool,
    shape: Shape,
) -> Result<Form, FormulaError> {
    let start: Vec<LiteralSet> = constant(and, shape).into_iter().collect();
    let unite = and == (shape == Shape::Clauses);
    // Clauses joined by `and` are all of them; joined by `or`, they are multiplied out, by the distributive law. Parts
    // that another one subsumes are dropped at once, since products of what remains would only be subsumed again.
    let parts = forms.try_fold(start, |mut all, form| {
        let form = form?;
        let count = if unite { all.len() + form.len() } else { all.len() * form.len() };
        if count > MAX_PARTS {
            return Err(FormulaError::TooLarge);
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
fn add(parts: &mut Vec<LiteralSet>, part: LiteralSet) {
    if parts.iter().any(|smaller| smaller.is_subset(&part)) {
        return;
    }
    parts.retain(|larger| !part.is_subset(larger));
    parts.push(part);
}

/// When something is checked.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub(crate) struct Trigger {
    /// At messages on these channels.
    pub(crate) channels: BTreeSet<ChannelId>,
    /// Also at ticks.
    pub(crate) ticks: bool,
}

impl Trigger {
    /// When parts are checked together: at messages on the channels of their own atoms. If they have none, at every
    /// tick, and at messages on the channels of their literals about the past.
    pub(crate) fn of<'a>(parts: impl Iterator<Item = &'a LiteralSet> + Clone, words: &Vocabulary) -> Self {
        let own = parts.clone().flatten().filter_map(|literal| match literal {
            Literal::Event { event, .. } | Literal::Fresh { event, .. } => Some(words.get(*event).channel),
            _ => None,
        });
        let own: BTreeSet<ChannelId> = own.collect();
        if !own.is_empty() {
            return Self { channels: own, ticks: false };
        }
        let mut channels = BTreeSet::new();
        let past = parts.flatten().filter(|literal| literal.past().is_some());
        past.for_each(|literal| all_channels(literal, words, &mut channels));
        Self { channels, ticks: true }
    }

    pub(crate) fn fires(&self, kind: &EventKind) -> bool {
        match kind {
            EventKind::Tick => self.ticks,
            EventKind::Received { channel, .. } => self.channels.contains(channel),
        }
    }
}

/// When a part is checked.
pub(crate) fn trigger(part: &LiteralSet, words: &Vocabulary) -> Trigger {
    Trigger::of(std::iter::once(part), words)
}

/// Whether a part is only about the present and the past.
pub(crate) fn is_of_the_present(part: &LiteralSet) -> bool {
    part.iter().all(|literal| matches!(literal, Literal::Event { .. }) || literal.past().is_some())
}

/// The clauses that must always hold, each once, if that is all that the formula demands.
pub(crate) fn always(form: &Form) -> Option<Vec<&LiteralSet>> {
    let (mut clauses, mut known) = (Vec::new(), BTreeSet::new());
    for clause in form {
        let mut literals = clause.iter();
        match (literals.next(), literals.next()) {
            (Some(Literal::Release { escape, hold }), None) if escape.is_empty() => {
                clauses.extend(hold.iter().filter(|clause| known.insert(*clause)));
            }
            _ => return None,
        }
    }
    Some(clauses)
}

/// Whether a violation of the formula is noticed as soon as nothing can avert it. It is if the formula is `always` of
/// clauses about the present and the past, either a single one or several without deadlines: then silence, or
/// everything that the clause waits for, still satisfies it.
pub(crate) fn is_prompt(form: &Form) -> bool {
    let Some(rules) = always(form) else { return false };
    let is_time = |literal: &Literal| matches!(literal, Literal::Time { .. });
    let is_present =
        |literal: &Literal| is_time(literal) || matches!(literal, Literal::Event { .. }) || literal.past().is_some();
    let is_timed = rules.iter().copied().flatten().any(is_time);
    rules.iter().copied().flatten().all(is_present) && (rules.len() <= 1 || !is_timed)
}

fn all_channels(literal: &Literal, words: &Vocabulary, channels: &mut BTreeSet<ChannelId>) {
    match literal {
        Literal::Event { event, .. }
        | Literal::Fresh { event, .. }
        | Literal::Time { event, .. }
        | Literal::Count { event, .. } => {
            channels.insert(words.get(*event).channel);
        }
        _ => literal.forms().into_iter().flatten().flatten().for_each(|inside| all_channels(inside, words, channels)),
    }
}

/// The bounds of all `time_until`s of a form that wait for the event.
pub(crate) fn bounds(form: &Form, of: EventId) -> BTreeSet<Bound> {
    let mut bounds = BTreeSet::new();
    for literal in form.iter().flatten() {
        match literal {
            Literal::Time { event, bound, .. } => bounds.extend(Some(*bound).filter(|_| *event == of)),
            operator => operator.forms().into_iter().for_each(|form| bounds.extend(self::bounds(form, of))),
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
        let condition =
            MessageCondition::Compare { field: field.into(), relation: Relation::Equal, value: true.into() };
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
        let parts: Vec<usize> = clauses(&formula, &words).unwrap().iter().map(LiteralSet::len).collect();
        assert_eq!(parts, [1, 1]);
    }

    #[test]
    fn windows_match_their_relations() {
        let of = |relation, ticks| -> Vec<(u64, u64)> {
            Bound::new(relation, ticks).windows().map(|window| (window.first, window.last)).collect()
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
        assert_eq!(clauses(&grown(11), &Vocabulary::of(&grown(11))), Err(FormulaError::TooLarge));
        // 2 · 2 · 2 · 2 · 5 · 5 · 5 clauses are the maximum.
        let all = |(first, last)| Formula::And((first..=last).map(|field| event(0, field)).collect());
        let largest = [(1, 2), (3, 4), (5, 6), (7, 8), (9, 13), (14, 18), (19, 23)];
        let largest = Formula::Or(largest.into_iter().map(all).collect());
        assert_eq!(clauses(&largest, &Vocabulary::of(&largest)).unwrap().len(), MAX_PARTS);
    }
}
