//! A search on two levels, for long ways on large maps.
//!
//! Where many ways are about equally long, A* expands nearly all cells of a building. Blocks of 8 × 8 cells are far
//! fewer. So the way is searched through the connected parts of blocks first, and then through the cells near that way.
//! It may cost slightly more than the cheapest one, since the cost of a step from part to part is only estimated.

use super::astar::{DIAGONAL, GaveUp, STRAIGHT, remaining, shortest_path};
use super::standing::Ground;

/// The number of cells along the side of a block, whose cells are the bits of a number: row by row, from the lowest.
const SIDE: usize = 8;

/// The first column of a block, and its first row.
const COLUMN: u64 = 0x0101_0101_0101_0101;
const ROW: u64 = 0xff;

/// How many blocks beside the way are searched, too. With one block, 1 of 1,000 random trips in a warehouse of 50 m ×
/// 84 m was 2.2 % longer than A*'s; with two, in three such sets, at most 1.5 %.
const BESIDE: usize = 2;

/// How much more expensive the first way becomes, in parts of 32. Chosen: the estimates of ways err by less.
const SURCHARGE: u32 = 2;

/// The cost of a cell on the line between two parts where the robot cannot be: a little more than that of any other,
/// since the way leads around it.
const DETOUR_COST: u32 = 60;

/// A connected part of the cells of a block where the robot can be.
#[derive(Clone, Copy)]
struct Part {
    block: usize,
    cells: u64,
    /// Its cheapest cell; of equally cheap ones, that nearest to the middle of the block.
    center: usize,
}

struct Blocks<'a> {
    ground: &'a Ground<'a>,
    columns: usize,
    rows: usize,
    /// The parts of all blocks, block by block.
    parts: Vec<Part>,
    /// For each block, its first part; then the number of parts.
    first: Vec<usize>,
}

/// After how many visited cells a search over all cells gives up: a building of 300,000 cells has fewer where the robot
/// can be, and a campus of 4 million would take 1.4 s.
const MOST_CELLS: usize = 133_000;

/// The cells of a path from one cell to another, inclusive, or `None` if there is none: the cheapest one or, if it
/// would take long to find, a cheap one.
pub(super) fn path(ground: &Ground<'_>, from: usize, to: usize) -> Option<Vec<usize>> {
    shortest_path(ground, from, to, None, MOST_CELLS).unwrap_or_else(|GaveUp| cheap_path(ground, from, to))
}

/// The cells of a cheap path from one cell to another, inclusive, or `None` if there is none.
fn cheap_path(ground: &Ground<'_>, from: usize, to: usize) -> Option<Vec<usize>> {
    let blocks = Blocks::of(ground);
    let [first, last] = [blocks.part_of(from)?, blocks.part_of(to)?];
    let mut near = vec![false; blocks.columns * blocks.rows];
    let mut steps: Vec<Option<Vec<(usize, u32)>>> = vec![None; blocks.parts.len()];
    // The estimates of two ways may err by some percent, so the cells of a second way are searched, too, which is found
    // by making the first one more expensive. With one way only, a trip in the warehouse was 2.5 % longer.
    for _ in 0..2 {
        let center = |part: usize| blocks.parts[part].center as u32;
        // With costs of the same type as those of cells, both searches would share a heap, which is then not inlined.
        let left = |part: &usize| u64::from(remaining(ground, center(*part), center(last)));
        let factor = |part: usize| if near[blocks.parts[part].block] { 32 + SURCHARGE } else { 32 };
        let steps = |part: &usize| {
            let steps = steps[*part].get_or_insert_with(|| blocks.steps(*part));
            steps.iter().map(|(next, cost)| (*next, u64::from(cost * factor(*next) / 32))).collect::<Vec<_>>()
        };
        let (way, _) = pathfinding::prelude::astar(&first, steps, left, |part| *part == last)?;
        blocks.mark_near(&way, &mut near);
    }
    shortest_path(ground, from, to, Some(&|cell| near[blocks.block(cell)]), usize::MAX).unwrap_or(None)
}

impl<'a> Blocks<'a> {
    fn of(ground: &'a Ground<'a>) -> Self {
        let frame = &ground.costmap.frame;
        let (columns, rows) = (frame.width.div_ceil(SIDE), frame.height.div_ceil(SIDE));
        let mut blocks = Self { ground, columns, rows, parts: Vec::new(), first: Vec::new() };
        for block in 0..columns * rows {
            blocks.first.push(blocks.parts.len());
            let mut open = blocks.open(block);
            while open != 0 {
                let cells = connected(open);
                open &= !cells;
                let center = blocks.center(block, cells);
                blocks.parts.push(Part { block, cells, center });
            }
        }
        blocks.first.push(blocks.parts.len());
        blocks
    }

    /// The cells of a block where the robot can be.
    fn open(&self, block: usize) -> u64 {
        let frame = &self.ground.costmap.frame;
        let (left, low) = (block % self.columns * SIDE, block / self.columns * SIDE);
        let mut open = 0;
        for (y, row) in (low..(low + SIDE).min(frame.height)).enumerate() {
            let cells = row * frame.width + left..row * frame.width + (left + SIDE).min(frame.width);
            for (x, cost) in self.ground.costs(cells).enumerate() {
                open |= u64::from(cost > 0) << (y * SIDE + x);
            }
        }
        open
    }

    fn center(&self, block: usize, cells: u64) -> usize {
        let off =
            |bit: usize| (2 * (bit % SIDE) + 1).abs_diff(SIDE).pow(2) + (2 * (bit / SIDE) + 1).abs_diff(SIDE).pow(2);
        let (mut best, mut rest) = ((u32::MAX, usize::MAX, 0), cells);
        while rest != 0 {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let cell = self.cell(block, bit);
            best = best.min((self.ground.cost(cell), off(bit), cell));
        }
        best.2
    }

    fn cell(&self, block: usize, bit: usize) -> usize {
        let (column, row) = (block % self.columns * SIDE + bit % SIDE, block / self.columns * SIDE + bit / SIDE);
        row * self.ground.costmap.frame.width + column
    }

    fn block(&self, cell: usize) -> usize {
        let (column, row) = self.ground.costmap.frame.column_and_row(cell);
        row / SIDE * self.columns + column / SIDE
    }

    fn part_of(&self, cell: usize) -> Option<usize> {
        let (column, row) = self.ground.costmap.frame.column_and_row(cell);
        let bit = row % SIDE * SIDE + column % SIDE;
        self.parts_of(self.block(cell)).find(|part| self.parts[*part].cells >> bit & 1 != 0)
    }

    fn parts_of(&self, block: usize) -> std::ops::Range<usize> {
        self.first[block]..self.first[block + 1]
    }

    /// The parts that share a side with a part.
    fn beside(&self, part: usize) -> Vec<usize> {
        let Part { block, cells, .. } = self.parts[part];
        let (column, row) = (block % self.columns, block / self.columns);
        // The cells of the next block that are beside cells of this part.
        let sides = [
            (column + 1 < self.columns).then(|| (block + 1, cells >> (SIDE - 1) & COLUMN)),
            (column > 0).then(|| (block - 1, (cells & COLUMN) << (SIDE - 1))),
            (row + 1 < self.rows).then(|| (block + self.columns, cells >> (SIDE * (SIDE - 1)) & ROW)),
            (row > 0).then(|| (block - self.columns, (cells & ROW) << (SIDE * (SIDE - 1)))),
        ];
        let touched = |(block, beside): (usize, u64)| {
            self.parts_of(block).filter(move |part| self.parts[*part].cells & beside != 0)
        };
        sides.into_iter().flatten().flat_map(touched).collect()
    }

    /// The parts to which a step leads, with its estimated cost: those beside a part and, diagonally, those beside
    /// them.
    fn steps(&self, part: usize) -> Vec<(usize, u32)> {
        let mut next = self.beside(part);
        for between in 0..next.len() {
            for diagonal in self.beside(next[between]) {
                let [here, there] = [part, diagonal].map(|part| self.parts[part].block);
                let is_diagonal =
                    here % self.columns != there % self.columns && here / self.columns != there / self.columns;
                if is_diagonal && !next.contains(&diagonal) {
                    next.push(diagonal);
                }
            }
        }
        next.into_iter().map(|next| (next, self.cost(part, next))).collect()
    }

    /// The cost of the straight line between the centers of two parts.
    fn cost(&self, from: usize, to: usize) -> u32 {
        let frame = &self.ground.costmap.frame;
        let [(x, y), (to_x, to_y)] = [from, to].map(|part| frame.column_and_row(self.parts[part].center));
        let (across, along) = (x.abs_diff(to_x), y.abs_diff(to_y));
        let (short, long) = (across.min(along), across.max(along));
        let between = |from: usize, to: usize, step: usize| (from * (long - step) + to * step) / long;
        let costs = (1..=long).map(|step| {
            let cost = self.ground.cost(between(y, to_y, step) * frame.width + between(x, to_x, step));
            if cost == 0 { DETOUR_COST } else { cost }
        });
        let length = short as u32 * DIAGONAL + (long - short) as u32 * STRAIGHT;
        costs.sum::<u32>() * length / long as u32
    }

    /// Marks the blocks near a way.
    fn mark_near(&self, way: &[usize], near: &mut [bool]) {
        for part in way {
            let block = self.parts[*part].block;
            let (column, row) = (block % self.columns, block / self.columns);
            let (left, right) = (column.saturating_sub(BESIDE), (column + BESIDE).min(self.columns - 1));
            for row in row.saturating_sub(BESIDE)..=(row + BESIDE).min(self.rows - 1) {
                near[row * self.columns + left..=row * self.columns + right].fill(true);
            }
        }
    }
}

/// The cells that are connected with the first of these cells of a block.
fn connected(open: u64) -> u64 {
    let mut cells = open & open.wrapping_neg();
    loop {
        let across = (cells & !(COLUMN << (SIDE - 1))) << 1 | (cells & !COLUMN) >> 1;
        let grown = (cells | across | cells << SIDE | cells >> SIDE) & open;
        if grown == cells {
            return cells;
        }
        cells = grown;
    }
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, OccupancyGrid, Point, pose};
    use rand::{RngExt, SeedableRng};

    use super::super::{astar, smoothing};
    use super::*;
    use crate::{Costmap, CostmapParameters};

    /// Rooms of 3.1 m, each with a door to every neighbor, some of them closed.
    fn rooms(across: usize, dice: &mut impl RngExt) -> OccupancyGrid {
        const ROOM: usize = 62;
        let size = across * ROOM;
        let mut map = OccupancyGrid::new(size, size, 0.05, pose(0.0, 0.0, 0.0));
        let mut fill = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>, cell| {
            rows.for_each(|row| columns.clone().for_each(|column| map.set(CellIndex { column, row }, cell)));
        };
        fill(0..size, 0..size, Cell::Free);
        for at in (0..across).map(|wall| wall * ROOM) {
            fill(at..at + 3, 0..size, Cell::Occupied);
            fill(0..size, at..at + 3, Cell::Occupied);
        }
        for (wall, room) in (1..across).flat_map(|wall| (0..across).map(move |room| (wall * ROOM, room * ROOM))) {
            let [one, other] = [0; 2].map(|_| room + dice.random_range(8..40));
            if dice.random_range(0..8) > 0 {
                fill(wall..wall + 3, one..one + 18, Cell::Free);
            }
            if dice.random_range(0..8) > 0 {
                fill(other..other + 18, wall..wall + 3, Cell::Free);
            }
        }
        map
    }

    type Search = fn(&Ground<'_>, usize, usize) -> Option<Vec<usize>>;

    /// How much longer than the cheapest path the one found is at most, for trips between random places this far apart.
    fn excess(map: &OccupancyGrid, search: Search, least_m: f64, trips: usize, dice: &mut impl RngExt) -> f64 {
        let costmap = Costmap::new(map, CostmapParameters::default()).expect("the parameters are valid");
        let ground = Ground::new(&costmap);
        let standable: Vec<usize> = (0..map.cells().len()).filter(|cell| ground.can_stand(*cell)).collect();
        let length_m = |cells: &[usize], end: &Point| {
            let path = smoothing::smoothed(&ground, cells, None, end);
            path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>()
        };
        let apart_m = |[from, to]: &[usize; 2]| (costmap.frame.center(*from) - costmap.frame.center(*to)).norm();
        let ends = std::iter::repeat_with(|| [0; 2].map(|_| standable[dice.random_range(0..standable.len())]));
        let trip = |[from, to]: [usize; 2]| {
            let cheapest = astar::shortest_path(&ground, from, to, None, usize::MAX).expect("it never gives up");
            let cheap = search(&ground, from, to);
            let (Some(cheap), Some(cheapest)) = (&cheap, &cheapest) else {
                assert_eq!(cheap, cheapest, "both or none find a path");
                return 0.0;
            };
            assert_eq!((cheap[0], cheap[cheap.len() - 1]), (from, to));
            for pair in cheap.windows(2) {
                assert!(astar::successors(&ground, pair[0] as u32).any(|(next, _)| next as usize == pair[1]));
            }
            let end = costmap.frame.center(to);
            length_m(cheap, &end) / length_m(cheapest, &end).max(0.05) - 1.0
        };
        ends.filter(|ends| apart_m(ends) >= least_m).take(trips).map(trip).fold(0.0, f64::max)
    }

    #[test]
    fn paths_through_blocks_are_at_most_two_percent_longer() {
        let mut dice = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        for _ in 0..4 {
            let excess = excess(&rooms(9, &mut dice), cheap_path, 15.0, 10, &mut dice);
            assert!(excess <= 0.02, "{excess}");
        }
    }

    /// `STEWARD_MAPS=FOLDER cargo test --release -p steward-nav -- on_maps_of_a_folder --ignored --nocapture`
    #[test]
    #[ignore = "needs maps, and minutes"]
    fn paths_on_maps_of_a_folder_are_at_most_two_percent_longer_on_demand() {
        let Ok(folder) = std::env::var("STEWARD_MAPS") else {
            return println!("not run: STEWARD_MAPS names no folder");
        };
        let mut dice = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        for file in std::fs::read_dir(folder).expect("a folder").map(|file| file.expect("a file").path()) {
            if file.extension().is_some_and(|ending| ending == "yaml") {
                let map = maps::load_map(&file, &|path| std::fs::read(path)).expect("a map");
                let excess = excess(&map, path, 0.0, 1000, &mut dice);
                println!("{}: at most {:.2} % longer", file.display(), 100.0 * excess);
                assert!(excess <= 0.02, "{}: {excess}", file.display());
            }
        }
    }
}
