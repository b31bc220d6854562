//! The operators of a formula, and how they carry obligations from one state to the next.

use std::sync::Arc;

use channels::{EventKind, Relation};
use smallvec::SmallVec;

use crate::clause::{EventId, Form, Literal, LiteralSet, Trigger, Vocabulary, trigger};
use crate::data::{Remembered, Values};
use crate::engine::alphabet::{Alphabet, Letter};
use crate::engine::history::Data;
use crate::engine::obligations::{Obligation, Obligations};
use crate::engine::past::{LetterTrigger, Memory, Past};
use crate::formula::Bound;

/// The messages that would answer an obligation, each with the values that it compares with.
pub(crate) type Awaited = SmallVec<[(EventId, Values); 1]>;

/// A state of the run, as the operators see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<'m> {
    /// What happened in it.
    pub(crate) letter: Letter,
    /// The events that the last messages of their channels satisfy, including this state's message, and the operators
    /// that look back and hold.
    pub(crate) last: u64,
    /// τ
    pub(crate) now: u64,
    /// The messages, if values are compared.
    data: Option<&'m Data>,
}

impl<'m> State<'m> {
    /// The state to which the memory belongs.
    pub(crate) fn present(letter: Letter, memory: &'m Memory, now: u64) -> Self {
        Self { letter, last: memory.last, now, data: memory.data.as_deref() }
    }

    /// The state without the memory, unless values are compared.
    pub(crate) fn without_memory(self) -> Option<State<'static>> {
        let Self { letter, last, now, data } = self;
        data.is_none().then_some(State { letter, last, now, data: None })
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Asked {
    trigger: LetterTrigger,
    part: CompiledPart,
}

/// A part, and what it remembers when it is checked.
#[derive(Clone, Debug, PartialEq, Eq)]
struct CompiledPart {
    literals: Vec<Compiled>,
    remembered: Vec<Remembered>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Compiled {
    /// An event, or an operator that looks back, that compares values: its index in `open`.
    Open {
        number: u32,
        holds: bool,
    },
    /// An event, or an operator that looks back.
    Event {
        bit: u64,
        holds: bool,
    },
    Time {
        event: EventId,
        bound: Bound,
        holds: bool,
        /// Whether the property is timed and has `<`.
        before: bool,
    },
    Operator(u32),
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Operator {
    Next { trigger: LetterTrigger, clauses: Vec<CompiledPart>, strong: bool },
    Until { hold: Vec<Asked>, goal: Vec<Asked> },
    Release { escape: Vec<Asked>, hold: Vec<Asked> },
}

/// A formula split into its operators.
#[derive(Clone, Debug)]
pub(crate) struct Operators {
    operators: Vec<Operator>,
    literals: Vec<Literal>,
    /// The clauses that hold at the first state.
    root: Vec<CompiledPart>,
    /// The literals that compare values.
    open: Vec<Literal>,
    /// For each operator, the names that it compares with.
    names: Vec<Vec<Arc<str>>>,
    /// The events whose last message matters in states with a message on another channel.
    remembered: u64,
    /// The events that have windows.
    awaited: u64,
    past: Arc<Past>,
}

impl Operators {
    /// `past` contains at least the operators of the form that look back.
    pub(crate) fn new(form: &Form, vocabulary: &Vocabulary, alphabet: &Alphabet, past: &Arc<Past>) -> Self {
        let remembered = past.remembered;
        let (known, operators, open) = (Vec::new(), Vec::new(), Vec::new());
        let mut compiler = Compiler { vocabulary, alphabet, past, known, operators, open, remembered, awaited: 0 };
        let root = compiler.parts(form);
        let Compiler { known: literals, operators, open, remembered, awaited, .. } = compiler;
        let names = literals.iter().map(|literal| vocabulary.free(literal)).collect();
        Self { root, remembered, awaited, operators, literals, open, names, past: Arc::clone(past) }
    }

    pub(crate) fn literal_of(&self, operator: u32) -> &Literal {
        &self.literals[operator as usize]
    }

    pub(crate) fn contain(&self, literal: &Literal) -> bool {
        self.literals.contains(literal)
    }

    /// The memory before the first state.
    pub(crate) fn memory(&self) -> Memory {
        self.past.memory()
    }

    /// The state that a letter leads to, to which the memory then belongs.
    pub(crate) fn read<'m>(
        &self,
        memory: &'m mut Memory,
        letter: Letter,
        kind: Option<&EventKind>,
        now: u64,
    ) -> State<'m> {
        self.past.read(memory, letter, kind);
        State::present(letter, memory, now)
    }

    /// Updates the memory when τ grows.
    pub(crate) fn age(&self, memory: &mut Memory, by: u64) {
        self.past.advance(memory, by);
    }

    /// Forgets what makes no difference.
    pub(crate) fn forget(&self, memory: &mut Memory) {
        memory.last &= self.remembered;
        self.past.forget(memory);
    }

    /// The obligations after the first state.
    pub(crate) fn begin(&self, state: State<'_>) -> Obligations {
        self.all(&self.root, state, &Values::default())
    }

    /// The obligations after the next state, if these were the obligations before it.
    pub(crate) fn step(&self, obligations: Obligations, state: State<'_>) -> Obligations {
        obligations.replace(|obligation| match obligation {
            Obligation::Goes(operator, values) => self.unfold(*operator, state, values),
            Obligation::Waits(operator, values) => match &self.operators[*operator as usize] {
                Operator::Next { trigger, clauses, .. } if trigger.at(state.letter) => {
                    Some(self.all(clauses, state, values))
                }
                _ => None,
            },
            Obligation::Passes { event, holds, first, values, .. } => {
                let passes = *first <= state.now && self.passes(*event, state, values);
                passes.then(|| Obligations::constant(*holds))
            }
        })
    }

    /// Whether the state may change any obligations of these operators.
    pub(crate) fn are_triggered(&self, state: State<'_>) -> bool {
        // What compares values has no bit for whether it holds.
        let passed = if state.data.is_some() { state.letter.channel } else { state.letter.satisfied };
        passed & self.awaited != 0
            || (0..self.operators.len()).any(|operator| self.is_triggered(operator as u32, state.letter))
    }

    pub(crate) fn concerns(&self, obligations: &Obligations, state: State<'_>) -> bool {
        obligations.clauses().iter().flatten().any(|obligation| match obligation {
            Obligation::Goes(operator, _) | Obligation::Waits(operator, _) => {
                self.is_triggered(*operator, state.letter)
            }
            Obligation::Passes { event, first, values, .. } => {
                *first <= state.now && self.passes(*event, state, values)
            }
        })
    }

    /// The events for which the root's own literals wait in this state, each with the values that it compares with.
    pub(crate) fn answers(&self, state: State<'_>) -> Awaited {
        let mut answers = Awaited::new();
        for clause in &self.root {
            let values = state.remembered(clause, &Values::default());
            answers.extend(clause.literals.iter().filter_map(|literal| match *literal {
                Compiled::Time { event, holds: true, .. } => Some((event, self.values_of(event, state, &values))),
                _ => None,
            }));
        }
        answers
    }

    /// Those of the values that an event compares with.
    fn values_of(&self, event: EventId, state: State<'_>, values: &Values) -> Values {
        if state.data.is_some() { values.only(&self.past.names(event)) } else { Values::default() }
    }

    /// Whether the state's message satisfies the event.
    pub(crate) fn passes(&self, event: EventId, state: State<'_>, values: &Values) -> bool {
        match state.data {
            Some(data) => data.passes(event, values, &self.past.known),
            None => state.letter.satisfied & (1 << event.0) != 0,
        }
    }

    /// The obligations when τ becomes `now`: windows begin and end.
    pub(crate) fn advance(&self, obligations: Obligations, now: u64) -> Obligations {
        obligations.replace(|obligation| match obligation {
            Obligation::Passes { holds, last, .. } if *last < now => Some(Obligations::constant(!holds)),
            Obligation::Passes { first, last, .. } if *first != 0 && *first <= now => {
                Some(Obligations::one(obligation.within(0, *last)))
            }
            _ => None,
        })
    }

    /// Whether obligations are met if nothing follows: an obligation that stays open counts as false, its negation as
    /// true.
    pub(crate) fn met_at_the_end(&self, obligations: &Obligations) -> bool {
        obligations.clauses().iter().all(|clause| clause.iter().any(|obligation| self.met_by_silence(obligation)))
    }

    /// Whether an obligation is met if nothing follows.
    pub(crate) fn met_by_silence(&self, obligation: &Obligation) -> bool {
        match *obligation {
            Obligation::Goes(operator, _) | Obligation::Waits(operator, _) => {
                match &self.operators[operator as usize] {
                    Operator::Next { strong, .. } => !strong,
                    Operator::Until { .. } => false,
                    Operator::Release { .. } => true,
                }
            }
            Obligation::Passes { holds, .. } => !holds,
        }
    }

    /// Whether a letter checks an obligation that waits for a message on its own channels.
    pub(crate) fn is_asked(&self, operator: u32, letter: Letter) -> bool {
        match &self.operators[operator as usize] {
            Operator::Next { trigger, .. } => trigger.at(letter),
            Operator::Until { .. } | Operator::Release { .. } => false,
        }
    }

    /// The obligation that the root's operators continue; its other literals count as broken.
    pub(crate) fn going(&self) -> Obligations {
        let goes = |literal: &Compiled| match literal {
            Compiled::Operator(operator) => Obligations::one(Obligation::Goes(*operator, Values::default())),
            _ => Obligations::broken(),
        };
        let clause =
            |clause: &CompiledPart| clause.literals.iter().map(goes).fold(Obligations::broken(), Obligations::or);
        self.root.iter().map(clause).fold(Obligations::met(), Obligations::and)
    }

    /// Whether the root holds on the empty run.
    pub(crate) fn holds_on_nothing(&self) -> bool {
        let holds = |literal: &Compiled| match literal {
            Compiled::Event { holds, .. } | Compiled::Time { holds, .. } | Compiled::Open { holds, .. } => !holds,
            Compiled::Operator(operator) => self.met_by_silence(&Obligation::Goes(*operator, Values::default())),
        };
        self.root.iter().all(|clause| clause.literals.iter().any(holds))
    }

    /// Whether a letter checks a part of an operator.
    fn is_triggered(&self, operator: u32, letter: Letter) -> bool {
        let at = |parts: &[Asked]| parts.iter().any(|part| part.trigger.at(letter));
        match &self.operators[operator as usize] {
            Operator::Next { trigger, .. } => trigger.at(letter),
            Operator::Until { hold, goal } => at(hold) || at(goal),
            Operator::Release { escape, hold } => at(escape) || at(hold),
        }
    }

    fn all(&self, clauses: &[CompiledPart], state: State<'_>, values: &Values) -> Obligations {
        let clauses = clauses.iter().map(|clause| self.clause(clause, state, values));
        clauses.reduce(Obligations::and).unwrap_or_default()
    }

    fn clause(&self, clause: &CompiledPart, state: State<'_>, values: &Values) -> Obligations {
        // Mostly, an event settles it; one that does not hold adds nothing.
        let holds = |literal: &Compiled| match *literal {
            Compiled::Event { bit, holds } => Some((state.last & bit != 0) == holds),
            _ => None,
        };
        if clause.literals.iter().any(|literal| holds(literal) == Some(true)) {
            return Obligations::met();
        }
        let values = &state.remembered(clause, values);
        let open = clause.literals.iter().filter(|literal| holds(literal).is_none());
        let open = open.map(|literal| self.literal(*literal, state, values));
        open.reduce(Obligations::or).unwrap_or_else(Obligations::broken)
    }

    fn product(&self, product: &CompiledPart, state: State<'_>, values: &Values) -> Obligations {
        let values = &state.remembered(product, values);
        product.literals.iter().fold(Obligations::met(), |all, literal| all.and(self.literal(*literal, state, values)))
    }

    fn literal(&self, literal: Compiled, state: State<'_>, values: &Values) -> Obligations {
        match literal {
            Compiled::Event { bit, holds } => Obligations::constant((state.last & bit != 0) == holds),
            Compiled::Open { number, holds } => {
                let open = &self.open[number as usize];
                let is_so = state.data.is_some_and(|data| data.holds_now(open, values, &self.past.known));
                Obligations::constant(is_so == holds)
            }
            Compiled::Time { event, bound, holds, before } => {
                self.awaited((event, bound, before), holds, state, values)
            }
            Compiled::Operator(operator) => {
                let values = values.only(&self.names[operator as usize]);
                match self.operators[operator as usize] {
                    Operator::Next { .. } => Obligations::one(Obligation::Waits(operator, values)),
                    _ => {
                        let unfolded = self.unfold(operator, state, &values);
                        unfolded.unwrap_or_else(|| Obligations::one(Obligation::Goes(operator, values)))
                    }
                }
            }
        }
    }

    /// The obligation that an event passes within a bound, or that it does not. In each window it may; without the
    /// event, all windows must stay empty.
    fn awaited(
        &self,
        (event, bound, before): (EventId, Bound, bool),
        holds: bool,
        state: State<'_>,
        values: &Values,
    ) -> Obligations {
        let passes = self.passes(event, state, values);
        let values = self.values_of(event, state, values);
        let windows = bound.windows().map(|window| {
            if window.first == 0 && passes {
                return Obligations::constant(holds);
            }
            let first = if window.first == 0 { 0 } else { state.now.saturating_add(window.first) };
            let last = state.now.saturating_add(window.last);
            Obligations::one(Obligation::Passes { event, holds, first, last, before, values: values.clone() })
        });
        let combine: fn(_, _) -> _ = if holds { Obligations::or } else { Obligations::and };
        windows.reduce(combine).unwrap_or_else(|| Obligations::constant(!holds))
    }

    /// The obligation of an `until` or a release from this state on; `None` if it is only itself, as in states that
    /// concern none of its parts.
    fn unfold(&self, operator: u32, state: State<'_>, values: &Values) -> Option<Obligations> {
        if !self.is_triggered(operator, state.letter) {
            return None;
        }
        let is_asked = |asked: &&Asked| asked.trigger.at(state.letter);
        let later = || Obligations::one(Obligation::Goes(operator, values.clone()));
        let all = |hold: &[Asked]| {
            let hold = hold.iter().filter(is_asked).map(|asked| self.clause(&asked.part, state, values));
            hold.fold(Obligations::met(), Obligations::and)
        };
        let any = |goal: &[Asked]| {
            let goal = goal.iter().filter(is_asked).map(|asked| self.product(&asked.part, state, values));
            goal.fold(Obligations::broken(), Obligations::or)
        };
        // The expansion laws: α until β is β ∨ (α ∧ ○(α until β)), and release is its dual. Parts that this state does
        // not trigger neither hold nor fail here.
        match &self.operators[operator as usize] {
            Operator::Until { hold, goal } => Some(any(goal).or(all(hold).and(later()))),
            Operator::Release { escape, hold } => Some(all(hold).and(any(escape).or(later()))),
            Operator::Next { .. } => None,
        }
    }
}

impl State<'_> {
    /// The values, with those that are remembered here.
    fn remembered(&self, part: &CompiledPart, values: &Values) -> Values {
        match self.data {
            Some(data) => data.remembered(&part.remembered, values),
            None => Values::default(),
        }
    }
}

struct Compiler<'a> {
    vocabulary: &'a Vocabulary,
    alphabet: &'a Alphabet,
    past: &'a Past,
    known: Vec<Literal>,
    operators: Vec<Operator>,
    open: Vec<Literal>,
    remembered: u64,
    awaited: u64,
}

impl Compiler<'_> {
    fn parts(&mut self, form: &Form) -> Vec<CompiledPart> {
        form.iter().map(|part| self.part(part)).collect()
    }

    fn part(&mut self, part: &LiteralSet) -> CompiledPart {
        let remembered = self.vocabulary.remembered(part);
        CompiledPart { literals: part.iter().map(|literal| self.literal(literal)).collect(), remembered }
    }

    fn asked(&mut self, form: &Form) -> Vec<Asked> {
        let parts = form.iter().map(|part| {
            let trigger = LetterTrigger::new(&trigger(part, self.vocabulary), self.alphabet);
            self.remember(trigger, part);
            Asked { trigger, part: self.part(part) }
        });
        parts.collect()
    }

    fn remember(&mut self, trigger: LetterTrigger, part: &LiteralSet) {
        self.remembered |= trigger.remembered(part, self.vocabulary, self.alphabet);
    }

    fn literal(&mut self, literal: &Literal) -> Compiled {
        match literal {
            Literal::Event { event, holds } if !self.vocabulary.names(*event).is_empty() => {
                self.open(Literal::Event { event: *event, holds: true }, *holds)
            }
            Literal::Event { event, holds } => Compiled::Event { bit: 1 << event.0, holds: *holds },
            Literal::Time { event, bound, holds } => {
                self.awaited |= 1 << event.0;
                let before = self.vocabulary.is_timed && bound.relation == Relation::Less;
                Compiled::Time { event: *event, bound: *bound, holds: *holds, before }
            }
            literal => match (self.past.bit(literal), literal.past()) {
                (Some((bit, holds)), _) => Compiled::Event { bit, holds },
                (None, Some((open, holds))) => self.open(open, holds),
                (None, None) => Compiled::Operator(self.operator(literal)),
            },
        }
    }

    fn open(&mut self, literal: Literal, holds: bool) -> Compiled {
        self.open.push(literal);
        Compiled::Open { number: (self.open.len() - 1) as u32, holds }
    }

    fn operator(&mut self, literal: &Literal) -> u32 {
        if let Some(known) = self.known.iter().position(|known| known == literal) {
            return known as u32;
        }
        let operator = match literal {
            Literal::Next { clauses, strong } => {
                let trigger = LetterTrigger::new(&Trigger::of(clauses.iter(), self.vocabulary), self.alphabet);
                clauses.iter().for_each(|clause| self.remember(trigger, clause));
                Operator::Next { trigger, clauses: self.parts(clauses), strong: *strong }
            }
            Literal::Until { hold, goal } => Operator::Until { hold: self.asked(hold), goal: self.asked(goal) },
            Literal::Release { escape, hold } => {
                Operator::Release { escape: self.asked(escape), hold: self.asked(hold) }
            }
            _ => unreachable!("atoms are not operators that look ahead"),
        };
        // Nested operators precede the operator that contains them.
        self.known.push(literal.clone());
        self.operators.push(operator);
        (self.operators.len() - 1) as u32
    }
}
