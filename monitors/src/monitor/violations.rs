//! Every violation of a property, not only the first: a monitor that begins anew.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, Message, Verdict};
use serde::{Deserialize, Serialize};

use super::witness::EventTime;
use crate::clause::{Form, Literal, LiteralSet, always, trigger};
use crate::engine::{Letter, LetterTrigger, Memory, Operators, Progression};
use crate::synthesis::Synthesis;

/// How often, when and how long a property was violated.
///
/// A property that only demands that clauses `always` hold is judged anew after a violation. A violated clause begins
/// anew with the next state, but what was seen before still counts for the operators that look back. What it still owed
/// is given up with the violation, and so is what all clauses owed at the first one. A violation lasts until each
/// violated clause has been checked again and held. Any other property is violated once and for good.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violations {
    /// How many there were.
    pub count: u64,
    /// How long those that have ended lasted together.
    pub total: Duration,
    /// When the present one began, if the property has not been checked and held since.
    pub since: Option<EventTime>,
    /// The first of them: at most [`Violations::MOST`].
    pub first: Vec<Violation>,
    /// Whether the property is judged anew after each violation.
    pub goes_on: bool,
}

/// A stretch of a run in which a property was violated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violation {
    /// When it was noticed.
    pub from: EventTime,
    /// The next time at which the property was checked and held; `None` if there was none.
    pub until: Option<EventTime>,
}

impl Violations {
    /// So many violations are kept with their times. More do not fit on a page; all are counted.
    pub const MOST: usize = 1000;

    /// How long they lasted together if the run ends at this time.
    #[must_use]
    pub fn lasting(&self, end: Duration) -> Duration {
        self.total + self.since.map_or(Duration::ZERO, |since| end.saturating_sub(since.time))
    }

    /// How often and how long, in words, if the run ends at this time; `None` if that is no more than when it was
    /// violated first: for good.
    #[must_use]
    pub fn in_words(&self, end: Duration) -> Option<String> {
        // A missed deadline is noticed, and over: it has no length.
        let lasted_s = self.lasting(end).as_secs_f64();
        let has_lasted = lasted_s >= 0.005;
        match (self.count, self.since) {
            (0, _) | (1, Some(_)) => None,
            (1, None) => has_lasted.then(|| format!("violated for {lasted_s:.2} s")),
            (count, since) => {
                let mut words = format!("violated {count} times");
                if has_lasted {
                    words += &format!(", for {lasted_s:.2} s in all");
                }
                if let Some(since) = since {
                    words += &format!(", the last time from {:.2} s to the end", since.time.as_secs_f64());
                }
                Some(words)
            }
        }
    }
}

/// Judges a violated property anew.
#[derive(Clone, Debug)]
pub(super) struct Recurrence {
    /// The clauses that must always hold; none if the property is violated for good.
    clauses: Vec<Clause>,
    violations: Violations,
}

/// A clause that must always hold.
#[derive(Clone, Debug)]
struct Clause {
    run: Progression,
    /// When it is checked.
    trigger: LetterTrigger,
    /// Whether it was violated when it was checked last.
    is_violated: bool,
}

impl Recurrence {
    /// Begins with the first violation, in this state at τ = `now`; `memory` is what has been seen.
    pub(super) fn new(synthesis: &Synthesis, memory: &Memory, event: &Event, letter: Letter, now: u64) -> Self {
        let Synthesis { form, vocabulary, alphabet, past, .. } = synthesis;
        let clauses = always(form);
        let violations = Violations { goes_on: clauses.is_some(), ..Violations::default() };
        let clauses = clauses.into_iter().flatten().map(|clause| {
            let alone = Literal::Release { escape: Form::new(), hold: Form::from([clause.clone()]) };
            let operators = Operators::new(&Form::from([LiteralSet::from([alone])]), vocabulary, alphabet, past);
            let mut run = Progression::resume(Arc::new(operators), None, memory.clone(), now);
            run.begin_with(letter);
            let trigger = LetterTrigger::new(&trigger(clause, vocabulary), alphabet);
            let mut clause = Clause { run, trigger, is_violated: false };
            clause.settle(letter);
            clause
        });
        let mut begun = Self { clauses: clauses.collect(), violations };
        begun.violated(event);
        begun
    }

    /// What has been seen, unless the property is violated for good.
    pub(super) fn memory(&self) -> Option<&Memory> {
        Some(self.clauses.first()?.run.memory())
    }

    pub(super) fn violations(&self) -> &Violations {
        &self.violations
    }

    /// Processes a state at τ = `now`.
    pub(super) fn read(&mut self, event: &Event, letter: Letter, message: Option<(ChannelId, &Message)>, now: u64) {
        let (mut is_checked, mut is_broken) = (false, false);
        for clause in &mut self.clauses {
            clause.run.advance(now);
            clause.run.read(letter, message);
            is_broken |= clause.settle(letter);
            is_checked |= clause.trigger.at(letter);
        }
        if is_broken {
            self.violated(event);
        } else if is_checked && self.clauses.iter().all(|clause| !clause.is_violated) {
            self.ended(event);
        }
    }

    fn violated(&mut self, event: &Event) {
        let Violations { count, since: since @ None, first, .. } = &mut self.violations else { return };
        let from = EventTime::of(event);
        *since = Some(from);
        *count += 1;
        if first.len() < Violations::MOST {
            first.push(Violation { from, until: None });
        }
    }

    fn ended(&mut self, event: &Event) {
        let Violations { total, since, first, .. } = &mut self.violations;
        let Some(from) = since.take() else { return };
        let until = EventTime::of(event);
        *total += until.time.saturating_sub(from.time);
        if let Some(last) = first.last_mut().filter(|last| last.from == from) {
            last.until = Some(until);
        }
    }
}

impl Clause {
    /// Begins anew if the clause is violated now; returns whether it is.
    fn settle(&mut self, letter: Letter) -> bool {
        let is_broken = self.run.verdict() == Verdict::False;
        if is_broken {
            self.run.begin_anew();
        }
        self.is_violated = is_broken || self.is_violated && !self.trigger.at(letter);
        is_broken
    }
}
