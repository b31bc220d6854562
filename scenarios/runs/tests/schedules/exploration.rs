//! All states that a channel system can reach.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};

use channels::ChannelSystem;

/// States of a system, each once, in the order in which they were found.
#[derive(Default)]
pub(crate) struct States {
    found: Vec<ChannelSystem>,
    /// The indices in `found` of the states with each hash.
    by_hash: HashMap<u64, Vec<usize>>,
}

impl States {
    /// Adds a state, unless it is there already.
    pub(crate) fn insert(&mut self, state: ChannelSystem) {
        let mut hasher = DefaultHasher::new();
        state.hash_state(&mut hasher);
        let places = self.by_hash.entry(hasher.finish()).or_default();
        if places.iter().any(|&place| self.found[place].same_state(&state)) {
            return;
        }
        places.push(self.found.len());
        self.found.push(state);
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &ChannelSystem> {
        self.found.iter()
    }

    pub(crate) fn len(&self) -> usize {
        self.found.len()
    }
}

impl FromIterator<ChannelSystem> for States {
    fn from_iter<I: IntoIterator<Item = ChannelSystem>>(systems: I) -> Self {
        let mut states = Self::default();
        for system in systems {
            states.insert(system);
        }
        states
    }
}

/// All states that can be reached from these without time passing, under any scheduler.
pub(crate) fn reachable(starts: impl IntoIterator<Item = ChannelSystem>) -> States {
    let mut states: States = starts.into_iter().collect();
    let mut next = 0;
    while next < states.len() {
        let mut state = states.found[next].fork();
        for transition in state.enabled() {
            let mut successor = state.fork();
            successor.take(&transition).expect("every message fits its channel");
            states.insert(successor);
        }
        next += 1;
    }
    states
}
