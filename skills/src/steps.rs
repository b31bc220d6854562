//! What a machine may do before it comes to rest, in steps that are counted.

use std::cell::Cell;

use crate::expression::EvaluationError;

/// Steps until a machine has to be at rest.
const MAX_STEPS: u64 = 4_000_000;
/// Steps of one block of executable content, or of one expression outside of any.
const MAX_STEPS_OF_BLOCK: u64 = 1_000_000;
/// A text of so many bytes is handled in a step, as are so many members that are searched.
const SIZE_OF_STEP: usize = 64;

/// The steps that are left. An action is one, and so is each of the engine's calls and rounds of loops; values cost by
/// their size.
#[derive(Debug)]
pub(crate) struct Steps {
    of_block: Cell<u64>,
    of_all: Cell<u64>,
}

impl Default for Steps {
    fn default() -> Self {
        Self { of_block: Cell::new(MAX_STEPS_OF_BLOCK), of_all: Cell::new(MAX_STEPS) }
    }
}

impl Steps {
    /// Begins a block.
    pub(crate) fn begin(&self) {
        self.of_block.set(MAX_STEPS_OF_BLOCK.min(self.of_all.get()));
    }

    /// How many may still be taken in this block.
    #[cfg(feature = "ecmascript")]
    pub(crate) fn left(&self) -> u64 {
        self.of_block.get()
    }

    /// Whether the machine has to be stopped.
    pub(crate) fn are_over(&self) -> bool {
        self.of_all.get() == 0
    }

    /// Takes so many steps.
    pub(crate) fn take(&self, steps: u64) -> Result<(), EvaluationError> {
        let left = self.of_block.get().saturating_sub(steps);
        self.of_block.set(left);
        self.of_all.set(self.of_all.get().saturating_sub(steps));
        if left == 0 { Err(EvaluationError::TooLong) } else { Ok(()) }
    }

    /// Takes the steps for something of that size.
    pub(crate) fn take_size(&self, size: usize) -> Result<(), EvaluationError> {
        if size < SIZE_OF_STEP { Ok(()) } else { self.take((size / SIZE_OF_STEP) as u64) }
    }
}
