//! Drawing on a grid in meters.

use maps::{Cell, CellIndex, OccupancyGrid, Point, pose};
use nalgebra::Vector2;

/// An axis-aligned rectangle from (`x_m.0`, `y_m.0`) to (`x_m.1`, `y_m.1`).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rect {
    pub(crate) x_m: (f64, f64),
    pub(crate) y_m: (f64, f64),
}

pub(crate) const fn rect(x_m: (f64, f64), y_m: (f64, f64)) -> Rect {
    Rect { x_m, y_m }
}

/// Fills shapes: a cell belongs to a shape if its center does.
#[derive(Debug)]
pub(crate) struct Pen {
    grid: OccupancyGrid,
}

impl Pen {
    /// A grid of unknown cells that covers `sheet`. Cells are counted from its lower left corner.
    pub(crate) fn new(sheet: Rect, resolution_m: f64) -> Self {
        let cells = |(from, to): (f64, f64)| ((to - from) / resolution_m).round() as usize;
        let origin = pose(sheet.x_m.0, sheet.y_m.0, 0.0);
        Self { grid: OccupancyGrid::new(cells(sheet.x_m), cells(sheet.y_m), resolution_m, origin) }
    }

    pub(crate) fn finish(self) -> OccupancyGrid {
        self.grid
    }

    pub(crate) fn rect(&mut self, Rect { x_m, y_m }: Rect, cell: Cell) {
        self.fill(cell, |point| (x_m.0..x_m.1).contains(&point.x) && (y_m.0..y_m.1).contains(&point.y));
    }

    pub(crate) fn disc(&mut self, (x_m, y_m): (f64, f64), radius_m: f64, cell: Cell) {
        self.fill(cell, |point| (point - Point::new(x_m, y_m)).norm_squared() < radius_m * radius_m);
    }

    /// A straight stroke with round ends.
    pub(crate) fn stroke(&mut self, from: (f64, f64), to: (f64, f64), width_m: f64, cell: Cell) {
        let (from, to) = (Point::new(from.0, from.1), Point::new(to.0, to.1));
        let along: Vector2<f64> = to - from;
        self.fill(cell, |point| {
            let share = ((point - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (point - from - along * share).norm_squared() < width_m * width_m / 4.0
        });
    }

    /// Everything to the left of the line from `from` to `to`.
    pub(crate) fn beyond(&mut self, from: (f64, f64), to: (f64, f64), cell: Cell) {
        let (from, to) = (Point::new(from.0, from.1), Point::new(to.0, to.1));
        self.fill(cell, |point| (to - from).perp(&(point - from)) > 0.0);
    }

    fn fill(&mut self, cell: Cell, inside: impl Fn(&Point) -> bool) {
        for row in 0..self.grid.height() {
            for column in 0..self.grid.width() {
                let index = CellIndex { column, row };
                if inside(&self.grid.center(index)) {
                    self.grid.set(index, cell);
                }
            }
        }
    }
}
