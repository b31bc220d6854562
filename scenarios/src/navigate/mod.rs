//! The benchmark of navigation: trips between random places on maps, among people.
//!
//! A trip is one robot with localization and navigation in the loop, noisy lasers and wheels, a start and a goal drawn
//! from the map, and people whose walks cross the robot's way. Each has a root seed of its own, so that one that failed
//! can be driven again alone.

mod course;
mod drive;
mod people;
mod picture;
mod table;

use serde::Serialize;

pub use course::Course;
pub(crate) use picture::picture;
pub(crate) use table::table;

use crate::batch;
use crate::draw::Scene;

/// What a benchmark is made of.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How many trips there are on each map.
    pub goals: u64,
    /// How many people are about.
    pub people: usize,
    /// The root seed of the first trip on each map; those of the others follow.
    pub seed: u64,
    /// Which trips leave a scene behind.
    pub scenes: Scenes,
}

/// Which trips leave a scene behind, for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Scenes {
    /// Those that did not arrive, or touched a wall or somebody who stood still.
    Failed,
    /// All.
    All,
    /// None.
    None,
}

/// What came of a trip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The robot is at its goal, and knows it.
    Arrived,
    /// The robot believes that it is at its goal, and is not.
    Elsewhere,
    /// Navigation has given up, with a reason.
    GaveUp,
    /// The robot was still under way when time was over.
    TimeOver,
}

impl Outcome {
    fn words(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::Elsewhere => "believes to have arrived, elsewhere",
            Self::GaveUp => "gave up",
            Self::TimeOver => "still under way when time was over",
        }
    }
}

/// A trip and what came of it.
#[derive(Clone, Debug, Serialize)]
pub struct Trip {
    /// The map's name.
    pub map: String,
    /// The trip's root seed.
    pub seed: u64,
    /// What came of it.
    pub outcome: Outcome,
    /// Why navigation gave up; null if it did not.
    pub reason: Option<String>,
    /// How long it took, in seconds.
    pub time_s: f64,
    /// How far the robot drove, in metres.
    pub driven_m: f64,
    /// Length of the shortest way that a robot of its size can take, in metres, people or not.
    pub shortest_m: f64,
    /// How far the robot was from its goal in the end, in metres.
    pub off_m: f64,
    /// How far the estimated position was from the true one at worst, in metres.
    pub localization_max_m: f64,
    /// The contacts begun with walls and people, in order.
    pub contacts: Vec<Touched>,
    /// Contacts begun with walls.
    pub wall_contacts: usize,
    /// Contacts begun with people who had stood still for half a second or longer.
    pub standing_contacts: usize,
    /// Contacts begun with people who walked.
    pub walking_contacts: usize,
}

/// A contact of the robot's body.
#[derive(Clone, Debug, Serialize)]
pub struct Touched {
    /// When it began, in seconds.
    pub time_s: f64,
    /// With whom; null for walls.
    pub who: Option<String>,
}

impl Trip {
    /// Whether the robot arrived and touched neither a wall nor anybody who stood still.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.outcome == Outcome::Arrived && self.wall_contacts == 0 && self.standing_contacts == 0
    }

    /// What came of it, in words.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words = self.outcome.words().to_owned();
        if let Some(reason) = &self.reason {
            words += &format!(": {reason}");
        }
        let contacts = [
            (self.wall_contacts, "walls"),
            (self.standing_contacts, "people who stood"),
            (self.walking_contacts, "people who walked"),
        ];
        for (count, what) in contacts.into_iter().filter(|(count, _)| *count > 0) {
            words += &format!("; contacts with {what}: {count}");
        }
        words
    }
}

/// Sums over trips.
#[derive(Clone, Debug, Serialize)]
pub struct Sums {
    /// The map's name, or `all`.
    pub map: String,
    /// Number of trips.
    pub trips: usize,
    /// Share of them that arrived, in percent.
    pub arrived_pct: f64,
    /// Number of trips on which navigation gave up.
    pub gave_up: usize,
    /// Number of trips that took too long.
    pub time_over: usize,
    /// Number of trips that ended elsewhere.
    pub elsewhere: usize,
    /// Contacts with walls.
    pub wall_contacts: usize,
    /// Contacts with people who stood still.
    pub standing_contacts: usize,
    /// Contacts with people who walked.
    pub walking_contacts: usize,
    /// The way driven over the shortest one, median of the trips that arrived; null if none did.
    pub way_ratio: Option<f64>,
    /// The time taken over that for the shortest way at full speed, median of the trips that arrived; null if none did.
    pub time_ratio: Option<f64>,
}

impl Sums {
    fn of<'t>(map: &str, trips: impl Iterator<Item = &'t Trip>, full_speed_mps: f64) -> Self {
        let trips: Vec<&Trip> = trips.collect();
        let count = |outcome: Outcome| trips.iter().filter(|trip| trip.outcome == outcome).count();
        let arrived = || trips.iter().filter(|trip| trip.outcome == Outcome::Arrived);
        Self {
            map: map.to_owned(),
            trips: trips.len(),
            arrived_pct: 100.0 * count(Outcome::Arrived) as f64 / trips.len().max(1) as f64,
            gave_up: count(Outcome::GaveUp),
            time_over: count(Outcome::TimeOver),
            elsewhere: count(Outcome::Elsewhere),
            wall_contacts: trips.iter().map(|trip| trip.wall_contacts).sum(),
            standing_contacts: trips.iter().map(|trip| trip.standing_contacts).sum(),
            walking_contacts: trips.iter().map(|trip| trip.walking_contacts).sum(),
            way_ratio: median(arrived().map(|trip| trip.driven_m / trip.shortest_m)),
            time_ratio: median(arrived().map(|trip| trip.time_s * full_speed_mps / trip.shortest_m)),
        }
    }
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// What came of a benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Benchmark {
    /// How many people were about.
    pub people: usize,
    /// The root seed of the first trip on each map.
    pub seed: u64,
    /// Sums for each map, in the order of the maps, then for all together.
    pub maps: Vec<Sums>,
    /// The trips that did not arrive, or touched a wall or somebody who stood still.
    pub failures: Vec<Trip>,
    /// The scenes that trips left behind: how each ended.
    #[serde(skip)]
    pub scenes: Vec<(Trip, Scene)>,
}

impl Benchmark {
    /// Drives all trips on all courses, on all cores. `progress` is told how many of how many are done.
    pub fn run(courses: &[Course], settings: &Settings, progress: impl Fn(usize, usize) + Sync) -> Self {
        let seeds = settings.seed..settings.seed.saturating_add(settings.goals);
        let jobs: Vec<(&Course, u64)> =
            courses.iter().flat_map(|course| seeds.clone().map(move |seed| (course, seed))).collect();
        let one = |(course, seed): &(&Course, u64)| {
            let (trip, scene) = drive::drive(course, *seed, settings.people);
            let keeps = match settings.scenes {
                Scenes::Failed => !trip.is_good(),
                Scenes::All => true,
                Scenes::None => false,
            };
            (trip, keeps.then_some(scene))
        };
        let done = batch::run(&jobs, one, |done| progress(done, jobs.len()));
        let (trips, scenes): (Vec<Trip>, Vec<Option<Scene>>) = done.into_iter().unzip();
        let full_speed_mps = courses.first().map_or(1.0, |course| course.model().max_linear_mps);
        let per_map = trips.chunks(settings.goals.max(1) as usize).zip(courses);
        let mut maps: Vec<Sums> =
            per_map.map(|(trips, course)| Sums::of(course.name(), trips.iter(), full_speed_mps)).collect();
        if courses.len() > 1 {
            maps.push(Sums::of("all", trips.iter(), full_speed_mps));
        }
        Self {
            people: settings.people,
            seed: settings.seed,
            maps,
            failures: trips.iter().filter(|trip| !trip.is_good()).cloned().collect(),
            scenes: trips.into_iter().zip(scenes).filter_map(|(trip, scene)| Some((trip, scene?))).collect(),
        }
    }
}
