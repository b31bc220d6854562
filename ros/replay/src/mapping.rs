//! Makes a map from the scans of a log at their corrected poses.
//!
//! Each cell counts the beams that ended in it and those that passed through. A cell is an obstacle if the beams that
//! ended there are a sufficient fraction of all its beams. This is the reflection model of D. Hähnel, "Mapping with
//! Mobile Robots", 2004; it does not depend on the order of scans.

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose, pose};
use robot::recorded::Recording;

/// The parameters of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappingParameters {
    /// Side of a cell, in meters. Default 0.05.
    pub resolution_m: f64,
    /// Beams count up to this range, in meters: farther away, a slight rotation of the pose moves their ends by whole
    /// cells. Default 20.
    pub range_max_m: f64,
    /// A cell is an obstacle if at least this fraction of the beams that reached it ended there. Default 0.2: grazing
    /// beams pass through the cells of a wall.
    pub hit_share: f64,
}

impl Default for MappingParameters {
    fn default() -> Self {
        Self { resolution_m: 0.05, range_max_m: 20.0, hit_share: 0.2 }
    }
}

/// Why there is no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MappingError {
    /// No beam of the log has hit anything.
    #[error("no beam of the log hit anything")]
    NothingSeen,
    /// The corrected poses are too far apart.
    #[error("the map would have {width} × {height} cells; the maximum is {}", maps::MAX_CELLS)]
    TooLarge {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
}

/// Makes a map from a log. Its frame is that of the corrected poses; its origin is aligned with the cells.
///
/// # Errors
/// [`MappingError`] if no beam hit anything or the map would be too large.
pub fn map_of(recording: &Recording, parameters: &MappingParameters) -> Result<OccupancyGrid, MappingError> {
    let frame = frame_of(recording, parameters)?;
    let mut counts = vec![Count::default(); frame.cells().len()];
    visit_beams(recording, parameters.range_max_m, |eye, direction, reach_m, hits| {
        // A hit is on the face of an obstacle, whose cell is behind it. With half a cell added, the faces of the marked
        // cells are, on average, at the faces of the obstacles.
        let depth_m = if hits { parameters.resolution_m / 2.0 } else { 0.0 };
        walk(&frame, eye, &(eye * (direction * (reach_m + depth_m))), |offset, is_last| {
            let count = &mut counts[offset];
            if hits && is_last { count.hits += 1 } else { count.passed += 1 }
        });
    });
    let cells = counts.iter().map(|count| count.cell(parameters.hit_share)).collect();
    Ok(OccupancyGrid::from_cells(frame.width(), frame.height(), frame.resolution_m(), frame.origin(), cells))
}

/// The beams that reached a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    hits: u32,
    passed: u32,
}

impl Count {
    fn cell(self, hit_share: f64) -> Cell {
        match self.hits + self.passed {
            0 => Cell::Unknown,
            all if f64::from(self.hits) >= hit_share * f64::from(all) => Cell::Occupied,
            _ => Cell::Free,
        }
    }
}

/// Visits all beams: the pose of the laser, the point at 1 m along the beam in the laser's frame, the beam's length,
/// and whether there is an obstacle at its end. A beam that hit nothing, or may have failed, gives no information and
/// is left out: some materials absorb it.
fn visit_beams(recording: &Recording, range_max_m: f64, mut visit: impl FnMut(&Pose, Point, f64, bool)) {
    for (_, scan, pose) in recording.corrected_scans() {
        let laser = &recording.model().lasers[scan.laser];
        let eye = pose * laser.mount;
        for (beam, range_m) in scan.ranges_m.iter().enumerate().filter(|(_, range_m)| range_m.is_finite()) {
            let (range_m, (sin, cos)) = (f64::from(*range_m), libm::sincos(laser.beam_angle_rad(beam)));
            visit(&eye, Point::new(cos, sin), range_m.min(range_max_m), range_m < range_max_m);
        }
    }
}

/// An empty grid around all beams, with a margin.
fn frame_of(recording: &Recording, parameters: &MappingParameters) -> Result<OccupancyGrid, MappingError> {
    let (mut low, mut high) =
        (Point::new(f64::INFINITY, f64::INFINITY), Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY));
    visit_beams(recording, parameters.range_max_m, |eye, direction, reach_m, _| {
        let end = eye * (direction * reach_m);
        let eye = Point::from(eye.translation.vector);
        (low, high) = (low.inf(&end).inf(&eye), high.sup(&end).sup(&eye));
    });
    if low.x > high.x {
        return Err(MappingError::NothingSeen);
    }
    let cell = |meters: f64| (meters / parameters.resolution_m).floor();
    let (left, bottom) = (cell(low.x) - MARGIN, cell(low.y) - MARGIN);
    let (width, height) =
        ((cell(high.x) + MARGIN + 1.0 - left) as usize, (cell(high.y) + MARGIN + 1.0 - bottom) as usize);
    if width.saturating_mul(height) > maps::MAX_CELLS {
        return Err(MappingError::TooLarge { width, height });
    }
    let origin = pose(left * parameters.resolution_m, bottom * parameters.resolution_m, 0.0);
    Ok(OccupancyGrid::new(width, height, parameters.resolution_m, origin))
}

/// Width of the margin around all beams, in cells.
const MARGIN: f64 = 10.0;

/// Visits the cells from a laser to a beam's end, in order.
///
/// Source: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987.
fn walk(frame: &OccupancyGrid, eye: &Pose, end: &Point, mut visit: impl FnMut(usize, bool)) {
    let (from, to) = (frame.to_grid(&eye.translation.vector.into()), frame.to_grid(end));
    let offset = to - from;
    let mut cell = [from.x.floor() as i64, from.y.floor() as i64];
    let last = [to.x.floor() as i64, to.y.floor() as i64];
    let axis = |offset: f64, at: f64, cell: i64| match offset {
        0.0 => (0, f64::INFINITY, f64::INFINITY),
        _ if offset > 0.0 => (1, ((cell + 1) as f64 - at) / offset, 1.0 / offset),
        _ => (-1, (cell as f64 - at) / offset, -1.0 / offset),
    };
    let (step_x, mut next_x, width_x) = axis(offset.x, from.x, cell[0]);
    let (step_y, mut next_y, width_y) = axis(offset.y, from.y, cell[1]);
    for _ in 0..(last[0] - cell[0]).abs() + (last[1] - cell[1]).abs() {
        mark(frame, cell, false, &mut visit);
        if next_x < next_y {
            (next_x, cell[0]) = (next_x + width_x, cell[0] + step_x);
        } else {
            (next_y, cell[1]) = (next_y + width_y, cell[1] + step_y);
        }
    }
    mark(frame, last, true, &mut visit);
}

fn mark(frame: &OccupancyGrid, [column, row]: [i64; 2], is_last: bool, visit: &mut impl FnMut(usize, bool)) {
    let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else { return };
    if let Some(offset) = frame.offset(CellIndex { column, row }) {
        visit(offset, is_last);
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use robot::LaserScan;
    use robot::recorded::LogWriter;

    use super::*;

    /// The map of a robot at (1.025, 2.025) with these ranges to the right, ahead (along x) and to the left.
    fn map(ranges_m: [f32; 3]) -> Result<OccupancyGrid, MappingError> {
        let mut log = LogWriter::new("test");
        let scan = LaserScan { time: Duration::ZERO, laser: 0, ranges_m: ranges_m.to_vec() };
        log.scan(&scan, &pose(0.0, 0.0, 0.0), &pose(1.025, 2.025, 0.0));
        let recording = Recording::read(log.into_text().as_bytes()).expect("a good log");
        map_of(&recording, &MappingParameters::default())
    }

    #[test]
    fn beams_clear_their_path_and_mark_their_end() {
        let map = map([f32::INFINITY, 2.98, 25.0]).expect("a beam hit something");
        let at = |x_m, y_m| map.index_of(&Point::new(x_m, y_m)).and_then(|index| map.cell(index));
        assert_eq!(at(1.025, 2.025), Some(Cell::Free), "where the robot is");
        assert_eq!([at(2.0, 2.025), at(3.975, 2.025)], [Some(Cell::Free); 2]);
        assert_eq!(at(4.025, 2.025), Some(Cell::Occupied));
        assert_eq!(at(4.075, 2.025), Some(Cell::Unknown), "behind the face at 4.005 m");
        assert_eq!(at(1.025, 1.975), Some(Cell::Unknown), "a beam that hit nothing is ignored");
        assert_eq!(at(1.025, 21.9), Some(Cell::Free), "a long beam clears up to its limit, and marks nothing");
        assert_eq!(map.cells().iter().filter(|cell| **cell == Cell::Occupied).count(), 1);
    }

    #[test]
    fn a_log_without_hits_makes_no_map() {
        assert_eq!(map([f32::INFINITY; 3]), Err(MappingError::NothingSeen));
    }
}
