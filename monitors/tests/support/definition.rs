//! The meaning of formulas, written a second time from the documentation of the crate. It shares no code with the
//! monitors or their oracle, only the types of formulas and messages: neither clause form, nor states, nor comparisons.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Message, Relation, Shape, Topology};
use monitors::{Bound, EventAtom, EventTime, Formula, MessageCondition, MessageField, Violation};

use super::exact::{Named, Names, satisfies};

/// A formula as clauses.
pub(crate) struct Definition {
    clauses: Parts,
    words: Words,
}

/// The events of a formula, each once.
#[derive(Default)]
struct Words {
    events: Vec<EventAtom>,
    /// Whether an event gives a name to a value.
    names: Vec<BTreeMap<Arc<str>, MessageField>>,
    /// The shapes of the messages on each channel.
    shapes: BTreeMap<ChannelId, Vec<Shape>>,
    is_timed: bool,
    /// The bounds of deadlines that are themselves in time, `<= D` and `= D`.
    lasts: Vec<Bound>,
}

/// An atom or an operator without its negation.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Atom {
    Event(usize),
    Fresh(usize),
    Passes(usize, Bound),
    AtLeast(u64, usize, u64),
    /// The clauses of its operand, and those of its operand's negation.
    Next(Parts, Parts),
    Until(Parts, Parts),
    Since(Parts, Parts, Bound),
    Previous(Parts, Bound),
}

/// An atom, and whether it holds.
type Literal = (Atom, bool);
type Part = BTreeSet<Literal>;
type Parts = BTreeSet<Part>;

impl Definition {
    pub(crate) fn new(formula: &Formula, topology: &Topology) -> Self {
        let mut words = Words { is_timed: matches!(formula, Formula::Timed(_)), ..Words::default() };
        words.shapes =
            topology.channels().map(|channel| (channel, topology.get(channel).domain.shapes().to_vec())).collect();
        let clauses = words.clauses(formula, true);
        collect_lasts(formula, &mut words.lasts);
        Self { clauses, words }
    }

    /// Whether the formula holds on a finished sequence.
    pub(crate) fn holds(&self, sequence: &[Event]) -> bool {
        self.holds_endlessly(sequence, &[])
    }

    /// Every violation of a formula that only demands that something always holds; `None` for any other formula. Each
    /// position of each clause is looked at by itself.
    pub(crate) fn violations(&self, sequence: &[Event]) -> Option<Vec<Violation>> {
        let mut products = Parts::new();
        for clause in &self.clauses {
            match clause.iter().collect::<Vec<_>>()[..] {
                [(Atom::Until(hold, goal), false)] if hold.is_empty() => products.extend(goal.iter().cloned()),
                _ => return None,
            }
        }
        let (mut events, mut states) = (Vec::new(), Vec::new());
        let mut seen = BTreeSet::new();
        visible(self.clauses.iter().flatten(), &self.words, &mut seen);
        for event in sequence {
            if matches!(&event.kind, EventKind::Received { channel, .. } if !seen.contains(channel)) {
                continue;
            }
            let time = if self.words.is_timed { event.time.as_nanos() as u64 } else { event.tick };
            states.push((time, &event.kind));
            events.push(event);
        }
        let run = Run { words: &self.words, back: states.len(), states, lap: 0 };
        if products.iter().flatten().any(|(atom, _)| is_deep(atom)) {
            return None;
        }
        let looks_ahead = |(atom, _): &Literal| matches!(atom, Atom::Passes(..) | Atom::Next(..) | Atom::Until(..));
        // These are the negations of the clauses.
        let (ahead, present): (Vec<&Part>, Vec<&Part>) =
            products.iter().partition(|product| product.iter().any(looks_ahead));
        let mut violations = run.stretches(&present, &events);
        for product in ahead {
            let asked = (0..events.len()).filter(|i| run.is_asked(product, *i));
            violations.extend(asked.filter_map(|i| run.missed(product, i, &events)));
        }
        violations.sort_by_key(order_of);
        Some(violations)
    }

    /// Whether it holds on the sequence that repeats `cycle` forever; each tick takes one tick, or one second.
    pub(crate) fn holds_endlessly(&self, stem: &[Event], cycle: &[EventKind]) -> bool {
        let mut seen = BTreeSet::new();
        visible(self.clauses.iter().flatten(), &self.words, &mut seen);
        let is_seen = |kind: &EventKind| match kind {
            EventKind::Tick => true,
            EventKind::Received { channel, .. } => seen.contains(channel),
        };
        let time = |event: &Event| if self.words.is_timed { event.time.as_nanos() as u64 } else { event.tick };
        let unit = if self.words.is_timed { 1_000_000_000 } else { 1 };
        let mut now = stem.last().map_or(0, time);
        let mut states: Vec<(u64, &EventKind)> = stem.iter().map(|event| (time(event), &event.kind)).collect();
        states.retain(|(_, kind)| is_seen(kind));
        let cycle: Vec<&EventKind> = cycle.iter().filter(|kind| is_seen(kind)).collect();
        let mut back = states.len();
        if !cycle.is_empty() {
            // In the last turn, everything that looks back says what it says in all later ones.
            for _ in 0..2 + longest_look_back(&self.clauses, unit) {
                back = states.len();
                for kind in &cycle {
                    now += if **kind == EventKind::Tick { unit } else { 0 };
                    states.push((now, kind));
                }
            }
        }
        let lap = cycle.iter().filter(|kind| ***kind == EventKind::Tick).count() as u64 * unit;
        let run = Run { words: &self.words, states, back, lap };
        self.clauses.iter().all(|clause| run.any(clause, 0, &Names::new()))
    }
}

impl Words {
    fn event(&mut self, event: &EventAtom) -> usize {
        self.events.iter().position(|known| known == event).unwrap_or_else(|| {
            let mut names = BTreeMap::new();
            named(&event.condition, &mut names);
            self.names.push(names);
            self.events.push(event.clone());
            self.events.len() - 1
        })
    }

    /// The clauses of the formula, or of its negation.
    fn clauses(&mut self, formula: &Formula, holds: bool) -> Parts {
        let single = |atom, holds| Parts::from([Part::from([(atom, holds)])]);
        match formula {
            Formula::True | Formula::False if matches!(formula, Formula::True) == holds => Parts::new(),
            Formula::True | Formula::False => Parts::from([Part::new()]),
            Formula::Timed(a) => self.clauses(a, holds),
            Formula::Not(a) => self.clauses(a, !holds),
            Formula::And(all) if holds => self.all(all, true),
            Formula::And(all) => self.any(all, false),
            Formula::Or(all) if holds => self.any(all, true),
            Formula::Or(all) => self.all(all, false),
            Formula::Implies(a, b) => {
                let either = Formula::Or(vec![Formula::Not(a.clone()), (**b).clone()]);
                self.clauses(&either, holds)
            }
            Formula::Event(event) => single(Atom::Event(self.event(event)), holds),
            Formula::Fresh(event) => single(Atom::Fresh(self.event(event)), holds),
            Formula::TimeUntil { event, bound } => single(Atom::Passes(self.event(event), *bound), holds),
            Formula::Count { event, is_at_most, count, bound } => {
                let least = count + u64::from(*is_at_most);
                if least == 0 {
                    return self.clauses(&Formula::True, holds);
                }
                single(Atom::AtLeast(least, self.event(event), bound.ticks), holds != *is_at_most)
            }
            Formula::Next(a) => {
                let (yes, no) = (self.clauses(a, true), self.clauses(a, false));
                single(Atom::Next(yes, no), holds)
            }
            Formula::Until(a, b) => {
                let (hold, goal) = (self.clauses(a, true), self.products(b, true));
                single(Atom::Until(hold, goal), holds)
            }
            Formula::Eventually(a) => single(Atom::Until(Parts::new(), self.products(a, true)), holds),
            Formula::Always(a) => single(Atom::Until(Parts::new(), self.products(a, false)), !holds),
            Formula::Since(bound, a, b) => {
                let (hold, goal) = (self.clauses(a, true), self.products(b, true));
                single(Atom::Since(hold, goal, *bound), holds)
            }
            Formula::Once(bound, a) => single(Atom::Since(Parts::new(), self.products(a, true), *bound), holds),
            Formula::Historically(bound, a) => {
                single(Atom::Since(Parts::new(), self.products(a, false), *bound), !holds)
            }
            Formula::Previous(bound, a) => single(Atom::Previous(self.clauses(a, true), *bound), holds),
        }
    }

    /// The products of a formula are the negated clauses of its negation.
    fn products(&mut self, formula: &Formula, holds: bool) -> Parts {
        let denied = |part: Part| part.into_iter().map(|(atom, holds)| (atom, !holds)).collect();
        self.clauses(formula, !holds).into_iter().map(denied).collect()
    }

    fn all(&mut self, parts: &[Formula], holds: bool) -> Parts {
        smallest(parts.iter().flat_map(|part| self.clauses(part, holds)).collect())
    }

    fn any(&mut self, parts: &[Formula], holds: bool) -> Parts {
        parts.iter().fold(Parts::from([Part::new()]), |all, part| {
            let more = self.clauses(part, holds);
            smallest(all.iter().flat_map(|one| more.iter().map(move |other| one | other)).collect())
        })
    }

    /// The channels of a part's own events.
    fn own<'a>(&self, parts: impl Iterator<Item = &'a Part>) -> impl Iterator<Item = ChannelId> {
        parts.flatten().filter_map(|(atom, _)| match atom {
            Atom::Event(event) | Atom::Fresh(event) => Some(self.events[*event].channel),
            _ => None,
        })
    }

    /// Whether parts are checked together at a state of this kind.
    fn asks<'a>(&self, parts: impl Iterator<Item = &'a Part> + Clone, kind: &EventKind) -> bool {
        let mut own = self.own(parts.clone()).peekable();
        match kind {
            EventKind::Tick => own.peek().is_none(),
            EventKind::Received { channel, .. } if own.peek().is_some() => own.any(|own| own == *channel),
            EventKind::Received { channel, .. } => {
                let mut past = BTreeSet::new();
                let looks_back =
                    |(atom, _): &&Literal| matches!(atom, Atom::Since(..) | Atom::Previous(..) | Atom::AtLeast(..));
                visible(parts.flatten().filter(looks_back), self, &mut past);
                past.contains(channel)
            }
        }
    }
}

/// The parts that contain no other.
fn smallest(parts: Parts) -> Parts {
    let is_smallest = |part: &&Part| !parts.iter().any(|other| other != *part && other.is_subset(part));
    parts.iter().filter(is_smallest).cloned().collect()
}

/// The channels that literals mention at any depth.
fn visible<'a>(literals: impl Iterator<Item = &'a Literal>, words: &Words, channels: &mut BTreeSet<ChannelId>) {
    for (atom, holds) in literals {
        match atom {
            Atom::Event(event) | Atom::Fresh(event) | Atom::Passes(event, _) | Atom::AtLeast(_, event, _) => {
                channels.insert(words.events[*event].channel);
            }
            Atom::Next(yes, no) => visible(if *holds { yes } else { no }.iter().flatten(), words, channels),
            Atom::Previous(inside, _) => visible(inside.iter().flatten(), words, channels),
            Atom::Until(hold, goal) | Atom::Since(hold, goal, _) => {
                visible(hold.iter().flatten(), words, channels);
                visible(goal.iter().flatten(), words, channels);
            }
        }
    }
}

/// Turns of a cycle after which operators that look back, one in another, have settled.
fn longest_look_back(parts: &Parts, unit: u64) -> u64 {
    let of = |atom: &Atom| match atom {
        Atom::Event(_) | Atom::Fresh(_) | Atom::Passes(..) => 0,
        Atom::AtLeast(count, _, ticks) => count + ticks / unit + 2,
        Atom::Next(yes, no) => longest_look_back(yes, unit).max(longest_look_back(no, unit)),
        Atom::Until(hold, goal) => longest_look_back(hold, unit).max(longest_look_back(goal, unit)),
        Atom::Since(hold, goal, bound) => {
            longest_look_back(hold, unit).max(longest_look_back(goal, unit)) + bound.ticks / unit + 2
        }
        Atom::Previous(inside, bound) => longest_look_back(inside, unit) + bound.ticks / unit + 2,
    };
    parts.iter().flatten().map(|(atom, _)| of(atom)).max().unwrap_or(0)
}

/// The fields to which a condition gives names.
fn named(condition: &MessageCondition, names: &mut BTreeMap<Arc<str>, MessageField>) {
    match condition {
        MessageCondition::Remember { field, name } => _ = names.insert(Arc::clone(name), field.clone()),
        MessageCondition::Not(a) => named(a, names),
        MessageCondition::And(all) | MessageCondition::Or(all) => all.iter().for_each(|part| named(part, names)),
        MessageCondition::Implies(a, b) => {
            named(a, names);
            named(b, names);
        }
        MessageCondition::True
        | MessageCondition::False
        | MessageCondition::Compare { .. }
        | MessageCondition::Relate { .. }
        | MessageCondition::Is { .. } => {}
    }
}

/// A sequence whose last state is followed by the one at `back`, if there is one.
struct Run<'a> {
    words: &'a Words,
    states: Vec<(u64, &'a EventKind)>,
    back: usize,
    /// The time that a turn takes.
    lap: u64,
}

impl Run<'_> {
    /// The states from i on with their distances, for at least two turns, one of which is beyond `span`.
    fn walk(&self, i: usize, span: u64) -> impl Iterator<Item = (usize, u64)> {
        let mut next = (i < self.states.len()).then_some((i, 0));
        let (mut turns, mut turn_began) = (0, 0);
        std::iter::from_fn(move || {
            let (here, distance) = next?;
            next = if here + 1 < self.states.len() {
                Some((here + 1, distance + self.states[here + 1].0 - self.states[here].0))
            } else if self.back < self.states.len() && (turns < 2 || self.lap > 0 && turn_began <= span) {
                // Two states of neighboring turns that are alike are one lap apart.
                turns += 1;
                turn_began = distance + self.lap - (self.states[here].0 - self.states[self.back].0);
                Some((self.back, turn_began))
            } else {
                None
            };
            Some((here, distance))
        })
    }

    fn message(&self, channel: ChannelId, i: usize) -> Option<&Message> {
        match self.states[i].1 {
            EventKind::Received { channel: on, message } if *on == channel => Some(message),
            _ => None,
        }
    }

    /// The last message on a channel, up to and including state i.
    fn last(&self, channel: ChannelId, i: usize) -> Option<&Message> {
        (0..self.states.len().min(i + 1)).rev().find_map(|j| self.message(channel, j))
    }

    fn named<'m>(&'m self, channel: ChannelId, message: &'m Message) -> Named<'m> {
        Named::new(message, self.words.shapes.get(&channel).map_or(&[], Vec::as_slice))
    }

    fn passes(&self, event: usize, i: usize, names: &Names) -> bool {
        let EventAtom { channel, condition } = &self.words.events[event];
        self.message(*channel, i).is_some_and(|message| satisfies(condition, self.named(*channel, message), names))
    }

    /// The names with the values that a part's own events give them at state i.
    fn naming(&self, part: &Part, i: usize, names: &Names) -> Names {
        let mut names = names.clone();
        for (atom, _) in part {
            let (Atom::Event(event) | Atom::Fresh(event)) = atom else { continue };
            for (name, field) in &self.words.names[*event] {
                names.remove(name);
                let channel = self.words.events[*event].channel;
                let message = self.last(channel, i).map(|message| self.named(channel, message));
                if let Some(value) = message.and_then(|message| message.field(field)) {
                    names.insert(Arc::clone(name), value.clone());
                }
            }
        }
        names
    }

    /// Whether one literal of a clause holds.
    fn any(&self, clause: &Part, i: usize, names: &Names) -> bool {
        let names = self.naming(clause, i, names);
        clause.iter().any(|literal| self.literal(literal, i, &names))
    }

    /// Whether all literals of a product hold.
    fn every(&self, product: &Part, i: usize, names: &Names) -> bool {
        let names = self.naming(product, i, names);
        product.iter().all(|literal| self.literal(literal, i, &names))
    }

    fn is_asked(&self, part: &Part, i: usize) -> bool {
        self.words.asks(std::iter::once(part), self.states[i].1)
    }

    /// Whether no clause that is checked at state i is broken.
    fn keeps(&self, hold: &Parts, i: usize, names: &Names) -> bool {
        hold.iter().all(|clause| !self.is_asked(clause, i) || self.any(clause, i, names))
    }

    /// Whether a product is checked and holds at state i.
    fn reaches(&self, goal: &Parts, i: usize, names: &Names) -> bool {
        goal.iter().any(|product| self.is_asked(product, i) && self.every(product, i, names))
    }

    fn ago(&self, i: usize, j: usize) -> u64 {
        self.states.get(i).map_or(0, |now| now.0 - self.states[j].0)
    }

    fn literal(&self, (atom, holds): &Literal, i: usize, names: &Names) -> bool {
        let before = 0..self.states.len().min(i + 1);
        let is_so = match atom {
            Atom::Event(event) => {
                let EventAtom { channel, condition } = &self.words.events[*event];
                self.last(*channel, i).is_some_and(|message| satisfies(condition, self.named(*channel, message), names))
            }
            Atom::Fresh(event) => i < self.states.len() && self.passes(*event, i, names),
            Atom::Passes(event, bound) => {
                let mut states = self.walk(i, bound.ticks);
                states.any(|(j, distance)| within(distance, *bound) && self.passes(*event, j, names))
            }
            Atom::AtLeast(count, event, ticks) => {
                let counts = |j: &usize| self.ago(i, *j) < *ticks && self.passes(*event, *j, names);
                before.filter(counts).count() as u64 >= *count
            }
            Atom::Next(yes, no) => {
                let clauses = if *holds { yes } else { no };
                let mut later = self.walk(i, 0).skip(1);
                let next = later.find(|(j, _)| self.words.asks(clauses.iter(), self.states[*j].1));
                return next.map_or(!*holds, |(j, _)| clauses.iter().all(|clause| self.any(clause, j, names)));
            }
            Atom::Until(hold, goal) => {
                for (j, _) in self.walk(i, 0) {
                    if self.reaches(goal, j, names) {
                        return *holds;
                    }
                    if !self.keeps(hold, j, names) {
                        return !*holds;
                    }
                }
                false
            }
            Atom::Since(hold, goal, bound) => {
                let kept = |j: usize| (j + 1..before.end).all(|k| self.keeps(hold, k, names));
                before.clone().any(|j| within(self.ago(i, j), *bound) && self.reaches(goal, j, names) && kept(j))
            }
            Atom::Previous(clauses, bound) => {
                let asks = |j: &usize| self.words.asks(clauses.iter(), self.states[*j].1);
                let held =
                    |j| within(self.ago(i, j), *bound) && clauses.iter().all(|clause| self.any(clause, j, names));
                before.rev().filter(|j| *j < i).find(asks).is_some_and(held)
            }
        };
        is_so == *holds
    }
}

/// Whether it takes too long to look at each position by itself.
fn is_deep(atom: &Atom) -> bool {
    let is_until = |(atom, _): &Literal| matches!(atom, Atom::Until(..) | Atom::Next(..));
    match atom {
        Atom::Until(hold, goal) => hold.iter().chain(goal).flatten().any(is_until),
        Atom::Next(yes, no) => yes.iter().chain(no).flatten().any(is_until),
        _ => false,
    }
}

fn collect_lasts(formula: &Formula, lasts: &mut Vec<Bound>) {
    match formula {
        Formula::TimeUntil { bound, .. } if matches!(bound.relation, Relation::LessOrEqual | Relation::Equal) => {
            lasts.push(*bound);
        }
        _ => formula.operands().into_iter().for_each(|operand| collect_lasts(operand, lasts)),
    }
}

/// An order of violations by their beginnings.
pub(crate) fn order_of(violation: &Violation) -> (Duration, u64, Option<Duration>) {
    (violation.from.time, violation.from.step, violation.until.map(|until| until.time))
}

/// What is certain of a run of which only the states before `seen` have been, at a time not before theirs. What is not
/// certain is `None`.
#[derive(Clone, Copy)]
struct Seen {
    states: usize,
    time: u64,
}

impl Run<'_> {
    /// The stretches in which one of these products held when it was checked last.
    fn stretches(&self, products: &[&Part], events: &[&Event]) -> Vec<Violation> {
        let mut stretches: Vec<Violation> = Vec::new();
        let mut violated: BTreeSet<&Part> = BTreeSet::new();
        for (i, event) in events.iter().enumerate() {
            let asked: Vec<&&Part> = products.iter().filter(|product| self.is_asked(product, i)).collect();
            let (broken, kept): (Vec<&&Part>, Vec<&&Part>) =
                asked.iter().partition(|product| self.every(product, i, &Names::new()));
            kept.iter().for_each(|product| _ = violated.remove(**product));
            violated.extend(broken.iter().map(|product| **product));
            let open = stretches.last().is_some_and(|last| last.until.is_none());
            if !broken.is_empty() && !open {
                stretches.push(Violation { from: EventTime::of(event), until: None });
            } else if open && !asked.is_empty() && violated.is_empty() {
                stretches.last_mut().expect("one is open").until = Some(EventTime::of(event));
            }
        }
        stretches
    }

    /// The violation by what a clause demands at state i, if nothing can meet it any longer.
    fn missed(&self, product: &Part, i: usize, events: &[&Event]) -> Option<Violation> {
        let names = self.naming(product, i, &Names::new());
        let awaited: Vec<usize> = product
            .iter()
            .filter_map(|literal| match literal {
                (Atom::Passes(event, _), false) => Some(*event),
                _ => None,
            })
            .collect();
        let fails = |states, time| self.every_surely(product, i, Seen { states, time }, &Names::new()) == Some(true);
        let (from, first) = (i..events.len()).find_map(|n| {
            let time = self.states[n].0;
            let before = n.checked_sub(1).filter(|before| *before >= i).map(|before| self.states[before].0);
            if let Some(before) = before.filter(|_| fails(n, time)) {
                let moment = if self.words.is_timed { moment(before + 1, time, |time| fails(n, time)) } else { time };
                // Within `<= D`, it is too late after D, which is the deadline.
                let begins = |last: &Bound| self.states[..n].iter().any(|begin| begin.0 + last.ticks + 1 == moment);
                let is_deadline = self.words.lasts.iter().any(begins);
                let mut at = EventTime::of(events[n]);
                if moment < time || is_deadline && self.words.is_timed {
                    at.time = Duration::from_nanos(moment - u64::from(is_deadline));
                    // Before the first tick, there is none.
                    at.tick = at.tick.saturating_sub(u64::from(events[n].kind == EventKind::Tick));
                }
                return Some((at, n));
            }
            fails(n + 1, time).then(|| (EventTime::of(events[n]), n + 1))
        })?;
        if awaited.is_empty() {
            return Some(Violation { from, until: Some(from) });
        }
        let answer = (first..events.len()).find(|n| awaited.iter().any(|event| self.passes(*event, *n, &names)));
        Some(Violation { from, until: answer.map(|n| EventTime::of(events[n])) })
    }

    fn every_surely(&self, product: &Part, i: usize, seen: Seen, names: &Names) -> Option<bool> {
        let names = self.naming(product, i, names);
        both(product.iter().map(|literal| self.surely(literal, i, seen, &names)), true)
    }

    fn any_surely(&self, clause: &Part, i: usize, seen: Seen, names: &Names) -> Option<bool> {
        let names = self.naming(clause, i, names);
        both(clause.iter().map(|literal| self.surely(literal, i, seen, &names)), false)
    }

    fn surely(&self, literal @ (atom, holds): &Literal, i: usize, seen: Seen, names: &Names) -> Option<bool> {
        let is_so = match atom {
            Atom::Passes(event, bound) => {
                let begun = self.states[i].0;
                let passed = |j: usize| within(self.states[j].0 - begun, *bound) && self.passes(*event, j, names);
                let elapsed = seen.time - begun;
                let is_over = match bound.relation {
                    Relation::Less => elapsed >= bound.ticks,
                    Relation::LessOrEqual | Relation::Equal => elapsed > bound.ticks,
                    Relation::NotEqual | Relation::Greater | Relation::GreaterOrEqual => false,
                };
                if (i..seen.states).any(passed) { Some(true) } else { is_over.then_some(false) }
            }
            Atom::Next(yes, no) => {
                let clauses = if *holds { yes } else { no };
                let next = (i + 1..seen.states).find(|j| self.words.asks(clauses.iter(), self.states[*j].1))?;
                return both(clauses.iter().map(|clause| self.any_surely(clause, next, seen, names)), true);
            }
            Atom::Until(hold, goal) => {
                let mut later = None;
                for j in (i..seen.states).rev() {
                    let reached = goal.iter().filter(|product| self.is_asked(product, j));
                    let reached = both(reached.map(|product| self.every_surely(product, j, seen, names)), false);
                    let kept = hold.iter().filter(|clause| self.is_asked(clause, j));
                    let kept = both(kept.map(|clause| self.any_surely(clause, j, seen, names)), true);
                    later = both([reached, both([kept, later].into_iter(), true)].into_iter(), false);
                }
                later
            }
            _ => return Some(self.literal(literal, i, names)),
        };
        is_so.map(|is_so| is_so == *holds)
    }
}

/// Whether all hold, or with `false`, whether one does.
fn both(parts: impl Iterator<Item = Option<bool>>, all: bool) -> Option<bool> {
    let mut result = Some(all);
    for part in parts {
        match part {
            Some(part) if part != all => return Some(!all),
            Some(_) => {}
            None => result = None,
        }
    }
    result
}

/// The first moment from `low` to `high` from which on something is so.
fn moment(mut low: u64, mut high: u64, is_so: impl Fn(u64) -> bool) -> u64 {
    while low < high {
        let middle = low + (high - low) / 2;
        if is_so(middle) { high = middle } else { low = middle + 1 }
    }
    high
}

fn within(distance: u64, bound: Bound) -> bool {
    let order = distance.cmp(&bound.ticks);
    match bound.relation {
        Relation::Equal => order == Ordering::Equal,
        Relation::NotEqual => order != Ordering::Equal,
        Relation::Less => order == Ordering::Less,
        Relation::LessOrEqual => order != Ordering::Greater,
        Relation::Greater => order == Ordering::Greater,
        Relation::GreaterOrEqual => order != Ordering::Less,
    }
}
