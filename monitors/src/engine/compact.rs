//! Monitors without obligations: `always` of clauses over the present with at most one deadline each.
//!
//! For a clause `antecedent implies time_until (answer) < θ`, only the oldest open obligation matters: an event that
//! answers it also answers the later ones. For `antecedent implies not time_until (ban) < θ`, only the youngest does.
//! So one number per clause is enough, and an event takes the same time for any θ.
//!
//! Clauses that look back are rules too, without a table of states: their memory is computed during the run.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use channels::Verdict;

use crate::clause::{EventId, Form, Literal, LiteralSet, Vocabulary, Window, always, trigger};
use crate::data::Values;
use crate::engine::alphabet::{Alphabet, Letter, Symbol};
use crate::engine::obligations::{Obligation, Obligations};
use crate::engine::past::{LetterTrigger, Memory, Past};
use crate::engine::situation::Situation;
use crate::engine::table::TransitionTable;

/// A clause under `always`. It is checked whenever one of its own channels carries a message (at every tick, if it has
/// none). If none of its literals holds, its deadline starts; without a deadline, the formula is violated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Rule {
    pub(crate) clause: LiteralSet,
    trigger: LetterTrigger,
    /// The events whose last messages must be remembered.
    remembered: u64,
    /// Events and operators that look back, as bits: the clause holds if one in `hold` holds or one in `hold_not` does
    /// not.
    hold: u64,
    hold_not: u64,
    /// The deadline.
    pub(crate) timing: Timing,
}

/// The demand of a rule after its literals have failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Timing {
    /// They must never fail.
    Never,
    /// One of these events must pass within this many ticks.
    Within { answers: u64, ticks: u64 },
    /// None of these events may pass within this many ticks.
    Without { bans: u64, ticks: u64 },
}

/// The effect of a letter on the rules in a state: one bit each.
#[derive(Clone, Copy, Debug, Default)]
struct RuleStep {
    next: u16,
    /// The rules whose literals fail here.
    strikes: u16,
    /// The rules whose event passes.
    passes: u16,
}

/// Rules over remembered events.
#[derive(Clone, Debug)]
pub(crate) struct Compact {
    pub(crate) rules: Vec<Rule>,
    past: Arc<Past>,
    /// `None` if a rule looks back.
    table: Option<TransitionTable<RuleStep>>,
    /// For each state of the table, what is remembered in it.
    states: Vec<u64>,
    /// The states from which a violation is still possible.
    live: Vec<bool>,
    /// The rules that an event answers.
    answered: u16,
}

impl Compact {
    /// The rules of a formula that is `always` of such clauses, or several such formulas joined by `and`.
    pub(crate) fn new(form: &Form, vocabulary: &Vocabulary, alphabet: &Alphabet, past: &Arc<Past>) -> Option<Self> {
        if vocabulary.has_data() {
            return None;
        }
        let rules = rules(form, vocabulary, alphabet, past)?;
        let is_answered = |rule: &Rule| matches!(rule.timing, Timing::Within { .. });
        let answered = rules.iter().rev().fold(0, |bits, rule| bits << 1 | u16::from(is_answered(rule)));
        let mut compact =
            Self { rules, past: Arc::clone(past), table: None, states: Vec::new(), live: vec![true], answered };
        if past.len() == 0 {
            compact.explore(alphabet)?;
        }
        Some(compact)
    }

    /// Whether verdicts come as early as possible.
    pub(crate) fn is_exact(&self) -> bool {
        self.table.is_some() && self.is_prompt()
    }

    /// Whether a violation is noticed as early as possible: with a single rule, or without deadlines.
    pub(crate) fn is_prompt(&self) -> bool {
        self.rules.len() <= 1 || self.rules.iter().all(|rule| rule.timing == Timing::Never)
    }

    fn remembered(&self) -> u64 {
        self.rules.iter().map(|rule| rule.remembered).fold(self.past.remembered, |bits, rule| bits | rule)
    }

    /// Builds the table of all states. A state is what the rules may still check: of the events that the last message
    /// of each channel satisfied, those that some rule remembers. Two histories with the same bits trigger the same
    /// rules from then on, so each set of bits is explored once.
    fn explore(&mut self, alphabet: &Alphabet) -> Option<()> {
        let remembered = self.remembered();
        let mut table = TransitionTable::new(alphabet.symbols?);
        let possible: BTreeSet<Letter> = alphabet.letters().map(|(letter, ..)| letter).collect();
        let mut known = HashMap::from([(0_u64, 0_u16)]);
        let mut states = vec![0_u64];
        let mut edges = Vec::new();
        let mut at = 0;
        while at < states.len() {
            table.push_row(RuleStep { next: at as u16, ..RuleStep::default() });
            for symbol in (Symbol::MESSAGES..alphabet.symbols?).map(Symbol) {
                let letter = alphabet.letter(symbol);
                let last = letter.after(states[at]);
                let next = *known.entry(last & remembered).or_insert_with(|| {
                    states.push(last & remembered);
                    (states.len() - 1) as u16
                });
                let step = self.step(letter, last, next);
                table.set(at as u16, symbol, step);
                // A message outside the domains is processed, but not expected. A deadline that the same message sets
                // and meets is not pending.
                if possible.contains(&letter) || !alphabet.is_exact() {
                    edges.push((at, usize::from(next), step.strikes & !(step.passes & self.answered)));
                }
            }
            let step = self.step(Letter::TICK, states[at], at as u16);
            table.set(at as u16, Symbol::TICK, step);
            edges.push((at, at, step.strikes));
            if states.len() > alphabet.limits.graph_states {
                return None;
            }
            at += 1;
        }
        self.live = live(states.len(), &edges);
        self.states = states;
        self.table = Some(table);
        Some(())
    }

    fn step(&self, letter: Letter, last: u64, next: u16) -> RuleStep {
        let mut step = RuleStep { next, ..RuleStep::default() };
        for (index, rule) in self.rules.iter().enumerate() {
            // A clause is a disjunction: it fails if none of its positive events holds and all of its negated events
            // hold.
            let triggered = rule.trigger.at(letter);
            let failed = last & rule.hold == 0 && !last & rule.hold_not == 0;
            step.strikes |= u16::from(triggered && failed) << index;
            step.passes |= u16::from(letter.satisfied & rule.timing.events() != 0) << index;
        }
        step
    }
}

impl Timing {
    fn events(&self) -> u64 {
        match self {
            Self::Never => 0,
            Self::Within { answers: events, .. } | Self::Without { bans: events, .. } => *events,
        }
    }
}

impl Rule {
    fn new(clause: &LiteralSet, vocabulary: &Vocabulary, alphabet: &Alphabet, past: &Past) -> Option<Self> {
        let trigger = LetterTrigger::new(&trigger(clause, vocabulary), alphabet);
        let remembered = trigger.remembered(clause, vocabulary, alphabet);
        let mut rule =
            Self { clause: clause.clone(), trigger, remembered, hold: 0, hold_not: 0, timing: Timing::Never };
        for literal in clause {
            match literal {
                Literal::Event { event: EventId(event), holds: true } => rule.hold |= 1 << event,
                Literal::Event { event: EventId(event), holds: false } => rule.hold_not |= 1 << event,
                Literal::Time { event: EventId(event), bound, holds } => {
                    let mut windows = bound.windows();
                    let is_possible = alphabet.possible() & (1 << event) != 0;
                    match (windows.next().filter(|_| is_possible), windows.next()) {
                        // An event that no message satisfies, or whose window is empty, never passes: a clause that
                        // demands it has one literal less.
                        (None, _) if *holds => {}
                        (Some(Window { first: 0, last }), None) => {
                            rule.timing = rule.timing.with(1 << event, last.checked_add(1)?, *holds)?;
                        }
                        _ => return None,
                    }
                }
                literal => match past.bit(literal)? {
                    (bit, true) => rule.hold |= bit,
                    (bit, false) => rule.hold_not |= bit,
                },
            }
        }
        let asked_at_ticks_for_nothing = rule.hold | rule.hold_not == 0 && rule.timing == Timing::Never;
        (!asked_at_ticks_for_nothing).then_some(rule)
    }
}

impl Timing {
    fn with(&self, event: u64, ticks: u64, holds: bool) -> Option<Self> {
        match self {
            Self::Never if holds => Some(Self::Within { answers: event, ticks }),
            Self::Never => Some(Self::Without { bans: event, ticks }),
            Self::Within { answers, ticks: known } if holds && *known == ticks => {
                Some(Self::Within { answers: answers | event, ticks })
            }
            _ => None,
        }
    }
}

fn rules(form: &Form, vocabulary: &Vocabulary, alphabet: &Alphabet, past: &Past) -> Option<Vec<Rule>> {
    let rule = |clause| Rule::new(clause, vocabulary, alphabet, past);
    let rules = always(form)?.into_iter().map(rule).collect::<Option<Vec<_>>>()?;
    // Each rule is a bit.
    (rules.len() <= alphabet.limits.rules.min(16)).then_some(rules)
}

/// The states from which an edge that triggers a rule is reachable.
fn live(states: usize, edges: &[(usize, usize, u16)]) -> Vec<bool> {
    let mut live = vec![false; states];
    let mut changed = true;
    while changed {
        changed = false;
        for (from, to, strikes) in edges {
            let now_live = !live[*from] && (*strikes != 0 || live[*to]);
            live[*from] |= now_live;
            changed |= now_live;
        }
    }
    live
}

/// Running rules: a state, and a tick for each rule.
#[derive(Clone, Debug)]
pub(crate) struct CompactRun {
    pub(crate) compact: Arc<Compact>,
    state: u16,
    /// Replaces the state if there is no table.
    memory: Memory,
    now: u64,
    /// For each rule: the tick at which it is too late ([`Timing::Within`]; `u64::MAX`: nothing is pending), or the
    /// first at which everything is allowed again ([`Timing::Without`]; 0: now).
    ticks: Vec<u64>,
    /// The rule that was broken.
    pub(crate) broken: Option<usize>,
    /// Whether other rules may be armed or broken than when that was last asked.
    owes_anew: bool,
}

impl CompactRun {
    pub(crate) fn new(compact: Arc<Compact>) -> Self {
        let ticks = compact.rules.iter().map(|rule| rule.timing.at_rest()).collect();
        let memory = compact.past.memory();
        Self { compact, state: 0, memory, now: 0, ticks, broken: None, owes_anew: true }
    }

    /// Starts in the middle of a run, at τ = `now`: nothing is pending.
    pub(crate) fn resume(compact: Arc<Compact>, memory: Memory, now: u64) -> Self {
        let last = memory.last & compact.remembered();
        let state = compact.states.iter().position(|known| *known == last).unwrap_or_default() as u16;
        Self { state, memory, now, ..Self::new(compact) }
    }

    /// The rules with a pending answer, with the tick at which it is too late.
    pub(crate) fn owed(&self) -> impl Iterator<Item = (usize, u64)> {
        let rules = self.compact.rules.iter().zip(&self.ticks).enumerate();
        rules.filter_map(|(index, (rule, ticks))| match rule.timing {
            Timing::Within { .. } if *ticks != u64::MAX => Some((index, *ticks)),
            _ => None,
        })
    }

    /// The pending obligations and bans of these rules, in ticks from now, without the rules themselves.
    pub(crate) fn begun(&self, rules: &[usize]) -> Obligations {
        let armed = rules.iter().filter(|rule| self.is_armed(**rule)).map(|rule| {
            let (events, holds) = match self.compact.rules[*rule].timing {
                Timing::Within { answers, .. } => (answers, true),
                Timing::Never => (0, false),
                Timing::Without { bans, .. } => (bans, false),
            };
            let last = self.ticks[*rule].saturating_sub(self.now + 1);
            let passes = (0..u64::BITS)
                .filter(|event| events >> event & 1 == 1)
                .map(EventId)
                .map(|event| Obligation::Passes {
                    event,
                    holds,
                    first: 0,
                    last,
                    before: false,
                    values: Values::default(),
                })
                .map(Obligations::one);
            let combine: fn(_, _) -> _ = if holds { Obligations::or } else { Obligations::and };
            passes.fold(Obligations::constant(!holds), combine)
        });
        armed.fold(Obligations::met(), Obligations::and)
    }

    /// Whether an obligation or a ban of the rule is active.
    pub(crate) fn is_armed(&self, rule: usize) -> bool {
        match self.compact.rules[rule].timing {
            Timing::Never => false,
            Timing::Within { .. } => self.ticks[rule] != u64::MAX,
            Timing::Without { .. } => self.ticks[rule] > self.now,
        }
    }

    /// Whether no rule is armed or broken: one that waits for what no message can satisfy is never armed.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.broken.is_none() && (0..self.ticks.len()).all(|rule| !self.is_armed(rule))
    }

    /// Resets τ to 0, and forgets what no rule needs.
    pub(crate) fn normalize(&mut self) {
        self.forget();
        for ticks in self.ticks.iter_mut().filter(|ticks| **ticks != u64::MAX) {
            *ticks = ticks.saturating_sub(self.now);
        }
        (self.now, self.owes_anew) = (0, true);
    }

    /// Forgets what no rule needs: what the last messages were, and bans that are over.
    pub(crate) fn forget(&mut self) {
        self.memory.last &= self.compact.remembered();
        for (rule, ticks) in self.compact.rules.iter().zip(&mut self.ticks) {
            if matches!(rule.timing, Timing::Without { .. }) && *ticks <= self.now {
                *ticks = 0;
            }
        }
    }

    /// The state that determines how it continues.
    pub(crate) fn situation(&self) -> Situation<'_> {
        Situation::Compact(self.state, &self.ticks, &self.memory)
    }

    /// Sets τ to `now`. Returns whether a deadline has passed unmet.
    #[inline]
    pub(crate) fn advance(&mut self, now: u64) -> bool {
        self.compact.past.advance(&mut self.memory, now.saturating_sub(self.now));
        let before = std::mem::replace(&mut self.now, now);
        for (index, (rule, tick)) in self.compact.rules.iter().zip(&self.ticks).enumerate() {
            // A deadline has passed, or a ban is over.
            let is_over = before < *tick && *tick <= now;
            self.owes_anew |= is_over;
            let is_late = is_over && matches!(rule.timing, Timing::Within { .. });
            // Of several deadlines that have passed, the first.
            if is_late && self.broken.is_none_or(|broken| *tick < self.ticks[broken]) {
                self.broken = Some(index);
            }
        }
        self.broken.is_some()
    }

    /// Processes a state with this letter.
    #[inline]
    pub(crate) fn read(&mut self, letter: Letter, alphabet: &Alphabet) {
        let step = match &self.compact.table {
            Some(table) => table.get(self.state, alphabet.symbol(letter)),
            None => {
                self.compact.past.read(&mut self.memory, letter, None);
                self.compact.step(letter, self.memory.last, 0)
            }
        };
        self.state = step.next;
        if (step.strikes | step.passes) != 0 {
            self.apply(step);
        }
    }

    /// Whether other rules may be armed or broken than when this was last asked.
    #[inline]
    pub(crate) fn owes_anew(&mut self) -> bool {
        std::mem::take(&mut self.owes_anew)
    }

    fn apply(&mut self, step: RuleStep) {
        for (index, rule) in self.compact.rules.iter().enumerate() {
            let (struck, passed) = (step.strikes >> index & 1 == 1, step.passes >> index & 1 == 1);
            let (ticks, fine) = rule.timing.after(self.ticks[index], self.now, struck, passed);
            self.owes_anew |= ticks != self.ticks[index] || !fine;
            self.ticks[index] = ticks;
            if !fine && self.broken.is_none() {
                self.broken = Some(index);
            }
        }
    }

    #[inline]
    pub(crate) fn verdict(&self) -> Verdict {
        if self.broken.is_some() {
            Verdict::False
        } else if self.compact.live[usize::from(self.state)] || !self.is_at_rest() {
            Verdict::Inconclusive
        } else {
            Verdict::True
        }
    }

    /// Whether the formula holds on the run so far.
    pub(crate) fn holds(&self) -> bool {
        self.broken.is_none() && self.owed().next().is_none()
    }
}

impl Timing {
    /// The tick of a rule that currently demands nothing.
    fn at_rest(&self) -> u64 {
        match self {
            Self::Within { .. } => u64::MAX,
            Self::Never | Self::Without { .. } => 0,
        }
    }

    /// The rule's tick after a state, and whether the rule is kept.
    fn after(&self, tick: u64, now: u64, struck: bool, passed: bool) -> (u64, bool) {
        match *self {
            Self::Never => (tick, !struck),
            Self::Within { .. } if passed => (u64::MAX, true),
            Self::Within { ticks, .. } if struck => (tick.min(now.saturating_add(ticks)), true),
            Self::Within { .. } => (tick, true),
            Self::Without { ticks, .. } => {
                let until = if struck { tick.max(now.saturating_add(ticks)) } else { tick };
                (until, !(passed && now < until))
            }
        }
    }
}
