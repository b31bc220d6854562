//! The budget of a machine until it comes to rest, in counted steps.

use std::cell::Cell;

use crate::datum::EvaluationError;

/// Steps until a machine must be at rest. The three numbers are chosen, not measured.
const MAX_STEPS: u64 = 4_000_000;
/// Steps of one block of executable content, or of one expression outside of a block.
const MAX_STEPS_OF_BLOCK: u64 = 1_000_000;
/// One step handles this many bytes of text, or searches this many members.
const SIZE_OF_STEP: usize = 64;

/// The remaining steps. An action is one step, and so is each call and loop iteration in the engine; values count by
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

    /// The number of steps left in this block.
    #[cfg(feature = "ecmascript")]
    pub(crate) fn left(&self) -> u64 {
        self.of_block.get()
    }

    /// Whether the machine must be stopped.
    pub(crate) fn are_over(&self) -> bool {
        self.of_all.get() == 0
    }

    /// Uses this many steps.
    pub(crate) fn take(&self, steps: u64) -> Result<(), EvaluationError> {
        let left = self.of_block.get().saturating_sub(steps);
        self.of_block.set(left);
        self.of_all.set(self.of_all.get().saturating_sub(steps));
        if left == 0 { Err(EvaluationError::TooLong) } else { Ok(()) }
    }

    /// Uses the steps for a value of this size.
    pub(crate) fn take_size(&self, size: usize) -> Result<(), EvaluationError> {
        if size < SIZE_OF_STEP { Ok(()) } else { self.take((size / SIZE_OF_STEP) as u64) }
    }
}
