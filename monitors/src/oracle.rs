//! The meaning of a formula on finite and endless sequences, implemented literally: the slow and simple definition that
//! everything else is checked against.

use channels::{ChannelId, Event, EventKind, Message};

use crate::clause::{Form, Literal, LiteralSet, Trigger, Vocabulary, normal_form, trigger};
use crate::data::Values;
use crate::formula::{self, Bound, Formula, FormulaError};

/// Whether a formula holds on a finished sequence, by the definition in the [crate documentation](crate).
///
/// This takes quadratic time in the length of the sequence, and more with nested operators: the aim is correctness.
///
/// # Errors
/// [`FormulaError`] if the formula's clause form has more than two thousand parts.
pub fn holds(formula: &Formula, sequence: &[Event]) -> Result<bool, FormulaError> {
    holds_endlessly(formula, sequence, &[])
}

/// Whether a formula holds on the endless sequence that begins with `stem` and then repeats `cycle` forever.
///
/// Each tick of the cycle raises τ by one, or by one second if the formula is timed. A cycle without ticks and without
/// messages visible to the formula is silence: nothing follows the stem.
///
/// # Errors
/// [`FormulaError`] if the formula's clause form has more than two thousand parts.
pub fn holds_endlessly(formula: &Formula, stem: &[Event], cycle: &[EventKind]) -> Result<bool, FormulaError> {
    let (form, words) = normal_form(formula)?;
    let channels = words.channels();
    let is_seen = |kind: &EventKind| match kind {
        EventKind::Tick => true,
        EventKind::Received { channel, .. } => channels.contains(channel),
    };
    let mut states: Vec<Position<'_>> =
        stem.iter().map(|event| Position { kind: &event.kind, tick: words.tau(event) }).collect();
    let unit = if words.is_timed { SECOND } else { 1 };
    let mut tick = states.last().map_or(0, |last| last.tick);
    states.retain(|state| is_seen(state.kind));
    let mut turn = || {
        let kinds = cycle.iter().filter(|kind| is_seen(kind));
        let turn = kinds.map(|kind| {
            tick += unit * u64::from(*kind == EventKind::Tick);
            Position { kind, tick }
        });
        turn.collect::<Vec<_>>()
    };
    // From some cycle on, all cycles are the same. From the second cycle on, the last messages are its own; the value
    // of an operator about the past stays the same once its operands do and its bound has passed.
    for _ in 0..=form.iter().flatten().map(|literal| settling(literal, unit)).max().unwrap_or(0) {
        states.extend(turn());
    }
    let repeated = turn();
    let ticks = cycle.iter().filter(|kind| **kind == EventKind::Tick).count() as u64;
    let lap = Lap { start: states.len(), ticks: unit * ticks };
    states.extend(repeated);
    let oracle = Oracle { words, states, lap };
    Ok(form.iter().all(|clause| oracle.clause(clause, 0, &Values::default())))
}

/// A tick, or a message on a channel that the formula mentions.
struct Position<'a> {
    kind: &'a EventKind,
    /// τ
    tick: u64,
}

/// The part that repeats at the end of a sequence; `None` if the sequence is finite.
#[derive(Clone, Copy)]
struct Lap {
    /// Its first state, which also follows its last one.
    start: usize,
    /// The number of ticks by which τ grows in one turn.
    ticks: u64,
}

/// The time between the ticks of a cycle, for a timed formula.
const SECOND: u64 = 1_000_000_000;

struct Oracle<'a> {
    words: Vocabulary,
    states: Vec<Position<'a>>,
    lap: Lap,
}

impl Oracle<'_> {
    fn clause(&self, clause: &LiteralSet, i: usize, values: &Values) -> bool {
        let values = self.remembered(clause, i, values);
        clause.iter().any(|literal| self.literal(literal, i, &values))
    }

    fn product(&self, product: &LiteralSet, i: usize, values: &Values) -> bool {
        let values = self.remembered(product, i, values);
        product.iter().all(|literal| self.literal(literal, i, &values))
    }

    /// The values, with those that are remembered where a part is checked.
    fn remembered(&self, part: &LiteralSet, i: usize, values: &Values) -> Values {
        values.with(&self.words.remembered(part), |channel| self.last(channel, i))
    }

    /// The states from i on, in order, until every later situation has been seen from each of them.
    fn onwards(&self, i: usize) -> impl Iterator<Item = usize> + Clone {
        (i..self.states.len()).chain(self.lap.start..self.states.len())
    }

    /// Whether a literal holds at state i, which may lie past the end: then nothing follows.
    fn literal(&self, literal: &Literal, i: usize, values: &Values) -> bool {
        match literal {
            Literal::Event { event, holds } => self.last_satisfies(self.words.get(*event), i, values) == *holds,
            Literal::Fresh { event, holds } => self.passes(self.words.get(*event), i, values) == *holds,
            Literal::Time { event, bound, holds } => {
                let event = self.words.get(*event);
                (0..self.states.len()).any(|j| self.passes(event, j, values) && self.in_time(*bound, i, j)) == *holds
            }
            Literal::Next { clauses, strong } => {
                let trigger = Trigger::of(clauses.iter(), &self.words);
                let next = self.onwards(i).skip(1).find(|j| trigger.fires(self.states[*j].kind));
                next.map_or(!strong, |j| clauses.iter().all(|clause| self.clause(clause, j, values)))
            }
            Literal::Until { hold, goal } => self.until(hold, goal, i, values),
            Literal::Release { escape, hold } => self.release(escape, hold, i, values),
            Literal::Since { hold, goal, bound, holds } => {
                let since = |j: usize| {
                    self.some_asked_holds(goal, j, values) && (j + 1..=i).all(|k| self.all_asked_hold(hold, k, values))
                };
                self.up_to(i).any(|j| self.ago(*bound, i, j) && since(j)) == *holds
            }
            Literal::Previous { clauses, bound, holds } => self.previously(clauses, *bound, i, values) == *holds,
            Literal::Count { event, count, bound, holds } => {
                let event = self.words.get(*event);
                let passed =
                    self.up_to(i).filter(|j| self.passes(event, *j, values) && self.ago(*bound, i, *j)).count();
                (passed as u64 >= *count) == *holds
            }
        }
    }

    fn until(&self, hold: &Form, goal: &Form, i: usize, values: &Values) -> bool {
        for j in self.onwards(i) {
            if self.some_asked_holds(goal, j, values) {
                return true;
            }
            if !self.all_asked_hold(hold, j, values) {
                return false;
            }
        }
        false
    }

    fn release(&self, escape: &Form, hold: &Form, i: usize, values: &Values) -> bool {
        for j in self.onwards(i) {
            if !self.all_asked_hold(hold, j, values) {
                return false;
            }
            if self.some_asked_holds(escape, j, values) {
                return true;
            }
        }
        true
    }

    fn previously(&self, clauses: &Form, bound: Bound, i: usize, values: &Values) -> bool {
        let trigger = Trigger::of(clauses.iter(), &self.words);
        let before = self.up_to(i).rev().find(|j| *j < i && trigger.fires(self.states[*j].kind));
        before.is_some_and(|j| self.ago(bound, i, j) && clauses.iter().all(|clause| self.clause(clause, j, values)))
    }

    fn up_to(&self, i: usize) -> impl DoubleEndedIterator<Item = usize> + use<> {
        0..(i + 1).min(self.states.len())
    }

    /// Whether the time from state j to state i is within the bound.
    fn ago(&self, bound: Bound, i: usize, j: usize) -> bool {
        let ticks = self.states.get(i).map_or(0, |now| now.tick - self.states[j].tick);
        bound.windows().any(|window| (window.first..=window.last).contains(&ticks))
    }

    fn all_asked_hold(&self, clauses: &Form, k: usize, values: &Values) -> bool {
        clauses.iter().all(|clause| !self.asked(clause, k) || self.clause(clause, k, values))
    }

    fn some_asked_holds(&self, products: &Form, k: usize, values: &Values) -> bool {
        products.iter().any(|product| self.asked(product, k) && self.product(product, k, values))
    }

    /// Whether a part is checked at state j.
    fn asked(&self, part: &LiteralSet, j: usize) -> bool {
        trigger(part, &self.words).fires(self.states[j].kind)
    }

    /// Whether the message that passes at state j, if any, satisfies the event.
    fn passes(&self, event: &formula::EventAtom, j: usize, values: &Values) -> bool {
        self.message(event.channel, j).is_some_and(|message| event.condition.holds_with(message, values))
    }

    /// Whether there was a message on the event's channel up to state i, and the last one satisfies the event.
    fn last_satisfies(&self, event: &formula::EventAtom, i: usize, values: &Values) -> bool {
        self.last(event.channel, i).is_some_and(|message| event.condition.holds_with(message, values))
    }

    /// The last message on a channel up to state i.
    fn last(&self, channel: ChannelId, i: usize) -> Option<&Message> {
        self.up_to(i).rev().find_map(|j| self.message(channel, j))
    }

    /// The message that passes on a channel at state j.
    fn message(&self, channel: ChannelId, j: usize) -> Option<&Message> {
        match self.states.get(j)?.kind {
            EventKind::Received { channel: on, message } if *on == channel => Some(message),
            _ => None,
        }
    }

    /// Whether the time from state i to state j is within the bound in one of the cycles after i.
    fn in_time(&self, bound: Bound, i: usize, j: usize) -> bool {
        let Some(here) = self.states.get(i) else { return false };
        let Lap { start, ticks } = self.lap;
        if j < i && j < start {
            return false;
        }
        // If j is before i, its first turn after i is in the next cycle.
        let first = self.states[j].tick + if j < i { ticks } else { 0 } - here.tick;
        bound.windows().any(|window| {
            let turns = if j < start || ticks == 0 { 0 } else { window.first.saturating_sub(first).div_ceil(ticks) };
            (window.first..=window.last).contains(&first.saturating_add(turns.saturating_mul(ticks)))
        })
    }
}

/// A number of turns after which a literal about the past holds at the same states of the cycle in each turn.
fn settling(literal: &Literal, unit: u64) -> u64 {
    let inside = literal.forms().into_iter().flatten().flatten().map(|literal| settling(literal, unit)).max();
    let own = match literal {
        Literal::Since { bound, .. } | Literal::Previous { bound, .. } => bound.ticks / unit + 3,
        // Without ticks, each turn adds to the count until it is reached.
        Literal::Count { count, bound, .. } => (bound.ticks / unit).max(*count) + 3,
        _ => 0,
    };
    inside.unwrap_or(0) + own
}
