//! Occupied cells as bits, and queries for ranges of a row.

/// The occupied cells of a grid, one bit per cell, row after row, with a second level that combines eight rows: it
/// shows which columns are occupied in any of them.
///
/// Rows and columns are those of the bitmap: for fans along x, the grid's columns are its rows.
#[derive(Clone, Debug)]
pub(super) struct BitRows {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Bytes from one row to the next.
    stride: usize,
    bits: Vec<u8>,
    /// Row g is the OR of rows 8 g to 8 g + 7.
    groups: Vec<u8>,
}

/// Rows in a group.
pub(super) const GROUP: usize = 8;

/// Bytes after the last row, so that a word can be read from any byte of it.
const PADDING: usize = 8;

/// The bits of a row or of a group of rows, and those after them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    bytes: &'a [u8],
}

impl BitRows {
    /// Without any occupied cell.
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let stride = columns.div_ceil(8);
        let empty = |rows: usize| vec![0; rows * stride + PADDING];
        Self { rows, columns, stride, bits: empty(rows), groups: empty(rows.div_ceil(GROUP)) }
    }

    /// Makes a cell occupied or free: a bit of its row, and a bit of its group.
    pub(super) fn set(&mut self, row: usize, column: usize, occupied: bool) {
        let (byte, bit) = (column / 8, 1 << (column % 8));
        let group = row / GROUP;
        if occupied {
            self.bits[row * self.stride + byte] |= bit;
            self.groups[group * self.stride + byte] |= bit;
        } else {
            self.bits[row * self.stride + byte] &= !bit;
            let rows = group * GROUP..self.rows.min((group + 1) * GROUP);
            let any = rows.map(|row| self.bits[row * self.stride + byte]).fold(0, |any, bits| any | bits);
            self.groups[group * self.stride + byte] = any;
        }
    }

    #[inline]
    pub(super) fn row(&self, row: usize) -> Row<'_> {
        Row { bytes: &self.bits[row * self.stride..] }
    }

    /// The OR of the eight rows that include `row`.
    #[inline]
    pub(super) fn group(&self, row: usize) -> Row<'_> {
        Row { bytes: &self.groups[row / GROUP * self.stride..] }
    }
}

impl Row<'_> {
    /// Whether a cell from column `from` to `to`, both inclusive, is occupied.
    #[inline]
    pub(super) fn any(self, from: usize, to: usize) -> bool {
        // A word that begins with the byte of `from` has at least 57 bits from there on.
        if to - from < 57 {
            self.word(from / 8) >> (from % 8) << (63 - (to - from)) != 0
        } else {
            self.first_unlike(0, from, to).is_some()
        }
    }

    /// The first run of occupied cells among columns `from` to `to`, both inclusive: its beginning and the first column
    /// after it, which is `to + 1` if it extends that far.
    #[inline]
    pub(super) fn run(self, from: usize, to: usize) -> Option<(usize, usize)> {
        let start = self.first_unlike(0, from, to)?;
        Some((start, self.first_unlike(u64::MAX, start, to).unwrap_or(to + 1)))
    }

    /// The first column from `from` to `to` whose bit differs from those of `background`, which are all the same.
    #[inline]
    fn first_unlike(self, background: u64, from: usize, to: usize) -> Option<usize> {
        let mut column = from;
        let mut unlike = (self.word(from / 8) ^ background) >> (from % 8);
        let mut next = from / 8 * 8 + 64;
        while unlike == 0 && next <= to {
            column = next;
            unlike = self.word(next / 8) ^ background;
            next += 64;
        }
        let found = column + unlike.trailing_zeros() as usize;
        (unlike != 0 && found <= to).then_some(found)
    }

    /// The 64 bits from this byte on.
    #[inline]
    fn word(self, byte: usize) -> u64 {
        u64::from_le_bytes(self.bytes[byte..byte + 8].try_into().expect("a word has eight bytes"))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const ROWS: usize = 19;
    const COLUMNS: usize = 301;

    /// Runs of cells that are occupied, some of which are freed again.
    fn changes() -> impl Strategy<Value = Vec<(usize, usize, usize, bool)>> {
        prop::collection::vec((0..ROWS, 0..COLUMNS, 1..150_usize, any::<bool>()), 0..40)
    }

    proptest! {
        #[test]
        fn rows_and_groups_contain_the_cells_of_any_range(
            changes in changes(),
            row in 0..ROWS,
            ends in [0..COLUMNS, 0..COLUMNS],
        ) {
            let mut bits = BitRows::new(ROWS, COLUMNS);
            let mut cells = vec![[false; COLUMNS]; ROWS];
            for (row, start, length, occupied) in changes {
                let columns = start..COLUMNS.min(start + length);
                columns.clone().for_each(|column| bits.set(row, column, occupied));
                cells[row][columns].fill(occupied);
            }
            let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let start = (from..=to).find(|column| cells[row][*column]);
            let run = start.map(|start| (start, (start..=to).find(|column| !cells[row][*column]).unwrap_or(to + 1)));
            prop_assert_eq!(bits.row(row).run(from, to), run);
            prop_assert_eq!(bits.row(row).any(from, to), run.is_some());
            let group = &cells[row / GROUP * GROUP..ROWS.min((row / GROUP + 1) * GROUP)];
            let any = group.iter().any(|cells| cells[from..=to].contains(&true));
            prop_assert_eq!(bits.group(row).any(from, to), any);
        }
    }
}
