//! Monitoring by progression: the obligations themselves are transformed from state to state.

use std::sync::Arc;

use channels::{EventKind, Verdict};

use crate::engine::alphabet::Letter;
use crate::engine::obligations::{Clause, Obligations};
use crate::engine::operators::Operators;
use crate::engine::past::Memory;
use crate::engine::situation::Situation;

/// A running formula: its obligations and the last messages.
///
/// Never wrong, but late when several obligations contradict each other. Memory is bounded by the formula and the
/// lengths of its windows.
#[derive(Clone, Debug)]
pub(crate) struct Progression {
    operators: Arc<Operators>,
    /// `None` before the first state.
    owed: Option<Obligations>,
    memory: Memory,
    now: u64,
    /// The clause whose deadline passed before it was met, if that is why the formula is false.
    pub(crate) missed: Option<Clause>,
}

impl Progression {
    pub(crate) fn new(operators: Arc<Operators>) -> Self {
        let memory = operators.memory();
        Self::resume(operators, None, memory, 0)
    }

    /// Starts in the middle of a run: with these obligations at τ = `now`.
    pub(crate) fn resume(operators: Arc<Operators>, owed: Option<Obligations>, memory: Memory, now: u64) -> Self {
        Self { operators, owed, memory, now, missed: None }
    }

    /// Sets τ to `now`. Returns whether a deadline has passed unmet.
    pub(crate) fn advance(&mut self, now: u64) -> bool {
        self.operators.age(&mut self.memory, now.saturating_sub(self.now));
        self.now = now;
        if let Some(owed) = self.owed.take() {
            self.missed = self.missed.take().or_else(|| owed.ending_by(now.saturating_sub(1)).cloned());
            self.owed = Some(self.operators.advance(owed, now));
        }
        self.verdict() == Verdict::False
    }

    /// Processes a state with this letter, and what happened if values are compared.
    #[inline(never)]
    pub(crate) fn read(&mut self, letter: Letter, kind: Option<&EventKind>) {
        let state = self.operators.read(&mut self.memory, letter, kind, self.now);
        self.owed = Some(match self.owed.take() {
            None => self.operators.begin(state),
            Some(owed) => self.operators.step(owed, state),
        });
    }

    /// The obligations, and the tick of the run from which they are counted; `None` before the first state.
    pub(crate) fn owed(&self) -> Option<(&Obligations, u64)> {
        self.owed.as_ref().map(|owed| (owed, 0))
    }

    /// Resets τ to 0, and forgets what explains a verdict.
    pub(crate) fn normalize(&mut self) {
        self.owed = self.owed.take().map(|owed| owed.shifted(self.now));
        self.forget();
        (self.now, self.missed) = (0, None);
    }

    /// Forgets what does not matter for what comes.
    pub(crate) fn forget(&mut self) {
        self.operators.forget(&mut self.memory);
    }

    /// The state that determines how it continues.
    pub(crate) fn situation(&self) -> Situation<'_> {
        Situation::Progression(self.owed.as_ref(), &self.memory)
    }

    pub(crate) fn verdict(&self) -> Verdict {
        match &self.owed {
            Some(owed) if owed.is_met() => Verdict::True,
            Some(owed) if owed.is_broken() => Verdict::False,
            _ => Verdict::Inconclusive,
        }
    }

    /// Whether the formula holds on the run so far.
    pub(crate) fn holds(&self) -> bool {
        match &self.owed {
            None => self.operators.holds_on_nothing(),
            Some(owed) => self.operators.met_at_the_end(owed),
        }
    }
}
