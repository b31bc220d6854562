//! The beams of one quadrant, in coordinates that are the same for all four.
//!
//! A fan goes through *rows*, one after the other, and gains at most one *column* a row. For a fan along y these are the
//! grid's rows and columns, for one along x they have changed places. Rows are counted from the one that holds the
//! origin, in the way of the fan: beams cross line k on their way from row k − 1 to row k. Columns keep their numbers.

use maps::Point;
use nalgebra::Vector2;

use super::fixed::fixed;
use super::quadrant::Quadrant;

/// Beams that are measured at once.
pub(super) const BLOCK: usize = 4;

/// A beam of a fan.
#[derive(Clone, Copy, Debug)]
pub(super) struct FanBeam {
    /// Component of the direction along the fan's axis; positive and the greater one.
    pub(super) along: f64,
    /// Component across; positive towards higher columns.
    pub(super) across: f64,
    /// Columns gained from a line to the next, as a fixed-point number.
    pub(super) slope: i64,
    /// Where it crosses line 0 or would have, as a fixed-point number: it crosses line k at `column + k · slope`.
    pub(super) column: i64,
}

/// Where a fan begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// The number that the row which holds the origin has in the bitmap.
    pub(super) row: usize,
    /// The column that holds the origin.
    pub(super) column: usize,
    /// The origin's coordinate across the fan's axis, in columns.
    pub(super) across: f64,
    /// Whether row 1 comes after row 0 in the bitmap.
    pub(super) forward: bool,
    /// The line from which distances are counted, 0 or 1: the lower of those beside the origin in the grid.
    base: f64,
    /// Distance from the origin to that line: from −1 to 0 ahead if `forward`, from 0 to 1 if not.
    to_base: f64,
}

impl Origin {
    /// `point`, in grid coordinates, lies within the grid.
    pub(super) fn new(point: &Point, quadrant: Quadrant) -> Self {
        let (along, across) = if quadrant.is_along_x() { (point.x, point.y) } else { (point.y, point.x) };
        let forward = quadrant.is_forward();
        let (row, column) = (along as usize, across as usize);
        // Nothing is rounded here: the row is 0, or at least half of the coordinate.
        let (base, to_base) = if forward { (0.0, row as f64 - along) } else { (1.0, along - row as f64) };
        Self { row, column, across, forward, base, to_base }
    }

    /// Distance from the origin to line `k` along the fan's axis; not positive for line 0, which no beam crosses.
    ///
    /// As it is rounded once, it is the same number as the difference of their coordinates.
    #[inline]
    pub(super) fn to_line(self, k: usize) -> f64 {
        (k as f64 - self.base) + self.to_base
    }

    /// The number that row `k` has in the bitmap.
    #[inline]
    pub(super) fn row(self, k: usize) -> usize {
        if self.forward { self.row + k } else { self.row - k }
    }
}

/// Lays out the beams of a fan by their slope, in ascending order. `directions` go counter-clockwise, all in `quadrant`.
/// A few beams that are none follow the last, so that blocks can be read from any.
pub(super) fn lay_out(quadrant: Quadrant, origin: Origin, directions: &[Vector2<f64>], beams: &mut Vec<FanBeam>) {
    let to_line_1 = origin.to_line(1);
    let beam = |direction: &Vector2<f64>| {
        let (along, across) = quadrant.components(direction);
        let exact_slope = across / along;
        let slope = fixed(exact_slope);
        FanBeam { along, across, slope, column: fixed(origin.across + exact_slope * to_line_1) - slope }
    };
    beams.clear();
    if quadrant.is_reversed() {
        beams.extend(directions.iter().rev().map(beam));
    } else {
        beams.extend(directions.iter().map(beam));
    }
    beams.extend([FanBeam { along: 1.0, across: 0.0, slope: 0, column: 0 }; BLOCK - 1]);
}
