//! Antecedents that never held: a property that demands nothing is satisfied vacuously.

use std::fmt;

use channels::{Event, EventKind, Topology};
use serde::{Deserialize, Serialize};

use crate::clause::{Literal, LiteralSet, Vocabulary, trigger};
use crate::describe;
use crate::engine::{Letter, LetterTrigger};
use crate::formula::{self, MessageCondition};
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
}

impl Watch {
    /// A watch for each clause of an outermost `always` that has an antecedent.
    pub(crate) fn of(synthesis: &Synthesis, _topology: &Topology) -> Vec<Self> {
        let always = synthesis.form.iter().filter_map(|clause| match clause.iter().collect::<Vec<_>>()[..] {
            [Literal::Release { escape, hold }] if escape.is_empty() => Some(hold),
            _ => None,
        });
        always.flatten().filter_map(|clause| Self::new(clause, synthesis)).collect()
    }

    fn new(clause: &LiteralSet, synthesis: &Synthesis) -> Option<Self> {
        let words = &synthesis.vocabulary;
        let denied = describe::denied(clause).into_iter().fold(0_u64, |bits, literal| match literal {
            // Clauses that compare values are not counted.
            Literal::Event { event, .. } if !words.names(*event).is_empty() => bits,
            Literal::Event { event, .. } => bits | 1 << event.0,
            literal => bits | synthesis.past.bit(literal).map_or(0, |(bit, _)| bit),
        });
        // A clause that only forbids, `not a` or `not (a and b)`, is tested all the time.
        let is_ban = denied.count_ones() as usize == clause.len();
        let antecedent = match clause.iter().collect::<Vec<_>>()[..] {
            _ if is_ban => return None,
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
            _ => return None,
        };
        let trigger = LetterTrigger::new(&trigger(clause, words), &synthesis.alphabet);
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
        };
    }

    /// Whether the antecedent has held.
    pub(crate) fn has_held(&self) -> bool {
        self.held
    }

    /// The clause to report if the antecedent never held.
    pub(crate) fn vacuity(&self, words: &Vocabulary, topology: &Topology) -> Option<Vacuity> {
        let antecedent = || match &self.antecedent {
            Antecedent::Events(_) => describe::antecedent(&self.clause, words, topology),
            Antecedent::Message(event) => describe::event(event, topology),
        };
        (!self.held).then(|| Vacuity {
            clause: describe::clause(&self.clause, words, topology),
            antecedent: antecedent(),
            asked: self.asked,
        })
    }
}
