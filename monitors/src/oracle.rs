//! The meaning of a formula on finite and endless sequences, implemented literally: the slow and simple definition that
//! everything else is checked against.

use std::collections::BTreeSet;

use channels::{ChannelId, Event, EventKind};

use crate::clause::{Bound, Form, Literal, Part, TooManyParts, Vocabulary, clauses, own_channels, own_channels_of_all};
use crate::formula::{self, Formula};

/// Whether a formula holds on a finished sequence, by the definition in the [crate documentation](crate).
///
/// The time is quadratic in the length of the sequence, and more with nested operators: the aim is to be correct.
///
/// # Errors
/// [`FormulaTooLarge`] if the formula's clause form has more than two thousand parts.
pub fn holds(formula: &Formula, sequence: &[Event]) -> Result<bool, FormulaTooLarge> {
    holds_endlessly(formula, sequence, &[])
}

/// Whether a formula holds on the endless sequence that begins with `stem` and then repeats `cycle` forever.
///
/// Each tick of the cycle raises τ by one. A cycle without ticks and without messages visible to the formula is
/// silence: nothing follows the stem.
///
/// # Errors
/// [`FormulaTooLarge`] if the formula's clause form has more than two thousand parts.
pub fn holds_endlessly(formula: &Formula, stem: &[Event], cycle: &[EventKind]) -> Result<bool, FormulaTooLarge> {
    let words = Vocabulary::of(formula);
    let channels = words.channels();
    let is_seen = |kind: &EventKind| match kind {
        EventKind::Tick => true,
        EventKind::Received { channel, .. } => channels.contains(channel),
    };
    let mut states: Vec<State<'_>> = stem.iter().map(|event| State { kind: &event.kind, tick: event.tick }).collect();
    let mut tick = states.last().map_or(0, |last| last.tick);
    states.retain(|state| is_seen(state.kind));
    let mut turn = || {
        let kinds = cycle.iter().filter(|kind| is_seen(kind));
        let turn = kinds.map(|kind| {
            tick += u64::from(*kind == EventKind::Tick);
            State { kind, tick }
        });
        turn.collect::<Vec<_>>()
    };
    // From its second turn on, the cycle is always the same: the last messages are its own.
    states.extend(turn());
    let repeated = turn();
    let lap = Lap { start: states.len(), ticks: cycle.iter().filter(|kind| **kind == EventKind::Tick).count() as u64 };
    states.extend(repeated);
    let form = clauses(formula, &words)?;
    let oracle = Oracle { words, states, lap };
    Ok(form.iter().all(|clause| oracle.clause(clause, 0)))
}

/// A formula's clause form has too many parts to be evaluated or monitored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the formula is too large: its clause form has more than two thousand parts")]
pub struct FormulaTooLarge;

impl From<TooManyParts> for FormulaTooLarge {
    fn from(_: TooManyParts) -> Self {
        Self
    }
}

/// A tick, or a message on a channel that the formula mentions.
struct State<'a> {
    kind: &'a EventKind,
    /// τ
    tick: u64,
}

/// The part that repeats at the end of a sequence; `None` if the sequence is finite.
#[derive(Clone, Copy)]
struct Lap {
    /// Its first state; after its last one it begins again.
    start: usize,
    /// The number of ticks by which τ grows in one turn.
    ticks: u64,
}

struct Oracle<'a> {
    words: Vocabulary,
    states: Vec<State<'a>>,
    lap: Lap,
}

impl Oracle<'_> {
    fn clause(&self, clause: &Part, i: usize) -> bool {
        clause.iter().any(|literal| self.literal(literal, i))
    }

    fn product(&self, product: &Part, i: usize) -> bool {
        product.iter().all(|literal| self.literal(literal, i))
    }

    /// The states from i on, in order, until every later situation has been seen from each of them.
    fn onwards(&self, i: usize) -> impl Iterator<Item = usize> + Clone {
        (i..self.states.len()).chain(self.lap.start..self.states.len())
    }

    /// Whether a literal holds at state i, which may lie past the end: then nothing follows.
    fn literal(&self, literal: &Literal, i: usize) -> bool {
        match literal {
            Literal::Event { event, holds } => self.last_satisfies(self.words.get(*event), i) == *holds,
            Literal::Time { event, bound, holds } => {
                let event = self.words.get(*event);
                (0..self.states.len()).any(|j| self.passes(event, j) && self.in_time(*bound, i, j)) == *holds
            }
            Literal::Next { clauses, strong } => {
                let own = own_channels_of_all(clauses, &self.words);
                let next = self.onwards(i).skip(1).find(|j| self.speaks(&own, *j));
                next.map_or(!strong, |j| clauses.iter().all(|clause| self.clause(clause, j)))
            }
            Literal::Until { hold, goal } => {
                for j in self.onwards(i) {
                    if self.some_asked_holds(goal, j) {
                        return true;
                    }
                    if !self.all_asked_hold(hold, j) {
                        return false;
                    }
                }
                false
            }
            Literal::Release { escape, hold } => {
                for j in self.onwards(i) {
                    if !self.all_asked_hold(hold, j) {
                        return false;
                    }
                    if self.some_asked_holds(escape, j) {
                        return true;
                    }
                }
                true
            }
        }
    }

    fn all_asked_hold(&self, clauses: &Form, k: usize) -> bool {
        clauses.iter().all(|clause| !self.asked(clause, k) || self.clause(clause, k))
    }

    fn some_asked_holds(&self, products: &Form, k: usize) -> bool {
        products.iter().any(|product| self.asked(product, k) && self.product(product, k))
    }

    /// Whether a part is checked at state j: one of its own channels carries a message, or it has none and there is a
    /// tick.
    fn asked(&self, part: &Part, j: usize) -> bool {
        self.speaks(&own_channels(part, &self.words), j)
    }

    fn speaks(&self, own: &BTreeSet<ChannelId>, j: usize) -> bool {
        match self.states[j].kind {
            EventKind::Tick => own.is_empty(),
            EventKind::Received { channel, .. } => own.contains(channel),
        }
    }

    /// Whether the message that passes at state j, if any, satisfies the event.
    fn passes(&self, event: &formula::EventAtom, j: usize) -> bool {
        match self.states[j].kind {
            EventKind::Received { channel, message } => *channel == event.channel && event.condition.holds(message),
            EventKind::Tick => false,
        }
    }

    /// Whether there was a message on the event's channel up to state i, and the last one satisfies the event.
    fn last_satisfies(&self, event: &formula::EventAtom, i: usize) -> bool {
        let on_channel = |j: &usize| matches!(self.states[*j].kind, EventKind::Received { channel, .. } if *channel == event.channel);
        let states = 0..(i + 1).min(self.states.len());
        states.rev().find(on_channel).is_some_and(|j| self.passes(event, j))
    }

    /// Whether, in one of its turns after state i, state j is as many ticks away as the bound demands.
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
