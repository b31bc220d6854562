//! A map made ready for trips: where a robot can be, and how far it is from one place to another.

use std::sync::Arc;

use maps::{OccupancyGrid, Point, Pose, pose};
use nav::{Atlas, Costmap, CostmapParameters, LocalizationParameters, largest_part, plan};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::RobotModel;

use crate::draw::MapPicture;

/// Starts and goals have at least so much more room than the robot needs, in metres.
const SPARE_M: f64 = 0.05;

/// A goal is at least so far from the start, in metres.
const SHORTEST_TRIP_M: f64 = 3.0;

/// How often a trip is drawn until one is long enough.
const TRIES: usize = 1000;

/// Why there can be no trips on a map.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CourseError {
    /// Nobody can be localized on the map.
    #[error(transparent)]
    Map(#[from] nav::Error),
    /// The robot fits nowhere, or only in places too near to each other.
    #[error("the map has no two places {SHORTEST_TRIP_M} m apart between which the robot can drive")]
    NoRoom,
}

/// A map made ready for trips.
#[derive(Clone, Debug)]
pub struct Course {
    name: String,
    atlas: Arc<Atlas>,
    picture: Arc<MapPicture>,
    /// The costmap of the robot's navigation, nothing seen yet.
    costmap: Costmap,
    /// A costmap on which all that matters is where the robot fits.
    shortest: Costmap,
    /// Centres of the cells in which trips begin and end: all can be reached from all.
    open: Vec<Point>,
}

/// From where to where a trip leads.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub(super) start: Pose,
    pub(super) goal: Pose,
    /// The shortest way that the robot can take.
    pub(super) way: Vec<Point>,
}

impl Task {
    pub(super) fn shortest_m(&self) -> f64 {
        self.way.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }
}

impl Course {
    /// The course on a map.
    ///
    /// # Errors
    /// If there can be no trips.
    pub fn new(name: &str, map: OccupancyGrid) -> Result<Self, CourseError> {
        let map = Arc::new(map);
        let model = RobotModel::default();
        let atlas = Atlas::new(Arc::clone(&map), &model, LocalizationParameters::default())?;
        let costmap = Costmap::on(&atlas, CostmapParameters::of(&model))?;
        let tight = CostmapParameters { inflation_radius: model.radius_m, ..CostmapParameters::of(&model) };
        let shortest = Costmap::on(&atlas, tight)?;
        let course = Self {
            name: name.to_owned(),
            picture: Arc::new(MapPicture::new(&map)),
            open: open_places(&costmap, model.radius_m, map.resolution_m()),
            atlas: Arc::new(atlas),
            costmap,
            shortest,
        };
        let far = |from: &Point| course.open.iter().any(|to| (to - from).norm() >= SHORTEST_TRIP_M);
        if course.open.first().is_none_or(|first| !far(first)) { Err(CourseError::NoRoom) } else { Ok(course) }
    }

    /// The map's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The robot that drives.
    #[must_use]
    pub fn model(&self) -> &RobotModel {
        self.atlas.model()
    }

    pub(super) fn atlas(&self) -> &Arc<Atlas> {
        &self.atlas
    }

    pub(super) fn picture(&self) -> &Arc<MapPicture> {
        &self.picture
    }

    /// How far the nearest obstacle of the map is from a place, in metres.
    pub(super) fn clearance_m(&self, place: &Point) -> f64 {
        self.costmap.clearance_m(place)
    }

    /// A place where the robot can be.
    pub(super) fn place(&self, rng: &mut ChaCha8Rng) -> Point {
        self.open[rng.random_range(0..self.open.len())]
    }

    /// A way between two places that keeps clear of walls, if there is one.
    pub(super) fn way(&self, from: &Point, to: &Point) -> Option<Vec<Point>> {
        plan(&self.costmap, from, to, SPARE_M).ok()
    }

    /// A trip.
    ///
    /// # Panics
    /// If there is none, which [`new`](Self::new) has looked for.
    pub(super) fn task(&self, rng: &mut ChaCha8Rng) -> Task {
        for _ in 0..TRIES {
            let (start, goal) = (self.place(rng), self.place(rng));
            let far = (goal - start).norm() >= SHORTEST_TRIP_M;
            let Some(way) = far.then(|| plan(&self.shortest, &start, &goal, SPARE_M).ok()).flatten() else { continue };
            let mut facing = |at: Point| pose(at.x, at.y, std::f64::consts::TAU * rng.random::<f64>());
            return Task { start: facing(start), goal: facing(goal), way };
        }
        unreachable!("there are places far enough apart, and each can be reached from each")
    }
}

/// Centres of the cells in which the robot has some room to spare, in the largest part of the map in which it can drive
/// about. It may be anywhere in a cell, and so needs half a cell more than its radius.
fn open_places(costmap: &Costmap, radius_m: f64, resolution_m: f64) -> Vec<Point> {
    let mut places = largest_part(costmap, radius_m + resolution_m / 2.0);
    places.retain(|place| costmap.clearance_m(place) >= radius_m + SPARE_M);
    places
}

#[cfg(test)]
mod tests {
    use maps::{Cell, CellIndex};
    use robot::Streams;

    use super::*;

    #[test]
    fn every_trip_on_the_house_map_leads_where_the_robot_can_be() {
        let course = Course::new("house", maps::house::draw()).unwrap();
        for seed in 0..20 {
            let task = course.task(&mut Streams::new(seed).stream("navigate/task"));
            for end in [&task.start, &task.goal] {
                let at = Point::from(end.translation.vector);
                assert!(course.clearance_m(&at) >= 0.35, "{at}");
            }
            let straight_m = (task.goal.translation.vector - task.start.translation.vector).norm();
            assert!(task.shortest_m() >= straight_m - 1e-6 && straight_m >= SHORTEST_TRIP_M);
            assert!(course.way(&task.start.translation.vector.into(), &task.goal.translation.vector.into()).is_some());
        }
    }

    #[test]
    fn only_the_largest_part_of_a_map_has_trips() {
        let mut map = OccupancyGrid::new(200, 60, 0.05, pose(1.0, 2.0, 0.4));
        for (row, column) in (0..60).flat_map(|row| (0..200).map(move |column| (row, column))) {
            let cell = if column == 60 { Cell::Occupied } else { Cell::Free };
            map.set(CellIndex { column, row }, cell);
        }
        let course = Course::new("two rooms", map.clone()).unwrap();
        assert!(course.open.iter().all(|place| map.to_grid(place).x > 60.0));
    }

    #[test]
    fn a_closet_has_no_trips() {
        let mut map = OccupancyGrid::new(30, 30, 0.05, pose(0.0, 0.0, 0.0));
        (0..900).for_each(|cell| map.set(CellIndex { column: cell % 30, row: cell / 30 }, Cell::Free));
        assert!(matches!(Course::new("closet", map), Err(CourseError::NoRoom)));
    }
}
