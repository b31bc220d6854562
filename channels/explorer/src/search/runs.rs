//! Runs to states that were found, and what is wrong with states once all are known: deadlocks and livelocks.

use std::collections::HashSet;

use super::{Bad, Desk, End, Search};
use crate::path::{Path, PathStep};
use crate::semantics::Fate;

impl Search<'_> {
    /// A run to a state, and on to one of its successors: a shortest one, of all that there are the first.
    pub(super) fn path_to(&self, number: u32, last: Option<u32>) -> Path {
        let mut desk = Desk::default();
        let mut steps: Vec<Vec<PathStep>> = Vec::new();
        steps.extend(last.map(|index| self.steps(number, index as usize, &mut desk)));
        let mut target = number;
        while target > 0 {
            let (from, index) = self.predecessor(target, &mut desk);
            steps.push(self.steps(from, index, &mut desk));
            target = from;
        }
        Path::from(steps.into_iter().rev().flatten().collect::<Vec<_>>())
    }

    /// The first state from which a state was found, and its index among the successors.
    fn predecessor(&self, target: u32, desk: &mut Desk) -> (u32, usize) {
        let layer = self.layers.partition_point(|first| *first <= target) - 1;
        let above = self.layers[layer - 1]..self.layers[layer];
        let found = above.into_iter().find_map(|number| {
            let successors = self.successors(number, desk);
            Some((number, successors.iter().find(|(_, successor)| *successor == target)?.0))
        });
        found.expect("every state but the first was found from one of the layer before")
    }

    /// The stored successors of a state: for each, its index among all successors.
    fn successors(&self, number: u32, desk: &mut Desk) -> Vec<(usize, u32)> {
        self.unpack_and_expand(number, desk);
        let Desk { state, successors, passage, .. } = desk;
        let found = (0..successors.len()).filter_map(|index| {
            let (mut fate, mut changes) = (successors.fate(index), successors.changes(index));
            if self.reduce && fate == Fate::GoOn {
                fate = passage.follow(&self.semantics, state.slots(), changes, |_, _| ()).expect(KNOWN);
                changes = &passage.changes;
            }
            let number = self.store.find(state, changes).filter(|_| fate == Fate::GoOn)?;
            Some((index, number))
        });
        found.collect()
    }

    fn unpack_and_expand(&self, number: u32, desk: &mut Desk) {
        self.store.unpack(number, &mut desk.state);
        self.semantics.expand(desk.state.slots(), &mut desk.successors).expect(KNOWN);
    }

    /// The steps from a state to the next stored one.
    fn steps(&self, number: u32, index: usize, desk: &mut Desk) -> Vec<PathStep> {
        self.unpack_and_expand(number, desk);
        let Desk { state, successors, passage, .. } = desk;
        let mut steps = self.semantics.path_steps(state.slots(), successors.label(index));
        if self.reduce && successors.fate(index) == Fate::GoOn {
            let visit = |state: &[u32], label: &_| steps.extend(self.semantics.path_steps(state, label));
            passage.follow(&self.semantics, state.slots(), successors.changes(index), visit).expect(KNOWN);
        }
        steps
    }

    /// A deadlock or a livelock, now that all states are known: the state that was found first.
    pub(super) fn dead_end(&self) -> Option<End> {
        let bad = |number: u32, kind| End::Bad { from: Some((number, None)), kind };
        let deadlock = self.deadlock().map(|number| bad(number, Bad::Deadlock));
        deadlock.or_else(|| self.livelock().map(|number| bad(number, Bad::Livelock)))
    }

    /// The first state after which no tick is taken any more, however the environment moves.
    fn deadlock(&self) -> Option<u32> {
        let mut desk = Desk::default();
        let stuck: HashSet<u32> = self.stuck.iter().copied().collect();
        self.stuck.iter().copied().find(|&start| {
            let (mut seen, mut next) = (HashSet::from([start]), vec![start]);
            while let Some(number) = next.pop() {
                for (_, successor) in self.successors(number, &mut desk) {
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

    /// The first state on a cycle on which no time passes.
    fn livelock(&self) -> Option<u32> {
        #[derive(Clone, Copy, PartialEq, Eq)]
        enum Color {
            New,
            Open,
            Done,
        }
        let mut desk = Desk::default();
        let mut colors = vec![Color::New; self.store.len() as usize];
        for start in 0..self.store.len() {
            let mut open: Vec<(u32, Vec<(usize, u32)>)> = Vec::new();
            let mut next = Some(start);
            loop {
                if let Some(number) = next.take()
                    && colors[number as usize] == Color::New
                {
                    let successors = self.successors(number, &mut desk);
                    let is_quiet = desk.successors.is_quiet;
                    colors[number as usize] = if is_quiet { Color::Done } else { Color::Open };
                    if !is_quiet {
                        open.push((number, successors));
                    }
                }
                let Some((number, successors)) = open.last_mut() else { break };
                match successors.pop() {
                    Some((_, successor)) if colors[successor as usize] == Color::Open => return Some(successor),
                    Some((_, successor)) => next = Some(successor),
                    None => {
                        colors[*number as usize] = Color::Done;
                        open.pop();
                    }
                }
            }
        }
        None
    }
}

/// The guarantee about states that were stored.
const KNOWN: &str = "what was expanded once is known";
