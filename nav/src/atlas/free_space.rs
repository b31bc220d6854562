//! The free cells of a map, to draw poses from.

use std::f64::consts::{PI, TAU};

use maps::{Cell, OccupancyGrid};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::particle::Particle;

/// Free cells as runs along rows: compact, and each cell is equally likely to be drawn.
#[derive(Clone, Debug)]
pub(crate) struct FreeSpace {
    width: usize,
    resolution_m: f64,
    runs: Vec<CellRun>,
    cells: usize,
}

#[derive(Clone, Copy, Debug)]
struct CellRun {
    /// Offset of the first cell.
    start: u32,
    /// Free cells before this run.
    before: u32,
}

impl FreeSpace {
    /// The free cells of a map, or `None` if there is none.
    pub(crate) fn new(map: &OccupancyGrid) -> Option<Self> {
        let mut runs: Vec<CellRun> = Vec::new();
        let mut cells = 0;
        let mut in_run = false;
        for (offset, cell) in map.cells().iter().enumerate() {
            let free = *cell == Cell::Free;
            if free && !in_run {
                runs.push(CellRun { start: offset as u32, before: cells as u32 });
            }
            in_run = free;
            cells += usize::from(free);
        }
        (cells > 0).then_some(Self { width: map.width(), resolution_m: map.resolution_m(), runs, cells })
    }

    /// The area of the free space, in square meters.
    pub(crate) fn area_m2(&self) -> f64 {
        self.cells as f64 * self.resolution_m * self.resolution_m
    }

    /// A random pose on a free cell with a random heading, in the grid's frame.
    pub(crate) fn draw(&self, rng: &mut ChaCha8Rng) -> Particle {
        let cell = rng.random_range(0..self.cells) as u32;
        let run = self.runs[self.runs.partition_point(|run| run.before <= cell) - 1];
        let offset = (run.start + cell - run.before) as usize;
        let x_m = ((offset % self.width) as f64 + rng.random::<f64>()) * self.resolution_m;
        let y_m = ((offset / self.width) as f64 + rng.random::<f64>()) * self.resolution_m;
        Particle::new(x_m, y_m, rng.random::<f64>() * TAU - PI)
    }
}

#[cfg(test)]
mod tests {
    use maps::{CellIndex, Point, pose};

    use super::*;

    #[test]
    fn exactly_the_free_cells_are_drawn_equally_often() {
        let mut map = OccupancyGrid::new(7, 5, 0.5, pose(0.0, 0.0, 0.0));
        let free = [(0, 0), (6, 0), (0, 1), (2, 2), (3, 2), (6, 4)];
        for (column, row) in free {
            map.set(CellIndex { column, row }, Cell::Free);
        }
        let space = FreeSpace::new(&map).unwrap();
        let mut rng = robot::Streams::new(2).stream("free");
        let mut drawn = [0; 6];
        for _ in 0..6000 {
            let particle = space.draw(&mut rng);
            let cell = map.index_of(&Point::new(particle.x_m, particle.y_m)).unwrap();
            drawn[free.iter().position(|at| *at == (cell.column, cell.row)).unwrap()] += 1;
        }
        assert!(drawn.iter().all(|count| (880..1120).contains(count)), "{drawn:?}");
    }

    #[test]
    fn a_map_without_free_cells_has_no_free_space() {
        assert!(FreeSpace::new(&OccupancyGrid::new(4, 4, 0.1, pose(0.0, 0.0, 0.0))).is_none());
    }
}
