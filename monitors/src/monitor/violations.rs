//! Every violation of a property, not only the first: each clause is followed at each position.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use channels::Event;
use serde::{Deserialize, Serialize};

use super::record::Observation;
use super::witness::EventTime;
use crate::clause::{Form, LiteralSet, always, is_of_the_present, trigger};
use crate::engine::{Awaited, CompactRun, LetterTrigger, Obligations, Operators, State};
use crate::synthesis::{RunningMonitor, Synthesis};

/// How often, when and how long a property was violated.
///
/// A property that only demands that clauses `always` hold can be violated again and again. At each position at which
/// a clause is checked, it holds or fails, whatever has failed before.
///
/// - A clause about the present and the past fails there and then. Such clauses of a property are violated in
///   stretches: one violation lasts until each of them that has failed was checked again and held.
/// - A clause that looks ahead makes an obligation at each position. Each obligation that is missed is a violation,
///   from the moment at which nothing can meet it: its deadline, or the message that must not come. A missed
///   `time_until` lasts until its message comes, or to the end of the run; any other violation is over at once.
///
/// Any other property is violated once and for good.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violations {
    /// How many there were.
    pub count: u64,
    /// How long at least one of them lasted, until the last time at which none did.
    pub total: Duration,
    /// Since when at least one has lasted, if one does at present.
    pub since: Option<EventTime>,
    /// The first of them: at most [`Violations::MOST`].
    pub first: Vec<Violation>,
    /// Whether the property can be violated again.
    pub goes_on: bool,
}

/// One violation of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violation {
    /// When it began. Of an obligation that was missed, this is its deadline: in a timed property the moment itself,
    /// otherwise the tick.
    pub from: EventTime,
    /// When it was over; `None` if it lasts to the end.
    pub until: Option<EventTime>,
}

impl Violations {
    /// So many violations are kept with their times. More do not fit on a page; all are counted.
    pub const MOST: usize = 1000;

    /// How long at least one of them lasted if the run ends at this time.
    #[must_use]
    pub fn lasting(&self, end: Duration) -> Duration {
        self.total + self.since.map_or(Duration::ZERO, |since| end.saturating_sub(since.time))
    }

    /// How often and how long, in words, if the run ends at this time; `None` if that is no more than when it was
    /// violated first: for good.
    #[must_use]
    pub fn in_words(&self, end: Duration) -> Option<String> {
        // A message that must not come is noticed, and over: such a violation has no length.
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
                    words += &format!(", without a break from {:.2} s to the end", since.time.as_secs_f64());
                }
                Some(words)
            }
        }
    }
}

/// Obligations that are pending at once, and missed ones that last at once, are followed up to this number of
/// different ones for each clause, so that memory stays bounded.
const MOST_AT_ONCE: usize = 100_000;

/// So many states are kept before they are followed.
const MOST_UNREAD: usize = 4096;

/// Follows the clauses of a property.
///
/// How often something is demanded matters only once the property is violated. Until then, states are kept from the
/// first one on that demands something of later ones, and forgotten as soon as nothing is owed any more.
#[derive(Clone, Debug)]
pub(super) struct Recurrence {
    /// The clauses that must always hold; none if the property is violated for good.
    clauses: Vec<Clause>,
    looks_ahead: bool,
    /// Whether something is owed because of the states so far, or may be.
    pub(super) owes: bool,
    /// The obligations of the whole property if its clauses owe nothing. None where obligations do not show that: a
    /// clause may owe what is demanded always anyway.
    rest: Option<Obligations>,
    /// The last states, which have not been followed yet.
    unread: Vec<State<'static>>,
    violations: Violations,
    /// How many violations last at present.
    lasting: u64,
    /// The stretch in which a clause about the present is violated.
    stretch: Option<Place>,
    /// A violation that was certain before any clause had failed: the next one that does is the same.
    foreseen: Option<Place>,
    missed: Vec<Missed>,
}

/// The index of a violation among the first ones, if it is one of these.
type Place = Option<usize>;

/// A clause that must always hold.
#[derive(Clone, Debug)]
struct Clause {
    operators: Arc<Operators>,
    /// When it is checked.
    trigger: LetterTrigger,
    looks_ahead: bool,
    /// Of one about the present: whether it was violated when it was checked last.
    is_violated: bool,
    /// What it demands because of earlier positions, which are told apart only as far as they demand different things.
    pending: VecDeque<Pending>,
    /// Before this τ, time changes nothing of that.
    changes_at: u64,
}

#[derive(Clone, Debug)]
struct Pending {
    owed: Obligations,
    awaited: Awaited,
    /// At how many positions.
    count: u64,
}

/// Obligations that were missed, and for which the same answers are still awaited.
#[derive(Clone, Debug)]
struct Missed {
    awaited: Awaited,
    count: u64,
    places: Vec<usize>,
}

/// Obligations that have just been missed.
struct Failed {
    from: EventTime,
    awaited: Awaited,
    count: u64,
}

impl Recurrence {
    pub(super) fn new(synthesis: &Synthesis) -> Self {
        let clauses = always(&synthesis.form);
        let violations = Violations { goes_on: clauses.is_some(), ..Violations::default() };
        let clauses: Vec<Clause> = clauses.into_iter().flatten().map(|clause| Clause::new(clause, synthesis)).collect();
        let mut demanded = synthesis.form.iter().flatten();
        let is_owed = |always| clauses.iter().any(|clause| clause.operators.contain(always));
        let rest = (!demanded.any(is_owed)).then(|| synthesis.operators.going());
        Self {
            looks_ahead: clauses.iter().any(|clause| clause.looks_ahead),
            clauses,
            owes: false,
            rest,
            unread: Vec::new(),
            violations,
            lasting: 0,
            stretch: None,
            foreseen: None,
            missed: Vec::new(),
        }
    }

    /// The violations so far; `None` if there was none.
    pub(super) fn violations(&self) -> Option<&Violations> {
        Some(&self.violations).filter(|violations| violations.count > 0)
    }

    /// Notes whether something is owed because of the states so far.
    pub(super) fn note(&mut self, run: &RunningMonitor, rules: Option<&CompactRun>) {
        if !self.looks_ahead {
            return;
        }
        let is_rest = |owed: &Obligations| self.rest.as_ref() == Some(owed);
        let rests = || rules.map_or_else(|| run.owed().is_some_and(|(owed, _)| is_rest(owed)), CompactRun::is_at_rest);
        let owed = std::mem::replace(&mut self.owes, !rests());
        if owed && !self.owes {
            self.unread.clear();
            self.clauses.iter_mut().for_each(Clause::rest);
        }
    }

    /// Keeps a state before the property is violated, while something is owed.
    #[inline]
    pub(super) fn keep(&mut self, observation: &Observation<'_>, state: State<'_>) {
        match state.without_memory() {
            Some(state) if self.unread.len() < MOST_UNREAD => self.unread.push(state),
            _ => self.read(observation, state),
        }
    }

    /// Processes a state of a property that is violated: first at the time `settled`, by its witness.
    pub(super) fn follow(&mut self, observation: &Observation<'_>, state: State<'_>, settled: EventTime) {
        self.read(observation, state);
        self.check(state, observation.event);
        if self.violations.count == 0 {
            let place = self.begin(settled);
            self.foreseen = self.violations.goes_on.then_some(place);
        }
    }

    /// Processes a state, and those before it, for the clauses that look ahead. What fails does so in this state:
    /// otherwise, the property would have been violated before.
    #[inline(never)]
    fn read(&mut self, observation: &Observation<'_>, state: State<'_>) {
        for state in std::mem::take(&mut self.unread) {
            self.step(observation, state);
        }
        self.step(observation, state);
    }

    fn step(&mut self, observation: &Observation<'_>, state: State<'_>) {
        let (event, now) = (observation.event, state.now);
        if self.clauses.iter().any(|clause| clause.changes_at <= now) {
            self.advance(observation, now);
        }
        if !self.missed.is_empty() {
            self.answer(state, event);
        }
        let mut failed: Vec<Failed> = Vec::new();
        self.clauses.iter_mut().for_each(|clause| clause.step(event, state, &mut failed));
        failed.into_iter().for_each(|failed| self.miss(failed));
    }

    /// τ grows: deadlines pass.
    fn advance(&mut self, observation: &Observation<'_>, now: u64) {
        let mut failed: Vec<Failed> = Vec::new();
        self.clauses.iter_mut().for_each(|clause| clause.advance(observation, now, &mut failed));
        failed.sort_by_key(|failed| failed.from.time);
        failed.into_iter().for_each(|failed| self.miss(failed));
    }

    /// The clauses about the present.
    fn check(&mut self, state: State<'_>, event: &Event) {
        let (mut is_checked, mut is_broken) = (false, false);
        for clause in self.clauses.iter_mut().filter(|clause| !clause.looks_ahead) {
            if clause.trigger.at(state.letter) {
                clause.is_violated = clause.operators.begin(state).is_broken();
                is_broken |= clause.is_violated;
                is_checked = true;
            }
        }
        let at = EventTime::of(event);
        if is_broken && self.stretch.is_none() {
            self.stretch = Some(self.foreseen.take().unwrap_or_else(|| self.begin(at)));
        } else if is_checked
            && self.clauses.iter().all(|clause| !clause.is_violated)
            && let Some(place) = self.stretch.take()
        {
            self.end(place.as_slice(), 1, at);
        }
    }

    fn miss(&mut self, Failed { from, awaited, count }: Failed) {
        let mut places: Vec<usize> = Vec::new();
        let foreseen = self.foreseen.take();
        places.extend(foreseen.flatten());
        for _ in 0..count - u64::from(foreseen.is_some()) {
            places.extend(self.begin(from));
        }
        if let Some(missed) = self.missed.iter_mut().find(|missed| missed.awaited == awaited) {
            missed.count += count;
            missed.places.append(&mut places);
        } else if awaited.is_empty() || self.missed.len() == MOST_AT_ONCE {
            self.end(&places, count, from);
        } else {
            self.missed.push(Missed { awaited, count, places });
        }
    }

    /// Ends the violations that this state's message answers.
    fn answer(&mut self, state: State<'_>, event: &Event) {
        let Some(Clause { operators, .. }) = self.clauses.first() else { return };
        let is_answered =
            |missed: &mut Missed| missed.awaited.iter().any(|(event, values)| operators.passes(*event, state, values));
        let answered: Vec<Missed> = self.missed.extract_if(.., is_answered).collect();
        answered.iter().for_each(|missed| self.end(&missed.places, missed.count, EventTime::of(event)));
    }

    fn begin(&mut self, from: EventTime) -> Place {
        if self.lasting == 0 {
            self.violations.since = Some(from);
        }
        self.lasting += 1;
        let Violations { count, first, .. } = &mut self.violations;
        *count += 1;
        let is_kept = first.len() < Violations::MOST;
        is_kept.then(|| {
            first.push(Violation { from, until: None });
            first.len() - 1
        })
    }

    fn end(&mut self, places: &[usize], count: u64, until: EventTime) {
        let Violations { total, since, first, .. } = &mut self.violations;
        places.iter().for_each(|place| first[*place].until = Some(until));
        self.lasting -= count;
        if self.lasting == 0
            && let Some(from) = since.take()
        {
            *total += until.time.saturating_sub(from.time);
        }
    }
}

impl Clause {
    fn new(clause: &LiteralSet, synthesis: &Synthesis) -> Self {
        let Synthesis { vocabulary, alphabet, past, .. } = synthesis;
        Self {
            operators: Arc::new(Operators::new(&Form::from([clause.clone()]), vocabulary, alphabet, past)),
            trigger: LetterTrigger::new(&trigger(clause, vocabulary), alphabet),
            looks_ahead: !is_of_the_present(clause),
            is_violated: false,
            pending: VecDeque::new(),
            changes_at: u64::MAX,
        }
    }

    fn rest(&mut self) {
        self.pending.clear();
        self.changes_at = u64::MAX;
    }

    fn advance(&mut self, observation: &Observation<'_>, now: u64, failed: &mut Vec<Failed>) {
        self.changes_at = u64::MAX;
        self.pending.retain_mut(|pending| {
            // The first moment at which it is broken, if it is: a window has ended.
            let mut moment = pending.owed.changes_at();
            while moment <= now {
                let due = pending.owed.missed_at(moment);
                pending.owed = self.operators.advance(std::mem::take(&mut pending.owed), moment);
                if pending.owed.is_broken() {
                    failed.push(pending.fails(observation.at(due)));
                    return false;
                }
                moment = pending.owed.changes_at();
            }
            self.changes_at = self.changes_at.min(moment);
            !pending.owed.is_met()
        });
    }

    /// Processes the state for what is pending, and begins with it.
    fn step(&mut self, event: &Event, state: State<'_>, failed: &mut Vec<Failed>) {
        if !self.looks_ahead {
            return;
        }
        let operators = &self.operators;
        if operators.are_triggered(state) {
            self.pending.retain_mut(|pending| {
                if !operators.concerns(&pending.owed, state) {
                    return true;
                }
                pending.owed = operators.step(std::mem::take(&mut pending.owed), state);
                if pending.owed.is_broken() {
                    failed.push(pending.fails(EventTime::of(event)));
                }
                self.changes_at = self.changes_at.min(pending.owed.changes_at());
                !pending.owed.is_broken() && !pending.owed.is_met()
            });
        }
        if !self.trigger.at(state.letter) {
            return;
        }
        let owed = operators.begin(state);
        if owed.is_met() {
            return;
        }
        let awaited = operators.answers(state);
        if owed.is_broken() {
            failed.push(Failed { from: EventTime::of(event), awaited, count: 1 });
            return;
        }
        let is_same = |last: &&mut Pending| last.owed == owed && last.awaited == awaited;
        if let Some(last) = self.pending.back_mut().filter(is_same) {
            last.count += 1;
        } else if self.pending.len() < MOST_AT_ONCE {
            self.changes_at = self.changes_at.min(owed.changes_at());
            self.pending.push_back(Pending { owed, awaited, count: 1 });
        }
    }
}

impl Pending {
    fn fails(&mut self, from: EventTime) -> Failed {
        Failed { from, awaited: std::mem::take(&mut self.awaited), count: self.count }
    }
}
