//! Messages that are kept because values are compared: the last one on each channel, and those of the states that an
//! operator that looks back may still ask for.

use std::collections::BTreeSet;

use channels::{ChannelId, EventKind, Message};

use crate::clause::{EventId, Form, Literal, LiteralSet, Trigger, Vocabulary, trigger};
use crate::data::{Remembered, Values};
use crate::formula::Bound;

/// The operators of a formula that look back, as their literals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    pub(super) words: Vocabulary,
    /// Those that a bit represents: each holds or does not.
    pub(super) literals: Vec<Literal>,
    /// The bit of the first of them, which follows that of the last event.
    pub(super) first: u32,
    /// Those that compare values, for which messages are kept.
    pub(super) open: Vec<Literal>,
}

impl Known {
    /// The bit of a literal, and whether the literal requires it; `None` if it has no bit.
    pub(crate) fn bit(&self, literal: &Literal) -> Option<(u64, bool)> {
        let (literal, holds) = literal.past()?;
        let place = self.literals.iter().position(|known| *known == literal)?;
        Some((1 << (self.first + place as u32), holds))
    }
}

/// The messages of a run, as far as they matter.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Data {
    /// τ
    pub(crate) now: u64,
    /// The states that an operator may still ask for, and the current one.
    moments: Vec<Moment>,
}

/// A state of the run.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Moment {
    /// τ
    at: u64,
    /// A tick, or a message on this channel.
    channel: Option<ChannelId>,
    /// The events and operators that hold, without those that compare values.
    last: u64,
    /// The last message on each channel.
    messages: Vec<(ChannelId, Message)>,
}

impl Moment {
    fn message(&self, channel: ChannelId) -> Option<&Message> {
        self.messages.iter().find(|(known, _)| *known == channel).map(|(_, message)| message)
    }

    fn is_triggered(&self, trigger: &Trigger) -> bool {
        self.channel.map_or(trigger.ticks, |channel| trigger.channels.contains(&channel))
    }
}

impl Data {
    /// Processes a state, and forgets those that no operator will ask for.
    #[inline(never)]
    pub(super) fn read(&mut self, last: u64, kind: Option<&EventKind>, known: &Known) {
        let mut messages = self.moments.last().map(|moment| moment.messages.clone()).unwrap_or_default();
        let mut channel = None;
        if let Some(EventKind::Received { channel: own, message }) = kind {
            match messages.iter_mut().find(|(known, _)| known == own) {
                Some((_, known)) => known.clone_from(message),
                None => messages.push((*own, message.clone())),
            }
            channel = Some(*own);
        }
        self.forget(known);
        self.moments.push(Moment { at: self.now, channel, last, messages });
    }

    /// Keeps the states within the bounds of the operators that look back; and the last state at which a `previous`
    /// without a bound was checked, however long ago, with those that the operators inside it look back on from there.
    fn forget(&mut self, known: &Known) {
        let moments = &self.moments;
        let within = |horizon: Option<u64>, from: u64| {
            moments.partition_point(|moment| horizon.is_none_or(|horizon| from.saturating_sub(moment.at) > horizon))
        };
        let mut kept = vec![false; moments.len()];
        kept[within(known.open.iter().filter_map(horizon).max(), self.now)..].fill(true);
        for literal in &known.open {
            if let Literal::Previous { clauses, .. } = literal {
                let trigger = Trigger::of(clauses.iter(), &known.words);
                if let Some(before) = moments.iter().rposition(|moment| moment.is_triggered(&trigger)) {
                    let first = within(horizon_inside(literal), moments[before].at);
                    kept[first.min(before)..=before].fill(true);
                }
            }
        }
        let mut kept = kept.into_iter();
        self.moments.retain(|_| kept.next().unwrap_or(false));
    }

    fn present(&self) -> usize {
        self.moments.len() - 1
    }

    /// Whether this state's message is the event.
    pub(super) fn passes(&self, event: EventId, values: &Values, known: &Known) -> bool {
        self.passes_at(event, values, self.present(), known)
    }

    /// Whether a literal holds in this state: an event, or an operator that looks back.
    pub(super) fn holds_now(&self, literal: &Literal, values: &Values, known: &Known) -> bool {
        self.literal(literal, values, self.present(), known)
    }

    /// The values, with those that are remembered in this state.
    pub(super) fn remembered(&self, remembered: &[Remembered], values: &Values) -> Values {
        values.with(remembered, |channel| self.moments[self.present()].message(channel))
    }

    fn passes_at(&self, event: EventId, values: &Values, i: usize, known: &Known) -> bool {
        let (moment, event) = (&self.moments[i], known.words.get(event));
        moment.channel == Some(event.channel)
            && moment.message(event.channel).is_some_and(|message| event.condition.holds_with(message, values))
    }

    /// Whether a literal held in state i, by the definition.
    fn literal(&self, literal: &Literal, values: &Values, i: usize, known: &Known) -> bool {
        let ago = |j: usize, bound: &Bound| {
            let ticks = self.moments[i].at - self.moments[j].at;
            bound.windows().any(|window| (window.first..=window.last).contains(&ticks))
        };
        if let Some((bit, holds)) = known.bit(literal) {
            return (self.moments[i].last & bit != 0) == holds;
        }
        match literal {
            Literal::Event { event, holds } => {
                let event = known.words.get(*event);
                let last = self.moments[i].message(event.channel);
                last.is_some_and(|message| event.condition.holds_with(message, values)) == *holds
            }
            Literal::Fresh { event, holds } => self.passes_at(*event, values, i, known) == *holds,
            Literal::Since { hold, goal, bound, holds } => {
                let kept = |k: usize| self.asked(hold, k, known).all(|part| self.clause(part, values, k, known));
                let begun = |j: usize| self.asked(goal, j, known).any(|part| self.product(part, values, j, known));
                // Going back from now, the first state that decides.
                let decides = |j: usize| match (begun(j) && ago(j, bound), kept(j)) {
                    (false, true) => None,
                    (since, _) => Some(since),
                };
                (0..=i).rev().find_map(decides).unwrap_or(false) == *holds
            }
            Literal::Previous { clauses, bound, holds } => {
                let trigger = Trigger::of(clauses.iter(), &known.words);
                let before = (0..i).rev().find(|j| self.moments[*j].is_triggered(&trigger));
                let held = |j: usize| clauses.iter().all(|clause| self.clause(clause, values, j, known));
                before.is_some_and(|j| ago(j, bound) && held(j)) == *holds
            }
            Literal::Count { event, count, bound, holds } => {
                let passed = (0..=i).filter(|j| ago(*j, bound) && self.passes_at(*event, values, *j, known));
                (passed.count() as u64 >= *count) == *holds
            }
            _ => false,
        }
    }

    fn asked<'f>(&self, form: &'f Form, k: usize, known: &'f Known) -> impl Iterator<Item = &'f LiteralSet> {
        let moment = &self.moments[k];
        form.iter().filter(move |part| moment.is_triggered(&trigger(part, &known.words)))
    }

    fn clause(&self, clause: &LiteralSet, values: &Values, i: usize, known: &Known) -> bool {
        let values = values.with(&known.words.remembered(clause), |channel| self.moments[i].message(channel));
        clause.iter().any(|literal| self.literal(literal, &values, i, known))
    }

    fn product(&self, product: &LiteralSet, values: &Values, i: usize, known: &Known) -> bool {
        let values = values.with(&known.words.remembered(product), |channel| self.moments[i].message(channel));
        product.iter().all(|literal| self.literal(literal, &values, i, known))
    }

    /// Forgets how the state was reached, and all messages but those on these channels.
    pub(super) fn normalize(&mut self, kept: &BTreeSet<ChannelId>) {
        let mut messages = self.moments.pop().map(|moment| moment.messages).unwrap_or_default();
        messages.retain(|(channel, _)| kept.contains(channel));
        messages.sort_by_key(|(channel, _)| *channel);
        self.now = 0;
        self.moments = vec![Moment { at: 0, channel: None, last: 0, messages }];
    }
}

/// The maximum number of ticks that an operator looks back.
fn horizon(literal: &Literal) -> Option<u64> {
    let own = match literal {
        Literal::Since { bound, .. } | Literal::Previous { bound, .. } => bound.end().filter(|end| *end < u64::MAX),
        Literal::Count { bound, .. } => Some(bound.ticks),
        _ => None,
    };
    let inside = horizon_inside(literal);
    own.map(|own| own.saturating_add(inside.unwrap_or(0))).or(inside)
}

/// The maximum number of ticks that the operators inside an operator look back.
fn horizon_inside(literal: &Literal) -> Option<u64> {
    literal.forms().into_iter().flatten().flatten().filter_map(horizon).max()
}
