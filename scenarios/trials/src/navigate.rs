//! The benchmark of navigation: trips between random places on maps, among people.
//!
//! A trip consists of one robot with localization and navigation in the loop, noisy lasers and wheels, a start and a
//! goal drawn from the map, people who walk across the robot's path, and boxes that are not on the map. Each trip has
//! its own root seed, so that a failed trip can be repeated alone.

mod beside;
mod boxes;
mod course;
mod drive;
mod people;
mod picture;
mod table;
mod trip;

use std::ops::RangeInclusive;

use drawing::Scene;
use serde::Serialize;

use crate::median;

pub use course::Course;
pub use picture::picture;
pub use table::table;
pub use trip::{About, Touched, Trip, TripOutcome};

/// The settings of a benchmark.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The root seeds of the trips on each map.
    pub seeds: RangeInclusive<u64>,
    /// The people and boxes wanted on each trip.
    pub about: About,
    /// Which trips keep their last scene.
    pub scenes: Scenes,
}

/// Which trips keep their last scene, for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scenes {
    /// Those that did not arrive, or touched a wall, or a person or box that stood still.
    Failed,
    /// All.
    All,
    /// None.
    None,
}

/// Aggregates over trips.
#[derive(Clone, Debug, Serialize)]
pub struct Sums {
    /// The map's name, or `all`.
    pub map: String,
    /// Number of trips.
    pub trips: usize,
    /// Percentage of them that arrived.
    pub arrived_pct: f64,
    /// Number of trips on which navigation gave up.
    pub gave_up: usize,
    /// Number of trips that timed out.
    pub time_over: usize,
    /// Number of trips on which the robot wrongly believed that it had arrived.
    pub elsewhere: usize,
    /// Contacts with walls.
    pub wall_contacts: usize,
    /// Contacts with people and boxes that stood still.
    pub standing_contacts: usize,
    /// Contacts with walking people and with boxes that were being pushed.
    pub walking_contacts: usize,
    /// The distance driven divided by the shortest one, as the median of the trips that arrived; null if none did.
    pub way_ratio: Option<f64>,
    /// The time taken divided by that for the shortest path at full speed, as the median of the trips that arrived;
    /// null if none did.
    pub time_ratio: Option<f64>,
}

impl Sums {
    fn of<'t>(map: &str, trips: impl Iterator<Item = &'t Trip>, full_speed_mps: f64) -> Self {
        let trips: Vec<&Trip> = trips.collect();
        let count = |outcome: TripOutcome| trips.iter().filter(|trip| trip.outcome == outcome).count();
        let arrived = || trips.iter().filter(|trip| trip.outcome == TripOutcome::Arrived);
        Self {
            map: map.to_owned(),
            trips: trips.len(),
            arrived_pct: 100.0 * count(TripOutcome::Arrived) as f64 / trips.len().max(1) as f64,
            gave_up: count(TripOutcome::GaveUp),
            time_over: count(TripOutcome::TimeOver),
            elsewhere: count(TripOutcome::Elsewhere),
            wall_contacts: trips.iter().map(|trip| trip.wall_contacts).sum(),
            standing_contacts: trips.iter().map(|trip| trip.standing_contacts).sum(),
            walking_contacts: trips.iter().map(|trip| trip.walking_contacts).sum(),
            way_ratio: median(arrived().map(|trip| trip.driven_m / trip.shortest_m)),
            time_ratio: median(arrived().map(|trip| trip.time_s * full_speed_mps / trip.shortest_m)),
        }
    }
}

/// The results of a benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Benchmark {
    /// The people and boxes wanted on each trip.
    pub wanted: About,
    /// The mean number of people that could be placed.
    pub mean_people: f64,
    /// The mean number of boxes that could be placed.
    pub mean_boxes: f64,
    /// The root seed of the first trip on each map.
    pub seed: u64,
    /// Aggregates for each map, in the order of the maps, then for all together.
    pub maps: Vec<Sums>,
    /// All trips, ordered by map and seed.
    pub trips: Vec<Trip>,
    /// The scenes that trips kept, which show how each trip ended.
    #[serde(skip)]
    pub scenes: Vec<(Trip, Scene)>,
}

impl Benchmark {
    /// Drives all trips on all courses, on all cores. Calls `progress` with the number of finished trips and the total.
    pub fn run(courses: &[Course], settings: &Settings, progress: impl Fn(usize, usize) + Sync) -> Self {
        let jobs: Vec<(&Course, u64)> =
            courses.iter().flat_map(|course| settings.seeds.clone().map(move |seed| (course, seed))).collect();
        let one = |(course, seed): &(&Course, u64)| {
            let (trip, scene) = drive::drive(course, *seed, settings.about);
            let keeps = match settings.scenes {
                Scenes::Failed => !trip.good,
                Scenes::All => true,
                Scenes::None => false,
            };
            (trip, keeps.then_some(scene))
        };
        let done = batch::run(&jobs, one, |done| progress(done, jobs.len()));
        let (trips, scenes): (Vec<Trip>, Vec<Option<Scene>>) = done.into_iter().unzip();
        Self::of(courses, settings, trips, scenes)
    }

    /// The results of trips, which are ordered by course and seed.
    fn of(courses: &[Course], settings: &Settings, trips: Vec<Trip>, scenes: Vec<Option<Scene>>) -> Self {
        let full_speed_mps = courses.first().map_or(1.0, |course| course.model().max_linear_mps);
        let per_map = trips.chunks((trips.len() / courses.len().max(1)).max(1)).zip(courses);
        let mut maps: Vec<Sums> =
            per_map.map(|(trips, course)| Sums::of(course.name(), trips.iter(), full_speed_mps)).collect();
        if courses.len() > 1 {
            maps.push(Sums::of("all", trips.iter(), full_speed_mps));
        }
        let scenes = trips.iter().zip(scenes).filter_map(|(trip, scene)| Some((trip.clone(), scene?))).collect();
        let mean = |count: fn(&About) -> usize| {
            trips.iter().map(|trip| count(&trip.about)).sum::<usize>() as f64 / trips.len().max(1) as f64
        };
        Self {
            wanted: settings.about,
            mean_people: mean(|about| about.people),
            mean_boxes: mean(|about| about.boxes),
            seed: *settings.seeds.start(),
            maps,
            trips,
            scenes,
        }
    }

    /// The trips that did not arrive, or touched a wall, or a person or box that stood still.
    pub fn failures(&self) -> impl Iterator<Item = &Trip> {
        self.trips.iter().filter(|trip| !trip.good)
    }
}
