//! Runs to states that were found, and deadlocks and livelocks once all states are known.

use std::collections::{HashMap, HashSet, VecDeque};

use super::{BATCH, Bad, End, Limit, Progress, Scratch, Search};
use crate::path::{Path, PathStep};
use crate::semantics::{Fate, Label};

impl Search<'_> {
    /// A shortest run to a state and on to one of its successors; if there are several, the first of them.
    pub(super) fn path_to(&self, number: u32, last: Option<u32>) -> Path {
        let mut scratch = Scratch::default();
        let mut steps: Vec<Vec<PathStep>> = Vec::new();
        steps.extend(last.map(|index| self.steps(number, index as usize, &mut scratch)));
        let mut target = number;
        while target > 0 {
            let (from, index) = self.predecessor(target, &mut scratch);
            steps.push(self.steps(from, index, &mut scratch));
            target = from;
        }
        Path::from(steps.into_iter().rev().flatten().collect::<Vec<_>>())
    }

    /// The first state from which a state was found, and the state's index among its successors.
    fn predecessor(&self, target: u32, scratch: &mut Scratch) -> (u32, usize) {
        let above = match &self.origins {
            Some(origins) => origins[target as usize]..origins[target as usize] + 1,
            None => {
                let layer = self.layers.partition_point(|first| *first <= target) - 1;
                self.layers[layer - 1]..self.layers[layer]
            }
        };
        let found = above.into_iter().find_map(|number| {
            let successors = self.successors(number, scratch);
            Some((number, successors.iter().find(|(_, successor)| *successor == target)?.0))
        });
        found.expect("every state but the first was found from another")
    }

    /// The stored successors of a state: for each, its index among all successors.
    fn successors(&self, number: u32, scratch: &mut Scratch) -> Vec<(usize, u32)> {
        self.unpack_and_expand(number, scratch);
        let Scratch { state, successors, passage, packed } = scratch;
        let mut stored = Vec::new();
        for index in 0..successors.len() {
            let (mut fate, mut changes) = (successors.fate(index), successors.changes(index));
            if self.reduce && fate == Fate::GoOn {
                fate = passage.follow(&self.semantics, state, changes, |_, _| ()).expect(KNOWN);
                changes = &passage.changes;
            }
            self.store.clear(packed);
            if fate == Fate::GoOn && self.store.pack(number, changes, packed).is_ok() {
                stored.extend(self.store.find(packed, 0).map(|number| (index, number)));
            }
        }
        stored
    }

    fn unpack_and_expand(&self, number: u32, scratch: &mut Scratch) {
        self.store.unpack(number, &mut scratch.state);
        self.semantics.expand(&scratch.state, &mut scratch.successors).expect(KNOWN);
    }

    /// The steps from a state to the next stored one.
    fn steps(&self, number: u32, index: usize, scratch: &mut Scratch) -> Vec<PathStep> {
        self.unpack_and_expand(number, scratch);
        let Scratch { state, successors, passage, .. } = scratch;
        let mut steps = self.semantics.path_steps(state, successors.label(index));
        if self.reduce && successors.fate(index) == Fate::GoOn {
            let visit = |state: &[u32], label: &_| steps.extend(self.semantics.path_steps(state, label));
            passage.follow(&self.semantics, state, successors.changes(index), visit).expect(KNOWN);
        }
        steps
    }

    /// A deadlock or a livelock, now that all states are known: the one whose state was found first.
    pub(super) fn dead_end(&self, progress: &mut dyn FnMut(&Progress)) -> Option<End> {
        let bad = |number: u32, kind| End::Bad { from: Some((number, None)), kind };
        if let Some(number) = self.deadlock() {
            return Some(bad(number, Bad::Deadlock));
        }
        match self.livelock(progress) {
            Ok(found) => found.map(|number| bad(number, Bad::Livelock)),
            Err(limit) => Some(End::Incomplete(limit)),
        }
    }

    /// The first state after which no tick is ever taken, however the environment moves.
    fn deadlock(&self) -> Option<u32> {
        let mut scratch = Scratch::default();
        let stuck: HashSet<u32> = self.stuck.iter().copied().collect();
        self.stuck.iter().copied().find(|&start| {
            let (mut seen, mut next) = (HashSet::from([start]), vec![start]);
            while let Some(number) = next.pop() {
                for (_, successor) in self.successors(number, &mut scratch) {
                    if !stuck.contains(&successor) {
                        return false;
                    }
                    if seen.insert(successor) {
                        next.push(successor);
                    }
                }
            }
            true
        })
    }

    /// The first state on a cycle in which processes communicate and nothing else happens: the one with the smallest
    /// number in a strongly connected component (Tarjan). An error if the search is stopped meanwhile.
    fn livelock(&self, progress: &mut dyn FnMut(&Progress)) -> Result<Option<u32>, Limit> {
        let mut scratch = Scratch::default();
        let mut components = Components { reached: vec![0; self.store.len() as usize], ..Components::default() };
        let known = Progress { is_complete: true, ..self.progress() };
        for start in 0..self.store.len() {
            if start % BATCH == 0 {
                progress(&known);
                if self.limits.is_stopped() {
                    return Err(Limit::Stop);
                }
            }
            let mut next = (components.reached[start as usize] == 0).then_some(start);
            loop {
                if let Some(number) = next.take() {
                    components.enter(number, self.communications(number, &mut scratch));
                }
                let Some(top) = components.open.last_mut() else { break };
                match top.rest.pop() {
                    Some((_, successor)) => next = components.follow(successor),
                    None => components.leave(),
                }
            }
        }
        Ok(components.first)
    }

    /// The successors of a state that are reached by communication alone; none if time passes there.
    fn communications(&self, number: u32, scratch: &mut Scratch) -> Vec<(usize, u32)> {
        let mut successors = self.successors(number, scratch);
        successors.retain(|(index, _)| {
            !scratch.successors.is_quiet && !matches!(scratch.successors.label(*index), Label::Drive { .. })
        });
        successors
    }

    /// A run to a state on a cycle of communications, and then once around a shortest such cycle.
    pub(super) fn path_around(&self, number: u32) -> Path {
        let mut scratch = Scratch::default();
        let mut known: HashMap<u32, (u32, usize)> = HashMap::new();
        let mut queue = VecDeque::from([number]);
        // The state itself is not known at first: it is reached again once around the cycle.
        while let Some(from) = queue.pop_front().filter(|_| !known.contains_key(&number)) {
            for (index, successor) in self.communications(from, &mut scratch) {
                known.entry(successor).or_insert_with(|| {
                    queue.push_back(successor);
                    (from, index)
                });
            }
        }
        let mut around = Vec::new();
        let mut target = number;
        while let Some((from, index)) = known.get(&target) {
            around.push(self.steps(*from, *index, &mut scratch));
            target = *from;
            if target == number {
                break;
            }
        }
        let mut path = self.path_to(number, None);
        path.cycle = around.iter().map(Vec::len).sum();
        path.steps.extend(around.into_iter().rev().flatten());
        path
    }
}

/// Strongly connected components, found by Tarjan's algorithm with a stack of its own: a run of communications can be
/// longer than the thread's stack is deep. Only the first state on a cycle is kept of them.
#[derive(Default)]
struct Components {
    /// When each state was reached, from 1; 0 if it was not, and `u32::MAX` once its component is complete.
    reached: Vec<u32>,
    time: u32,
    /// The states of components that are not complete, in the order in which they were reached.
    members: Vec<u32>,
    /// The path to the current state.
    open: Vec<Open>,
    /// The first state on a cycle.
    first: Option<u32>,
}

impl Components {
    fn enter(&mut self, number: u32, successors: Vec<(usize, u32)>) {
        self.time += 1;
        self.reached[number as usize] = self.time;
        self.members.push(number);
        self.open.push(Open { number, lowest: self.time, rest: successors });
    }

    /// Looks at a successor of the current state, and returns it if it has not been reached yet.
    fn follow(&mut self, successor: u32) -> Option<u32> {
        match self.reached[successor as usize] {
            0 => return Some(successor),
            u32::MAX => {}
            earlier => {
                let top = self.open.last_mut()?;
                top.lowest = top.lowest.min(earlier);
                // A component of one state is a cycle only if the state is its own successor.
                if successor == top.number {
                    self.first = self.first.into_iter().chain([successor]).min();
                }
            }
        }
        None
    }

    /// Leaves the current state, all of whose successors have been visited.
    fn leave(&mut self) {
        let Some(Open { number, lowest, .. }) = self.open.pop() else { return };
        if let Some(below) = self.open.last_mut() {
            below.lowest = below.lowest.min(lowest);
        }
        if lowest == self.reached[number as usize] {
            let begin = self.members.iter().rposition(|member| *member == number).unwrap_or(0);
            if self.members.len() - begin > 1 {
                self.first = self.members[begin..].iter().copied().chain(self.first).min();
            }
            self.members.drain(begin..).for_each(|member| self.reached[member as usize] = u32::MAX);
        }
    }
}

/// A state whose successors are being visited.
struct Open {
    number: u32,
    /// When the earliest reached state was reached to which a path leads back from here.
    lowest: u32,
    rest: Vec<(usize, u32)>,
}

/// The invariant about stored states.
const KNOWN: &str = "what was expanded once is known";
