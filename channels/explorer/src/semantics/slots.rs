//! The vector that is a state.

use crate::local::bit;
use crate::tables::{Start, Tables};

/// The position of each part of a system's state in a vector.
#[derive(Debug)]
pub(crate) struct Slots {
    pub(crate) processes: Vec<u32>,
    pub(crate) channels: Vec<u32>,
    pub(crate) clock: u32,
    pub(crate) transit: u32,
    pub(crate) environment: u32,
    pub(crate) monitor: u32,
    pub(crate) len: usize,
    /// The processes that are not composed of others.
    pub(crate) populated: Vec<usize>,
    /// By slot: the [`bit`] of the process whose state is there, or 0.
    pub(crate) owners: Vec<u64>,
}

impl Slots {
    /// Each process is next to the channels on which it sends, since they often change together.
    pub(crate) fn new(tables: &Tables) -> Self {
        let mut next = 0..;
        let mut slot = || next.next().unwrap_or_default();
        let [monitor, clock, transit, environment] = [slot(), slot(), slot(), slot()];
        let mut processes = Vec::new();
        let mut channels = vec![0; tables.links.len()];
        for process in tables.topology.processes() {
            processes.push(slot());
            for channel in tables.topology.channels().filter(|id| tables.topology.get(*id).source == process) {
                channels[channel.index()] = slot();
            }
        }
        let len = slot() as usize;
        let populated = (0..processes.len()).filter(|process| tables.locals[*process].len() > 0).collect();
        let mut owners = vec![0; len];
        (0..).zip(&processes).for_each(|(process, slot)| owners[*slot as usize] = bit(process));
        Self { processes, channels, clock, transit, environment, monitor, len, populated, owners }
    }

    /// The vector of the initial state.
    pub(crate) fn vector(&self, start: &Start) -> Vec<u32> {
        let mut vector = vec![0; self.len];
        let parts = self.processes.iter().zip(&start.processes).chain(self.channels.iter().zip(&start.contents));
        parts.for_each(|(slot, value)| vector[*slot as usize] = *value);
        let rest = [
            (self.clock, start.clock),
            (self.transit, start.transit),
            (self.environment, start.environment),
            (self.monitor, start.monitor),
        ];
        rest.into_iter().for_each(|(slot, value)| vector[slot as usize] = value);
        vector
    }
}
