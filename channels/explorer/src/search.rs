//! The search: breadth first, layer by layer, so that the first violation is a shortest one; or depth first.

mod deep;
mod runs;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::ScopedJoinHandle;

use channels::{Monitor, Process, ProcessId, Verdict};

use crate::error::Refused;
use crate::local::UNKNOWN;
use crate::model::Model;
use crate::passage::Passage;
use crate::path::Path;
use crate::semantics::{Fate, Semantics, Slots, Successors};
use crate::store::{AHEAD, Assignment, Packed, Store};
use crate::tables::{Gap, Tables};

/// How far a search may go, and how it proceeds.
#[derive(Clone, Debug)]
pub struct Limits {
    /// The memory that states and tables may take, in bytes.
    pub memory: usize,
    /// How many states may be visited. It is counted after each batch of states, on any number of threads in the same
    /// way, and thus exceeded by at most one batch.
    pub visits: u64,
    /// The number of threads. The result does not depend on it.
    pub threads: usize,
    /// Whether to leave out equivalent runs, and states with a single successor.
    pub reduction: Reduction,
    /// Which state is expanded next.
    pub order: Order,
    /// Once this is set, the search ends with what it has found so far.
    pub stop: Option<&'static AtomicBool>,
}

impl Limits {
    fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}

/// When to leave out equivalent runs, and to pass through states with a single successor without storing them. This
/// takes less memory, but a run that violates the property need not be a shortest one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Reduction {
    /// Never.
    Off,
    /// Always.
    On,
    /// In a second search, if the first ran out of memory.
    #[default]
    WhenNeeded,
}

/// Which state a search expands next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Order {
    /// The one that was found first: breadth first, so that the first violation is a shortest one.
    #[default]
    Breadth,
    /// The one that was found last: depth first, so that violations that take many steps are found soon. A run that
    /// violates the property is not a shortest one. This uses one thread; without a property, the order is always
    /// `Breadth`.
    Depth,
}

impl Default for Limits {
    fn default() -> Self {
        let (reduction, order) = (Reduction::default(), Order::default());
        Self { memory: 4 << 30, visits: u64::MAX, threads: 1, reduction, order, stop: None }
    }
}

/// The progress of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The states stored so far.
    pub states: u64,
    /// The states visited so far: those whose successors are known, and those that were passed through.
    pub visited: u64,
    /// How many of them are quiet: nothing happens before time passes.
    pub quiet: u64,
    /// The number of the current layer; depth first, the length of the longest run so far.
    pub depth: u64,
    /// The memory taken, in bytes.
    pub memory: usize,
    /// Whether states with a single successor are passed through.
    pub is_reduced: bool,
    /// Whether all states are known. Without a property, cycles are searched for then.
    pub is_complete: bool,
}

/// The result of a search.
#[derive(Debug)]
pub struct Exploration {
    /// The answer.
    pub outcome: Outcome,
    /// The progress at the end.
    pub progress: Progress,
    /// The progress at the end of the search before this one, if that ran out of memory: see
    /// [`Reduction::WhenNeeded`].
    pub earlier: Option<Progress>,
    /// The number of transitions between states.
    pub transitions: u64,
    pub(crate) tables: Tables,
}

/// The outcome of a search.
#[derive(Debug)]
pub enum Outcome {
    /// No run violates the property, however long it is. [`Exploration::is_vacuous`] is whether the runs get far
    /// enough for this to mean anything.
    Proved,
    /// This run violates the property. It is a shortest one, unless the search was reduced.
    Violated(Path),
    /// In this run, messages pile up in a process: more than [`NormalForm::QUEUE`](channels::NormalForm::QUEUE) of
    /// them, or of its timers, wait, and what follows is not searched. With a property, no other run violates it as far
    /// as the search got, so it is not decided.
    Endless(Path),
    /// In this run, the tree never takes another tick, and nothing else ever happens.
    Deadlock(Path),
    /// In this run, processes communicate forever before time passes: the [steps at its end](Path::cycle) lead back to
    /// where they began.
    Livelock(Path),
    /// The search reached this limit before it could decide.
    Undecided(Limit),
}

/// What ended a search that did not decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Limit {
    /// [`Limits::memory`], or the largest number of states that can be numbered.
    #[error("memory ran out")]
    Memory,
    /// [`Limits::visits`].
    #[error("the limit of visited states was reached")]
    Visits,
    /// [`Limits::stop`].
    #[error("the search was interrupted")]
    Stop,
}

impl Exploration {
    /// The states found of each process, in normal form.
    pub fn processes(&self) -> impl Iterator<Item = (ProcessId, &dyn Process)> {
        let tables = &self.tables;
        tables
            .ids
            .iter()
            .zip(&tables.locals)
            .flat_map(|(id, locals)| locals.iter().map(|local| (*id, local.process.as_ref())))
    }

    /// Whether a tick is delivered in some run that was explored; `None` if the model has no ticks.
    #[must_use]
    pub fn is_ticked(&self) -> Option<bool> {
        let generator = self.tables.ticks?.generator.index();
        Some(self.tables.locals[generator].iter().any(|local| local.ticked != UNKNOWN))
    }

    /// Whether the property is proved, but no tick is ever delivered: time does not pass, or nothing takes a tick.
    /// Then it holds of a system of which next to nothing has happened. Where the property is settled, a run is not
    /// followed any further: whether a tick would come is not known then, and the answer is no.
    #[must_use]
    pub fn is_vacuous(&self) -> bool {
        let is_settled = || self.tables.monitors.iter().any(|watching| watching.verdict == Verdict::True);
        matches!(self.outcome, Outcome::Proved) && self.is_ticked() == Some(false) && !is_settled()
    }
}

/// How many states are expanded before their successors are stored. Limits, interruption and progress are looked at as
/// often: several hundred times per second, at the speeds that the benchmark of the philosophers measures. The number
/// is chosen, not measured.
const BATCH: u32 = 4096;

/// The fewest states for which it is worth starting a thread: chosen, not measured.
const SMALLEST_SHARE: u32 = 64;

/// Explores a model until the property is decided. Without a property, it searches for deadlocks, livelocks and
/// messages that pile up.
///
/// # Errors
/// [`Refused`] if the model has no finite form.
pub fn explore(
    model: &Model,
    property: Option<&dyn Monitor>,
    limits: &Limits,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Exploration, Refused> {
    let found = search(model, property, limits, limits.reduction == Reduction::On, progress)?;
    match found.outcome {
        Outcome::Undecided(Limit::Memory) if limits.reduction == Reduction::WhenNeeded => {
            let earlier = found.progress;
            drop(found);
            let rest = Limits { visits: limits.visits.saturating_sub(earlier.visited), ..limits.clone() };
            Ok(Exploration { earlier: Some(earlier), ..search(model, property, &rest, true, progress)? })
        }
        _ => Ok(found),
    }
}

fn search(
    model: &Model,
    property: Option<&dyn Monitor>,
    limits: &Limits,
    reduce: bool,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Exploration, Refused> {
    let mut search = Search::new(model, property, limits, reduce)?;
    let end = match property.map_or(Verdict::Inconclusive, Monitor::verdict) {
        Verdict::True => End::Complete,
        Verdict::False => End::Bad { from: None, kind: Bad::Violated },
        Verdict::Inconclusive if property.is_some() && limits.order == Order::Depth => search.run_deep(progress)?,
        Verdict::Inconclusive => search.run(progress)?,
    };
    Ok(search.conclude(end, property.is_some(), progress))
}

/// All states of a model, with everything computed about them.
pub(crate) struct AllStates {
    pub(crate) semantics: Semantics,
    pub(crate) start: Vec<u32>,
    pub(crate) states: u64,
    /// What ended the search before it had found all states.
    pub(crate) limit: Option<Limit>,
}

/// Finds all states, even if the property is violated in some of them.
pub(crate) fn find_all(
    model: &Model,
    property: Option<&dyn Monitor>,
    limits: &Limits,
    progress: &mut dyn FnMut(&Progress),
) -> Result<AllStates, Refused> {
    let mut search = Search { goes_on: true, ..Search::new(model, property, limits, false)? };
    let is_open = property.is_none_or(|property| property.verdict() == Verdict::Inconclusive);
    let end = if is_open { search.run(progress)? } else { End::Complete };
    let limit = if let End::Incomplete(limit) = end { Some(limit) } else { None };
    let mut start = Vec::new();
    search.store.unpack(0, &mut start);
    let states = u64::from(search.store.len());
    Ok(AllStates { semantics: search.semantics, start, states, limit })
}

#[derive(Clone, Copy, Debug)]
enum End {
    Complete,
    Incomplete(Limit),
    /// The successor of this state with this index is bad, or the state itself is if there is no index.
    Bad {
        from: Option<(u32, Option<u32>)>,
        kind: Bad,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bad {
    Violated,
    Endless,
    Deadlock,
    Livelock,
}

impl Bad {
    fn outcome(self, path: Path) -> Outcome {
        match self {
            Self::Violated => Outcome::Violated(path),
            Self::Endless => Outcome::Endless(path),
            Self::Deadlock => Outcome::Deadlock(path),
            Self::Livelock => Outcome::Livelock(path),
        }
    }
}

struct Search<'a> {
    semantics: Semantics,
    store: Store,
    limits: &'a Limits,
    reduce: bool,
    /// The number of the first state of each layer.
    layers: Vec<u32>,
    quiet: u64,
    visited: u64,
    transitions: u64,
    /// The quiet states in which a tick is lost, whatever the environment does.
    stuck: Vec<u32>,
    /// The first step after which messages pile up: a state, and the index of its successor. With a property, the
    /// search goes on with the other runs, which may still violate it.
    endless: Option<(u32, u32)>,
    /// Whether to continue after finding something bad.
    goes_on: bool,
    /// Depth first: the state from which each state was found.
    origins: Option<Vec<u32>>,
    /// Depth first: the length of the longest run.
    deepest: u64,
}

/// The results for states that were expanded without changing the tables.
#[derive(Debug, Default)]
struct Expansions {
    states: Vec<Expanded>,
    /// Their successors. As far as they were looked up, only those that are new.
    found: Packed,
    /// How many of the states and of the successors were looked up.
    looked_up: (usize, usize),
}

#[derive(Clone, Copy, Debug, Default)]
struct Expanded {
    /// Something was not known yet: the state must be expanded again.
    is_incomplete: bool,
    is_quiet: bool,
    is_stuck: bool,
    transitions: u32,
    /// How many states were passed through on the way to its successors.
    passed: u32,
    /// The first bad successor, or the state itself.
    bad: Option<(Option<u32>, Bad)>,
    /// The first successor in which messages pile up, if a property may still be violated elsewhere.
    endless: Option<u32>,
    /// Where its successors end.
    end: usize,
}

/// Why a state cannot be expanded yet.
enum Obstacle {
    Gap(Gap),
    /// This number does not fit.
    TooNarrow(Assignment),
}

impl From<Gap> for Obstacle {
    fn from(gap: Gap) -> Self {
        Self::Gap(gap)
    }
}

impl Expansions {
    fn clear(&mut self, store: &Store) {
        self.states.clear();
        store.clear(&mut self.found);
        self.looked_up = (0, 0);
    }

    /// Looks up the last successors, and drops those that are stored already.
    fn keep_new(&mut self, store: &Store) {
        let (states, mut kept) = self.looked_up;
        let mut next = kept;
        for expanded in &mut self.states[states..] {
            for index in next..expanded.end {
                if (index - self.looked_up.1).is_multiple_of(AHEAD) {
                    store.read_ahead(&self.found, index);
                }
                if store.find(&self.found, index).is_none() {
                    self.found.shift(index, kept);
                    kept += 1;
                }
            }
            next = expanded.end;
            expanded.end = kept;
        }
        self.found.truncate(kept);
        self.looked_up = (self.states.len(), kept);
    }
}

/// Working memory of a thread.
#[derive(Debug, Default)]
struct Scratch {
    state: Vec<u32>,
    successors: Successors,
    passage: Passage,
    packed: Packed,
}

impl<'a> Search<'a> {
    fn new(model: &Model, property: Option<&dyn Monitor>, limits: &'a Limits, reduce: bool) -> Result<Self, Refused> {
        let (tables, start) = Tables::new(model, property)?;
        let slots = Slots::new(&tables);
        let store = Store::new(&slots.vector(&start));
        Ok(Self {
            semantics: Semantics::new(tables, slots, model, property.is_some(), reduce),
            store,
            limits,
            reduce,
            layers: vec![0],
            quiet: 0,
            visited: 0,
            transitions: 0,
            stuck: Vec::new(),
            endless: None,
            goes_on: false,
            origins: None,
            deepest: 0,
        })
    }

    fn progress(&self) -> Progress {
        Progress {
            states: u64::from(self.store.len()),
            visited: self.visited,
            quiet: self.quiet,
            depth: self.deepest.max(self.layers.len() as u64 - 1),
            memory: self.store.bytes() + self.semantics.tables.bytes(),
            is_reduced: self.reduce,
            is_complete: false,
        }
    }

    fn reached(&self, now: &Progress) -> Option<Limit> {
        // The store's index has up to twice as many entries as states, and numbers them with 32 bits.
        let is_full = now.memory > self.limits.memory || self.store.len() > u32::MAX / 2;
        let limits = [
            (self.limits.is_stopped(), Limit::Stop),
            (is_full, Limit::Memory),
            (now.visited >= self.limits.visits, Limit::Visits),
        ];
        limits.into_iter().find_map(|(is_reached, limit)| is_reached.then_some(limit))
    }

    /// Searches layer by layer.
    fn run(&mut self, progress: &mut dyn FnMut(&Progress)) -> Result<End, Refused> {
        let mut per_thread: Vec<Scratch> = (0..self.limits.threads.max(1)).map(|_| Scratch::default()).collect();
        let mut next = 0;
        while next < self.store.len() {
            let end_of_layer = self.store.len();
            while next < end_of_layer {
                let batch = next..end_of_layer.min(next + BATCH);
                for expansions in self.expand_all(batch, &mut per_thread) {
                    if let Some(end) = self.take_in(&mut next, &expansions, &mut per_thread[0])? {
                        return Ok(end);
                    }
                }
                let now = self.progress();
                progress(&now);
                // What ends with the last batch is complete.
                if next < self.store.len()
                    && let Some(limit) = self.reached(&now)
                {
                    return Ok(End::Incomplete(limit));
                }
            }
            if self.store.len() > end_of_layer {
                self.layers.push(end_of_layer);
            }
        }
        Ok(End::Complete)
    }

    /// Expands some states on all threads, without changing the tables.
    fn expand_all(&self, batch: Range<u32>, per_thread: &mut [Scratch]) -> Vec<Expansions> {
        // Each thread takes a run of adjacent states, and what they find is stored in this order: so states have the
        // same numbers with any number of threads.
        let share = (batch.end - batch.start).div_ceil(per_thread.len() as u32).max(SMALLEST_SHARE);
        let shares = (0..per_thread.len() as u32).map(|index| {
            let begin = batch.start.saturating_add(index * share).min(batch.end);
            begin..begin.saturating_add(share).min(batch.end)
        });
        let expand = |share: Range<u32>, scratch: &mut Scratch| {
            let mut expansions = Expansions::default();
            expansions.clear(&self.store);
            for number in share {
                let found = expansions.found.len();
                let expanded = self.expand(number, scratch, &mut expansions.found).unwrap_or_else(|_| {
                    expansions.found.truncate(found);
                    Expanded { is_incomplete: true, end: found, ..Expanded::default() }
                });
                expansions.states.push(expanded);
                if expansions.found.len() >= expansions.looked_up.1 + AHEAD {
                    expansions.keep_new(&self.store);
                }
            }
            expansions.keep_new(&self.store);
            expansions
        };
        let mut work = shares.zip(per_thread).filter(|(share, _)| !share.is_empty());
        let Some((mine, my_scratch)) = work.next() else { return Vec::new() };
        std::thread::scope(|scope| {
            let others: Vec<_> = work.map(|(share, scratch)| scope.spawn(move || expand(share, scratch))).collect();
            let join = |other: ScopedJoinHandle<'_, Expansions>| {
                other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            std::iter::once(expand(mine, my_scratch)).chain(others.into_iter().map(join)).collect()
        })
    }

    fn expand(&self, number: u32, scratch: &mut Scratch, found: &mut Packed) -> Result<Expanded, Obstacle> {
        self.store.unpack(number, &mut scratch.state);
        self.semantics.expand(&scratch.state, &mut scratch.successors)?;
        scratch.passage.passed = 0;
        let (mut bad, mut endless) = (None, None);
        for index in 0..scratch.successors.len() {
            match self.follow(number, index, scratch, found)? {
                Some((successor, Bad::Endless)) if self.semantics.has_monitor => endless = endless.or(successor),
                Some(reached) => {
                    bad = Some(reached);
                    break;
                }
                None => {}
            }
        }
        Ok(Expanded {
            is_incomplete: false,
            is_quiet: scratch.successors.is_quiet,
            is_stuck: self.semantics.is_stuck(&scratch.state, &scratch.successors),
            transitions: scratch.successors.len() as u32,
            passed: scratch.passage.passed,
            bad,
            endless,
            end: found.len(),
        })
    }

    /// Follows one of the successors of the state on the scratch: adds it to what was found, or reports what is wrong
    /// with it.
    fn follow(
        &self,
        number: u32,
        index: usize,
        scratch: &mut Scratch,
        found: &mut Packed,
    ) -> Result<Option<(Option<u32>, Bad)>, Obstacle> {
        let Scratch { state, successors, passage, .. } = scratch;
        let (mut fate, mut changes) = (successors.fate(index), successors.changes(index));
        if self.reduce && fate == Fate::GoOn {
            fate = passage.follow(&self.semantics, state, changes, |_, _| ())?;
            changes = &passage.changes;
        }
        let bad = match fate {
            Fate::GoOn => {
                self.store.pack(number, changes, found).map_err(Obstacle::TooNarrow)?;
                return Ok(None);
            }
            Fate::Settled => return Ok(None),
            Fate::Violated => Bad::Violated,
            Fate::Endless => Bad::Endless,
        };
        Ok((!self.goes_on).then_some((Some(index as u32), bad)))
    }

    /// Stores what was found, starting with the state `next`. Returns how the search ends, if it does.
    fn take_in(
        &mut self,
        next: &mut u32,
        expansions: &Expansions,
        scratch: &mut Scratch,
    ) -> Result<Option<End>, Refused> {
        let mut begin = 0;
        for expanded in &expansions.states {
            let number = *next;
            *next += 1;
            let found = begin..expanded.end;
            begin = expanded.end;
            // What the batch lacked is computed now that nothing else reads the tables. After that, slots may be wider,
            // and then what the rest of the batch found is packed in the old layout.
            if expanded.is_incomplete || !self.store.is_current(&expansions.found) {
                let mut again = Expansions::default();
                self.complete(number, scratch, &mut again)?;
                let mut same = number;
                if let Some(end) = self.take_in(&mut same, &again, scratch)? {
                    return Ok(Some(end));
                }
                continue;
            }
            self.quiet += u64::from(expanded.is_quiet);
            self.visited += 1 + u64::from(expanded.passed);
            self.stuck.extend(expanded.is_stuck.then_some(number));
            self.transitions += u64::from(expanded.transitions);
            self.store.insert(&expansions.found, found);
            self.endless = self.endless.or(expanded.endless.map(|index| (number, index)));
            if let Some((index, kind)) = expanded.bad {
                return Ok(Some(End::Bad { from: Some((number, index)), kind }));
            }
        }
        Ok(None)
    }

    /// Expands a state, and computes what is not known yet. The result is about this state alone.
    fn complete(&mut self, number: u32, scratch: &mut Scratch, expansions: &mut Expansions) -> Result<(), Refused> {
        let expanded = loop {
            expansions.clear(&self.store);
            match self.expand(number, scratch, &mut expansions.found) {
                Ok(expanded) => break expanded,
                Err(Obstacle::Gap(gap)) => self.semantics.tables.fill(&gap)?,
                Err(Obstacle::TooNarrow(change)) => self.store.widen(change),
            }
        };
        expansions.states.push(expanded);
        Ok(())
    }

    /// The end of a search for a violation that found none, if messages pile up in some run: no larger limit would make
    /// this a proof. A search that is interrupted, or repeated with a reduction, ends as it did.
    fn or_endless(&self, end: End) -> End {
        let is_repeated = !self.reduce && self.limits.reduction == Reduction::WhenNeeded;
        match (end, self.endless) {
            (End::Incomplete(Limit::Stop), _) => end,
            (End::Incomplete(Limit::Memory), _) if is_repeated => end,
            (End::Complete | End::Incomplete(_), Some((number, index))) => {
                End::Bad { from: Some((number, Some(index))), kind: Bad::Endless }
            }
            _ => end,
        }
    }

    /// The answer.
    fn conclude(self, end: End, has_property: bool, progress: &mut dyn FnMut(&Progress)) -> Exploration {
        let end = match end {
            End::Complete if !has_property => self.dead_end(progress).unwrap_or(End::Complete),
            end => self.or_endless(end),
        };
        let is_complete = matches!(end, End::Complete);
        let outcome = match end {
            End::Complete => Outcome::Proved,
            End::Incomplete(limit) => Outcome::Undecided(limit),
            End::Bad { from, kind } => {
                let path = from.map_or_else(Path::default, |(number, index)| match kind {
                    Bad::Livelock => self.path_around(number),
                    _ => self.path_to(number, index),
                });
                kind.outcome(path)
            }
        };
        let progress = Progress { is_complete, ..self.progress() };
        Exploration { outcome, progress, earlier: None, transitions: self.transitions, tables: self.semantics.tables }
    }
}
