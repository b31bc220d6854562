//! The meaning of a formula on a finite sequence, written out: the slow and plain definition that everything else is
//! held against.

use channels::{Event, EventKind};

use crate::clause::{
    Form, Literal, Part, TooManyParts, Vocabulary, Window, clauses, own_channels, own_channels_of_all,
};
use crate::formula::{self, Formula};

/// Whether a formula holds on a recorded sequence as it stands, by the definition in the [crate documentation](crate).
///
/// Takes time in the square of the sequence's length, and more with nested operators: it is there to be right.
///
/// # Errors
/// [`FormulaTooLarge`] if the formula's clause form has more than two thousand parts.
pub fn holds(formula: &Formula, sequence: &[Event]) -> Result<bool, FormulaTooLarge> {
    let words = Vocabulary::of(formula);
    let channels = words.channels();
    let seen = sequence.iter().filter(|event| match &event.kind {
        EventKind::Tick => true,
        EventKind::Received { channel, .. } => channels.contains(channel),
    });
    let form = clauses(formula, &words)?;
    let oracle = Oracle { words, sequence: seen.collect() };
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

struct Oracle<'a> {
    words: Vocabulary,
    /// The ticks, and the messages on channels that the formula mentions.
    sequence: Vec<&'a Event>,
}

impl Oracle<'_> {
    fn clause(&self, clause: &Part, i: usize) -> bool {
        clause.iter().any(|literal| self.literal(literal, i))
    }

    fn product(&self, product: &Part, i: usize) -> bool {
        product.iter().all(|literal| self.literal(literal, i))
    }

    /// Whether a literal holds at state i, which need not be there: then nothing comes any more.
    fn literal(&self, literal: &Literal, i: usize) -> bool {
        let n = self.sequence.len();
        match literal {
            Literal::Event { event, holds } => self.last_satisfies(self.words.get(*event), i) == *holds,
            Literal::Time { event, window, holds } => {
                (i..n).any(|j| self.passes(self.words.get(*event), j) && self.within(*window, i, j)) == *holds
            }
            Literal::Next { clauses, strong } => {
                let own = own_channels_of_all(clauses, &self.words);
                let next = (i + 1..n).find(|j| self.speaks(&own, *j));
                next.map_or(!strong, |j| clauses.iter().all(|clause| self.clause(clause, j)))
            }
            Literal::Until { hold, goal } => (i..n).any(|j| {
                let reached = goal.iter().any(|product| self.asked(product, j) && self.product(product, j));
                reached && (i..j).all(|k| self.all_asked_hold(hold, k))
            }),
            Literal::Release { escape, hold } => (i..n).all(|j| {
                let escaped = |k| escape.iter().any(|product| self.asked(product, k) && self.product(product, k));
                self.all_asked_hold(hold, j) || (i..j).any(escaped)
            }),
        }
    }

    fn all_asked_hold(&self, clauses: &Form, k: usize) -> bool {
        clauses.iter().all(|clause| !self.asked(clause, k) || self.clause(clause, k))
    }

    /// Whether a part is asked at state j: one of its own channels speaks, or it has none and there is a tick.
    fn asked(&self, part: &Part, j: usize) -> bool {
        self.speaks(&own_channels(part, &self.words), j)
    }

    fn speaks(&self, own: &std::collections::BTreeSet<channels::ChannelId>, j: usize) -> bool {
        match &self.sequence[j].kind {
            EventKind::Tick => own.is_empty(),
            EventKind::Received { channel, .. } => own.contains(channel),
        }
    }

    /// Whether the message that passes at state j, if any, satisfies the event.
    fn passes(&self, event: &formula::Event, j: usize) -> bool {
        match &self.sequence[j].kind {
            EventKind::Received { channel, message } => *channel == event.channel && event.condition.holds(message),
            EventKind::Tick => false,
        }
    }

    /// Whether there was a message on the event's channel up to state i, and the last one satisfies the event.
    fn last_satisfies(&self, event: &formula::Event, i: usize) -> bool {
        let on_channel = |j: &usize| matches!(&self.sequence[*j].kind, EventKind::Received { channel, .. } if *channel == event.channel);
        let states = 0..(i + 1).min(self.sequence.len());
        states.rev().find(on_channel).is_some_and(|j| self.passes(event, j))
    }

    fn within(&self, window: Window, i: usize, j: usize) -> bool {
        let elapsed = self.sequence[j].tick - self.sequence[i].tick;
        (window.first..=window.last).contains(&elapsed)
    }
}
