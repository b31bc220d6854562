//! Antecedents that never held: a property that demands nothing is satisfied vacuously.

use std::fmt;

use channels::{ChannelId, Event, EventKind, Topology};
use serde::{Deserialize, Serialize};

use crate::clause::{Literal, LiteralSet, Vocabulary, trigger};
use crate::describe;
use crate::engine::{Letter, LetterTrigger};
use crate::formula::{self, Formula, MessageCondition};
use crate::synthesis::Synthesis;

/// A clause of a property whose antecedent never held, so that it demanded nothing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Vacuity {
    /// The clause, in the SCOPE language.
    pub clause: String,
    /// Its antecedent.
    pub antecedent: String,
    /// The number of states in which the clause was checked.
    pub asked: u64,
}

impl fmt::Display for Vacuity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "vacuously satisfied: {} never occurred", self.antecedent)
    }
}

/// The events on the left of implications that must always hold.
fn antecedents<'a>(formula: &'a Formula, found: &mut Vec<&'a formula::EventAtom>) {
    match formula {
        Formula::Timed(inside) | Formula::Always(inside) => antecedents(inside, found),
        Formula::And(parts) => parts.iter().for_each(|part| antecedents(part, found)),
        Formula::Implies(left, right) => {
            left.own_events(&mut |event| found.push(event));
            antecedents(right, found);
        }
        _ => {}
    }
}

/// Watches whether the antecedent of a clause holds.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    clause: LiteralSet,
    antecedent: Antecedent,
    /// When the clause is checked.
    trigger: LetterTrigger,
    asked: u64,
    held: bool,
}

#[derive(Clone, Debug)]
enum Antecedent {
    /// All of these events and operators that look back.
    Events(u64),
    /// A message that satisfies this event: any on the channel of the clause's only event, or the left of an `implies`
    /// inside it.
    Message(formula::EventAtom),
    /// A message on one of these channels, so that the clause is checked at all.
    Any(Vec<ChannelId>),
}

impl Watch {
    /// A watch for each clause of an outermost `always` that has an antecedent.
    pub(crate) fn of(synthesis: &Synthesis, formula: &Formula) -> Vec<Self> {
        let mut conditions = Vec::new();
        antecedents(formula, &mut conditions);
        let always = synthesis.form.iter().filter_map(|clause| match clause.iter().collect::<Vec<_>>()[..] {
            [Literal::Release { escape, hold }] if escape.is_empty() => Some(hold),
            _ => None,
        });
        always.flatten().filter_map(|clause| Self::new(clause, &conditions, synthesis)).collect()
    }

    /// `conditions` are the events on the left of the formula's implications.
    fn new(clause: &LiteralSet, conditions: &[&formula::EventAtom], synthesis: &Synthesis) -> Option<Self> {
        let words = &synthesis.vocabulary;
        let denied = describe::denied(clause).into_iter().fold(0_u64, |bits, literal| match literal {
            // Clauses that compare values are not counted.
            Literal::Event { event, .. } if !words.names(*event).is_empty() => bits,
            Literal::Event { event, .. } => bits | 1 << event.0,
            literal => bits | synthesis.past.bit(literal).map_or(0, |(bit, _)| bit),
        });
        // A clause that only forbids, `not a` or `not (a and b)`, is tested all the time: silence keeps it. But `a
        // implies not b` is about what comes after an a.
        let is_ban = denied.count_ones() as usize == clause.len();
        let trigger = trigger(clause, words);
        let antecedent = match clause.iter().collect::<Vec<_>>()[..] {
            _ if is_ban => {
                let is_condition =
                    |bit: &u64| words.ids().any(|id| *bit == 1 << id.0 && conditions.contains(&words.get(id)));
                let bits = (0..u64::BITS).map(|bit| 1 << bit).filter(|bit| denied & bit != 0);
                let (condition, banned): (Vec<u64>, Vec<u64>) = bits.partition(is_condition);
                if condition.is_empty() || banned.is_empty() {
                    return None;
                }
                Antecedent::Events(condition.into_iter().fold(0, |all, bit| all | bit))
            }
            _ if denied != 0 => Antecedent::Events(denied),
            [Literal::Event { event, holds: true }] if words.names(*event).is_empty() => {
                let formula::EventAtom { channel, condition } = words.get(*event);
                let condition = match condition {
                    MessageCondition::Implies(antecedent, _) => (**antecedent).clone(),
                    // It is about every message of the channel.
                    _ => MessageCondition::True,
                };
                Antecedent::Message(formula::EventAtom { channel: *channel, condition })
            }
            _ if !trigger.ticks => Antecedent::Any(trigger.channels.iter().copied().collect()),
            _ => return None,
        };
        let trigger = LetterTrigger::new(&trigger, &synthesis.alphabet);
        Some(Self { clause: clause.clone(), antecedent, trigger, asked: 0, held: false })
    }

    /// Processes a state. `last` is the set of events that the last messages satisfy.
    pub(crate) fn see(&mut self, event: &Event, letter: Letter, last: u64) {
        if self.held || !self.trigger.at(letter) {
            return;
        }
        self.asked += 1;
        self.held = match (&self.antecedent, &event.kind) {
            (Antecedent::Events(events), _) => last & events == *events,
            (Antecedent::Message(event), EventKind::Received { channel, message }) => {
                event.channel == *channel && event.condition.holds(message)
            }
            (Antecedent::Message(_), EventKind::Tick) => false,
            (Antecedent::Any(_), _) => true,
        };
    }

    /// Whether the antecedent has held.
    pub(crate) fn has_held(&self) -> bool {
        self.held
    }

    /// The clause to report if the antecedent never held.
    pub(crate) fn vacuity(&self, words: &Vocabulary, topology: &Topology) -> Option<Vacuity> {
        let antecedent = || match &self.antecedent {
            Antecedent::Events(events) => describe::antecedent(&self.clause, *events, words, topology),
            Antecedent::Any(channels) => {
                let any = |channel| formula::EventAtom { channel, condition: MessageCondition::True };
                let events = channels.iter().map(|channel| describe::event(&any(*channel), topology));
                events.collect::<Vec<_>>().join(" or ")
            }
            Antecedent::Message(event) => describe::event(event, topology),
        };
        (!self.held).then(|| Vacuity {
            clause: describe::clause(&self.clause, words, topology),
            antecedent: antecedent(),
            asked: self.asked,
        })
    }
}
