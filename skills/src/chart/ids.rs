//! Identifiers of the parts of a chart: their indices.

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
