//! Everything that a channel system can come to.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};

use channels::ChannelSystem;

/// States of a system, each once, in the order in which they were found.
#[derive(Default)]
pub(crate) struct States {
    found: Vec<ChannelSystem>,
    /// Where the states with a hash are in `found`.
    by_hash: HashMap<u64, Vec<usize>>,
}

impl States {
    /// Adds a state; whether it is a new one.
    pub(crate) fn insert(&mut self, state: ChannelSystem) -> bool {
        let mut hasher = DefaultHasher::new();
        state.hash_state(&mut hasher);
        let places = self.by_hash.entry(hasher.finish()).or_default();
        if places.iter().any(|&place| self.found[place].same_state(&state)) {
            return false;
        }
        places.push(self.found.len());
        self.found.push(state);
        true
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &ChannelSystem> {
        self.found.iter()
    }

    pub(crate) fn len(&self) -> usize {
        self.found.len()
    }
}

/// All states that can be reached from one without time passing, whatever the scheduler does.
pub(crate) fn reachable(start: ChannelSystem) -> States {
    let mut states = States::default();
    states.insert(start);
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
