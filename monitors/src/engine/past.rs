//! The past: the operators that look back, as a state that each letter moves.
//!
//! An operator keeps how long ago its operand held, and only as precisely as its bound can distinguish. So there are
//! only finitely many memories of a past, and each determines which operators hold. To the rest of the engine, such an
//! operator is just another event.

use std::collections::BTreeSet;
use std::sync::Arc;

use channels::{ChannelId, EventKind};

use crate::clause::{EventId, Form, Literal, LiteralSet, Trigger, Vocabulary, Window, trigger};
use crate::engine::alphabet::{Alphabet, Letter};
use crate::engine::history::{Data, Known};

/// The memory that a run leaves behind. Runs with the same memory behave the same from then on.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Memory {
    /// The events that the last messages of their channels satisfy, and the operators that held in the last state.
    pub(crate) last: u64,
    /// For each window of each operator: how many ticks ago its operand held, oldest first.
    ages: Vec<Vec<u64>>,
    /// The messages, if values are compared.
    pub(super) data: Option<Box<Data>>,
}

/// When something is checked: at messages on these events' channels, and at ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LetterTrigger {
    /// The events of these channels.
    pub(crate) channels: u64,
    pub(crate) ticks: bool,
}

impl LetterTrigger {
    pub(crate) fn new(trigger: &Trigger, alphabet: &Alphabet) -> Self {
        let channels = trigger.channels.iter().fold(0, |mask, channel| mask | alphabet.mask_of(*channel));
        Self { channels, ticks: trigger.ticks }
    }

    pub(crate) fn at(self, letter: Letter) -> bool {
        if letter.is_tick() { self.ticks } else { self.channels & letter.channel != 0 }
    }

    /// The events of a part checked at these times whose last messages must be remembered, because several channels
    /// trigger it.
    pub(crate) fn remembered(self, part: &LiteralSet, words: &Vocabulary, alphabet: &Alphabet) -> u64 {
        let events = part.iter().filter_map(|literal| match literal {
            Literal::Event { event, .. } => Some(*event),
            _ => None,
        });
        let others = events.filter(|event| alphabet.mask_of(words.get(*event).channel) != self.channels);
        others.fold(0, |bits, event| bits | 1 << event.0)
    }
}

/// The operators of a formula that look back; operands precede what they are part of.
#[derive(Clone, Debug, Default)]
pub(crate) struct Past {
    operators: Vec<Operator>,
    /// Their literals, and those of the operators that compare values.
    pub(super) known: Known,
    /// The events whose last message must be remembered.
    pub(super) remembered: u64,
    /// The channels whose last messages are compared in states with other messages.
    kept: BTreeSet<ChannelId>,
}

#[derive(Clone, Debug)]
struct Operator {
    kind: PastOperator,
    windows: Vec<Window>,
}

#[derive(Clone, Debug)]
enum PastOperator {
    Since { hold: Vec<Asked>, goal: Vec<Asked> },
    Previous { trigger: LetterTrigger, clauses: Vec<Bits> },
    Count { event: u64, count: usize },
    Fresh { event: u64 },
}

#[derive(Clone, Debug)]
struct Asked {
    trigger: LetterTrigger,
    bits: Bits,
}

/// The literals of a part: what must hold, and what must not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits {
    pub(crate) yes: u64,
    pub(crate) no: u64,
}

impl Bits {
    fn of(bits: impl Iterator<Item = (u64, bool)>) -> Self {
        let mut all = Self { yes: 0, no: 0 };
        bits.for_each(|(bit, holds)| *(if holds { &mut all.yes } else { &mut all.no }) |= bit);
        all
    }

    fn one_holds(self, last: u64) -> bool {
        last & self.yes != 0 || !last & self.no != 0
    }

    pub(crate) fn all_hold(self, last: u64) -> bool {
        !last & self.yes == 0 && last & self.no == 0
    }
}

impl Past {
    /// The operators of a form.
    pub(crate) fn new(form: &Form, words: &Vocabulary, alphabet: &Alphabet) -> Self {
        let known = Known { first: words.len() as u32, words: words.clone(), ..Known::default() };
        let mut past = Self { known, ..Self::default() };
        past.collect(form, words, alphabet);
        past.keep(form);
        past
    }

    /// The number of operators.
    pub(crate) fn len(&self) -> usize {
        self.operators.len()
    }

    /// The bit of a literal, and whether the literal requires it; `None` if it does not look back.
    pub(crate) fn bit(&self, literal: &Literal) -> Option<(u64, bool)> {
        self.known.bit(literal)
    }

    /// Whether messages are kept, for operators that compare values.
    pub(crate) fn keeps_messages(&self) -> bool {
        !self.known.open.is_empty()
    }

    /// The names that an event compares with.
    pub(crate) fn names(&self, event: EventId) -> Vec<Arc<str>> {
        self.known.words.names(event)
    }

    /// For each operator, its bit, and how many states in which its operand held can explain it.
    pub(crate) fn reasons(&self) -> impl Iterator<Item = (u64, usize)> {
        self.operators.iter().enumerate().map(|(number, operator)| {
            let states = if let PastOperator::Count { count, .. } = operator.kind { count } else { 1 };
            (1 << (self.known.first + number as u32), states)
        })
    }

    /// The memory before the first state.
    pub(crate) fn memory(&self) -> Memory {
        let windows = self.operators.iter().map(|operator| operator.windows.len()).sum();
        let data = self.known.words.has_data().then(Box::default);
        Memory { last: 0, ages: vec![Vec::new(); windows], data }
    }

    /// τ grows.
    #[inline]
    pub(crate) fn advance(&self, memory: &mut Memory, by: u64) {
        if let Some(data) = &mut memory.data {
            data.now += by;
        }
        if self.operators.is_empty() {
            return;
        }
        let mut ages = memory.ages.iter_mut();
        for operator in &self.operators {
            for (window, ages) in operator.windows.iter().zip(&mut ages) {
                ages.iter_mut().for_each(|age| *age = age.saturating_add(by));
                if window.last == u64::MAX {
                    ages.iter_mut().for_each(|age| *age = (*age).min(window.first));
                } else {
                    ages.retain(|age| *age <= window.last);
                }
            }
        }
    }

    /// Processes a state: `last` becomes what holds in it. Returns the operators whose operand holds in it.
    #[inline]
    pub(crate) fn read(&self, memory: &mut Memory, letter: Letter, kind: Option<&EventKind>) -> u64 {
        memory.last = letter.after(memory.last);
        let begun = if self.operators.is_empty() { 0 } else { self.look_back(memory, letter) };
        if let Some(data) = &mut memory.data {
            data.read(memory.last, kind, &self.known);
        }
        begun
    }

    #[inline(never)]
    fn look_back(&self, memory: &mut Memory, letter: Letter) -> u64 {
        memory.last &= (1 << self.known.first) - 1;
        let mut begun = 0;
        let mut rest = &mut memory.ages[..];
        for (number, operator) in self.operators.iter().enumerate() {
            let ages;
            (ages, rest) = rest.split_at_mut(operator.windows.len());
            let (holds, begins) = operator.read(ages, memory.last, letter);
            memory.last |= u64::from(holds) << (self.known.first + number as u32);
            begun |= u64::from(begins) << (self.known.first + number as u32);
        }
        begun
    }

    fn collect(&mut self, form: &Form, words: &Vocabulary, alphabet: &Alphabet) {
        for literal in form.iter().flatten() {
            if literal.past().is_some() && words.looks_back_at_values(literal) {
                self.known.open.extend(literal.past().map(|(literal, _)| literal));
                literal.forms().into_iter().for_each(|inside| self.collect(inside, words, alphabet));
                continue;
            }
            literal.forms().into_iter().for_each(|inside| self.collect(inside, words, alphabet));
            let Some((literal, _)) = literal.past().filter(|(literal, _)| !self.known.literals.contains(literal))
            else {
                continue;
            };
            let operator = self.operator(&literal, words, alphabet);
            self.operators.extend(operator);
            self.known.literals.push(literal);
        }
    }

    fn keep(&mut self, form: &Form) {
        let channels = Trigger::of(form.iter(), &self.known.words).channels;
        if channels.len() > 1 {
            self.kept.extend(channels);
        }
        let literals = form.iter().flatten();
        literals.flat_map(Literal::forms).for_each(|inside| self.keep(inside));
    }

    /// Forgets the messages that make no difference.
    pub(crate) fn forget(&self, memory: &mut Memory) {
        if let Some(data) = &mut memory.data {
            data.normalize(&self.kept);
        }
    }

    fn operator(&mut self, literal: &Literal, words: &Vocabulary, alphabet: &Alphabet) -> Option<Operator> {
        let (kind, bound) = match literal {
            Literal::Fresh { event, .. } => {
                return Some(Operator { kind: PastOperator::Fresh { event: 1 << event.0 }, windows: Vec::new() });
            }
            Literal::Since { hold, goal, bound, .. } => {
                let [hold, goal] = [hold, goal].map(|form| self.asked(form, words, alphabet));
                (PastOperator::Since { hold, goal }, *bound)
            }
            Literal::Previous { clauses, bound, .. } => {
                let trigger = LetterTrigger::new(&Trigger::of(clauses.iter(), words), alphabet);
                for clause in clauses {
                    self.remembered |= trigger.remembered(clause, words, alphabet);
                }
                (
                    PastOperator::Previous {
                        trigger,
                        clauses: clauses.iter().map(|clause| self.bits(clause)).collect(),
                    },
                    *bound,
                )
            }
            Literal::Count { event, count, bound, .. } => {
                let count = usize::try_from(*count).unwrap_or(usize::MAX);
                (PastOperator::Count { event: 1 << event.0, count }, *bound)
            }
            _ => return None,
        };
        Some(Operator { kind, windows: bound.windows().collect() })
    }

    fn asked(&mut self, form: &Form, words: &Vocabulary, alphabet: &Alphabet) -> Vec<Asked> {
        let parts = form.iter().map(|part| {
            let trigger = LetterTrigger::new(&trigger(part, words), alphabet);
            self.remembered |= trigger.remembered(part, words, alphabet);
            Asked { trigger, bits: self.bits(part) }
        });
        parts.collect()
    }

    fn bits(&self, part: &LiteralSet) -> Bits {
        Bits::of(part.iter().filter_map(|literal| self.bit_now(literal)))
    }

    /// The literals of a part; `None` if one of them looks ahead or compares values.
    pub(crate) fn all_bits(&self, part: &LiteralSet) -> Option<Bits> {
        let bits: Option<Vec<(u64, bool)>> = part.iter().map(|literal| self.bit_now(literal)).collect();
        Some(Bits::of(bits?.into_iter()))
    }

    fn bit_now(&self, literal: &Literal) -> Option<(u64, bool)> {
        match literal {
            Literal::Event { event, holds } => {
                self.known.words.names(*event).is_empty().then_some((1 << event.0, *holds))
            }
            literal => self.bit(literal),
        }
    }
}

impl Operator {
    /// Whether it holds in a state, given `last`, the bits of what else holds there, and whether its operand holds.
    fn read(&self, ages: &mut [Vec<u64>], last: u64, letter: Letter) -> (bool, bool) {
        let within = |ages: &[Vec<u64>]| {
            let mut windows = self.windows.iter().zip(ages);
            windows.any(|(window, ages)| ages.iter().any(|age| (window.first..=window.last).contains(age)))
        };
        match &self.kind {
            PastOperator::Since { hold, goal } => {
                // First what must hold since then, and then the goal: where the goal holds, the other need not.
                if hold.iter().any(|part| part.trigger.at(letter) && !part.bits.one_holds(last)) {
                    ages.iter_mut().for_each(Vec::clear);
                }
                let begins = goal.iter().any(|part| part.trigger.at(letter) && part.bits.all_hold(last));
                if begins {
                    self.windows.iter().zip(&mut *ages).for_each(|(window, ages)| begin(*window, ages));
                }
                (within(ages), begins)
            }
            PastOperator::Previous { trigger, clauses } => {
                // What held before this state, which is then kept for the next one.
                let held = within(ages);
                let holds = clauses.iter().all(|clause| clause.one_holds(last));
                if trigger.at(letter) {
                    ages.iter_mut().for_each(|ages| *ages = if holds { vec![0] } else { Vec::new() });
                }
                (held, trigger.at(letter) && holds)
            }
            PastOperator::Count { event, count } => {
                let passes = letter.satisfied & event != 0;
                for ages in ages.iter_mut().filter(|_| passes) {
                    ages.push(0);
                    ages.drain(..ages.len().saturating_sub(*count));
                }
                (ages.iter().map(Vec::len).sum::<usize>() >= *count, passes)
            }
            PastOperator::Fresh { event } => (letter.satisfied & event != 0, letter.satisfied & event != 0),
        }
    }
}

/// The operand holds now. Only what the window can distinguish is kept: the last time, if it begins now; the first, if
/// it has no end; otherwise all.
fn begin(window: Window, ages: &mut Vec<u64>) {
    if window.first == 0 {
        ages.clear();
    }
    if window.last != u64::MAX && ages.last() != Some(&0) || ages.is_empty() {
        ages.push(0);
    }
}
