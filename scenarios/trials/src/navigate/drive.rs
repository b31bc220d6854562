//! One trip, driven.

use diagnostics::seconds;
use std::sync::Arc;
use std::time::Duration;

use drawing::{Place, Scene};
use maps::{Point, Pose, heading};
use nav::{Goal, InitialPose, Localization, NavigationParameters, NavigationStatus, Navigator};
use robot::{Odometry, Reading, Robot, Streams, VelocityCommand};
use sim::{DriftNoise, SimConfig, Simulation};

use super::boxes::boxes;
use super::course::{Course, Task};
use super::people::people;
use super::picture::body;
use super::{About, Touched, Trip, TripOutcome};

/// Standard deviation of a range, in meters.
const LASER_SIGMA_M: f64 = 0.01;

/// Noise of the wheels' encoders: about 2 % of the distance, and 1° per meter.
const ODOMETRY_NOISE: DriftNoise = DriftNoise {
    angle_per_sqrt_rad: 0.02,
    angle_per_sqrt_m: 0.015,
    distance_per_sqrt_m: 0.02,
    distance_per_sqrt_rad: 0.005,
};

/// The time limit of a trip: this long, plus this many times the duration of its shortest path at full speed.
const MOST_TIME: Duration = Duration::from_secs(300);
const MOST_TIMES: f64 = 6.0;

/// The robot has arrived if its true position is within this distance from its goal, in meters.
const ARRIVED_M: f64 = 0.25;

/// A person or a box that has not moved for this long stands still.
const STANDS_STILL: Duration = Duration::from_millis(500);

/// Distance between the points of the trail, in meters.
const TRAIL_STEP_M: f64 = 0.1;

/// Drives the trip of a root seed among people and boxes, as far as they can be placed, and shows how it ended.
pub(super) fn drive(course: &Course, seed: u64, wanted: About) -> (Trip, Scene) {
    let streams = Streams::new(seed);
    let task = course.task(&mut streams.stream("navigate/task"));
    let mut obstacles = boxes(course, &task, wanted.boxes, &mut streams.stream("navigate/boxes"));
    let people = people(course, &task, &obstacles, wanted.people, &mut streams.stream("navigate/people"));
    let about = About { people: people.len(), boxes: obstacles.len() };
    obstacles.extend(people);
    let mut config = SimConfig { obstacles, ..SimConfig::default() };
    config.lasers.range_sigma_m = LASER_SIGMA_M;
    config.odometry.noise = ODOMETRY_NOISE;
    let sim = Simulation::new(&config, course.atlas.map(), task.start, task.goal, &streams)
        .expect("the robot has room at the start, and no person is near");
    let mut ride = Ride::new(course, sim, &task, &streams);
    let most = MOST_TIME + Duration::from_secs_f64(MOST_TIMES * task.shortest_m() / course.model().max_linear_mps);
    while ride.navigator.status().is_under_way() && ride.sim.time() < most {
        ride.step();
    }
    (ride.trip(course, seed, &task, about), ride.scene(course, &task))
}

/// A robot with its software during a trip.
struct Ride {
    sim: Simulation,
    localization: Localization,
    navigator: Navigator,
    odometry: Option<Odometry>,
    readings: Vec<Reading>,
    trail: Vec<Point>,
    localization_max_m: f64,
}

impl Ride {
    fn new(course: &Course, sim: Simulation, task: &Task, streams: &Streams) -> Self {
        let atlas = &course.atlas;
        let rng = streams.stream("nav/localization");
        let parameters = NavigationParameters::of(course.model());
        let mut navigator = Navigator::on(atlas, parameters).expect("the defaults make sense");
        navigator.start(Goal::at(task.goal.translation.vector.into(), Some(heading(&task.goal))));
        Self {
            localization: Localization::on(atlas, &InitialPose::at(task.start), rng),
            navigator,
            sim,
            odometry: None,
            readings: Vec::new(),
            trail: Vec::new(),
            localization_max_m: 0.0,
        }
    }

    fn step(&mut self) {
        self.sim.step();
        self.readings.clear();
        self.sim.read(&mut self.readings);
        for reading in &self.readings {
            match reading {
                Reading::Odometry(odometry) => {
                    self.localization.odometry(odometry);
                    self.odometry = Some(*odometry);
                }
                Reading::Scan(scan) => {
                    self.localization.scan(scan);
                    self.navigator.scan(scan, &self.localization.estimate());
                }
                Reading::Battery(_) => {}
            }
        }
        let estimate = self.localization.estimate();
        let command = self
            .odometry
            .map_or(VelocityCommand::STOP, |odometry| self.navigator.update(self.sim.time(), &estimate, &odometry));
        self.sim.drive(command);
        // The estimate against the truth after the step, which the command of this step does not affect yet.
        let position = Point::from(self.sim.truth().pose().translation.vector);
        let off_m = (self.localization.estimate().pose.translation.vector - position.coords).norm();
        self.localization_max_m = self.localization_max_m.max(off_m);
        if self.trail.last().is_none_or(|last| (last - position).norm() >= TRAIL_STEP_M) {
            self.trail.push(position);
        }
    }

    /// How the trip ended, with the robot this far from its goal.
    fn outcome(&self, off_m: f64) -> TripOutcome {
        match self.navigator.status() {
            NavigationStatus::GoalReached if off_m <= ARRIVED_M => TripOutcome::Arrived,
            NavigationStatus::GoalReached => TripOutcome::Elsewhere,
            status if status.is_under_way() => TripOutcome::TimeOver,
            _ => TripOutcome::GaveUp,
        }
    }

    fn trip(&self, course: &Course, seed: u64, task: &Task, about: About) -> Trip {
        let xy = |pose: &Pose| [pose.translation.x, pose.translation.y];
        let truth = self.sim.truth();
        let off_m = (truth.pose().translation.vector - task.goal.translation.vector).norm();
        let outcome = self.outcome(off_m);
        let (walls, bodies): (Vec<_>, Vec<_>) = truth.contacts().iter().partition(|contact| contact.obstacle.is_none());
        let standing = bodies.iter().filter(|contact| contact.at_rest >= STANDS_STILL).count();
        Trip {
            map: course.name().to_owned(),
            map_file: course.file().display().to_string(),
            seed,
            about,
            start: xy(&task.start),
            goal: xy(&task.goal),
            end: xy(&truth.pose()),
            // Walking people are not counted: some of them walk into a robot that stands still.
            good: outcome == TripOutcome::Arrived && walls.is_empty() && standing == 0,
            outcome,
            reason: self.navigator.reason().map(|reason| reason.to_string()),
            time_s: seconds(self.sim.time()),
            driven_m: truth.distance_m(),
            shortest_m: task.shortest_m(),
            off_m,
            localization_max_m: self.localization_max_m,
            contacts: truth
                .contacts()
                .iter()
                .map(|contact| Touched { time_s: seconds(contact.time), who: contact.obstacle.clone() })
                .collect(),
            wall_contacts: walls.len(),
            standing_contacts: standing,
            walking_contacts: bodies.len() - standing,
        }
    }

    fn scene(&self, course: &Course, task: &Task) -> Scene {
        let (truth, model) = (self.sim.truth(), course.model());
        let goal = Point::from(task.goal.translation.vector);
        let estimate: Pose = self.localization.estimate().pose;
        Scene {
            estimate: Some(estimate),
            path: self.navigator.path().to_vec(),
            laser_hits: truth.scans().flat_map(|scan| scan.hits(&model.lasers[scan.laser], &truth.pose())).collect(),
            trail: self.trail.clone(),
            start: Some(task.start),
            destination: Some(Place { label: "goal".to_owned(), corners: vec![goal], keep_out: false }),
            bodies: truth.obstacles().map(|obstacle| body(&obstacle)).collect(),
            ..Scene::new(Arc::clone(&course.picture), truth.pose(), model.radius_m)
        }
    }
}

#[cfg(test)]
mod tests {
    use maps::{CellIndex, OccupancyGrid, pose};

    use super::*;

    fn house() -> Course {
        Course::new("house", "house.yaml".as_ref(), maps::house::map()).expect("the house has room")
    }

    #[test]
    fn trips_through_the_house_arrive_without_contact() {
        let house = house();
        for seed in 1..=4 {
            let (trip, _) = drive(&house, seed, About::default());
            assert!(trip.good, "seed {seed}: {}", trip.words());
            assert!(trip.driven_m > 0.9 * trip.shortest_m && trip.driven_m < 1.5 * trip.shortest_m, "{trip:?}");
        }
    }

    #[test]
    fn a_trip_among_people_is_reproducible() {
        let house = house();
        let about = About { people: 6, boxes: 0 };
        let (first, again) = (drive(&house, 5, about), drive(&house, 5, about));
        assert_eq!(format!("{:?}", first.0), format!("{:?}", again.0));
        assert_eq!(first.1.bodies.len(), 6);
        assert_eq!(first.0.wall_contacts + first.0.standing_contacts, 0, "{}", first.0.words());
    }
    #[test]
    fn trips_past_boxes_arrive_without_contact() {
        let house = house();
        for seed in 1..=4 {
            let (trip, scene) = drive(&house, seed, About { people: 0, boxes: 3 });
            assert!(trip.good, "seed {seed}: {}", trip.words());
            assert!(trip.about.boxes > 0 && scene.bodies.len() == trip.about.boxes);
        }
    }

    /// Positions on a map this far away are rounded to a nanometer. Where localization and control decide between near
    /// ties, rounding can change the trip by centimeters.
    #[test]
    fn trips_do_not_depend_on_how_far_the_map_is_from_the_origin() {
        let plan = maps::house::map();
        let by = pose(688_000.0, 5_335_000.0, 0.0);
        let mut moved = OccupancyGrid::new(plan.width(), plan.height(), plan.resolution_m(), by * plan.origin());
        for (offset, cell) in plan.cells().iter().enumerate() {
            moved.set(CellIndex { column: offset % plan.width(), row: offset / plan.width() }, *cell);
        }
        let (near, far) = (house(), Course::new("far", "far.yaml".as_ref(), moved).expect("the house has room"));
        let off_m = |near: [f64; 2], far: [f64; 2]| {
            (Point::new(near[0], near[1]) - by.inverse_transform_point(&Point::new(far[0], far[1]))).norm()
        };
        for seed in 1..=3 {
            let ((near, _), (far, _)) = (drive(&near, seed, About::default()), drive(&far, seed, About::default()));
            assert!(near.good && far.good, "seed {seed}: {} and {}", near.words(), far.words());
            assert!(off_m(near.start, far.start) < 1e-6 && off_m(near.goal, far.goal) < 1e-6);
            let driven_m = near.driven_m - far.driven_m;
            let time_s = near.time_s - far.time_s;
            assert!(off_m(near.end, far.end) < 0.05 && driven_m.abs() < 0.1 && time_s.abs() < 0.5, "{near:?}, {far:?}");
        }
    }
}
