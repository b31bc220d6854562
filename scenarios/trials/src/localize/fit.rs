//! Whether a map shows the place where a log was recorded, and what its cells represent.
//!
//! The walls of a drawn map end at the faces of cells. A map made from scans has a wall in every cell in which beams
//! ended, anywhere in the cell: its surfaces lie about half a cell behind the faces.

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose};
use nav::LocalizationParameters;
use robot::recorded::Recording;

/// Number of scans in the sample, at most.
const SCANS: usize = 200;

/// One out of this many beams of a scan is used.
const STRIDE: usize = 4;

/// A beam fits if it ends this close to an obstacle, in meters.
const NEAR_M: f64 = 0.15;

/// Step length along a beam in the search for the face of an obstacle, in meters.
const STEP_M: f64 = 0.005;

/// How well scans at their corrected poses fit a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The fraction of beams that end near an obstacle.
    pub beams: f64,
    /// The fraction of poses on free cells of the map.
    pub poses: f64,
    /// How far behind the faces of cells beams end, in meters: the median of the beams that end near a face. At least
    /// zero, at most half a cell: greater depths come from errors of the poses, which occur on both sides.
    pub surface_depth_m: f64,
}

/// Thresholds for the fractions of beams and poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Of beams.
    pub beams: f64,
    /// Of poses.
    pub poses: f64,
}

impl Fit {
    /// A map of another place, or in another frame, does not reach these by chance: on such maps, a fifth of the beams
    /// and half of the poses fit.
    pub const LEAST: Shares = Shares { beams: 0.4, poses: 0.5 };

    /// A map made from the log's own scans easily reaches these.
    pub const GOOD: Shares = Shares { beams: 0.7, poses: 0.9 };

    /// Examines a sample of a log's scans; none if no beam has hit anything.
    #[must_use]
    pub fn of(recording: &Recording, map: &OccupancyGrid) -> Option<Self> {
        let scans = recording.corrected_scans().count();
        let (mut poses, mut free, mut beams, mut near) = (0_u32, 0_u32, 0_u32, 0_u32);
        let mut depths_m = Vec::new();
        for (_, scan, pose) in recording.corrected_scans().step_by(scans.div_ceil(SCANS).max(1)) {
            poses += 1;
            let at = map.index_of(&pose.translation.vector.into());
            free += u32::from(at.and_then(|at| map.cell(at)) == Some(Cell::Free));
            let laser = &recording.model().lasers[scan.laser];
            let eye = pose * laser.mount;
            for (beam, range_m) in scan.ranges_m.iter().enumerate().step_by(STRIDE).filter(|(_, r)| r.is_finite()) {
                let (range_m, beam_rad) = (f64::from(*range_m), laser.beam_angle_rad(beam));
                beams += 1;
                near += u32::from(is_near_obstacle(map, &end_of(&eye, beam_rad, range_m)));
                depths_m.extend(depth_m(map, &eye, beam_rad, range_m));
            }
        }
        let share = |part: u32, whole: u32| f64::from(part) / f64::from(whole);
        depths_m.sort_unstable_by(f64::total_cmp);
        let depth_m = depths_m.get(depths_m.len() / 2).copied().unwrap_or_default();
        (beams > 0).then(|| Self {
            beams: share(near, beams),
            poses: share(free, poses),
            surface_depth_m: depth_m.clamp(0.0, map.resolution_m() / 2.0),
        })
    }

    /// Whether the map may show that place.
    #[must_use]
    pub fn is_plausible(&self) -> bool {
        self.reaches(&Self::LEAST)
    }

    /// Whether it fits as well as a map of that place should.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.reaches(&Self::GOOD)
    }

    /// The parameters of localization on the map: those of scenarios, except the depth of surfaces.
    #[must_use]
    pub fn parameters(&self) -> LocalizationParameters {
        LocalizationParameters { surface_depth: self.surface_depth_m, ..LocalizationParameters::default() }
    }

    fn reaches(&self, least: &Shares) -> bool {
        self.beams >= least.beams && self.poses >= least.poses
    }
}

fn end_of(eye: &Pose, beam_rad: f64, range_m: f64) -> Point {
    let (sin, cos) = libm::sincos(beam_rad);
    eye * (Point::new(cos, sin) * range_m)
}

/// How far a beam ends behind the face that it hits, in meters, if that is close. Negative if it ends in front of it.
fn depth_m(map: &OccupancyGrid, eye: &Pose, beam_rad: f64, range_m: f64) -> Option<f64> {
    let is_occupied = |depth_m: f64| {
        let at = map.index_of(&end_of(eye, beam_rad, range_m - depth_m));
        at.and_then(|at| map.cell(at)) == Some(Cell::Occupied)
    };
    let steps = (2.0 * NEAR_M / STEP_M) as u32;
    let mut depths_m = (0..=steps).map(|step| NEAR_M - f64::from(step) * STEP_M);
    // A face that is farther in front of the beam's end is not the one that the beam hit.
    depths_m.find(|depth_m| is_occupied(*depth_m)).filter(|depth_m| *depth_m < NEAR_M)
}

fn is_near_obstacle(map: &OccupancyGrid, point: &Point) -> bool {
    let Some(at) = map.index_of(point) else { return false };
    let reach = (NEAR_M / map.resolution_m()).ceil() as usize;
    let around = |at: usize| at.saturating_sub(reach)..=at + reach;
    let mut cells = around(at.row).flat_map(|row| around(at.column).map(move |column| CellIndex { column, row }));
    cells.any(|index| map.cell(index) == Some(Cell::Occupied))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use maps::pose;
    use robot::LaserScan;
    use robot::recorded::LogWriter;

    use super::*;

    /// The fit of a robot at (1, 1) to a hall of 3 m × 2 m with walls of one cell. It sees the walls ahead (1 m) and on
    /// both sides at this depth behind their faces.
    fn fit(depth_m: f32) -> Option<Fit> {
        let mut map = OccupancyGrid::new(40, 40, 0.05, pose(0.0, 0.0, 0.0));
        for index in (0..40).flat_map(|row| (0..40).map(move |column| CellIndex { column, row })) {
            let wall = [0, 39].contains(&index.column) || [0, 39].contains(&index.row);
            map.set(index, if wall { Cell::Occupied } else { Cell::Free });
        }
        let mut log = LogWriter::new("test");
        let ranges_m = vec![0.95 + depth_m, f32::INFINITY, 0.95 + depth_m, f32::INFINITY, 0.95 + depth_m];
        for second in 0..4 {
            let scan = LaserScan { time: Duration::from_secs(second), laser: 0, ranges_m: ranges_m.clone() };
            log.scan(&scan, &pose(0.0, 0.0, 0.0), &pose(1.0, 1.0, 0.0));
        }
        Fit::of(&Recording::read(log.into_text().as_bytes()).unwrap(), &map)
    }

    #[test]
    fn the_depth_of_surfaces_in_cells_is_estimated() {
        for (depth_m, expected_m) in [(0.0, 0.0), (0.01, 0.01), (0.025, 0.025), (0.048, 0.025), (-0.04, 0.0)] {
            let fit = fit(depth_m).unwrap();
            assert!((fit.surface_depth_m - expected_m).abs() < 1.1 * STEP_M, "{depth_m}: {fit:?}");
            assert!(fit.is_good());
        }
    }

    #[test]
    fn a_log_whose_beams_hit_nothing_fits_no_map() {
        assert_eq!(fit(f32::INFINITY), None);
    }
}
