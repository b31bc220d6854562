//! Marks obstacles that lasers see, and clears marks through which they see.
//!
//! A hit that the map explains changes nothing. Marks are cleared from the marks' side: each mark in range looks up the
//! beams that pass it. So a scan costs one lookup per beam end and per mark, not a walk along each beam.

use std::f64::consts::TAU;

use maps::{Point, Pose, heading, wrap_angle};
use robot::LaserScan;

use super::Costmap;
use crate::atlas::clearance;
use crate::beams::Beams;
use crate::grid_frame::GridFrame;

/// How far behind the end of a beam its obstacle is searched for, in cells: ends lie on surfaces, cells behind them.
const BEHIND_CELLS: f64 = 0.25;

impl Costmap {
    /// Processes a scan of a laser on a robot at `robot` in the `map` frame: marks obstacles that the map does not
    /// explain, and clears marks that beams pass.
    pub(crate) fn take_in(&mut self, scan: &LaserScan, beams: &Beams, robot: &Pose) {
        let eye = beams.eye(&self.frame.pose_in_grid(robot));
        if !self.marks.is_empty() {
            self.clear_seen_through(scan, beams, &eye);
        }
        let resolution_m = self.frame.resolution_m;
        let explained = clearance::at_least(self.parameters.map_tolerance / resolution_m);
        let (nearest_m, farthest_m) = (beams.spec.range_min_m, self.parameters.obstacle_max_range);
        for end in beams.ends(scan, eye, nearest_m, farthest_m, BEHIND_CELLS * resolution_m) {
            let Some(offset) = self.frame.offset_in_grid(&(end / resolution_m)) else { continue };
            // Obstacles in unknown space do not change plans, since no path leads there.
            if self.fixed[offset] >= explained {
                self.mark_cell(offset);
            }
        }
    }

    /// Clears marks under the robot's body, where there can be no obstacle.
    pub(crate) fn clear_footprint(&mut self, robot: &Point) {
        if self.marks.is_empty() {
            return;
        }
        let at = self.frame.in_grid(robot);
        let radius = self.parameters.robot_radius / self.frame.resolution_m - 0.5;
        self.clear_marks(|frame, mark| to_cell(frame, &at, mark).norm() < radius);
    }

    fn clear_seen_through(&mut self, scan: &LaserScan, beams: &Beams, eye: &Pose) {
        let resolution_m = self.frame.resolution_m;
        let from = Point::from(eye.translation.vector) / resolution_m;
        let farthest = self.parameters.raytrace_max_range.min(beams.spec.range_max_m) / resolution_m;
        self.clear_marks(|frame, mark| {
            let way = to_cell(frame, &from, mark);
            let distance = way.norm();
            if distance > farthest {
                return false;
            }
            let bearing = wrap_angle(libm::atan2(way.y, way.x) - heading(eye));
            passes(scan, beams, bearing, (distance + 1.0) * resolution_m)
        });
    }
}

/// Whether the beams on both sides of a bearing (in the laser's frame) extend beyond a distance.
fn passes(scan: &LaserScan, beams: &Beams, bearing_rad: f64, distance_m: f64) -> bool {
    let turn = (bearing_rad - beams.spec.angle_min_rad).rem_euclid(TAU);
    let beam = (turn / beams.spec.angle_increment_rad) as usize;
    let goes_on = |beam: usize| {
        beam < beams.spec.beams && scan.ranges_m.get(beam).is_some_and(|range_m| f64::from(*range_m) > distance_m)
    };
    goes_on(beam) && goes_on(beam + 1)
}

/// From a point in grid coordinates to a cell's center, in cells.
fn to_cell(frame: &GridFrame, from: &Point, offset: usize) -> nalgebra::Vector2<f64> {
    let (column, row) = frame.column_and_row(offset);
    nalgebra::Vector2::new(column as f64 + 0.5 - from.x, row as f64 + 0.5 - from.y)
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, OccupancyGrid, pose};
    use robot::RobotModel;

    use super::*;
    use crate::CostmapParameters;

    /// A free floor with a wall along its right side, from x = 5 m.
    fn costmap() -> Costmap {
        let mut map = OccupancyGrid::new(120, 80, 0.05, pose(0.0, 0.0, 0.0));
        for row in 0..80 {
            (0..120).for_each(|column| {
                map.set(CellIndex { column, row }, if column >= 100 { Cell::Occupied } else { Cell::Free });
            });
        }
        Costmap::new(&map, CostmapParameters::default()).unwrap()
    }

    /// A front laser at (2, 2) that faces along x. Every beam hits something at `x_m`, as far as that is in front of
    /// it.
    fn scan(x_m: f64) -> (LaserScan, Beams) {
        let mut spec = RobotModel::default().lasers[0].clone();
        spec.mount = pose(0.0, 0.0, 0.0);
        let ranges_m = (0..spec.beams)
            .map(|beam| {
                let cos = libm::cos(spec.beam_angle_rad(beam));
                if cos > 0.3 { ((x_m - 2.0) / cos) as f32 } else { f32::INFINITY }
            })
            .collect();
        (LaserScan { time: std::time::Duration::ZERO, laser: 0, ranges_m }, Beams::new(&spec))
    }

    #[test]
    fn walls_of_the_map_mark_nothing_even_with_a_small_pose_error() {
        let mut costmap = costmap();
        let (scan, beams) = scan(5.0);
        costmap.take_in(&scan, &beams, &pose(1.92, 2.0, 0.02));
        assert_eq!((costmap.marked().len(), costmap.generation()), (0, 0));
    }

    #[test]
    fn unmapped_obstacles_are_marked_and_cleared_when_they_are_gone() {
        let mut costmap = costmap();
        let there = Point::new(3.52, 2.01);
        let (near, beams) = scan(3.5);
        costmap.take_in(&near, &beams, &pose(2.0, 2.0, 0.0));
        assert_eq!(costmap.cost(&there), crate::LETHAL_COST);
        assert!(costmap.clearance_m(&Point::new(3.2, 2.0)) < 0.32);
        costmap.take_in(&near, &beams, &pose(2.0, 2.0, 0.0));
        assert_eq!(costmap.cost(&there), crate::LETHAL_COST, "seen again, it stays");
        let (far, _) = scan(5.0);
        costmap.take_in(&far, &beams, &pose(2.0, 2.0, 0.0));
        assert_eq!(costmap.cost(&there), 0);
        assert_eq!(costmap.marked().len(), 0, "all marks within range are gone");
    }

    #[test]
    fn failed_beams_neither_mark_nor_clear() {
        let mut costmap = costmap();
        let (mut near, beams) = scan(3.5);
        costmap.take_in(&near, &beams, &pose(2.0, 2.0, 0.0));
        let marks = costmap.marked().len();
        near.ranges_m.fill(f32::NAN);
        costmap.take_in(&near, &beams, &pose(2.0, 2.0, 0.0));
        near.ranges_m.clear();
        costmap.take_in(&near, &beams, &pose(2.0, 2.0, 0.0));
        assert_eq!(costmap.marked().len(), marks);
    }

    #[test]
    fn the_robots_own_footprint_is_free() {
        let mut costmap = costmap();
        for x in [1.9, 2.0, 2.2, 2.9] {
            costmap.mark(&Point::new(x, 2.0));
        }
        costmap.clear_footprint(&Point::new(2.0, 2.0));
        assert_eq!(costmap.marked().len(), 1);
    }
}
