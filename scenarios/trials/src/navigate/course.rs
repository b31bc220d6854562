//! A map prepared for trips: where a robot can be, and the distances between places.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use drawing::MapPicture;
use maps::{OccupancyGrid, Point, Pose, pose};
use nav::{Atlas, Costmap, CostmapParameters, LocalizationParameters, largest_part, plan};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use robot::RobotModel;

/// The minimum free space around the robot at starts and goals, in meters.
const SPARE_M: f64 = 0.05;

/// A goal is at least this far from the start, in meters.
const SHORTEST_TRIP_M: f64 = 3.0;

/// The maximum number of trips that are drawn to find one that is long enough. After that, only endpoints that are far
/// enough apart are drawn.
const TRIES: usize = 1000;

/// Why trips are impossible on a map.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CourseError {
    /// Localization is impossible on the map.
    #[error(transparent)]
    Map(#[from] nav::Error),
    /// The robot fits nowhere, or only at places that are too close to each other.
    #[error("the map has no two places, at least {SHORTEST_TRIP_M} m apart, between which the robot can drive")]
    NoRoom,
}

/// A map prepared for trips.
#[derive(Clone, Debug)]
pub struct Course {
    name: String,
    file: PathBuf,
    pub(super) atlas: Arc<Atlas>,
    pub(super) picture: Arc<MapPicture>,
    /// The costmap of the robot's navigation, without any observation.
    costmap: Costmap,
    /// A costmap that only considers where the robot fits.
    shortest: Costmap,
    /// Centers of the cells in which trips start and end: each can be reached from every other.
    open: Vec<Point>,
    /// The first and the last of these centers in each row of the map: they include the one farthest from any place.
    ends_of_rows: Vec<Point>,
}

/// Start and goal of a trip.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub(super) start: Pose,
    pub(super) goal: Pose,
    /// The shortest path that the robot can take.
    pub(super) path: Vec<Point>,
}

impl Task {
    pub(super) fn shortest_m(&self) -> f64 {
        self.path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }
}

impl Course {
    /// The course on a map read from a file.
    ///
    /// # Errors
    /// If trips are impossible.
    pub fn new(name: &str, file: &Path, map: OccupancyGrid) -> Result<Self, CourseError> {
        let map = Arc::new(map);
        let model = RobotModel::default();
        let atlas = Atlas::new(Arc::clone(&map), &model, LocalizationParameters::default())?;
        let costmap = Costmap::on(&atlas, CostmapParameters::of(&model))?;
        let tight = CostmapParameters { inflation_radius: model.radius_m, ..CostmapParameters::of(&model) };
        let shortest = Costmap::on(&atlas, tight)?;
        let open = open_places(&costmap, model.radius_m, map.resolution_m());
        let course = Self {
            name: name.to_owned(),
            file: file.to_owned(),
            picture: Arc::new(MapPicture::new(&map)),
            ends_of_rows: ends_of_rows(&open, &map),
            open,
            atlas: Arc::new(atlas),
            costmap,
            shortest,
        };
        course.some_trip().ok_or(CourseError::NoRoom)?;
        Ok(course)
    }

    /// The map's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file from which the map was read.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The robot that drives.
    #[must_use]
    pub fn model(&self) -> &RobotModel {
        self.atlas.model()
    }

    /// Distance from a place to the nearest obstacle of the map, in meters.
    pub(super) fn clearance_m(&self, place: &Point) -> f64 {
        self.costmap.clearance_m(place)
    }

    /// A place where the robot can be.
    pub(super) fn place(&self, rng: &mut ChaCha8Rng) -> Point {
        self.open[rng.random_range(0..self.open.len())]
    }

    /// A path between two places that keeps clear of walls, if there is one.
    pub(super) fn path(&self, from: &Point, to: &Point) -> Option<Vec<Point>> {
        plan(&self.costmap, from, to, SPARE_M).ok()
    }

    /// A trip.
    ///
    /// # Panics
    /// If there is none; [`new`](Self::new) has checked that there is.
    pub(super) fn task(&self, rng: &mut ChaCha8Rng) -> Task {
        let mut drawn = (0..TRIES).map(|_| (self.place(rng), self.place(rng)));
        let (start, goal, path) = drawn
            .find_map(|(start, goal)| self.shortest_path(&start, &goal).map(|path| (start, goal, path)))
            .or_else(|| {
                let (start, goal) = self.far_apart(rng);
                self.shortest_path(&start, &goal).map(|path| (start, goal, path))
            })
            .expect("there are places far enough apart, and each can be reached from each");
        let mut facing = |at: Point| pose(at.x, at.y, std::f64::consts::TAU * rng.random::<f64>());
        Task { start: facing(start), goal: facing(goal), path }
    }

    /// The shortest path that the robot can take between two places, if they are far enough apart for a trip.
    fn shortest_path(&self, start: &Point, goal: &Point) -> Option<Vec<Point>> {
        is_far(start, goal).then(|| plan(&self.shortest, start, goal, SPARE_M).ok()).flatten()
    }

    /// The path of one possible trip, if there are any.
    fn some_trip(&self) -> Option<Vec<Point>> {
        let (start, goal) = self.ends_of_rows.iter().find_map(|from| Some((from, self.far_from(from)?)))?;
        self.shortest_path(start, goal)
    }

    /// A place far enough away for a trip, if there is one.
    fn far_from(&self, from: &Point) -> Option<&Point> {
        self.ends_of_rows.iter().find(|to| is_far(from, to))
    }

    /// Two places, drawn from those that are far enough apart.
    fn far_apart(&self, rng: &mut ChaCha8Rng) -> (Point, Point) {
        let mut one_of = |places: Vec<&Point>| *places[rng.random_range(0..places.len())];
        let start = one_of(self.open.iter().filter(|from| self.far_from(from).is_some()).collect());
        let goal = one_of(self.open.iter().filter(|to| is_far(&start, to)).collect());
        (start, goal)
    }
}

fn is_far(from: &Point, to: &Point) -> bool {
    (to - from).norm() >= SHORTEST_TRIP_M
}

/// The first and the last place in each row of a map, from places ordered by rows. They include every corner of the
/// places' convex hull, and therefore the place farthest from any other.
fn ends_of_rows(places: &[Point], map: &OccupancyGrid) -> Vec<Point> {
    let row = |place: &Point| map.to_grid(place).y.floor();
    let rows = places.chunk_by(|one, next| row(one) == row(next));
    rows.filter_map(|row| Some([*row.first()?, *row.last()?])).flatten().collect()
}

/// Centers of the cells in which the robot has some free space around it, in the largest connected part of the map. The
/// robot may be anywhere in a cell, so it needs half a cell more than its radius.
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

    fn course(name: &str, map: OccupancyGrid) -> Result<Course, CourseError> {
        Course::new(name, "map.yaml".as_ref(), map)
    }

    #[test]
    fn every_trip_on_the_house_map_ends_where_the_robot_fits() {
        let course = course("house", maps::house::map()).unwrap();
        for seed in 0..20 {
            let task = course.task(&mut Streams::new(seed).stream("navigate/task"));
            for end in [&task.start, &task.goal] {
                let at = Point::from(end.translation.vector);
                assert!(course.clearance_m(&at) >= 0.35, "{at}");
            }
            let straight_m = (task.goal.translation.vector - task.start.translation.vector).norm();
            assert!(task.shortest_m() >= straight_m - 1e-6 && straight_m >= SHORTEST_TRIP_M);
            assert!(course.path(&task.start.translation.vector.into(), &task.goal.translation.vector.into()).is_some());
        }
    }

    #[test]
    fn only_the_largest_part_of_a_map_has_trips() {
        let mut map = OccupancyGrid::new(200, 60, 0.05, pose(1.0, 2.0, 0.4));
        for (row, column) in (0..60).flat_map(|row| (0..200).map(move |column| (row, column))) {
            let cell = if column == 60 { Cell::Occupied } else { Cell::Free };
            map.set(CellIndex { column, row }, cell);
        }
        let course = course("two rooms", map.clone()).unwrap();
        assert!(course.open.iter().all(|place| map.to_grid(place).x > 60.0));
    }

    /// A free, square floor with this many cells per side.
    fn floor(cells: usize) -> OccupancyGrid {
        let mut map = OccupancyGrid::new(cells, cells, 0.05, pose(0.0, 0.0, 0.0));
        (0..cells * cells).for_each(|cell| map.set(CellIndex { column: cell % cells, row: cell / cells }, Cell::Free));
        map
    }

    #[test]
    fn a_map_too_small_for_trips_is_rejected() {
        assert!(matches!(course("closet", floor(30)), Err(CourseError::NoRoom)));
    }

    #[test]
    fn a_room_with_few_places_far_enough_apart_has_trips_between_them() {
        // Only its opposite corners are 3 m apart.
        let course = course("chamber", floor(46)).unwrap();
        let pairs = course.open.iter().flat_map(|from| course.open.iter().map(move |to| (from, to)));
        let far = pairs.filter(|(from, to)| is_far(from, to)).count();
        let all = course.open.len() * course.open.len();
        assert!(far > 0 && far * 2000 < all, "{far} of {all} pairs");
        let mut starts = Vec::new();
        for seed in 0..20 {
            let task = course.task(&mut Streams::new(seed).stream("navigate/task"));
            assert!(task.shortest_m() >= SHORTEST_TRIP_M - 1e-9);
            starts.push(task.start.translation.vector);
        }
        assert!(starts.iter().any(|start| (start - starts[0]).norm() > 1.0), "they begin in one corner and another");
    }

    #[test]
    fn a_map_whose_first_place_is_in_its_middle_has_trips() {
        // The robot fits into a cross whose lowest row is one step below the middle of its bar.
        let mut map = OccupancyGrid::new(140, 40, 0.05, pose(0.0, 0.0, 0.0));
        for index in (0..40).flat_map(|row| (0..140).map(move |column| CellIndex { column, row })) {
            let (off, low) = (index.column.abs_diff(70), index.row < 20);
            map.set(index, if low && off > 10 || off > 45 { Cell::Occupied } else { Cell::Free });
        }
        let course = course("cross", map).unwrap();
        let first = course.open[0];
        assert!(course.open.iter().all(|to| !is_far(&first, to)), "no place is far from the first");
        assert!(course.some_trip().is_some());
    }
}
