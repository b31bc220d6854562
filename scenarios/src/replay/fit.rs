//! Whether a map is of the place that a log is from.

use maps::{Cell, CellIndex, OccupancyGrid, Point};
use robot::recorded::Recording;

/// Scans that are looked at, at most.
const SCANS: usize = 200;

/// Every how many beams of a scan are looked at.
const STRIDE: usize = 4;

/// A beam fits if it ends so near to an obstacle, in metres.
const NEAR_M: f64 = 0.15;

/// How well scans fit a map, seen from their corrected poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The share of beams that end near an obstacle.
    pub beams: f64,
    /// The share of poses on free cells of the map.
    pub poses: f64,
}

impl Fit {
    /// What a map of another place, or in another frame, does not reach by chance: a fifth of the beams and half of the
    /// poses are seen to fit there.
    pub const LEAST: Self = Self { beams: 0.4, poses: 0.5 };

    /// What a map made of the log's own scans reaches, with some to spare.
    pub const GOOD: Self = Self { beams: 0.7, poses: 0.9 };

    /// Looks at a sample of a log's scans; none if no beam has hit anything.
    #[must_use]
    pub fn of(recording: &Recording, map: &OccupancyGrid) -> Option<Self> {
        let scans = recording.corrected_scans().count();
        let (mut poses, mut free, mut beams, mut near) = (0_u32, 0_u32, 0_u32, 0_u32);
        for (_, scan, pose) in recording.corrected_scans().step_by(scans.div_ceil(SCANS).max(1)) {
            poses += 1;
            let at = map.index_of(&pose.translation.vector.into());
            free += u32::from(at.and_then(|at| map.cell(at)) == Some(Cell::Free));
            let laser = &recording.model().lasers[scan.laser];
            let eye = pose * laser.mount;
            for (beam, range_m) in scan.ranges_m.iter().enumerate().step_by(STRIDE).filter(|(_, r)| r.is_finite()) {
                let (sin, cos) = libm::sincos(laser.beam_angle_rad(beam));
                let end = eye * (Point::new(cos, sin) * f64::from(*range_m));
                beams += 1;
                near += u32::from(is_near_obstacle(map, &end));
            }
        }
        let share = |part: u32, whole: u32| f64::from(part) / f64::from(whole);
        (beams > 0).then(|| Self { beams: share(near, beams), poses: share(free, poses) })
    }

    /// Whether the map may be of that place.
    #[must_use]
    pub fn is_plausible(&self) -> bool {
        self.reaches(&Self::LEAST)
    }

    /// Whether it is as a map of that place should be.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.reaches(&Self::GOOD)
    }

    fn reaches(&self, least: &Self) -> bool {
        self.beams >= least.beams && self.poses >= least.poses
    }
}

fn is_near_obstacle(map: &OccupancyGrid, point: &Point) -> bool {
    let Some(at) = map.index_of(point) else { return false };
    let reach = (NEAR_M / map.resolution_m()).ceil() as usize;
    let around = |at: usize| at.saturating_sub(reach)..=at + reach;
    let mut cells = around(at.row).flat_map(|row| around(at.column).map(move |column| CellIndex { column, row }));
    cells.any(|index| map.cell(index) == Some(Cell::Occupied))
}
