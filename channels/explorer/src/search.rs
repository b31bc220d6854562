//! The search: breadth first, layer by layer, so that the first violation is a shortest one.

use std::sync::atomic::{AtomicUsize, Ordering};

use channels::{Monitor, Process, ProcessId, Verdict};

use crate::error::Refused;
use crate::model::Model;
use crate::path::{Path, PathStep};
use crate::semantics::{Fate, Semantics, Slots, Successors};
use crate::store::{Change, Lookup, Pair, Scratch, Store, Unfolded};
use crate::tables::Tables;

/// How far a search may go, and how it does.
#[derive(Clone, Debug)]
pub struct Limits {
    /// The memory that states and tables may take, in bytes.
    pub memory: usize,
    /// The number of threads; the result is the same with any number.
    pub threads: usize,
    /// Whether states with a single successor are passed through without being stored.
    pub reduce: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Self { memory: 4 << 30, threads: 1, reduce: true }
    }
}

/// How far a search is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The states stored so far.
    pub states: u64,
    /// Those of them in which nothing happens before time passes.
    pub quiet: u64,
    /// The number of the current layer.
    pub depth: u64,
    /// The memory taken, in bytes.
    pub memory: usize,
}

/// What a search has found.
#[derive(Debug)]
pub struct Exploration {
    /// The answer.
    pub outcome: Outcome,
    /// How far it went.
    pub progress: Progress,
    /// The number of transitions between states.
    pub transitions: u64,
    tables: Tables,
}

/// The answer of a search.
#[derive(Debug)]
pub enum Outcome {
    /// No run violates the property, however long it is.
    Proved,
    /// This run, a shortest one, violates the property.
    Violated(Path),
    /// In this run, messages pile up in a process without end.
    Endless(Path),
    /// In this run, the tree never takes a tick again, and nothing else happens any more.
    Deadlock(Path),
    /// In this run, processes communicate forever before time can pass; its last `cycle` steps repeat.
    Livelock {
        /// The run.
        path: Path,
        /// The number of steps that repeat.
        cycle: usize,
    },
    /// There was not enough memory to decide.
    Undecided,
}

impl Exploration {
    /// The states of processes that were found, in normal form, each with its process.
    pub fn processes(&self) -> impl Iterator<Item = (ProcessId, &dyn Process)> {
        let tables = &self.tables;
        tables
            .ids
            .iter()
            .zip(&tables.locals)
            .flat_map(|(id, locals)| locals.iter().map(|local| (*id, local.process.as_ref())))
    }
}

/// The number of states that are expanded before their successors are stored.
const BATCH: u32 = 4096;

/// Explores a model until the property is decided; without a property, until no run can end in a deadlock or a livelock.
///
/// # Errors
/// [`Refused`] if the model has no finite form.
pub fn explore(
    model: &Model,
    property: Option<&dyn Monitor>,
    limits: &Limits,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Exploration, Refused> {
    let (tables, start) = Tables::new(model, property)?;
    let slots = Slots::new(&tables);
    let vector = slots.vector(&start);
    let mut store = Store::new(slots.len);
    store.insert_slots(&vector);
    let semantics = Semantics {
        hold: model.faults.delayed.1,
        anywhere: model.anywhere,
        has_monitor: property.is_some(),
        tables,
        slots,
    };
    let mut search = Search { semantics, store, limits, layers: vec![0], quiet: 0, transitions: 0 };
    let verdict = property.map_or(Verdict::Inconclusive, Monitor::verdict);
    let end = match verdict {
        Verdict::True => End::Complete,
        Verdict::False => End::Bad { from: None, kind: Bad::Violated },
        Verdict::Inconclusive => search.run(property.is_none(), progress)?,
    };
    search.conclude(end, property.is_none())
}

/// How a search ended.
#[derive(Clone, Copy, Debug)]
enum End {
    Complete,
    OutOfMemory,
    /// The successor of this state with this index is bad; or the state itself, if there is no index.
    Bad {
        from: Option<(u32, Option<usize>)>,
        kind: Bad,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bad {
    Violated,
    Endless,
    Deadlock,
}

struct Search<'a> {
    semantics: Semantics,
    store: Store,
    limits: &'a Limits,
    /// The number of the first state of each layer.
    layers: Vec<u32>,
    quiet: u64,
    transitions: u64,
}

/// What became of a state that was expanded without changing anything.
#[derive(Debug, Default)]
struct Expanded {
    /// Something was not known yet: it must be expanded again.
    is_incomplete: bool,
    is_quiet: bool,
    transitions: u32,
    /// The first bad successor, and how many of the found ones come before it.
    bad: Option<(Option<usize>, Bad)>,
    found: Vec<Found>,
}

/// A successor that may be new.
#[derive(Debug)]
enum Found {
    Top(Pair),
    Changes(Vec<Change>),
}

/// Working memory of a thread.
#[derive(Debug, Default)]
struct Desk {
    state: Unfolded,
    successors: Successors,
    scratch: Scratch,
}

impl Search<'_> {
    fn progress(&self) -> Progress {
        Progress {
            states: u64::from(self.store.len()),
            quiet: self.quiet,
            depth: self.layers.len() as u64 - 1,
            memory: self.store.bytes() + self.semantics.tables.bytes(),
        }
    }

    /// Searches layer by layer.
    fn run(&mut self, find_deadlocks: bool, progress: &mut dyn FnMut(&Progress)) -> Result<End, Refused> {
        let mut desks: Vec<Desk> = (0..self.limits.threads.max(1)).map(|_| Desk::default()).collect();
        let mut next = 0;
        while next < self.store.len() {
            let end_of_layer = self.store.len();
            while next < end_of_layer {
                let batch = next..end_of_layer.min(next + BATCH);
                next = batch.end;
                let expanded = self.expand_batch(batch.clone(), find_deadlocks, &mut desks);
                for (number, expanded) in batch.zip(expanded) {
                    if let Some(end) = self.take_in(number, expanded, find_deadlocks, &mut desks[0])? {
                        return Ok(end);
                    }
                }
                let now = self.progress();
                progress(&now);
                if now.memory > self.limits.memory || self.store.len() > u32::MAX / 2 {
                    return Ok(End::OutOfMemory);
                }
            }
            if self.store.len() > end_of_layer {
                self.layers.push(end_of_layer);
            }
        }
        Ok(End::Complete)
    }

    /// Expands some states, on all threads, without changing anything.
    fn expand_batch(&self, batch: std::ops::Range<u32>, find_deadlocks: bool, desks: &mut [Desk]) -> Vec<Expanded> {
        const CHUNK: u32 = 64;
        let chunks = (batch.end - batch.start).div_ceil(CHUNK);
        let chunk = |index: u32| batch.start + index * CHUNK..batch.end.min(batch.start + (index + 1) * CHUNK);
        let expand = |index: u32, desk: &mut Desk| -> Vec<Expanded> {
            chunk(index).map(|number| self.expand(number, find_deadlocks, desk)).collect()
        };
        if desks.len() == 1 || chunks < 4 {
            return (0..chunks).flat_map(|index| expand(index, &mut desks[0])).collect();
        }
        let next = AtomicUsize::new(0);
        let mut done: Vec<(u32, Vec<Expanded>)> = std::thread::scope(|scope| {
            let workers: Vec<_> = desks
                .iter_mut()
                .map(|desk| {
                    scope.spawn(|| {
                        let take =
                            || u32::try_from(next.fetch_add(1, Ordering::Relaxed)).ok().filter(|next| *next < chunks);
                        std::iter::from_fn(take).map(|index| (index, expand(index, desk))).collect::<Vec<_>>()
                    })
                })
                .collect();
            workers
                .into_iter()
                .flat_map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect()
        });
        done.sort_unstable_by_key(|(index, _)| *index);
        done.into_iter().flat_map(|(_, expanded)| expanded).collect()
    }

    fn expand(&self, number: u32, find_deadlocks: bool, desk: &mut Desk) -> Expanded {
        let Desk { state, successors, scratch } = desk;
        self.store.unfold(number, state);
        if self.semantics.expand(state.slots(), successors).is_err() {
            return Expanded { is_incomplete: true, ..Expanded::default() };
        }
        let mut expanded = Expanded {
            is_quiet: successors.is_quiet,
            transitions: successors.len() as u32,
            bad: (find_deadlocks && self.semantics.is_stuck(state.slots(), successors))
                .then_some((None, Bad::Deadlock)),
            ..Expanded::default()
        };
        for index in 0..successors.len() {
            let bad = match successors.fate(index) {
                Fate::GoOn => None,
                Fate::Settled => continue,
                Fate::Violated => Some(Bad::Violated),
                Fate::Endless => Some(Bad::Endless),
            };
            if let Some(bad) = bad {
                expanded.bad = Some((Some(index), bad));
                return expanded;
            }
            match self.store.look_up(state, successors.changes(index), scratch) {
                Lookup::Known => {}
                Lookup::New(top) => expanded.found.push(Found::Top(top)),
                Lookup::Unknown => expanded.found.push(Found::Changes(successors.changes(index).to_vec())),
            }
        }
        expanded
    }

    /// Stores what was found. Returns how the search ends, if it does.
    fn take_in(
        &mut self,
        number: u32,
        mut expanded: Expanded,
        find_deadlocks: bool,
        desk: &mut Desk,
    ) -> Result<Option<End>, Refused> {
        while expanded.is_incomplete {
            self.store.unfold(number, &mut desk.state);
            match self.semantics.expand(desk.state.slots(), &mut desk.successors) {
                Ok(()) => expanded = self.expand(number, find_deadlocks, desk),
                Err(gap) => self.semantics.tables.fill(&gap)?,
            }
        }
        self.quiet += u64::from(expanded.is_quiet);
        self.transitions += u64::from(expanded.transitions);
        let mut is_unfolded = false;
        for found in expanded.found {
            match found {
                Found::Top(top) => _ = self.store.insert_top(top),
                Found::Changes(changes) => {
                    if !is_unfolded {
                        self.store.unfold(number, &mut desk.state);
                        is_unfolded = true;
                    }
                    self.store.insert(&desk.state, &changes, &mut desk.scratch);
                }
            }
        }
        Ok(expanded.bad.map(|(index, kind)| End::Bad { from: Some((number, index)), kind }))
    }

    /// The answer.
    fn conclude(mut self, end: End, _find_livelocks: bool) -> Result<Exploration, Refused> {
        let outcome = match end {
            End::Complete => Outcome::Proved,
            End::OutOfMemory => Outcome::Undecided,
            End::Bad { from, kind } => {
                let path = from.map_or_else(|| Ok(Path::default()), |(number, index)| self.path(number, index))?;
                match kind {
                    Bad::Violated => Outcome::Violated(path),
                    Bad::Endless => Outcome::Endless(path),
                    Bad::Deadlock => Outcome::Deadlock(path),
                }
            }
        };
        let progress = self.progress();
        Ok(Exploration { outcome, progress, transitions: self.transitions, tables: self.semantics.tables })
    }

    /// A shortest run to a state, and on to one of its successors: of all predecessors of a state, the first.
    fn path(&mut self, number: u32, last: Option<usize>) -> Result<Path, Refused> {
        let mut desk = Desk::default();
        let mut steps = Vec::new();
        if let Some(index) = last {
            steps.push(self.steps(number, index, &mut desk));
        }
        let mut target = number;
        while target > 0 {
            let layer = self.layers.partition_point(|first| *first <= target) - 1;
            let above = self.layers[layer - 1]..self.layers[layer];
            let (from, index) = self.predecessor(above, target, &mut desk);
            steps.push(self.steps(from, index, &mut desk));
            target = from;
        }
        Ok(Path { steps: steps.into_iter().rev().flatten().collect() })
    }

    /// The first of these states with this successor, and the successor's index.
    fn predecessor(&self, among: std::ops::Range<u32>, target: u32, desk: &mut Desk) -> (u32, usize) {
        for number in among {
            self.unfold_and_expand(number, desk);
            for index in 0..desk.successors.len() {
                let changes = desk.successors.changes(index);
                if desk.successors.fate(index) == Fate::GoOn
                    && self.store.number(&desk.state, changes, &mut desk.scratch) == Some(target)
                {
                    return (number, index);
                }
            }
        }
        unreachable!("every state but the first was found from one of the layer before")
    }

    fn unfold_and_expand(&self, number: u32, desk: &mut Desk) {
        self.store.unfold(number, &mut desk.state);
        let expanded = self.semantics.expand(desk.state.slots(), &mut desk.successors);
        assert!(expanded.is_ok(), "what was expanded once is known");
    }

    fn steps(&self, number: u32, index: usize, desk: &mut Desk) -> Vec<PathStep> {
        self.unfold_and_expand(number, desk);
        self.semantics.path_steps(desk.state.slots(), desk.successors.label(index))
    }
}
