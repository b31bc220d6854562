//! The march of a fan through the rows.
//!
//! ```text
//!   row 3    .  .  a  .  .  .  .  .  .  d  .  .     a and d: the outer beams of an interval
//!   row 2    .  .  a  b  #  #  #  c  .  d  .  .     ###:     a run of occupied cells
//!   row 1    .  .  .  a  b  .  c  .  d  .  .  .
//!   row 0    .  .  .  .  .  o  .  .  .  .  .  .     o:       the origin
//! ```
//!
//! An interval of beams that nothing has stopped advances row by row, or eight rows at once. In a row without occupied
//! cells, it only needs the columns of its outer beams. In row 2 it ends the beams between b and c; then [a, b] and [c,
//! d] continue, one after the other.

use super::bit_rows::{BitRows, GROUP};
use super::edges::Edges;
use super::fan::{FanBeam, Origin};
use super::fixed::floor;
use super::outcome::Outcome;

/// Neighboring beams that nothing has stopped yet: from `first` to `end`, exclusive, at the beginning of `row`.
#[derive(Clone, Copy, Debug)]
pub(super) struct BeamInterval {
    first: usize,
    end: usize,
    row: usize,
}

/// A fan on its march.
pub(super) struct March<'a> {
    /// The walls, its rows along the fan's.
    pub(super) walls: &'a BitRows,
    pub(super) beams: &'a [FanBeam],
    pub(super) origin: Origin,
    pub(super) edges: &'a Edges<'a>,
    /// The maximum number of rows that the beams pass through.
    pub(super) rows: usize,
    /// Intervals waiting for their turn.
    pub(super) waiting: &'a mut Vec<BeamInterval>,
    /// The ends of groups of beams, each at its first beam.
    pub(super) outcomes: &'a mut [Outcome],
}

impl March<'_> {
    /// Finds where each beam ends.
    pub(super) fn run(&mut self) {
        self.waiting.clear();
        self.waiting.push(BeamInterval { first: 0, end: self.beams.len(), row: 0 });
        while let Some(mut interval) = self.waiting.pop() {
            while let Some((row, columns)) = self.next_wall(&interval) {
                interval.row = row;
                match self.pass(interval, columns) {
                    Some(rest) => interval = rest,
                    None => break,
                }
            }
        }
    }

    /// The next row in which there is a wall between an interval's outer beams, and the columns between them.
    fn next_wall(&mut self, interval: &BeamInterval) -> Option<(usize, (usize, usize))> {
        let BeamInterval { first, end, mut row } = *interval;
        let mut span = RowWindow::new(&self.beams[first], &self.beams[end - 1], row, self.walls);
        let phase = if self.origin.forward { self.origin.row } else { GROUP - 1 - self.origin.row % GROUP };
        while row < self.rows {
            let number = self.origin.row(row);
            if (row + phase).is_multiple_of(GROUP) {
                let columns = span.over_group().columns(self.walls);
                if columns.is_none_or(|(from, to)| !self.walls.group(number).any(from, to)) {
                    span.advance(GROUP);
                    row += GROUP;
                    continue;
                }
            }
            let Some((from, to)) = span.columns(self.walls) else { break };
            if self.walls.row(number).any(from, to) {
                return Some((row, (from, to)));
            }
            span.advance(1);
            row += 1;
        }
        self.outcomes[first] = Outcome::nothing(end);
        None
    }

    /// Takes an interval through its row, in which it touches only columns between `from` and `to`. Ends the beams that
    /// hit a run of occupied cells, queues those before it, and returns those after all runs.
    fn pass(&mut self, interval: BeamInterval, (mut from, to): (usize, usize)) -> Option<BeamInterval> {
        let BeamInterval { mut first, end, row } = interval;
        while let Some((start, stop)) = self.walls.row(self.origin.row(row)).run(from, to) {
            let reaching = self.edges.first_reaching(first..end, start, row);
            if reaching == end {
                break;
            }
            // Nothing passes a run that extends beyond the last touched column, if there is a column after it.
            let goes_on = stop > to && stop < self.walls.columns;
            let beyond = if goes_on { end } else { self.edges.first_beyond(reaching..end, stop, row) };
            if beyond > reaching {
                self.outcomes[reaching] = self.outcome(beyond, row, (start, stop));
                if reaching > first {
                    self.waiting.push(BeamInterval { first, end: reaching, row: row + 1 });
                }
                if beyond == end {
                    return None;
                }
                first = beyond;
            }
            from = stop + 1;
        }
        Some(BeamInterval { first, end, row: row + 1 })
    }

    /// The outcome of beams up to `end` in a row: the cells from column `start` to `stop`, exclusive.
    #[inline]
    fn outcome(&self, end: usize, row: usize, (start, stop): (usize, usize)) -> Outcome {
        let to_side = if start > self.origin.column {
            start as f64 - self.origin.across
        } else if stop <= self.origin.column {
            self.origin.across - stop as f64
        } else {
            -1.0
        };
        Outcome { end, to_front: self.origin.to_line(row), to_side }
    }
}

/// The range between an interval's outer beams in a row, as fixed-point columns, and its change from row to row.
struct RowWindow {
    low: i64,
    high: i64,
    low_step: i64,
    high_step: i64,
}

impl RowWindow {
    fn new(first: &FanBeam, last: &FanBeam, row: usize, walls: &BitRows) -> Self {
        // In a row, a falling beam is lowest at the end, and a rising one is highest there. The margin covers rounding:
        // half a bit of the step per row, and 10⁻⁶ of a column for the rest.
        let margin = 4096 + walls.rows as i64;
        let low = first.column + row as i64 * first.slope + first.slope.min(0) - margin;
        let high = last.column + row as i64 * last.slope + last.slope.max(0) + margin;
        Self { low, high, low_step: first.slope, high_step: last.slope }
    }

    #[inline]
    fn advance(&mut self, rows: usize) {
        self.low += rows as i64 * self.low_step;
        self.high += rows as i64 * self.high_step;
    }

    /// The range between the beams in any of the next eight rows.
    #[inline]
    fn over_group(&self) -> Self {
        let steps = GROUP as i64 - 1;
        let low = self.low + (steps * self.low_step).min(0);
        let high = self.high + (steps * self.high_step).max(0);
        Self { low, high, ..*self }
    }

    /// The first and the last column, if any is inside the grid.
    #[inline]
    fn columns(&self, walls: &BitRows) -> Option<(usize, usize)> {
        let (from, to) = (floor(self.low).max(0), floor(self.high).min(walls.columns as i64 - 1));
        (from <= to).then_some((from as usize, to as usize))
    }
}
