//! The effect of each symbol in each state, as a table.

use crate::engine::alphabet::Symbol;

/// A row for each state, with a cell for each symbol.
#[derive(Clone, Debug)]
pub(crate) struct TransitionTable<T> {
    cells: Vec<T>,
    /// A row has room for two to the power of this many symbols.
    width: u32,
}

impl<T: Copy> TransitionTable<T> {
    /// A table without rows for this number of symbols.
    pub(crate) fn new(symbols: u16) -> Self {
        Self { cells: Vec::new(), width: u32::from(symbols).next_power_of_two().trailing_zeros() }
    }

    /// Adds the row of the next state, the same for all symbols.
    pub(crate) fn push_row(&mut self, cell: T) {
        self.cells.extend(std::iter::repeat_n(cell, 1 << self.width));
    }

    pub(crate) fn set(&mut self, state: u16, symbol: Symbol, cell: T) {
        let place = self.place(state, symbol);
        self.cells[place] = cell;
    }

    #[inline]
    pub(crate) fn get(&self, state: u16, symbol: Symbol) -> T {
        self.cells[self.place(state, symbol)]
    }

    #[inline]
    fn place(&self, state: u16, symbol: Symbol) -> usize {
        usize::from(state) << self.width | usize::from(symbol.0)
    }
}
