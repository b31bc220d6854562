//! The operators of a formula, and how they carry obligations from one state to the next.

use crate::clause::{Bound, EventId, Form, Literal, Part, Vocabulary, own_channels, own_channels_of_all};
use crate::engine::alphabet::{Alphabet, Letter};
use crate::engine::obligations::{Obligation, Obligations};

/// A state of the run, as the operators see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    /// What happened in it.
    pub(crate) letter: Letter,
    /// The events that the last messages of their channels satisfy, including this state's message.
    pub(crate) last: u64,
    /// τ
    pub(crate) now: u64,
}

/// When something is checked: at messages on these events' channels; at ticks if there are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Clock(u64);

impl Clock {
    fn strikes(self, letter: Letter) -> bool {
        if letter.is_tick() { self.0 == 0 } else { self.0 & letter.channel != 0 }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Asked {
    clock: Clock,
    literals: Vec<Compiled>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Compiled {
    Event { bit: u64, holds: bool },
    Time { event: EventId, bound: Bound, holds: bool },
    Operator(u32),
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Operator {
    Next { clock: Clock, clauses: Vec<Vec<Compiled>>, strong: bool },
    Until { hold: Vec<Asked>, goal: Vec<Asked> },
    Release { escape: Vec<Asked>, hold: Vec<Asked> },
}

/// A formula split into its operators.
#[derive(Clone, Debug)]
pub(crate) struct Operators {
    operators: Vec<Operator>,
    /// The literals of the operators.
    literals: Vec<Literal>,
    /// The clauses that hold at the first state.
    root: Vec<Vec<Compiled>>,
    /// The events whose last message matters in states with a message on another channel.
    remembered: u64,
}

impl Operators {
    pub(crate) fn new(form: &Form, vocabulary: &Vocabulary, alphabet: &Alphabet) -> Self {
        let mut compiler = Compiler { vocabulary, alphabet, known: Vec::new(), operators: Vec::new(), remembered: 0 };
        let root = compiler.parts(form);
        Self { root, remembered: compiler.remembered, operators: compiler.operators, literals: compiler.known }
    }

    /// The literal of an operator.
    pub(crate) fn literal_of(&self, operator: u32) -> &Literal {
        &self.literals[operator as usize]
    }

    /// The events whose last message must be remembered.
    pub(crate) fn remembered(&self) -> u64 {
        self.remembered
    }

    /// The obligations after the first state.
    pub(crate) fn begin(&self, state: State) -> Obligations {
        self.all(&self.root, state)
    }

    /// The obligations after the next state, if these were the obligations before it.
    pub(crate) fn step(&self, obligations: Obligations, state: State) -> Obligations {
        obligations.replace(|obligation| match *obligation {
            Obligation::Goes(operator) => self.unfold(operator, state),
            Obligation::Waits(operator) => match &self.operators[operator as usize] {
                Operator::Next { clock, clauses, .. } if clock.strikes(state.letter) => Some(self.all(clauses, state)),
                _ => None,
            },
            Obligation::Passes { event, holds, first, .. } => {
                let passes = first <= state.now && state.letter.satisfied & (1 << event.0) != 0;
                passes.then(|| Obligations::constant(holds))
            }
        })
    }

    /// The obligations when τ becomes `now`: windows begin and end.
    pub(crate) fn advance(&self, obligations: Obligations, now: u64) -> Obligations {
        obligations.replace(|obligation| match *obligation {
            Obligation::Passes { holds, last, .. } if last < now => Some(Obligations::constant(!holds)),
            Obligation::Passes { event, holds, first, last } if first != 0 && first <= now => {
                Some(Obligations::one(Obligation::Passes { event, holds, first: 0, last }))
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
            Obligation::Goes(operator) | Obligation::Waits(operator) => match &self.operators[operator as usize] {
                Operator::Next { strong, .. } => !strong,
                Operator::Until { .. } => false,
                Operator::Release { .. } => true,
            },
            Obligation::Passes { holds, .. } => !holds,
        }
    }

    /// Whether a letter checks an obligation that waits for a message on its own channels.
    pub(crate) fn is_asked(&self, operator: u32, letter: Letter) -> bool {
        match &self.operators[operator as usize] {
            Operator::Next { clock, .. } => clock.strikes(letter),
            Operator::Until { .. } | Operator::Release { .. } => false,
        }
    }

    /// The obligation that the root continues, if it consists of operators that do.
    pub(crate) fn going(&self) -> Obligations {
        let goes = |literal: &Compiled| match literal {
            Compiled::Operator(operator) => Obligations::one(Obligation::Goes(*operator)),
            Compiled::Event { .. } | Compiled::Time { .. } => Obligations::broken(),
        };
        let clause = |clause: &Vec<Compiled>| clause.iter().map(goes).fold(Obligations::broken(), Obligations::or);
        self.root.iter().map(clause).fold(Obligations::met(), Obligations::and)
    }

    /// Whether the root holds on the empty run.
    pub(crate) fn holds_on_nothing(&self) -> bool {
        let holds = |literal: &Compiled| match literal {
            Compiled::Event { holds, .. } | Compiled::Time { holds, .. } => !holds,
            Compiled::Operator(operator) => self.met_by_silence(&Obligation::Goes(*operator)),
        };
        self.root.iter().all(|clause| clause.iter().any(holds))
    }

    fn all(&self, clauses: &[Vec<Compiled>], state: State) -> Obligations {
        clauses.iter().fold(Obligations::met(), |all, clause| all.and(self.clause(clause, state)))
    }

    fn clause(&self, clause: &[Compiled], state: State) -> Obligations {
        clause.iter().fold(Obligations::broken(), |any, literal| any.or(self.literal(*literal, state)))
    }

    fn product(&self, product: &[Compiled], state: State) -> Obligations {
        product.iter().fold(Obligations::met(), |all, literal| all.and(self.literal(*literal, state)))
    }

    fn literal(&self, literal: Compiled, state: State) -> Obligations {
        match literal {
            Compiled::Event { bit, holds } => Obligations::constant((state.last & bit != 0) == holds),
            Compiled::Time { event, bound, holds } => {
                let passes = state.letter.satisfied & (1 << event.0) != 0;
                let windows = bound.windows().map(|window| {
                    if window.first == 0 && passes {
                        return Obligations::constant(holds);
                    }
                    let first = if window.first == 0 { 0 } else { state.now.saturating_add(window.first) };
                    let last = state.now.saturating_add(window.last);
                    Obligations::one(Obligation::Passes { event, holds, first, last })
                });
                let combine: fn(_, _) -> _ = if holds { Obligations::or } else { Obligations::and };
                windows.fold(Obligations::constant(!holds), combine)
            }
            Compiled::Operator(operator) => match self.operators[operator as usize] {
                Operator::Next { .. } => Obligations::one(Obligation::Waits(operator)),
                _ => self.unfold(operator, state).unwrap_or_else(|| Obligations::one(Obligation::Goes(operator))),
            },
        }
    }

    /// The obligation of an `until` or a release from this state on; `None` if it is only itself, as in states that
    /// concern none of its parts.
    fn unfold(&self, operator: u32, state: State) -> Option<Obligations> {
        let struck = |parts: &[Asked]| parts.iter().any(|part| part.clock.strikes(state.letter));
        let asked = |parts: &[Asked]| -> Vec<usize> {
            (0..parts.len()).filter(|part| parts[*part].clock.strikes(state.letter)).collect()
        };
        let later = || Obligations::one(Obligation::Goes(operator));
        let all = |hold: &[Asked]| {
            asked(hold)
                .into_iter()
                .fold(Obligations::met(), |all, part| all.and(self.clause(&hold[part].literals, state)))
        };
        let any = |goal: &[Asked]| {
            asked(goal)
                .into_iter()
                .fold(Obligations::broken(), |any, part| any.or(self.product(&goal[part].literals, state)))
        };
        match &self.operators[operator as usize] {
            Operator::Until { hold, goal } if struck(hold) || struck(goal) => {
                Some(any(goal).or(all(hold).and(later())))
            }
            Operator::Release { escape, hold } if struck(escape) || struck(hold) => {
                Some(all(hold).and(any(escape).or(later())))
            }
            _ => None,
        }
    }
}

struct Compiler<'a> {
    vocabulary: &'a Vocabulary,
    alphabet: &'a Alphabet,
    known: Vec<Literal>,
    operators: Vec<Operator>,
    remembered: u64,
}

impl Compiler<'_> {
    fn parts(&mut self, form: &Form) -> Vec<Vec<Compiled>> {
        form.iter().map(|part| part.iter().map(|literal| self.literal(literal)).collect()).collect()
    }

    fn asked(&mut self, form: &Form) -> Vec<Asked> {
        let parts = form.iter().map(|part| {
            let clock = self.clock(own_channels(part, self.vocabulary));
            self.remember(clock, part);
            Asked { clock, literals: part.iter().map(|literal| self.literal(literal)).collect() }
        });
        parts.collect()
    }

    fn clock(&self, channels: impl IntoIterator<Item = channels::ChannelId>) -> Clock {
        Clock(channels.into_iter().fold(0, |mask, channel| mask | self.alphabet.mask_of(channel)))
    }

    /// A part that several channels trigger needs the last messages of the others.
    fn remember(&mut self, clock: Clock, part: &Part) {
        for literal in part {
            if let Literal::Event { event, .. } = literal {
                let own = self.alphabet.mask_of(self.vocabulary.get(*event).channel);
                self.remembered |= if own == clock.0 { 0 } else { 1 << event.0 };
            }
        }
    }

    fn literal(&mut self, literal: &Literal) -> Compiled {
        match literal {
            Literal::Event { event, holds } => Compiled::Event { bit: 1 << event.0, holds: *holds },
            Literal::Time { event, bound, holds } => Compiled::Time { event: *event, bound: *bound, holds: *holds },
            operator => Compiled::Operator(self.operator(operator)),
        }
    }

    fn operator(&mut self, literal: &Literal) -> u32 {
        if let Some(known) = self.known.iter().position(|known| known == literal) {
            return known as u32;
        }
        let operator = match literal {
            Literal::Next { clauses, strong } => {
                let clock = self.clock(own_channels_of_all(clauses, self.vocabulary));
                clauses.iter().for_each(|clause| self.remember(clock, clause));
                Operator::Next { clock, clauses: self.parts(clauses), strong: *strong }
            }
            Literal::Until { hold, goal } => Operator::Until { hold: self.asked(hold), goal: self.asked(goal) },
            Literal::Release { escape, hold } => {
                Operator::Release { escape: self.asked(escape), hold: self.asked(hold) }
            }
            Literal::Event { .. } | Literal::Time { .. } => unreachable!("atoms are no operators"),
        };
        // The parts of an operator may be operators themselves and precede it.
        self.known.push(literal.clone());
        self.operators.push(operator);
        (self.operators.len() - 1) as u32
    }
}
