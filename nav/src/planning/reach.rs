//! The places that a robot can ever reach, answered from the map before anything runs.

use maps::{OccupancyGrid, Point};
use robot::RobotModel;

use super::reachability::parts;
use super::standing::{Ground, nearest_cell};
use super::{End, Goal, PlanError, beginning, end_at, end_inside};
use crate::{Costmap, CostmapParameters, Error};

/// The distance from an unreachable goal within which another is suggested, in meters.
const INSTEAD_M: f64 = 5.0;

/// The part of a map that robots of one model can reach, with no obstacles other than those of the map.
///
/// For any start and goal it gives the result of a [`Navigator`](crate::Navigator) that has seen nothing that is not on
/// the map. Building it visits every cell; after that, a query is very cheap.
///
/// ```
/// use maps::Point;
/// use nav::{Goal, PlanError, Reach};
/// use robot::RobotModel;
///
/// let reach = Reach::new(&maps::house::map(), &RobotModel::default())?;
/// let start = Point::new(0.0, 0.0);
/// let places = maps::house::places();
/// let station = places.get("RechargingStation").expect("the house has a charging station");
/// assert_eq!(reach.check(&start, &Goal::to(station)), Ok(()));
/// let far_away = Goal::at(Point::new(500.0, 0.0), None);
/// assert_eq!(reach.check(&start, &far_away), Err(PlanError::GoalOutside));
/// # Ok::<(), nav::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Reach {
    costmap: Costmap,
    /// The number of the connected part of each cell; 0 where the robot cannot be.
    parts: Vec<u32>,
}

impl Reach {
    /// Computes the reachable parts of the map for robots of this model.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the model is invalid.
    pub fn new(map: &OccupancyGrid, model: &RobotModel) -> Result<Self, Error> {
        let costmap = Costmap::new(map, CostmapParameters::of(model))?;
        let ground = Ground::new(&costmap);
        let parts = parts(&costmap.frame, costmap.clearances().len(), |cell| ground.can_stand(cell));
        Ok(Self { parts, costmap })
    }

    /// Whether a robot at `start` can reach the goal.
    ///
    /// # Errors
    /// The reason why it cannot; problems of the goal come first.
    pub fn check(&self, start: &Point, goal: &Goal) -> Result<(), PlanError> {
        let ground = Ground::new(&self.costmap);
        let end = end_at(&ground, &goal.position, goal.plan_tolerance_m());
        let inside = goal.area.as_ref().map(|area| (area, end_inside(&ground, area)));
        if let (Err(error), None) | (Err(_), Some((_, Err(error)))) = (&end, &inside) {
            return Err(*error);
        }
        let first = beginning(&ground, start)?[0];
        let is_there = |end: &Result<End, PlanError>| end.as_ref().is_ok_and(|end| self.connects(first, end.cell));
        let may_stay = |area: &maps::Place| area.contains(&maps::pose(start.x, start.y, 0.0));
        let arrives = is_there(&end) || inside.is_some_and(|(area, end)| is_there(&end) || may_stay(area));
        if arrives { Ok(()) } else { Err(PlanError::NoPath) }
    }

    /// The place nearest to the goal that a robot at `start` can reach, if there is one nearby.
    #[must_use]
    pub fn instead(&self, start: &Point, goal: &Goal) -> Option<Point> {
        let first = beginning(&Ground::new(&self.costmap), start).ok()?[0];
        let offset = self.costmap.frame.offset_at(&goal.position)?;
        let cell = nearest_cell(&self.costmap, offset, INSTEAD_M, |cell| self.connects(first, cell))?;
        Some(self.costmap.frame.center(cell))
    }

    fn connects(&self, from: usize, to: usize) -> bool {
        self.parts[from] > 0 && self.parts[from] == self.parts[to]
    }
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex, Place, pose};
    use proptest::prelude::*;

    use super::*;
    use crate::{plan, plan_into};

    /// A hall of 8 m × 6 m with boxes.
    fn hall(boxes: &[(usize, usize, usize, usize)]) -> OccupancyGrid {
        let mut map = OccupancyGrid::new(160, 120, 0.05, pose(-3.0, 2.0, 0.5));
        for index in (0..120).flat_map(|row| (0..160).map(move |column| CellIndex { column, row })) {
            let CellIndex { column, row } = index;
            let wall = column < 2 || row < 2 || column >= 158 || row >= 118;
            let boxed = boxes.iter().any(|(left, bottom, width, height)| {
                (*left..left + width).contains(&column) && (*bottom..bottom + height).contains(&row)
            });
            map.set(index, if wall || boxed { Cell::Occupied } else { Cell::Free });
        }
        map
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn reachable_places_are_those_with_a_plan(
            boxes in prop::collection::vec((5_usize..140, 5_usize..100, 2_usize..60, 2_usize..60), 0..9),
            ends in prop::collection::vec((-0.5..8.5_f64, -0.5..6.5_f64), 8),
        ) {
            let map = hall(&boxes);
            let model = RobotModel::default();
            let reach = Reach::new(&map, &model).unwrap();
            let costmap = Costmap::new(&map, CostmapParameters::of(&model)).unwrap();
            let at = |(x_m, y_m): (f64, f64)| map.origin() * Point::new(x_m, y_m);
            for pair in ends.windows(2) {
                let (start, goal) = (at(pair[0]), Goal::at(at(pair[1]), None));
                let tolerance_m = goal.plan_tolerance_m();
                let path = plan(&costmap, &start, &goal.position, tolerance_m);
                prop_assert_eq!(reach.check(&start, &goal), path.map(drop));
                if let Some(instead) = reach.instead(&start, &goal) {
                    prop_assert_eq!(reach.check(&start, &Goal::at(instead, None)), Ok(()));
                }
                let corners = [(0.0, 0.0), (1.2, 0.0), (1.2, 1.0), (0.0, 1.0)];
                let corner = |(x_m, y_m): (f64, f64)| at((pair[1].0 + x_m, pair[1].1 + y_m));
                let area = Place::Area { corners: corners.map(corner).to_vec() };
                let goal = Goal::to(&area);
                let path = plan(&costmap, &start, &goal.position, tolerance_m)
                    .or_else(|_| plan_into(&costmap, &start, &area));
                if !area.contains(&pose(start.x, start.y, 0.0)) {
                    prop_assert_eq!(reach.check(&start, &goal), path.map(drop));
                }
            }
        }
    }
}
