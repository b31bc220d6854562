//! Turns a formula into its monitor.

use std::sync::Arc;

use channels::{EventKind, Topology, Verdict};

use crate::clause::{Form, Vocabulary, always, is_prompt, normal_form};
use crate::engine::{
    Alphabet, Automaton, AutomatonRun, Clause, Compact, CompactRun, Letter, Limits, MAX_EVENTS, Memory, Obligations,
    Operators, Past, Progression, Situation,
};
use crate::formula::{Formula, FormulaError};

/// The kind of machine that monitors a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// A program graph with at most one number per clause: safety and bounded response. Time and memory do not depend
    /// on θ, and verdicts come as early as possible.
    Graph,
    /// Like [`Method::Graph`], for several clauses with deadlines whose automaton would be too large, or for conditions
    /// whose combinations are too many: late when two of them contradict each other.
    Graphs,
    /// An explicit automaton: verdicts come as early as possible.
    Automaton {
        /// The number of its states.
        states: usize,
    },
    /// Rules over the past, time or several values, which have no graph: a violation comes as early as possible. That
    /// nothing can violate the formula any more is noticed only at the end of the run.
    Rules,
    /// Progression of the formula: never wrong, but late when two obligations contradict each other.
    Progression,
}

/// The machines to choose from. They differ only in how early their verdicts come; this choice lets tests compare them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Choice {
    /// The best one for the formula.
    #[default]
    Best,
    /// An automaton, or progression if it would be too large.
    Automaton,
    /// Progression.
    Progression,
}

impl Method {
    /// Whether each verdict comes in the first state in which no continuation can change it.
    #[must_use]
    pub fn anticipates(self) -> bool {
        matches!(self, Self::Graph | Self::Automaton { .. })
    }

    /// Whether a violation is noticed in the first state in which no continuation can change it.
    #[must_use]
    pub fn is_prompt(self) -> bool {
        self.anticipates() || self == Self::Rules
    }
}

/// Everything that is computed about a formula before a run.
#[derive(Clone, Debug)]
pub(crate) struct Synthesis {
    pub(crate) form: Form,
    pub(crate) vocabulary: Vocabulary,
    pub(crate) alphabet: Alphabet,
    pub(crate) past: Arc<Past>,
    pub(crate) operators: Arc<Operators>,
    machine: Machine,
    /// The clauses as rules with a deadline each, if they have that form; they provide the words for explanations.
    pub(crate) rules: Option<Arc<Compact>>,
}

#[derive(Clone, Debug)]
enum Machine {
    Compact(Arc<Compact>),
    Automaton(Arc<Automaton>),
    Progression,
}

impl Synthesis {
    /// A machine for a formula, with the given choice and within these limits.
    pub(crate) fn new(
        formula: &Formula,
        topology: &Topology,
        choice: Choice,
        limits: Limits,
    ) -> Result<Self, FormulaError> {
        let (form, vocabulary) = normal_form(formula)?;
        if vocabulary.len() > MAX_EVENTS {
            return Err(FormulaError::TooLarge);
        }
        let alphabet = Alphabet::new(&vocabulary, topology, limits);
        let past = Arc::new(Past::new(&form, &vocabulary, &alphabet));
        if vocabulary.len() + past.len() > MAX_EVENTS {
            return Err(FormulaError::TooLarge);
        }
        let operators = Operators::new(&form, &vocabulary, &alphabet, &past);
        let rules = Compact::new(&form, &vocabulary, &alphabet, &past).map(Arc::new);
        let machine = choice.machine(rules.as_ref(), &alphabet, &operators, &vocabulary);
        Ok(Self { form, vocabulary, alphabet, past, operators: Arc::new(operators), machine, rules })
    }

    pub(crate) fn method(&self) -> Method {
        match &self.machine {
            Machine::Compact(compact) if compact.is_exact() && self.has_graph() => Method::Graph,
            Machine::Compact(compact) if compact.is_prompt() && !self.alphabet.is_cut_off() => Method::Rules,
            Machine::Compact(_) => Method::Graphs,
            Machine::Automaton(automaton) => Method::Automaton { states: automaton.len() },
            Machine::Progression
                if self.vocabulary.has_data() && is_prompt(&self.form) && !self.alphabet.is_cut_off() =>
            {
                Method::Rules
            }
            Machine::Progression => Method::Progression,
        }
    }

    /// Whether its rules can be drawn, which takes letters and rules out time.
    pub(crate) fn has_graph(&self) -> bool {
        !self.vocabulary.is_timed && self.alphabet.is_exact()
    }

    pub(crate) fn compact(&self) -> Option<&Compact> {
        match &self.machine {
            Machine::Compact(compact) => Some(compact),
            _ => None,
        }
    }

    pub(crate) fn automaton(&self) -> Option<&Automaton> {
        match &self.machine {
            Machine::Automaton(automaton) => Some(automaton),
            _ => None,
        }
    }

    /// Whether the formula only demands that clauses `always` hold which do not look back: then each violation follows
    /// from the last messages, and from what has happened since any moment before it began.
    pub(crate) fn can_begin_anew(&self) -> bool {
        self.past.len() == 0 && !self.past.keeps_messages() && always(&self.form).is_some()
    }

    /// A machine in the middle of a run, at τ = `now`, with nothing pending.
    pub(crate) fn resume(&self, memory: &Memory, now: u64) -> RunningMonitor {
        match &self.machine {
            Machine::Compact(compact) => {
                RunningMonitor::Compact(CompactRun::resume(Arc::clone(compact), memory.clone(), now))
            }
            // An automaton has no such state.
            Machine::Automaton(_) | Machine::Progression => {
                let operators = Arc::clone(&self.operators);
                RunningMonitor::Progression(Progression::resume(operators, None, memory.clone(), now))
            }
        }
    }

    /// The machine at the start of a run.
    pub(crate) fn start(&self) -> RunningMonitor {
        match &self.machine {
            Machine::Compact(compact) => RunningMonitor::Compact(CompactRun::new(Arc::clone(compact))),
            Machine::Automaton(automaton) => {
                RunningMonitor::Automaton(AutomatonRun::new(Arc::clone(automaton), Arc::clone(&self.operators)))
            }
            Machine::Progression => RunningMonitor::Progression(Progression::new(Arc::clone(&self.operators))),
        }
    }
}

impl Choice {
    fn machine(
        self,
        rules: Option<&Arc<Compact>>,
        alphabet: &Alphabet,
        operators: &Operators,
        words: &Vocabulary,
    ) -> Machine {
        let compact = rules.filter(|_| self == Self::Best).map(Arc::clone);
        if let Some(compact) = compact.clone().filter(|compact| compact.is_exact()) {
            return Machine::Compact(compact);
        }
        if self == Self::Progression {
            return Machine::Progression;
        }
        // Time and values have no letters.
        let has_letters = !words.is_timed && !words.has_data() && alphabet.is_exact();
        let automaton = has_letters.then(|| Automaton::new(operators, alphabet).ok()).flatten();
        match (automaton, compact) {
            (Some(automaton), _) => Machine::Automaton(Arc::new(automaton)),
            (None, Some(compact)) => Machine::Compact(compact),
            (None, None) => Machine::Progression,
        }
    }
}

/// A running machine.
#[derive(Clone, Debug)]
pub(crate) enum RunningMonitor {
    Compact(CompactRun),
    Automaton(AutomatonRun),
    Progression(Progression),
}

impl RunningMonitor {
    /// Sets τ, counted from the first state, to `now`. Returns whether a deadline has passed unmet.
    #[inline]
    pub(crate) fn advance(&mut self, now: u64) -> bool {
        match self {
            Self::Compact(run) => run.advance(now),
            Self::Automaton(run) => run.advance(now),
            Self::Progression(run) => run.advance(now),
        }
    }

    /// Resets τ to 0, and forgets what explains a verdict.
    pub(crate) fn normalize(&mut self) {
        match self {
            Self::Compact(run) => run.normalize(),
            Self::Automaton(run) => run.normalize(),
            Self::Progression(run) => run.normalize(),
        }
    }

    /// Forgets what does not matter for what comes.
    pub(crate) fn forget(&mut self) {
        match self {
            Self::Compact(run) => run.forget(),
            Self::Automaton(_) => {}
            Self::Progression(run) => run.forget(),
        }
    }

    /// The state that determines how it continues.
    pub(crate) fn situation(&self) -> Situation<'_> {
        match self {
            Self::Compact(run) => run.situation(),
            Self::Automaton(run) => run.situation(),
            Self::Progression(run) => run.situation(),
        }
    }

    /// Processes a state with this letter, and what happened if values are compared. Returns the verdict.
    #[inline]
    pub(crate) fn read(&mut self, letter: Letter, kind: Option<&EventKind>, alphabet: &Alphabet) -> Verdict {
        match self {
            Self::Compact(run) => {
                run.read(letter, alphabet);
                run.verdict()
            }
            Self::Automaton(run) => {
                run.read(letter, alphabet);
                run.verdict()
            }
            Self::Progression(run) => {
                run.read(letter, kind);
                run.verdict()
            }
        }
    }

    #[inline]
    pub(crate) fn verdict(&self) -> Verdict {
        match self {
            Self::Compact(run) => run.verdict(),
            Self::Automaton(run) => run.verdict(),
            Self::Progression(run) => run.verdict(),
        }
    }

    /// Whether something else may be owed than when this was last asked.
    #[inline]
    pub(crate) fn owes_anew(&mut self) -> bool {
        match self {
            Self::Compact(run) => run.owes_anew(),
            Self::Automaton(run) => run.owes_anew(),
            Self::Progression(_) => true,
        }
    }

    /// The rules, if it is made of them.
    pub(crate) fn rules(&self) -> Option<&CompactRun> {
        match self {
            Self::Compact(run) => Some(run),
            Self::Automaton(_) | Self::Progression(_) => None,
        }
    }

    /// The obligations, and the tick from which they are counted; none before the first state, nor for rules, which are
    /// obligations themselves.
    pub(crate) fn owed(&self) -> Option<(&Obligations, u64)> {
        match self {
            Self::Compact(_) => None,
            Self::Automaton(run) => run.owed(),
            Self::Progression(run) => run.owed(),
        }
    }

    /// The clause that was not met in time, if that settled the verdict; ticks count from the first state.
    pub(crate) fn missed(&self) -> Option<&Clause> {
        match self {
            Self::Compact(_) => None,
            Self::Automaton(run) => run.missed(),
            Self::Progression(run) => run.missed.as_ref(),
        }
    }

    /// Whether the formula holds on the run so far.
    #[inline]
    pub(crate) fn holds(&self) -> bool {
        match self {
            Self::Compact(run) => run.holds(),
            Self::Automaton(run) => run.holds(),
            Self::Progression(run) => run.holds(),
        }
    }
}
