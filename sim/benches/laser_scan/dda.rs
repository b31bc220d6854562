//! The usual fast way to cast a beam: an f32 traversal that chooses its direction without branches.

use maps::{Cell, OccupancyGrid, Pose};
use nalgebra::Vector2;
use sim::Beams;

const TRANSPARENT: u8 = 0;
const OCCUPIED: u8 = 1;
const BORDER: u8 = 2;

/// A grid with a border of one cell on all sides.
pub(crate) struct Dda {
    cells: Vec<u8>,
    stride: usize,
    resolution_m: f64,
    from_map: Pose,
}

impl Dda {
    pub(crate) fn new(grid: &OccupancyGrid) -> Self {
        let stride = grid.width() + 2;
        let mut cells = vec![BORDER; stride * (grid.height() + 2)];
        for (row, from) in grid.cells().chunks(grid.width()).enumerate() {
            let to = &mut cells[(row + 1) * stride + 1..][..from.len()];
            to.iter_mut()
                .zip(from)
                .for_each(|(to, from)| *to = if *from == Cell::Occupied { OCCUPIED } else { TRANSPARENT });
        }
        Self { cells, stride, resolution_m: grid.resolution_m(), from_map: grid.origin().inverse() }
    }

    /// The ranges of a scan from within the grid.
    pub(crate) fn ranges(&self, beams: &Beams, base: &Pose, range_max_m: f32, ranges_m: &mut Vec<f32>) {
        let base = self.from_map * base;
        let origin = (base * beams.origin() / self.resolution_m).coords;
        let (origin, resolution_m) = (origin.map(|c| c as f32), self.resolution_m as f32);
        ranges_m.clear();
        ranges_m.extend(beams.directions().map(|direction| {
            let direction = (base.rotation * direction).map(|c| c as f32);
            self.cast(origin, direction, range_max_m / resolution_m) * resolution_m
        }));
    }

    fn cast(&self, origin: Vector2<f32>, direction: Vector2<f32>, max: f32) -> f32 {
        let cell = origin.map(|c| c as usize);
        let mut offset = (cell.y + 1) * self.stride + cell.x + 1;
        if self.cells[offset] == OCCUPIED {
            return 0.0;
        }
        let pace = direction.map(|c| 1.0 / c.abs());
        let part = origin - cell.map(|c| c as f32);
        let to_line = |c: f32, part: f32, pace: f32| if c < 0.0 { part * pace } else { (1.0 - part) * pace };
        let mut x = to_line(direction.x, part.x, pace.x);
        let mut y = to_line(direction.y, part.y, pace.y);
        let right = if direction.x < 0.0 { usize::MAX } else { 1 };
        let up = if direction.y < 0.0 { self.stride.wrapping_neg() } else { self.stride };
        // Beyond the longest range it may continue to the border; that is cheaper than checking in each step.
        let (distance, cell) = loop {
            let distance = x.min(y);
            // All ones if the next line is one across x: the sign of the difference.
            let across_x = (x - y).to_bits().cast_signed() >> 31;
            let masked = |value: f32, mask: i32| f32::from_bits(value.to_bits() & mask.cast_unsigned());
            x += masked(pace.x, across_x);
            y += masked(pace.y, !across_x);
            offset = offset.wrapping_add(up ^ ((up ^ right) & across_x as usize));
            if self.cells[offset] != TRANSPARENT {
                break (distance, self.cells[offset]);
            }
        };
        if cell == OCCUPIED && distance <= max { distance } else { f32::INFINITY }
    }
}
