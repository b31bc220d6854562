//! Determines which beams of a fan pass on which side of a grid corner.
//!
//! ```text
//!                   columns below │ columns above
//!      row k                      │   _.-´
//!                                 │_-´      a beam that passes above the corner: it crosses the line
//!   line k ───────────────────────●──────   between the columns before line k
//!                             _.-´│
//!      row k - 1          _.-´    │
//! ```
//!
//! Beams are sorted by slope, so those that pass above a corner are all the beams from some index on. This index is
//! estimated from the corner's angle and then determined with the same products that the plain traversal compares.

use std::ops::Range;

use super::fan::{FanBeam, Origin};
use super::fixed::{ceil, fixed};

/// Finds the beams at the edges of a run of occupied cells.
pub(super) struct Edges<'a> {
    beams: &'a [FanBeam],
    origin: Origin,
    /// Whether a beam through a corner crosses the line between columns first. Lines across y come first.
    columns_first: bool,
    /// The number of beams that fall towards lower columns. They come first.
    falling: usize,
    /// Approximate angle of the first beam, in radians.
    first_rad: f64,
    beams_per_rad: f64,
}

impl<'a> Edges<'a> {
    /// For a fan of at least one beam.
    pub(super) fn new(beams: &'a [FanBeam], origin: Origin, columns_first: bool) -> Self {
        let falling = beams.partition_point(|beam| beam.across < 0.0);
        let angle = |beam: &FanBeam| atan(beam.across / beam.along);
        let (first_rad, last_rad) = (angle(&beams[0]), angle(&beams[beams.len() - 1]));
        let beams_per_rad = (beams.len() - 1) as f64 / (last_rad - first_rad);
        Self { beams, origin, columns_first, falling, first_rad, beams_per_rad }
    }

    /// Whether a beam crosses the line between columns at `to_column`, on the side to which the beam goes, before the
    /// line between rows at `to_row`.
    #[inline]
    pub(super) fn crosses_column_first(&self, beam: &FanBeam, to_column: f64, to_row: f64) -> bool {
        let (column, row) = (to_column * beam.along, to_row * beam.across.abs());
        column < row || (self.columns_first && column == row)
    }

    /// The first of `beams` that touches column `start` or a higher one in row `k`.
    #[inline]
    pub(super) fn first_reaching(&self, beams: Range<usize>, start: usize, k: usize) -> usize {
        // A column above the origin is reached by the end of the row; any other is not left before its beginning.
        self.first_above(beams, start, if start > self.origin.column { k + 1 } else { k })
    }

    /// The first of `beams` that touches no column below `end` in row `k`.
    #[inline]
    pub(super) fn first_beyond(&self, beams: Range<usize>, end: usize, k: usize) -> usize {
        self.first_above(beams, end, if end > self.origin.column { k } else { k + 1 })
    }

    /// The first of `beams` that passes above the corner where `column` begins on this line between rows.
    #[inline(always)]
    fn first_above(&self, beams: Range<usize>, column: usize, line: usize) -> usize {
        let to_column = column as f64 - self.origin.across;
        let to_line = self.origin.to_line(line);
        // A corner above the column of the origin is for beams that rise, any other for those that fall.
        let rises = column > self.origin.column;
        let beams =
            if rises { beams.start.max(self.falling)..beams.end } else { beams.start..beams.end.min(self.falling) };
        let rises_through = rises == self.columns_first;
        let passes_above = |index: usize| {
            let beam = &self.beams[index];
            let (column, row) = (to_column * beam.along, to_line * beam.across);
            column < row || (rises_through && column == row)
        };
        if beams.is_empty() || passes_above(beams.start) {
            return beams.start;
        }
        first(beams, self.estimate(to_column, to_line), passes_above)
    }

    /// The approximate index of the first beam above a corner; almost always exact if beams are evenly spaced.
    #[inline]
    fn estimate(&self, to_column: f64, to_line: f64) -> i64 {
        // Multiplied by a reciprocal that is available before the column is known.
        let slope = (to_column * (1.0 / to_line)).clamp(-1.0, 1.0);
        ceil(fixed((atan(slope) - self.first_rad) * self.beams_per_rad))
    }
}

/// The first of `indices` for which `holds` is true, if it is monotone; their end if there is none. Correct for any
/// estimate; two checks if the estimate is exact.
#[inline(always)]
fn first(indices: Range<usize>, estimate: i64, holds: impl Fn(usize) -> bool) -> usize {
    let Range { start, end } = indices;
    let at = estimate.clamp(start as i64, end as i64) as usize;
    let mut step = 1;
    if at < end && !holds(at) {
        let mut low = at + 1;
        while low + step <= end && !holds(low + step - 1) {
            low += step;
            step *= 2;
        }
        bisect(low, end.min(low + step - 1), holds)
    } else {
        let mut high = at;
        while start + step <= high && holds(high - step) {
            high -= step;
            step *= 2;
        }
        bisect(start.max((high + 1).saturating_sub(step)), high, holds)
    }
}

/// The first index from `low` to `high` for which `holds` is true; `high` if there is none before.
#[inline]
fn bisect(mut low: usize, mut high: usize, holds: impl Fn(usize) -> bool) -> usize {
    while low < high {
        let middle = low.midpoint(high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

/// The arctangent of a number from −1 to 1, within 10⁻⁴ (Hastings, *Approximations for Digital Computers*, 1955).
#[inline]
fn atan(slope: f64) -> f64 {
    let square = slope * slope;
    let (low, high) = (0.999_215 - 0.321_181_9 * square, 0.146_276_6 - 0.038_992_9 * square);
    slope * (low + square * square * high)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_first_is_found_for_any_estimate(
            start in 0..50_usize,
            count in 1..50_usize,
            at in 0..=50_usize,
            near in -3..120_i64,
            estimate in any::<i64>(),
        ) {
            let expected = start + at.min(count);
            for estimate in [estimate, near] {
                prop_assert_eq!(first(start..start + count, estimate, |index| index >= expected), expected);
            }
        }

        #[test]
        fn estimates_are_within_a_hundredth_of_half_a_degree(slope in -1.0..1.0_f64) {
            prop_assert!((atan(slope) - libm::atan(slope)).abs() < 0.01 * 0.5_f64.to_radians());
        }
    }
}
