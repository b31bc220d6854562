//! A map prepared for drawing, once per run.

use maps::{Cell, CellIndex, OccupancyGrid, Point};

use super::canvas::Canvas;
use super::geometry::Area;
use super::outline::Mask;
use super::theme;
use super::view::{Bounds, View};

/// With more blocks than this across, blocks would be finer than a pixel.
const MOST_BLOCKS: usize = 900;

/// Solid things thicker than this, in meters, have a lighter inside.
const THICK_M: f64 = 0.3;

/// Width of the dark outline of such things, in meters.
const RIM_M: f64 = 0.1;

/// Margin around the known cells, in meters.
const MARGIN_M: f64 = 0.6;

/// A map prepared for drawing: the outlines of its floor and its walls, cropped to the known part.
///
/// Make it once per run and share it; it takes no more than a few hundred kilobytes even for a large and noisy map. A
/// map that is finer than the picture is drawn in blocks of several cells, which are occupied if one of the cells is.
#[derive(Clone, Debug)]
pub struct MapPicture {
    /// Transforms blocks' coordinates to the `map` frame: the origin of block (0, 0), and the steps to the next column
    /// and row.
    corner: Point,
    column_step: nalgebra::Vector2<f64>,
    row_step: nalgebra::Vector2<f64>,
    occupied: Mask,
    floor: String,
    walls: String,
    insides: String,
    bounds: Bounds,
}

impl MapPicture {
    /// Prepares a map. A completely unknown map is an empty picture of the grid's size.
    #[must_use]
    pub fn new(grid: &OccupancyGrid) -> Self {
        // Maps are often drawn on a sheet that is mostly unknown, and in cells finer than a pixel: what cannot
        // be seen would only make the picture larger.
        let window = Window::around_known(grid);
        let cells_per_block = window.columns.max(window.rows).div_ceil(MOST_BLOCKS).max(1);
        let columns = window.columns.div_ceil(cells_per_block);
        let blocks = window.blocks(grid, cells_per_block);
        let mask = |wanted: fn(Cell) -> bool| Mask::new(columns, blocks.iter().map(|&block| wanted(block)).collect());
        let occupied = mask(|cell| cell == Cell::Occupied);
        let block_m = grid.resolution_m() * cells_per_block as f64;
        let corner = grid.from_grid(&Point::new(window.column as f64, window.row as f64));
        let turn = grid.origin().rotation;
        let column_step = turn * nalgebra::Vector2::new(block_m, 0.0);
        let row_step = turn * nalgebra::Vector2::new(0.0, block_m);
        let (far_column, far_row) =
            (column_step * columns.max(1) as f64, row_step * window.rows.div_ceil(cells_per_block).max(1) as f64);
        let corners = [corner, corner + far_column, corner + far_row, corner + far_column + far_row];
        let bounds = Bounds::around(corners).expect("a window has corners").grown(MARGIN_M);
        Self {
            corner,
            column_step,
            row_step,
            floor: mask(|cell| cell != Cell::Unknown).outline(),
            walls: occupied.outline(),
            insides: insides(&occupied, block_m).outline(),
            occupied,
            bounds,
        }
    }

    /// The visible part, with a margin.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Draws the floor and the walls.
    pub fn draw(&self, canvas: &mut Canvas, view: &View) {
        let matrix = view.matrix(self.corner, self.column_step, self.row_step);
        canvas.placed_path(&self.floor, matrix, theme::PAPER);
        canvas.placed_path(&self.walls, matrix, theme::WALL);
        canvas.placed_path(&self.insides, matrix, theme::SOLID);
    }

    /// The fraction of a box on the page that walls cover (0 to 1): of the blocks in it and, on a map that is turned,
    /// of those around it.
    pub fn covered(&self, area: &Area, view: &View) -> f64 {
        let to_blocks = nalgebra::Matrix2::from_columns(&[self.column_step, self.row_step]).try_inverse();
        let Some(to_blocks) = to_blocks else { return 0.0 };
        let spots = [(area.x, area.y), (area.right(), area.y), (area.x, area.bottom()), (area.right(), area.bottom())];
        let corners = spots.map(|spot| to_blocks * (view.point_at(spot) - self.corner));
        let range = |along: fn(&nalgebra::Vector2<f64>) -> f64| {
            let [low, high] = [f64::min, f64::max].map(|extreme| corners.iter().map(along).reduce(extreme));
            low.unwrap_or(0.0).max(0.0) as usize..high.unwrap_or(0.0).max(0.0).ceil() as usize
        };
        let (columns, rows) = (range(|corner| corner.x), range(|corner| corner.y));
        let all = columns.len() * rows.len();
        let walls = rows.flat_map(|row| columns.clone().map(move |column| (column, row)));
        walls.filter(|&(column, row)| self.occupied.get(column, row)).count() as f64 / all.max(1) as f64
    }
}

/// The light insides of thick things.
fn insides(occupied: &Mask, block_m: f64) -> Mask {
    let blocks = |length_m: f64| (length_m / block_m).ceil().max(1.0) as usize;
    let radius = blocks(THICK_M / 2.0);
    occupied.eroded(radius).dilated(radius.saturating_sub(blocks(RIM_M)))
}

/// The part of a grid that is drawn, in cells.
struct Window {
    column: usize,
    row: usize,
    columns: usize,
    rows: usize,
}

impl Window {
    /// The smallest window around all known cells; the whole grid if there are none.
    fn around_known(grid: &OccupancyGrid) -> Self {
        let (mut low, mut high) = ((usize::MAX, usize::MAX), (0, 0));
        for (row, cells) in grid.cells().chunks(grid.width().max(1)).enumerate() {
            let known = |cell: &Cell| *cell != Cell::Unknown;
            if let (Some(first), Some(last)) = (cells.iter().position(known), cells.iter().rposition(known)) {
                low = (low.0.min(first), low.1.min(row));
                high = (high.0.max(last), row);
            }
        }
        if low.0 == usize::MAX {
            return Self { column: 0, row: 0, columns: grid.width(), rows: grid.height() };
        }
        Self { column: low.0, row: low.1, columns: high.0 - low.0 + 1, rows: high.1 - low.1 + 1 }
    }

    /// The window as square blocks of cells, row by row. A block is occupied if one of its cells is, and otherwise free
    /// if one of them is.
    fn blocks(&self, grid: &OccupancyGrid, cells_per_block: usize) -> Vec<Cell> {
        let block = |column: usize, row: usize| {
            let cells = (0..cells_per_block * cells_per_block).filter_map(|i| {
                let column = self.column + column * cells_per_block + i % cells_per_block;
                let row = self.row + row * cells_per_block + i / cells_per_block;
                grid.cell(CellIndex { column, row })
            });
            cells.fold(Cell::Unknown, |seen, cell| match (seen, cell) {
                (Cell::Occupied, _) | (_, Cell::Occupied) => Cell::Occupied,
                (Cell::Free, _) | (_, Cell::Free) => Cell::Free,
                _ => Cell::Unknown,
            })
        };
        let columns = self.columns.div_ceil(cells_per_block);
        (0..self.rows.div_ceil(cells_per_block))
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| block(column, row))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::*;

    /// A room of 1 m × 2 m with a wall along its left side, somewhere in an unknown grid of 100 × 100 cells of 0.1 m.
    fn room(heading_rad: f64) -> OccupancyGrid {
        let mut grid = OccupancyGrid::new(100, 100, 0.1, pose(-5.0, -5.0, heading_rad));
        for row in 40..60 {
            for column in 50..60 {
                let cell = if column == 50 { Cell::Occupied } else { Cell::Free };
                grid.set(CellIndex { column, row }, cell);
            }
        }
        grid
    }

    #[test]
    fn a_picture_shows_what_is_known_with_a_margin() {
        let bounds = MapPicture::new(&room(0.0)).bounds();
        assert!((bounds.low - Point::new(-MARGIN_M, -1.0 - MARGIN_M)).norm() < 1e-9, "{bounds:?}");
        assert!((bounds.high - Point::new(1.0 + MARGIN_M, 1.0 + MARGIN_M)).norm() < 1e-9, "{bounds:?}");
    }

    #[test]
    fn a_rotated_grid_is_drawn_rotated() {
        let picture = MapPicture::new(&room(std::f64::consts::FRAC_PI_2));
        let extent = picture.bounds().high - picture.bounds().low;
        assert!((extent - nalgebra::Vector2::new(2.0, 1.0).add_scalar(2.0 * MARGIN_M)).norm() < 1e-9, "{extent}");
    }

    #[test]
    fn walls_are_found_where_they_are_drawn() {
        let picture = MapPicture::new(&room(0.3));
        let view = View::fitting(picture.bounds(), Area::new(0.0, 0.0, 640.0, 640.0));
        let around = |column: f64, row: f64| {
            let spot = view.spot(room(0.3).from_grid(&Point::new(column, row))).expect("the cell is finite");
            picture.covered(&Area::around(spot, 2.0, 2.0), &view)
        };
        assert_eq!((around(50.5, 45.0), around(52.5, 45.0), around(40.0, 45.0)), (1.0, 0.0, 0.0));
    }

    #[test]
    fn a_map_finer_than_the_picture_keeps_its_thin_walls() {
        let mut grid = OccupancyGrid::new(3000, 10, 0.01, pose(0.0, 0.0, 0.0));
        for column in 0..3000 {
            grid.set(CellIndex { column, row: 5 }, if column == 1501 { Cell::Occupied } else { Cell::Free });
        }
        let picture = MapPicture::new(&grid);
        assert_eq!(picture.walls, "M375,0h1v1h-1v-1z");
        assert_eq!(picture.floor, "M0,0h750v1h-750v-1z");
    }

    #[test]
    fn only_thick_things_have_a_lighter_inside() {
        let cells = |wide: usize| Mask::new(40, (0..1600).map(|i| (10..10 + wide).contains(&(i % 40))).collect());
        assert_eq!(insides(&cells(6), 0.05).outline(), "");
        assert_eq!(insides(&cells(10), 0.05).outline(), "M12,0h6v40h-6v-40z");
    }
}
