//! Identifiers of the parts of a chart: their indices, and their names in the file.

use std::sync::Arc;

/// A state of a chart, as an index in document order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StateId(u32);

impl StateId {
    pub(crate) const ROOT: Self = Self(0);

    pub(crate) fn new(index: usize) -> Self {
        Self(u32::try_from(index).expect("a file of 4 MiB has fewer than 2^32 states"))
    }

    /// The index in document order; the root is 0.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A transition of a chart, as an index in document order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TransitionId(u32);

impl TransitionId {
    pub(crate) fn new(index: usize) -> Self {
        Self(u32::try_from(index).expect("a file of 4 MiB has fewer than 2^32 transitions"))
    }

    /// The index in document order.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A datum of a chart, as an index into the data model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct DataId(u32);

impl DataId {
    pub(crate) fn new(index: usize) -> Self {
        Self(u32::try_from(index).expect("a file of 4 MiB declares fewer than 2^32 data"))
    }

    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// The names that expressions can read: of a machine, its states and its data, by index.
#[derive(Clone, Debug)]
pub(crate) struct Identifiers {
    pub(crate) machine: Arc<str>,
    states: Vec<Arc<str>>,
    data: Vec<Arc<str>>,
}

impl Identifiers {
    /// `states` begins with the root.
    pub(crate) fn new(machine: Arc<str>, states: Vec<Arc<str>>, data: Vec<Arc<str>>) -> Self {
        Self { machine, states, data }
    }

    #[cfg(feature = "ecmascript")]
    pub(crate) fn state(&self, index: usize) -> Option<&Arc<str>> {
        self.states.get(index)
    }

    #[cfg(feature = "ecmascript")]
    pub(crate) fn datum(&self, data: DataId) -> &str {
        &self.data[data.index()]
    }

    /// The state with this id; the root has none.
    pub(crate) fn find_state(&self, id: &str) -> Option<StateId> {
        (1..self.states.len()).find(|index| &*self.states[*index] == id).map(StateId::new)
    }

    pub(crate) fn find_data(&self, id: &str) -> Option<DataId> {
        self.data.iter().position(|known| &**known == id).map(DataId::new)
    }
}
