//! The explicit automaton of a formula: all states of its obligations, computed before the run.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

use channels::Verdict;

use crate::engine::alphabet::{Alphabet, Letter, Symbol};
use crate::engine::anticipation::{Anticipation, Lasso, TooManyWays};
use crate::engine::obligations::{Clause, Obligations};
use crate::engine::operators::Operators;
use crate::engine::past::Memory;
use crate::engine::progression::Progression;
use crate::engine::situation::Situation;
use crate::engine::table::TransitionTable;

pub(crate) type StateNumber = u16;

/// The target of symbols that no message within its channel's domain has.
const NOWHERE: StateNumber = StateNumber::MAX;

/// The automaton of a formula would have too many states or continuations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooManyStates;

impl From<TooManyWays> for TooManyStates {
    fn from(_: TooManyWays) -> Self {
        Self
    }
}

/// All states that a formula's obligations can reach, with the verdict in each.
///
/// A state is settled as soon as all endless words lead to the same outcome: anticipation is exact. In a word, τ grows
/// by one at each tick and nowhere else; only the first tick may leave it unchanged. (A state that is reachable by
/// messages alone may recur after ticks. The automaton then assumes another tick that may leave τ unchanged, which no
/// run has; a verdict that depends on it comes late.)
#[derive(Clone, Debug)]
pub(crate) struct Automaton {
    /// Where each symbol leads from each state.
    table: TransitionTable<StateNumber>,
    /// The meaning of each state: obligations (none yet at the start) and memory.
    meanings: Vec<Meaning>,
    verdicts: Vec<Verdict>,
    holds: Vec<bool>,
    /// Whether the same is owed at the same ticks of the run once time has passed.
    lasts: Vec<bool>,
    /// Which states are reachable by messages alone.
    before_ticks: Vec<bool>,
    symbols: u16,
}

impl Automaton {
    /// The automaton, within the alphabet's limits.
    pub(crate) fn new(operators: &Operators, alphabet: &Alphabet) -> Result<Self, TooManyStates> {
        let symbols = alphabet.symbols.ok_or(TooManyStates)?;
        let explorer = Explorer { operators, alphabet, known: HashMap::new(), meanings: Vec::new() };
        let (table, meanings) = explorer.explore(TransitionTable::new(symbols))?;
        let holds: Vec<bool> = meanings
            .iter()
            .map(|(owed, _)| {
                owed.as_ref().map_or_else(|| operators.holds_on_nothing(), |owed| operators.met_at_the_end(owed))
            })
            .collect();
        let lasts = |(owed, _): &Meaning| owed.as_ref().is_some_and(|owed| operators.advance(owed.clone(), 1) == *owed);
        let lasts = meanings.iter().map(lasts).collect();
        let (verdicts, before_ticks) = (Vec::new(), Vec::new());
        let mut automaton = Self { table, meanings, verdicts, holds, lasts, before_ticks, symbols };
        automaton.before_ticks = automaton.before_ticks();
        automaton.verdicts = automaton.anticipate(operators, alphabet)?;
        Ok(automaton)
    }

    /// The verdict in each state, from the states reachable from it.
    fn anticipate(&self, operators: &Operators, alphabet: &Alphabet) -> Result<Vec<Verdict>, TooManyWays> {
        let satisfiable = self.possible(true, operators, alphabet)?;
        let violable = self.possible(false, operators, alphabet)?;
        let verdict = |(satisfiable, violable): (bool, bool)| match (satisfiable, violable) {
            (true, true) => Verdict::Inconclusive,
            (true, false) => Verdict::True,
            _ => Verdict::False,
        };
        Ok(satisfiable.into_iter().zip(violable).map(verdict).collect())
    }

    /// The states from which some endless word satisfies (or violates) the formula.
    ///
    /// Silence is such a word: if the formula holds now, or at a state that can be reached, the question is settled.
    /// This usually leaves few states to examine.
    fn possible(&self, outcome: bool, operators: &Operators, alphabet: &Alphabet) -> Result<Vec<bool>, TooManyWays> {
        let mut possible: Vec<bool> = self.holds.iter().map(|holds| *holds == outcome).collect();
        self.spread(&mut possible);
        let left: Vec<usize> = (0..self.len()).filter(|state| !possible[*state]).collect();
        let (states, owed): (Vec<usize>, Vec<_>) = left
            .into_iter()
            .filter_map(|state| self.meanings[state].0.as_ref().map(|owed| (state, (owed, &self.meanings[state].1))))
            .unzip();
        let found = Anticipation::new(operators, alphabet, outcome).possible(&owed)?;
        states.into_iter().zip(found).for_each(|(state, found)| possible[state] = found);
        self.spread(&mut possible);
        Ok(possible)
    }

    /// If an outcome is possible in a state, it is possible in its predecessors.
    fn spread(&self, possible: &mut [bool]) {
        let mut before: Vec<Vec<StateNumber>> = vec![Vec::new(); self.len()];
        for (from, to) in (0..self.len()).flat_map(|from| self.moves(from).map(move |(_, to)| (from, to))) {
            before[to].push(from as StateNumber);
        }
        let mut open: Vec<usize> = (0..self.len()).filter(|state| possible[*state]).collect();
        while let Some(state) = open.pop() {
            for from in before[state].iter().map(|from| usize::from(*from)) {
                if !std::mem::replace(&mut possible[from], true) {
                    open.push(from);
                }
            }
        }
    }

    /// Which states are reachable by messages alone, so that the first tick can occur there.
    fn before_ticks(&self) -> Vec<bool> {
        let mut reached = vec![false; self.len()];
        let mut open = vec![0];
        while let Some(state) = open.pop() {
            if !std::mem::replace(&mut reached[state], true) {
                let messages = self.successors(state).filter(|(symbol, _)| symbol.0 >= Symbol::MESSAGES);
                open.extend(messages.map(|(_, to)| to));
            }
        }
        reached
    }

    fn moves(&self, state: usize) -> impl Iterator<Item = (Symbol, usize)> {
        self.successors(state).filter(move |(symbol, _)| match *symbol {
            Symbol::ADVANCE => false,
            Symbol::TICK => self.before_ticks[state],
            _ => true,
        })
    }

    fn is_broken(&self, state: StateNumber) -> bool {
        self.meanings[usize::from(state)].0.as_ref().is_some_and(Obligations::is_broken)
    }

    pub(crate) fn len(&self) -> usize {
        self.meanings.len()
    }

    pub(crate) fn verdict(&self, state: usize) -> Verdict {
        self.verdicts[state]
    }

    /// Whether the formula holds on a run that ends in this state.
    pub(crate) fn holds(&self, state: usize) -> bool {
        self.holds[state]
    }

    pub(crate) fn successors(&self, state: usize) -> impl Iterator<Item = (Symbol, usize)> {
        (0..self.symbols).map(Symbol).filter_map(move |symbol| Some((symbol, self.successor(state, symbol)?)))
    }

    /// The successor of a state for a symbol; `None` for messages outside the domains.
    pub(crate) fn successor(&self, state: usize, symbol: Symbol) -> Option<usize> {
        let next = self.table.get(state as StateNumber, symbol);
        (next != NOWHERE).then_some(usize::from(next))
    }

    /// An endless word from a state on which the formula holds, or does not.
    fn lasso(&self, state: usize, outcome: bool, operators: &Operators, alphabet: &Alphabet) -> Option<Lasso> {
        let (owed, last) = &self.meanings[state];
        Anticipation::new(operators, alphabet, outcome).lasso(owed.as_ref()?, last).ok()?
    }

    /// A shortest path from a state to the first state in which something is found, and what was found.
    fn path<T>(
        &self,
        start: usize,
        may: impl Fn(Symbol) -> bool,
        found: impl Fn(usize) -> Option<T>,
    ) -> Option<(T, Vec<Symbol>)> {
        let mut came: Vec<Option<(usize, Symbol)>> = vec![None; self.len()];
        let mut queue = VecDeque::from([start]);
        while let Some(state) = queue.pop_front() {
            if let Some(found) = found(state) {
                let back = std::iter::successors(Some(state), |state| came[*state].map(|(from, _)| from));
                let mut path: Vec<Symbol> = back.filter_map(|state| came[state].map(|(_, symbol)| symbol)).collect();
                path.reverse();
                return Some((found, path));
            }
            for (symbol, to) in self.moves(state).filter(|(symbol, _)| may(*symbol)) {
                if came[to].is_none() && to != start {
                    came[to] = Some((state, symbol));
                    queue.push_back(to);
                }
            }
        }
        None
    }
}

type Meaning = (Option<Obligations>, Memory);

struct Explorer<'a> {
    operators: &'a Operators,
    alphabet: &'a Alphabet,
    known: HashMap<Meaning, StateNumber>,
    meanings: Vec<Meaning>,
}

impl Explorer<'_> {
    fn explore(
        mut self,
        mut table: TransitionTable<StateNumber>,
    ) -> Result<(TransitionTable<StateNumber>, Vec<Meaning>), TooManyStates> {
        let letters: Vec<(Symbol, Letter)> = self
            .alphabet
            .letters()
            .map(|(letter, ..)| (self.alphabet.symbol(letter), letter))
            .chain([(Symbol::TICK, Letter::TICK)])
            .collect();
        self.number((None, self.operators.memory()))?;
        let mut state: StateNumber = 0;
        while usize::from(state) < self.meanings.len() {
            table.push_row(NOWHERE);
            let (owed, memory) = self.meanings[usize::from(state)].clone();
            let later = owed.clone().map(|owed| self.operators.advance(owed, 1).shifted(1));
            let mut older = memory.clone();
            self.operators.age(&mut older, 1);
            table.set(state, Symbol::ADVANCE, self.number((later, older))?);
            for (symbol, letter) in &letters {
                let next = self.after(owed.clone(), memory.clone(), *letter);
                table.set(state, *symbol, self.number(next)?);
            }
            state += 1;
        }
        // Time passes, and then there is a tick: two transitions at once, for which all others have to be known.
        for state in 0..state {
            let later = table.get(state, Symbol::ADVANCE);
            table.set(state, Symbol::NEXT_TICK, table.get(later, Symbol::TICK));
        }
        Ok((table, self.meanings))
    }

    fn after(&self, owed: Option<Obligations>, mut memory: Memory, letter: Letter) -> Meaning {
        let state = self.operators.read(&mut memory, letter, None, 0);
        let owed = match owed {
            None => self.operators.begin(state),
            Some(owed) => self.operators.step(owed, state),
        };
        self.operators.forget(&mut memory);
        (Some(owed), memory)
    }

    fn number(&mut self, (owed, memory): Meaning) -> Result<StateNumber, TooManyStates> {
        if owed.as_ref().is_some_and(|owed| owed.clauses().len() > self.alphabet.limits.clauses) {
            return Err(TooManyStates);
        }
        let settled = owed.as_ref().is_some_and(|owed| owed.is_met() || owed.is_broken());
        let meaning = (owed, if settled { self.operators.memory() } else { memory });
        if let Some(number) = self.known.get(&meaning) {
            return Ok(*number);
        }
        if self.meanings.len() >= self.alphabet.limits.automaton_states.min(usize::from(NOWHERE)) {
            return Err(TooManyStates);
        }
        let number = self.meanings.len() as StateNumber;
        self.meanings.push(meaning.clone());
        self.known.insert(meaning, number);
        Ok(number)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct AutomatonRun {
    automaton: Arc<Automaton>,
    operators: Arc<Operators>,
    state: StateNumber,
    now: u64,
    /// Whether there was a tick.
    has_ticked: bool,
    /// Used after a message outside its channel's domain: the automaton has no transition for it, so progression takes
    /// over.
    detour: Option<Progression>,
    /// Whether something else is owed than when that was last asked.
    owes_anew: bool,
    /// The clause whose deadline passed before it was met.
    missed: Option<Clause>,
}

impl AutomatonRun {
    pub(crate) fn new(automaton: Arc<Automaton>, operators: Arc<Operators>) -> Self {
        let (has_ticked, detour, missed) = (false, None, None);
        Self { automaton, operators, state: 0, now: 0, has_ticked, detour, owes_anew: true, missed }
    }

    pub(crate) fn state(&self) -> Option<usize> {
        self.detour.is_none().then_some(usize::from(self.state))
    }

    /// An endless word that continues from here and on which the formula holds, or does not.
    pub(crate) fn lasso(&self, outcome: bool, alphabet: &Alphabet) -> Option<Lasso> {
        let word = |state: usize| self.automaton.lasso(state, outcome, &self.operators, alphabet);
        let may = |symbol: Symbol| symbol != Symbol::TICK || !self.has_ticked;
        let automaton = &self.automaton;
        let silent = |state: usize| (automaton.holds[state] == outcome).then(Lasso::default);
        let (end, mut stem) =
            automaton.path(self.state()?, may, silent).or_else(|| automaton.path(self.state()?, may, word))?;
        stem.extend(end.0);
        Some((stem, end.1))
    }

    /// Sets τ to `now`. Returns whether a deadline has passed unmet.
    #[inline]
    pub(crate) fn advance(&mut self, now: u64) -> bool {
        if let Some(detour) = &mut self.detour {
            return detour.advance(now);
        }
        let mut is_late = false;
        while self.now < now {
            let next = self.automaton.table.get(self.state, Symbol::ADVANCE);
            if !self.automaton.lasts[usize::from(self.state)] {
                self.owes_anew = true;
                if self.automaton.is_broken(next) {
                    is_late = true;
                    self.miss();
                }
            }
            self.now = if next == self.state { now } else { self.now + 1 };
            self.state = next;
        }
        is_late
    }

    #[cold]
    fn miss(&mut self) {
        self.missed = self.meaning().0.and_then(|owed| owed.ending_by(self.now).cloned());
    }

    /// Processes a state with this letter.
    #[inline]
    pub(crate) fn read(&mut self, letter: Letter, alphabet: &Alphabet) {
        if let Some(detour) = &mut self.detour {
            return detour.read(letter, None);
        }
        self.has_ticked |= letter.is_tick();
        let symbol = alphabet.symbol(letter);
        let next = self.automaton.table.get(self.state, symbol);
        self.owes_anew |= next != self.state;
        if next == NOWHERE {
            self.leave(letter);
        } else {
            self.state = next;
        }
    }

    /// Whether something else is owed, at the ticks of the run, than when this was last asked.
    pub(crate) fn owes_anew(&mut self) -> bool {
        std::mem::take(&mut self.owes_anew) || self.detour.is_some()
    }

    #[cold]
    fn leave(&mut self, letter: Letter) {
        let (owed, memory) = self.meaning();
        let mut detour = Progression::resume(Arc::clone(&self.operators), owed, memory, self.now);
        detour.read(letter, None);
        self.detour = Some(detour);
    }

    /// The obligations in this state, in ticks of the run.
    fn meaning(&self) -> Meaning {
        let (owed, memory) = &self.automaton.meanings[usize::from(self.state)];
        (owed.as_ref().map(|owed| owed.at(self.now)), memory.clone())
    }

    /// The clause whose deadline passed before it was met, if that is why the formula is false.
    pub(crate) fn missed(&self) -> Option<&Clause> {
        match &self.detour {
            Some(detour) => detour.missed.as_ref(),
            None => self.missed.as_ref(),
        }
    }

    /// The obligations, and the tick of the run from which they are counted.
    pub(crate) fn owed(&self) -> Option<(&Obligations, u64)> {
        match &self.detour {
            Some(detour) => detour.owed(),
            None => Some((self.automaton.meanings[usize::from(self.state)].0.as_ref()?, self.now)),
        }
    }

    /// Resets τ to 0, and forgets what explains a verdict.
    pub(crate) fn normalize(&mut self) {
        (self.now, self.has_ticked, self.missed) = (0, true, None);
        self.detour.iter_mut().for_each(Progression::normalize);
    }

    /// The state that determines how it continues.
    pub(crate) fn situation(&self) -> Situation<'_> {
        match &self.detour {
            Some(detour) => detour.situation(),
            None => Situation::Automaton(self.state),
        }
    }

    pub(crate) fn verdict(&self) -> Verdict {
        match &self.detour {
            Some(detour) => detour.verdict(),
            None => self.automaton.verdicts[usize::from(self.state)],
        }
    }

    pub(crate) fn holds(&self) -> bool {
        match &self.detour {
            Some(detour) => detour.holds(),
            None => self.automaton.holds[usize::from(self.state)],
        }
    }
}
