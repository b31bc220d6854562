//! Conditions that never occurred: a property that demanded nothing is satisfied vacuously.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use channels::{Event, EventKind, Topology};
use serde::{Deserialize, Serialize};

use crate::clause::{Form, Literal, LiteralSet, Trigger, Vocabulary, clauses, events, products, trigger};
use crate::describe;
use crate::engine::{Bits, Letter, LetterTrigger, Memory, Obligations, Operators, State};
use crate::formula::{EventAtom, Formula, MessageCondition};
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

/// A part of a property that must hold by itself.
struct Demand {
    /// What is on the left of its implications.
    conditions: Vec<Formula>,
    what: Formula,
    /// Whether it must always hold, not only in the first state.
    is_always: bool,
}

/// Takes a formula apart: all its demands must hold.
fn demands(formula: &Formula, conditions: &[Formula], is_always: bool, found: &mut Vec<Demand>) {
    match formula {
        Formula::Timed(inside) => demands(inside, conditions, is_always, found),
        Formula::Always(inside) if conditions.is_empty() => demands(inside, conditions, true, found),
        Formula::And(parts) => parts.iter().for_each(|part| demands(part, conditions, is_always, found)),
        Formula::Implies(left, right) if **left == Formula::True => demands(right, conditions, is_always, found),
        // `e implies false` is `not e`.
        Formula::Implies(left, right) if **right == Formula::False => {
            demands(&(**left).clone().negated(), conditions, is_always, found);
        }
        Formula::Implies(left, right) => {
            let conditions: Vec<Formula> = conditions.iter().chain([&**left]).cloned().collect();
            demands(right, &conditions, is_always, found);
        }
        what => found.push(Demand { conditions: conditions.to_vec(), what: what.clone(), is_always }),
    }
}

/// Whether a clause only forbids: no event occurs in it but negated. Silence satisfies it, and not vacuously.
fn is_ban(clause: &LiteralSet) -> bool {
    clause.iter().all(|literal| mentions_only(literal, false))
}

/// Whether every event of a literal helps to meet it if it occurs (or, unless `helps`, to break it).
fn mentions_only(literal: &Literal, helps: bool) -> bool {
    let (held, forms) = match literal {
        Literal::Event { holds, .. }
        | Literal::Fresh { holds, .. }
        | Literal::Time { holds, .. }
        | Literal::Count { holds, .. } => return *holds == helps,
        Literal::Since { holds, .. } | Literal::Previous { holds, .. } => (*holds, literal.forms()),
        Literal::Next { .. } | Literal::Until { .. } | Literal::Release { .. } => (true, literal.forms()),
    };
    forms.into_iter().flatten().flatten().all(|inside| mentions_only(inside, helps == held))
}

/// Watches whether the condition of a demand occurs.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    condition: Precondition,
    /// When the demand is checked.
    trigger: LetterTrigger,
    /// Whether it is checked again and again, not only in the first state.
    is_always: bool,
    asked: u64,
    has_held: bool,
    /// The demand and its condition, in words.
    words: Arc<[String; 2]>,
}

#[derive(Clone, Debug)]
enum Precondition {
    /// The events and operators that look back which hold, and those which do not, in one of these ways.
    Holds(Vec<Bits>),
    /// Its negation, which looks ahead or compares values, and what that owes since every state in which it was
    /// checked.
    Follows(Arc<Operators>, Obligations),
    /// A message that satisfies this event: the left of an `implies` inside the clause's only event.
    Message(EventAtom),
    /// A message, so that a demand without a condition is checked at all.
    Any,
}

/// What a watch could be made of.
struct Maker<'a> {
    synthesis: &'a Synthesis,
    topology: &'a Topology,
    /// All events of the formula, those first that its clause form still contains.
    words: Vocabulary,
}

impl Maker<'_> {
    /// Whether the machine has all that a form consists of; what has been simplified away demands nothing.
    fn knows(&self, form: &Form) -> bool {
        let Synthesis { vocabulary, past, .. } = self.synthesis;
        let mut used = BTreeSet::new();
        events(form, &mut used);
        let is_known = |literal: &Literal| {
            literal.past().is_none() || past.bit(literal).is_some() || self.words.looks_back_at_values(literal)
        };
        used.iter().all(|event| (event.0 as usize) < vocabulary.len()) && form.iter().flatten().all(is_known)
    }

    fn form(&self, formula: &Formula) -> Option<Form> {
        clauses(formula, &self.words).ok().filter(|form| self.knows(form))
    }

    fn watches(&self, Demand { conditions, what, is_always }: Demand) -> Vec<Watch> {
        let Some(condition) = conditions.iter().cloned().reduce(|a, b| Formula::And(vec![a, b])) else {
            let form = self.form(&if is_always { what.always() } else { what });
            let always = form.iter().flatten().filter_map(|clause| match clause.iter().collect::<Vec<_>>()[..] {
                [Literal::Release { escape, hold }] if escape.is_empty() => Some(hold),
                _ => None,
            });
            return always.flatten().filter_map(|clause| self.unconditional(clause)).collect();
        };
        self.conditional(condition, what, is_always).into_iter().collect()
    }

    fn watch(&self, condition: Precondition, trigger: &Trigger, is_always: bool, words: [String; 2]) -> Watch {
        let trigger = LetterTrigger::new(trigger, &self.synthesis.alphabet);
        Watch { condition, trigger, is_always, asked: 0, has_held: false, words: Arc::new(words) }
    }

    /// A watch for what is demanded under a condition, even if it is a ban.
    fn conditional(&self, condition: Formula, what: Formula, is_always: bool) -> Option<Watch> {
        let Synthesis { alphabet, past, .. } = self.synthesis;
        let whole = condition.clone().implies(what);
        let form = self.form(&whole).filter(|form| !form.is_empty())?;
        let mut when = Trigger::default();
        for trigger in form.iter().map(|clause| trigger(clause, &self.words)) {
            when.channels.extend(trigger.channels);
            when.ticks |= trigger.ticks;
        }
        let ways = products(&condition, &self.words).ok().filter(|ways| self.knows(ways))?;
        let holds: Option<Vec<Bits>> = ways.iter().map(|way| past.all_bits(way)).collect();
        let kind = match holds {
            Some(ways) => Precondition::Holds(ways),
            None => {
                let negation = self.form(&condition.clone().negated())?;
                let operators = Operators::new(&negation, &self.words, alphabet, past);
                Precondition::Follows(Arc::new(operators), Obligations::met())
            }
        };
        let words = [whole, condition].map(|formula| describe::text(formula, &self.words, self.topology));
        Some(self.watch(kind, &when, is_always, words))
    }

    /// A watch for a clause that must always hold and whose condition is what it negates.
    fn unconditional(&self, clause: &LiteralSet) -> Option<Watch> {
        let Self { words, topology, synthesis } = self;
        if is_ban(clause) {
            return None;
        }
        let denied = describe::denied(clause);
        let yes = denied.iter().fold(0_u64, |bits, literal| match literal {
            // What compares values is not counted.
            Literal::Event { event, .. } if !words.names(*event).is_empty() => bits,
            Literal::Event { event, .. } => bits | 1 << event.0,
            literal => bits | synthesis.past.bit(literal).map_or(0, |(bit, _)| bit),
        });
        let trigger = trigger(clause, words);
        let (condition, named) = match clause.iter().collect::<Vec<_>>()[..] {
            _ if yes != 0 && denied.len() < clause.len() => {
                (Precondition::Holds(vec![Bits { yes, no: 0 }]), describe::antecedent(clause, yes, words, topology))
            }
            [Literal::Event { event, holds: true }] if words.names(*event).is_empty() => {
                let EventAtom { channel, condition } = words.get(*event);
                let condition = match condition {
                    MessageCondition::Implies(antecedent, _) => (**antecedent).clone(),
                    // It is about every message of the channel.
                    _ => MessageCondition::True,
                };
                let event = EventAtom { channel: *channel, condition };
                let named = describe::event(&event, topology);
                (Precondition::Message(event), named)
            }
            _ if !trigger.channels.is_empty() => {
                let any = |channel| EventAtom { channel, condition: MessageCondition::True };
                let events = trigger.channels.iter().map(|channel| describe::event(&any(*channel), topology));
                (Precondition::Any, events.collect::<Vec<_>>().join(" or "))
            }
            _ => return None,
        };
        Some(self.watch(condition, &trigger, true, [describe::clause(clause, words, topology), named]))
    }
}

impl Watch {
    /// A condition that looks ahead is not followed through more obligations than this.
    const MOST: usize = 1000;

    /// A watch for each demand that silence would meet without more ado.
    pub(crate) fn of(synthesis: &Synthesis, formula: &Formula, topology: &Topology) -> Vec<Self> {
        let maker = Maker { synthesis, topology, words: synthesis.vocabulary.with_all_of(formula) };
        let mut found = Vec::new();
        demands(formula, &[], false, &mut found);
        found.into_iter().flat_map(|demand| maker.watches(demand)).collect()
    }

    /// Processes a state, to which the memory belongs, at τ = `now`.
    pub(crate) fn see(&mut self, event: &Event, letter: Letter, memory: &Memory, now: u64) {
        if self.has_held {
            return;
        }
        let is_asked = if self.is_always { self.trigger.at(letter) } else { self.asked == 0 };
        self.asked += u64::from(is_asked);
        self.has_held = match (&mut self.condition, &event.kind) {
            (Precondition::Follows(operators, owed), _) if is_asked || !owed.is_met() => {
                let state = State::present(letter, memory, now);
                *owed = operators.step(operators.advance(std::mem::take(owed), now), state);
                if is_asked {
                    *owed = std::mem::take(owed).and(operators.begin(state));
                }
                // Beyond the limit, it is not known never to have held.
                owed.is_broken() || owed.clauses().len() > Self::MOST
            }
            (Precondition::Holds(ways), _) => is_asked && ways.iter().any(|way| way.all_hold(memory.last)),
            (Precondition::Message(event), EventKind::Received { channel, message }) => {
                event.channel == *channel && event.condition.holds(message)
            }
            (Precondition::Any, EventKind::Received { .. }) => is_asked,
            _ => false,
        };
    }

    /// Whether nothing that comes makes a difference.
    pub(crate) fn is_settled(&self) -> bool {
        let is_over = || match &self.condition {
            Precondition::Follows(_, owed) => owed.is_met(),
            _ => true,
        };
        self.has_held || (!self.is_always && self.asked > 0 && is_over())
    }

    /// The clause to report if its condition never occurred.
    pub(crate) fn vacuity(&self) -> Option<Vacuity> {
        // What is still pending of a condition counts as if the run ended now.
        let has_occurred = match &self.condition {
            Precondition::Follows(operators, owed) => self.has_held || !operators.met_at_the_end(owed),
            _ => self.has_held,
        };
        let [clause, antecedent] = &*self.words;
        let vacuity = || Vacuity { clause: clause.clone(), antecedent: antecedent.clone(), asked: self.asked };
        (!has_occurred).then(vacuity)
    }
}
