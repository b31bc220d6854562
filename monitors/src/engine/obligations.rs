//! Obligations: what the rest of a run must do.

use std::cmp::Ordering;

use smallvec::{SmallVec, smallvec};

use crate::clause::EventId;
use crate::data::Values;

/// Something that later states decide. Negations are separate obligations.
///
/// Ticks are absolute: those of the run's clock.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Obligation {
    /// An `until` or a release continues: its number among the operators, and the values that it compares with.
    Goes(u32, Values),
    /// A `next` waits for a message on its own channels: its number among the operators, and the values.
    Waits(u32, Values),
    /// A message that satisfies the event passes at a tick from `first` to `last` (or, unless `holds`, none does).
    ///
    /// `first` is 0 once it is no longer in the future; `last` is `u64::MAX` if there is no end.
    Passes {
        /// The event that passes.
        event: EventId,
        /// Whether it must or must not pass.
        holds: bool,
        /// The first tick of the window.
        first: u64,
        /// The last tick of the window.
        last: u64,
        /// Whether the deadline is the moment after `last`, since a timed property has `<`. Without time, windows that
        /// are equal are the same, however they are written.
        before: bool,
        /// The values that the event compares with.
        values: Values,
    },
}

impl Obligation {
    /// The moment at which it is too late for the event, in the words of the property, if there is one.
    pub(crate) fn deadline(&self) -> Option<u64> {
        match self {
            Self::Passes { last, before, .. } if *last < u64::MAX => Some(last + u64::from(*before)),
            _ => None,
        }
    }

    /// The obligation with every tick counted from τ = `now` instead of from 0.
    pub(crate) fn at(&self, now: u64) -> Self {
        match *self {
            Self::Passes { first, last, .. } => self.within(first_at(first, now), last.saturating_add(now)),
            _ => self.clone(),
        }
    }

    /// The parts of one that waits for an event, with every tick counted from τ = `now` instead of from 0.
    fn passes_at(&self, now: u64) -> Option<(EventId, bool, u64, u64, bool, &Values)> {
        match self {
            Self::Passes { event, holds, first, last, before, values } => {
                Some((*event, *holds, first_at(*first, now), last.saturating_add(now), *before, values))
            }
            _ => None,
        }
    }

    /// The order of this obligation, with every tick counted from τ = `now` instead of from 0, and the other.
    fn order_at(&self, now: u64, other: &Self) -> Ordering {
        match (self.passes_at(now), other.passes_at(0)) {
            (Some(own), Some(other)) => own.cmp(&other),
            _ => self.cmp(other),
        }
    }

    /// The obligation with another window, if it has one.
    pub(crate) fn within(&self, new_first: u64, new_last: u64) -> Self {
        let mut changed = self.clone();
        if let Self::Passes { first, last, .. } = &mut changed {
            (*first, *last) = (new_first, new_last);
        }
        changed
    }

    /// Whether meeting this one also meets the other, judging by the windows alone.
    pub(crate) fn implies(&self, other: &Self) -> bool {
        let (Some(own), Some(others)) = (self.passes_at(0), other.passes_at(0)) else { return self == other };
        let (event, holds, first, last, _, values) = own;
        let (other_event, other_holds, other_first, other_last, _, other_values) = others;
        let is_inside =
            if holds { other_first <= first && last <= other_last } else { first <= other_first && other_last <= last };
        is_inside && event == other_event && holds == other_holds && values == other_values
    }
}

/// The first tick of a window if it is counted from τ = `now` instead of from 0.
fn first_at(first: u64, now: u64) -> u64 {
    if first == 0 { 0 } else { first.saturating_add(now) }
}

/// A clause: one of its obligations must be met. Sorted; none implies another.
pub(crate) type Clause = SmallVec<[Obligation; 1]>;

/// The order of a clause, with every tick counted from τ = `now` instead of from 0, and another.
pub(crate) fn order_at(clause: &Clause, now: u64, other: &Clause) -> Ordering {
    let mut orders = clause.iter().zip(other).map(|(own, other)| own.order_at(now, other));
    orders.find(|order| order.is_ne()).unwrap_or_else(|| clause.len().cmp(&other.len()))
}

/// Clauses, all of which must be met; none implies another.
///
/// If there is no clause, nothing is pending, whatever happens; if a clause is empty, it is too late, whatever happens.
/// Without windows, the form is unique for its meaning, so one formula can lead to only finitely many of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Obligations {
    clauses: SmallVec<[Clause; 1]>,
}

impl Obligations {
    pub(crate) fn met() -> Self {
        Self::default()
    }

    pub(crate) fn broken() -> Self {
        Self { clauses: smallvec![Clause::new()] }
    }

    pub(crate) fn constant(truth: bool) -> Self {
        if truth { Self::met() } else { Self::broken() }
    }

    pub(crate) fn one(obligation: Obligation) -> Self {
        Self { clauses: smallvec![smallvec![obligation]] }
    }

    /// All of these obligations, without those implied by another.
    pub(crate) fn all(mut obligations: Clause) -> Self {
        obligations.sort_unstable();
        Self { clauses: obligations.into_iter().map(|obligation| smallvec![obligation]).collect() }
    }

    /// One of these obligations, without those that imply another.
    pub(crate) fn any(clause: Clause) -> Self {
        Self { clauses: smallvec![clause] }
    }

    pub(crate) fn is_met(&self) -> bool {
        self.clauses.is_empty()
    }

    pub(crate) fn is_broken(&self) -> bool {
        self.clauses.first().is_some_and(Clause::is_empty)
    }

    pub(crate) fn clauses(&self) -> &[Clause] {
        &self.clauses
    }

    /// The next τ at which a window begins or has ended; `u64::MAX` if there is none.
    pub(crate) fn changes_at(&self) -> u64 {
        let changes = self.clauses.iter().flatten().map(|obligation| match *obligation {
            Obligation::Passes { first, .. } if first != 0 => first,
            Obligation::Passes { last, .. } => last.saturating_add(1),
            Obligation::Goes(..) | Obligation::Waits(..) => u64::MAX,
        });
        changes.min().unwrap_or(u64::MAX)
    }

    /// The clause that could only be met by messages until `last`, if there is one: it is missed when τ passes `last`.
    /// Of several, the first that was missed.
    pub(crate) fn ending_by(&self, last: u64) -> Option<&Clause> {
        let end = |obligation: &Obligation| match obligation {
            Obligation::Passes { holds: true, last: end, .. } if *end <= last => Some(*end),
            _ => None,
        };
        let ends = self.clauses.iter().filter_map(|clause| {
            let ends: Option<Vec<u64>> = clause.iter().map(end).collect();
            Some((ends?.into_iter().max()?, clause))
        });
        ends.min_by_key(|(end, _)| *end).map(|(_, clause)| clause)
    }

    /// The deadline that is missed when τ becomes `now`.
    pub(crate) fn missed_at(&self, now: u64) -> u64 {
        let ends = self.clauses.iter().flatten().filter(
            |obligation| matches!(obligation, Obligation::Passes { last, .. } if last.checked_add(1) == Some(now)),
        );
        ends.filter_map(Obligation::deadline).max().unwrap_or(now)
    }

    fn add(&mut self, clause: Clause) {
        let implies = |a: &Clause, b: &Clause| a.iter().all(|x| b.iter().any(|y| x.implies(y)));
        if self.clauses.iter().any(|known| implies(known, &clause)) {
            return;
        }
        self.clauses.retain(|known| !implies(&clause, known));
        let place = self.clauses.binary_search(&clause).unwrap_or_else(|place| place);
        self.clauses.insert(place, clause);
    }

    pub(crate) fn and(mut self, other: Self) -> Self {
        if self.is_broken() || other.is_met() {
            return self;
        }
        if self.is_met() || other.is_broken() {
            return other;
        }
        other.clauses.into_iter().for_each(|clause| self.add(clause));
        self
    }

    pub(crate) fn or(self, other: Self) -> Self {
        if self.is_met() || other.is_broken() {
            return self;
        }
        if self.is_broken() || other.is_met() {
            return other;
        }
        let mut both = Self::met();
        for a in &self.clauses {
            for b in &other.clauses {
                both.add(union(a, b));
            }
        }
        both
    }

    /// The obligations after `change` has replaced each one (`None`: unchanged).
    pub(crate) fn replace(self, mut change: impl FnMut(&Obligation) -> Option<Self>) -> Self {
        let mut kept = Self::met();
        let mut changed = Vec::new();
        for clause in self.clauses {
            let new: SmallVec<[Option<Self>; 1]> = clause.iter().map(&mut change).collect();
            if new.iter().all(Option::is_none) {
                kept.clauses.push(clause);
            } else if !new.iter().flatten().any(Self::is_met) {
                changed.push((clause, new));
            }
        }
        for (clause, new) in changed {
            let parts = clause.into_iter().zip(new).map(|(old, new)| new.unwrap_or_else(|| Self::one(old)));
            kept = kept.and(parts.reduce(Self::or).unwrap_or_else(Self::broken));
        }
        kept
    }

    /// The obligations with every tick counted from τ = `now` instead of from 0.
    pub(crate) fn at(&self, now: u64) -> Self {
        // Their order stays the same.
        let at = |clause: &Clause| clause.iter().map(|obligation| obligation.at(now)).collect();
        Self { clauses: self.clauses.iter().map(at).collect() }
    }

    /// The obligations with every tick reduced by those that have passed: an automaton treats them as the same state.
    pub(crate) fn shifted(self, by: u64) -> Self {
        self.replace(|obligation| match obligation {
            Obligation::Passes { first, last, .. } => {
                let last = if *last == u64::MAX { *last } else { last.saturating_sub(by) };
                Some(Self::one(obligation.within(first.saturating_sub(by), last)))
            }
            _ => None,
        })
    }
}

/// The disjunction of two clauses, without redundant parts.
fn union(a: &Clause, b: &Clause) -> Clause {
    let mut all = Clause::with_capacity(a.len() + b.len());
    for obligation in a.iter().chain(b) {
        if all.iter().any(|known| obligation.implies(known)) {
            continue;
        }
        all.retain(|known| !known.implies(obligation));
        let place = all.binary_search(obligation).unwrap_or_else(|place| place);
        all.insert(place, obligation.clone());
    }
    all
}
