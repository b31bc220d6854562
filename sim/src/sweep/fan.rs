//! The beams of one quadrant, in coordinates that are the same for all four.
//!
//! A fan passes through *rows*, one after another, and gains at most one *column* per row. For a fan along y these are
//! the grid's rows and columns; for one along x they are swapped. Rows are counted from the one that contains the
//! origin, in the direction of the fan: beams cross line k from row k − 1 to row k. Columns keep their numbers.

use maps::Point;
use nalgebra::Vector2;

use super::fixed::fixed;
use super::quadrant::Quadrant;

/// Number of beams measured at once.
pub(super) const BLOCK: usize = 4;

#[derive(Clone, Copy, Debug)]
pub(super) struct FanBeam {
    /// Component of the direction along the fan's axis; positive, and the larger one.
    pub(super) along: f64,
    /// Component across; positive towards higher columns.
    pub(super) across: f64,
    /// Columns gained from one line to the next, as a fixed-point number.
    pub(super) slope: i64,
    /// The column where it crosses or would have crossed line 0, as a fixed-point number: it crosses line k at `column
    /// + k · slope`.
    pub(super) column: i64,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// The index in the bitmap of the row that contains the origin.
    pub(super) row: usize,
    /// The column that contains the origin.
    pub(super) column: usize,
    /// The origin's coordinate across the fan's axis, in columns.
    pub(super) across: f64,
    /// Whether row 1 comes after row 0 in the bitmap.
    pub(super) forward: bool,
    /// The line from which distances are counted, 0 or 1: the lower of the two lines next to the origin in the grid.
    base: f64,
    /// Distance from the origin to that line: from −1 to 0 ahead if `forward`, from 0 to 1 if not.
    to_base: f64,
}

impl Origin {
    /// `point`, in grid coordinates, is inside the grid.
    pub(super) fn new(point: &Point, quadrant: Quadrant) -> Self {
        let (along, across) = if quadrant.is_along_x() { (point.x, point.y) } else { (point.y, point.x) };
        let forward = quadrant.is_forward();
        let (row, column) = (along as usize, across as usize);
        // This is exact: the row is 0, or at least half of the coordinate.
        let (base, to_base) = if forward { (0.0, row as f64 - along) } else { (1.0, along - row as f64) };
        Self { row, column, across, forward, base, to_base }
    }

    /// Distance from the origin to line `k` along the fan's axis; not positive for line 0, which no beam crosses.
    ///
    /// Because it is rounded once, it equals the difference of the coordinates.
    #[inline]
    pub(super) fn to_line(self, k: usize) -> f64 {
        (k as f64 - self.base) + self.to_base
    }

    /// The index of row `k` in the bitmap.
    #[inline]
    pub(super) fn row(self, k: usize) -> usize {
        if self.forward { self.row + k } else { self.row - k }
    }
}

/// Prepares the beams of a fan in ascending order of their slopes. `directions` are counter-clockwise, all in
/// `quadrant`. Some padding follows the last beam, so that blocks can be read from any beam on.
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
