//! Path planning with clearance from obstacles.
//!
//! [A*](astar) over the cells, for a way across a campus after a search over [blocks] of them, then [shortening and
//! smoothing](smoothing) of the result. A path is a list of points, 0.1 m or less apart, in the `map` frame.

mod astar;
mod blocks;
mod goal;
mod reach;
mod reachability;
mod smoothing;
mod standing;

use maps::{Place, Point};

use crate::Costmap;
use standing::{Ground, nearest_cell};

pub use goal::Goal;
pub use reach::Reach;
pub use reachability::largest_part;

/// The distance within which a robot too near to an obstacle searches for a way out, in meters.
const ESCAPE_M: f64 = 1.0;

/// The distance from a goal where the robot just fits to a cell that it fits anywhere in, in cells.
const BESIDE_CELLS: f64 = 1.5;

/// The distance from the centroid of an area within which a goal inside it is searched for, in meters.
const WITHIN_AREA_M: f64 = 10.0;

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The robot is not on the map.
    #[error("the robot is outside the map")]
    StartOutside,
    /// The robot's center is in an obstacle, or so near to obstacles that there is no way out.
    #[error("the robot is in an obstacle")]
    StartInObstacle,
    /// The goal is not on the map.
    #[error("the goal is outside the map")]
    GoalOutside,
    /// The goal is in unknown space.
    #[error("the goal is in unknown space of the map")]
    GoalUnknown,
    /// The goal is in an obstacle, or too near to one.
    #[error("the goal is {clearance_m:.3} m from an obstacle, but the robot needs {needed_m:.3} m")]
    GoalInObstacle {
        /// Distance from the goal's cell to the obstacle, in meters.
        clearance_m: f64,
        /// Distance that the robot needs to be anywhere in a cell, in meters.
        needed_m: f64,
    },
    /// Both ends are acceptable, but obstacles or unknown space lie between them.
    #[error("there is no path to the goal")]
    NoPath,
}

/// A path from `start` to `goal`, in the `map` frame.
///
/// The path begins at `start`. It ends at `goal` if the robot fits there, otherwise at the nearest place where it does,
/// at most `tolerance_m` away. From a start that is too near to an obstacle, it takes the shortest way out. The path
/// never enters unknown cells (but may start in them), nor cells where the robot would touch an obstacle, as far as
/// [clearances](Costmap::clearance_m) show.
///
/// # Errors
/// The reason why there is no path.
pub fn plan(costmap: &Costmap, start: &Point, goal: &Point, tolerance_m: f64) -> Result<Vec<Point>, PlanError> {
    let end = end_at(&Ground::new(costmap), goal, tolerance_m)?;
    let mut path = plan_between(costmap, start, end.cell, &end.point)?;
    if end.leads_on {
        path.extend(&smoothing::straight(&end.point, goal)[1..]);
    }
    Ok(path)
}

/// A path from `start` to the centroid of an area, or to the nearest place inside the area where the robot can be.
///
/// # Errors
/// As for [`plan`].
pub fn plan_into(costmap: &Costmap, start: &Point, area: &Place) -> Result<Vec<Point>, PlanError> {
    let end = end_inside(&Ground::new(costmap), area)?;
    plan_between(costmap, start, end.cell, &end.point)
}

/// The end of paths to a goal.
struct End {
    cell: usize,
    point: Point,
    /// Whether the robot continues from there straight to the goal, where it just fits.
    leads_on: bool,
}

/// Where paths to `goal` end, at most `tolerance_m` away.
fn end_at(ground: &Ground<'_>, goal: &Point, tolerance_m: f64) -> Result<End, PlanError> {
    let (costmap, frame) = (ground.costmap, &ground.costmap.frame);
    let offset = frame.offset_at(goal).ok_or(PlanError::GoalOutside)?;
    if ground.can_stand(offset) {
        return Ok(End { cell: offset, point: *goal, leads_on: false });
    }
    let fits = costmap.cost_at(offset) < crate::INSCRIBED_COST;
    let within_m = if fits { tolerance_m.max(BESIDE_CELLS * frame.resolution_m) } else { tolerance_m };
    let near = |cell| ground.can_stand(cell) && (frame.center(cell) - goal).norm() <= within_m;
    let searched_m = within_m + frame.resolution_m;
    let cell = nearest_cell(costmap, offset, searched_m, near).ok_or_else(|| bad_goal(ground, offset))?;
    Ok(End { cell, point: frame.center(cell), leads_on: fits })
}

/// Where paths into an area end.
fn end_inside(ground: &Ground<'_>, area: &Place) -> Result<End, PlanError> {
    let (costmap, frame) = (ground.costmap, &ground.costmap.frame);
    let center = area.goal_position();
    let offset = frame.offset_at(&center).ok_or(PlanError::GoalOutside)?;
    let inside = |cell| {
        let at = frame.center(cell);
        ground.can_stand(cell) && area.contains(&maps::pose(at.x, at.y, 0.0))
    };
    let cell = nearest_cell(costmap, offset, WITHIN_AREA_M, inside).ok_or_else(|| bad_goal(ground, offset))?;
    Ok(End { cell, point: if offset == cell { center } else { frame.center(cell) }, leads_on: false })
}

/// The cell in which paths from `start` begin, and the one that contains `start`.
fn beginning(ground: &Ground<'_>, start: &Point) -> Result<[usize; 2], PlanError> {
    let costmap = ground.costmap;
    let start_cell = costmap.frame.offset_at(start).ok_or(PlanError::StartOutside)?;
    if costmap.is_on_map(start_cell) {
        return Err(PlanError::StartInObstacle);
    }
    let escape = |cell| ground.can_stand(cell) && !costmap.line_meets_obstacle(start, &costmap.frame.center(cell));
    let first = nearest_cell(costmap, start_cell, ESCAPE_M, escape).ok_or(PlanError::StartInObstacle)?;
    Ok([first, start_cell])
}

fn plan_between(costmap: &Costmap, start: &Point, goal_cell: usize, end: &Point) -> Result<Vec<Point>, PlanError> {
    let ground = Ground::new(costmap);
    let [first, start_cell] = beginning(&ground, start)?;
    // Obstacles seen by lasers may have closed the way; on the map alone there is almost always one.
    if costmap.marked().len() > 0 && !reachability::is_reachable(&ground, first, goal_cell) {
        return Err(PlanError::NoPath);
    }
    let cells = blocks::path(&ground, first, goal_cell).ok_or(PlanError::NoPath)?;
    if first == start_cell {
        return Ok(smoothing::smoothed(&ground, &cells, Some(start), end));
    }
    let path = smoothing::smoothed(&ground, &cells, None, end);
    let mut way_out = smoothing::straight(start, &path[0]);
    way_out.extend(&path[1..]);
    Ok(way_out)
}

fn bad_goal(Ground { costmap, needed_m, .. }: &Ground<'_>, offset: usize) -> PlanError {
    match costmap.cost_at(offset) {
        crate::UNKNOWN_COST => PlanError::GoalUnknown,
        _ => PlanError::GoalInObstacle { clearance_m: costmap.clearance_at_m(offset), needed_m: *needed_m },
    }
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, OccupancyGrid, pose};
    use proptest::prelude::*;

    use super::*;
    use crate::CostmapParameters;

    /// A hall of 8 m × 6 m with boxes, on a grid with a rotated origin.
    fn hall(boxes: &[(usize, usize, usize, usize)]) -> OccupancyGrid {
        let mut map = OccupancyGrid::new(160, 120, 0.05, pose(-3.0, 2.0, 0.5));
        for row in 0..120 {
            for column in 0..160 {
                let wall = column < 2 || row < 2 || column >= 158 || row >= 118;
                let boxed = boxes.iter().any(|(left, bottom, width, height)| {
                    (*left..left + width).contains(&column) && (*bottom..bottom + height).contains(&row)
                });
                map.set(CellIndex { column, row }, if wall || boxed { Cell::Occupied } else { Cell::Free });
            }
        }
        map
    }

    fn costmap(map: &OccupancyGrid) -> Costmap {
        Costmap::new(map, CostmapParameters::default()).unwrap()
    }

    /// A point of the map's frame by its distance from the lower left corner along the grid.
    fn at(map: &OccupancyGrid, x_m: f64, y_m: f64) -> Point {
        map.origin() * Point::new(x_m, y_m)
    }

    /// The exact distance from a point to the nearest obstacle of the map, in meters.
    fn distance_m(map: &OccupancyGrid, point: &Point) -> f64 {
        let from = map.to_grid(point);
        let beside = |at: f64, cell: usize| (cell as f64 - at).max(at - (cell + 1) as f64).max(0.0);
        let occupied = map.cells().iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied);
        occupied
            .map(|(offset, _)| (beside(from.x, offset % map.width()), beside(from.y, offset / map.width())))
            .map(|(x, y)| (x * x + y * y).sqrt() * map.resolution_m())
            .fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn the_body_touches_nothing_along_a_path(
            boxes in prop::collection::vec((5_usize..140, 5_usize..100, 2_usize..30, 2_usize..30), 0..9),
        ) {
            let map = hall(&boxes);
            let (start, goal) = (at(&map, 0.6, 0.6), at(&map, 7.3, 5.3));
            let Ok(path) = plan(&costmap(&map), &start, &goal, 0.05) else { return Ok(()) };
            prop_assert!((path[0] - start).norm() < 1e-9);
            prop_assert!((path[path.len() - 1] - goal).norm() < 0.051);
            for pair in path.windows(2) {
                prop_assert!((pair[1] - pair[0]).norm() < 0.11);
                for step in 0..10 {
                    let point = pair[0] + (pair[1] - pair[0]) * (f64::from(step) / 10.0);
                    // The path may still be leaving a start that is too near.
                    if (point - start).norm() > ESCAPE_M {
                        let distance_m = distance_m(&map, &point);
                        // Half a cell's diagonal from a cell's center, minus the error of a line between two samples.
                        prop_assert!(distance_m > 0.28, "{distance_m} m from an obstacle at {point}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_path_is_straight_in_the_open_and_curved_around_an_obstacle() {
        let map = hall(&[]);
        let path = plan(&costmap(&map), &at(&map, 1.5, 1.5), &at(&map, 6.5, 4.5), 0.05).unwrap();
        let length_m: f64 = path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        assert!(length_m < 1.001 * (25.0_f64 + 9.0).sqrt(), "{length_m} m");
        let map = hall(&[(60, 0, 40, 60)]);
        let path = plan(&costmap(&map), &at(&map, 1.5, 1.5), &at(&map, 6.5, 1.5), 0.05).unwrap();
        let sharpest = path.windows(3).map(|p| (p[1] - p[0]).angle(&(p[2] - p[1]))).fold(0.0, f64::max);
        assert!(sharpest < 0.5, "a corner of {sharpest} rad");
    }

    #[test]
    fn a_path_ends_at_a_goal_where_the_robot_fits_and_near_one_where_it_does_not() {
        let map = hall(&[]);
        let costmap = costmap(&map);
        // The wall's face is 0.1 m from the corner.
        let end = |x_m: f64, tolerance_m| {
            let goal = at(&map, x_m, 3.02);
            plan(&costmap, &at(&map, 6.0, 3.0), &goal, tolerance_m).map(|path| (path[path.len() - 1] - goal).norm())
        };
        assert!(end(0.41, 0.05).unwrap() < 1e-9);
        let missed_m = end(0.35, 0.1).unwrap();
        assert!(missed_m > 0.01 && missed_m <= 0.1, "{missed_m}");
        assert!(matches!(end(0.35, 0.02), Err(PlanError::GoalInObstacle { .. })));
    }

    #[test]
    fn a_start_beside_a_wall_is_left_by_the_shortest_way() {
        let map = hall(&[]);
        let start = at(&map, 0.35, 3.0);
        let path = plan(&costmap(&map), &start, &at(&map, 6.0, 3.0), 0.05).unwrap();
        assert_eq!(path[0], start);
        let gone = path.iter().filter(|point| (*point - start).norm() > 0.12);
        let nearest_m = gone.map(|point| distance_m(&map, point)).fold(f64::INFINITY, f64::min);
        assert!(nearest_m >= 0.3, "{nearest_m} m from the wall after 0.12 m");
    }

    #[test]
    fn every_failure_has_its_reason() {
        let mut map = hall(&[(60, 0, 4, 120)]);
        map.set(CellIndex { column: 20, row: 100 }, Cell::Unknown);
        let costmap = costmap(&map);
        let (here, there) = (at(&map, 1.0, 1.0), at(&map, 6.0, 3.0));
        let unknown = map.center(CellIndex { column: 20, row: 100 });
        let fails = |from: &Point, to: &Point| plan(&costmap, from, to, 0.01).unwrap_err();
        assert_eq!(fails(&here, &there), PlanError::NoPath);
        assert_eq!(fails(&here, &unknown), PlanError::GoalUnknown);
        assert_eq!(fails(&here, &at(&map, -1.0, 3.0)), PlanError::GoalOutside);
        assert_eq!(fails(&at(&map, -1.0, 3.0), &here), PlanError::StartOutside);
        assert_eq!(fails(&at(&map, 3.1, 3.0), &here), PlanError::StartInObstacle);
        assert!(matches!(fails(&here, &at(&map, 2.9, 3.0)), PlanError::GoalInObstacle { .. }));
        assert_eq!(fails(&here, &Point::new(f64::NAN, 0.0)), PlanError::GoalOutside);
        // A corridor of 0.65 m, in the middle of which the robot just fits.
        let map = hall(&[(60, 0, 40, 50), (60, 63, 40, 57)]);
        let costmap = Costmap::new(&map, CostmapParameters { robot_radius: 0.31, ..Default::default() }).unwrap();
        let error = plan(&costmap, &at(&map, 1.0, 1.0), &at(&map, 4.0, 2.825), 0.0).unwrap_err();
        let PlanError::GoalInObstacle { clearance_m, needed_m } = error else { panic!("{error:?}") };
        assert!(clearance_m > 0.31 && clearance_m < needed_m, "{error}");
    }
}
