//! The simulation as a whole: built, stepped, and driven as a robot.

use std::fmt;
use std::time::Duration;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy_ecs::system::RunSystemOnce;
use maps::{OccupancyGrid, Pose};
use robot::{Reading, Robot, RobotModel, Streams, VelocityCommand};

use crate::battery::{Battery, report_battery};
use crate::bodies::{ExtraBodies, place_bodies};
use crate::boxes::{pick_up, put_down};
use crate::building::Building;
use crate::clock::{Clock, advance_clock};
use crate::config::SimConfig;
use crate::contacts::{Contacts, count_contacts};
use crate::docking::{Dock, Station, update_battery};
use crate::doors::{Leaf, move_doors};
use crate::drive::{Drive, drive_robot, settle_robot};
use crate::error::{BoxError, Placement, SimError};
use crate::faults::Faults;
use crate::kidnapping::{check_walls, kidnap};
use crate::lasers::{Laser, scan};
use crate::motion::{Motion, RobotPose};
use crate::noise::Drift;
use crate::obstacles::{Obstacles, move_obstacles, named, note_rest, settle_obstacles};
use crate::odometer::{Odometer, measure_odometry};
use crate::people::{follow, walk};
use crate::physics::{Physics, step_physics};
use crate::readings::Readings;
use crate::room::{check_on_map, check_room};
use crate::spawning::{first_pose, spawn_obstacle};
use crate::truth::Truth;
use crate::walls::Walls;

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct SimulationStep;

/// A simulated robot in its world.
///
/// The first readings, of time 0, are available before the first step. Readings accumulate until they are read: read
/// them after every step.
pub struct Simulation {
    model: RobotModel,
    world: World,
    schedule: Schedule,
    robot: Entity,
    lasers: Vec<Entity>,
}

impl Simulation {
    /// A robot at rest at `start`. The walls are the occupied cells of `grid`; there may be a charging station at
    /// `station`. Both poses are in the `map` frame. All randomness of the run comes from `streams`.
    ///
    /// # Errors
    /// If a setting has an invalid value, if start or station are outside the map, or if the robot's body would overlap
    /// a wall or an obstacle at the start.
    pub fn new(
        config: &SimConfig,
        grid: &OccupancyGrid,
        start: Pose,
        station: impl Into<Option<Pose>>,
        streams: &Streams,
    ) -> Result<Self, SimError> {
        Self::within(&Building::new(grid), config, start, station, streams)
    }

    /// A robot as made by [`new`](Self::new), in a building that other simulations may share.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn within(
        building: &Building,
        config: &SimConfig,
        start: Pose,
        station: impl Into<Option<Pose>>,
        streams: &Streams,
    ) -> Result<Self, SimError> {
        let bad_settings = config.bad_settings();
        if !bad_settings.is_empty() {
            return Err(SimError::Settings(bad_settings));
        }
        let station = station.into();
        check_places(config, building.walls(), &start, station.as_ref())?;
        let mut world = world_of(config, building);
        let robot = spawn_robot(&mut world, config, start, streams);
        let lasers = spawn_lasers(&mut world, config, streams);
        world.spawn(Station(station));
        for obstacle in &config.obstacles {
            spawn_obstacle(&mut world, obstacle);
        }
        take_first_readings(&mut world);
        let schedule = schedule(&mut world);
        Ok(Self { model: config.model.clone(), world, schedule, robot, lasers })
    }

    /// Advances time by [`SimConfig::dt`].
    pub fn step(&mut self) {
        self.schedule.run(&mut self.world);
    }

    /// Time since the start of the run.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.world.resource::<Clock>().now
    }

    /// The true state: for reports, never for the robot's software.
    #[must_use]
    pub fn truth(&self) -> Truth<'_> {
        Truth { world: &self.world, robot: self.robot, lasers: &self.lasers }
    }

    /// The current faults.
    #[must_use]
    pub fn faults(&self) -> &Faults {
        self.world.resource::<Faults>()
    }

    /// The faults, to be changed; changes apply from the next step on.
    pub fn faults_mut(&mut self) -> &mut Faults {
        self.world.resource_mut::<Faults>().into_inner()
    }

    /// Sets the battery's charge, in percent, clamped to 0 to 100; NaN changes nothing. The next reading shows it.
    pub fn set_battery_charge(&mut self, charge_pct: f64) {
        if let Some(mut battery) = self.world.get_mut::<Battery>(self.robot) {
            battery.set_charge(charge_pct);
        }
    }

    /// Moves the robot to a pose in the `map` frame, at rest. Its wheels do not notice: odometry continues from its
    /// last pose, and [`Truth::distance_m`] does not count the move. The software's command stays in effect.
    ///
    /// # Errors
    /// If the pose is outside the map, or if the robot's body would overlap a wall or an obstacle there; then the robot
    /// stays where it is.
    pub fn kidnap(&mut self, pose: Pose) -> Result<(), SimError> {
        kidnap(&mut self.world, self.robot, pose)
    }

    /// Whether the robot can ever be moved to this pose: [`kidnap`](Self::kidnap) succeeds unless an obstacle is in the
    /// way at that moment.
    ///
    /// # Errors
    /// If the pose is outside the map, or if the robot's body would overlap a wall there.
    pub fn check_kidnapping(&self, pose: &Pose) -> Result<(), SimError> {
        check_walls(&self.world, self.robot, pose)
    }

    /// Opens or closes the door with this name: its leaf begins to move in the next step, and from then on ignores its
    /// schedule. Returns whether there is such a door.
    pub fn command_door(&mut self, name: &str, open: bool) -> bool {
        let leaf = named::<Leaf>(&self.world, name).and_then(|door| self.world.get_mut::<Leaf>(door));
        leaf.map(|mut leaf| leaf.command(open)).is_some()
    }

    /// Takes a [movable](crate::ObstacleMotion::Movable) obstacle off the floor, wherever it is: lasers no longer see
    /// it, and nothing collides with it. One that a fault has added disappears when the fault ends.
    ///
    /// # Errors
    /// If there is no movable obstacle with this name, or if it has been picked up already.
    pub fn pick_up(&mut self, name: &str) -> Result<(), BoxError> {
        pick_up(&mut self.world, name)
    }

    /// Puts a box that has been [picked up](Self::pick_up) down at a pose in the `map` frame, at rest.
    ///
    /// # Errors
    /// If there is no movable obstacle with this name, if it has not been picked up, or if its center would be outside
    /// the map or its body would overlap a wall, the robot or another obstacle; then it stays where it is.
    pub fn put_down(&mut self, name: &str, pose: Pose) -> Result<(), BoxError> {
        put_down(&mut self.world, self.robot, name, pose)
    }
}

impl fmt::Debug for Simulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (time, pose) = (self.time(), self.truth().pose());
        f.debug_struct("Simulation").field("time", &time).field("pose", &pose).finish_non_exhaustive()
    }
}

impl Robot for Simulation {
    fn model(&self) -> &RobotModel {
        &self.model
    }

    fn read(&mut self, readings: &mut Vec<Reading>) {
        self.world.resource_mut::<Readings>().hand_over(readings);
    }

    fn drive(&mut self, command: VelocityCommand) {
        if let Some(mut drive) = self.world.get_mut::<Drive>(self.robot) {
            drive.commands.send(command);
        }
    }
}

/// Fails if there is no room for the robot at the start, or the station is outside the map.
fn check_places(config: &SimConfig, walls: &Walls, start: &Pose, station: Option<&Pose>) -> Result<(), SimError> {
    let poses: Vec<Pose> = config.obstacles.iter().map(first_pose).collect();
    let obstacles = config.obstacles.iter().zip(&poses);
    let obstacles = obstacles.map(|(obstacle, pose)| (obstacle.name.as_str(), &obstacle.shape, pose));
    let at = |pose: &Pose| pose.translation.vector.into();
    check_room(walls.rays(), obstacles, config.model.radius_m, Placement::Start, &at(start))?;
    station.map_or(Ok(()), |station| check_on_map(walls.rays(), Placement::Station, &at(station)))
}

fn world_of(config: &SimConfig, building: &Building) -> World {
    let physics = Physics::within(building, config.dt.as_secs_f64(), config.body.friction);
    let mut world = World::new();
    world.insert_resource(Clock { now: Duration::ZERO, dt: config.dt });
    world.insert_resource(physics);
    world.insert_resource(building.clone());
    world.insert_resource(Faults::default());
    world.insert_resource(Readings::default());
    world.insert_resource(Obstacles::default());
    world.insert_resource(ExtraBodies::default());
    world
}

fn spawn_robot(world: &mut World, config: &SimConfig, start: Pose, streams: &Streams) -> Entity {
    let model = &config.model;
    let body = world.resource_mut::<Physics>().add_robot(&start, model.radius_m, config.body.mass_kg);
    let motion_drift = Drift::new(config.drive.noise, streams.stream("sim/motion"));
    let odometry_drift = Drift::new(config.odometry.noise, streams.stream("sim/odometry"));
    let parts = (
        body,
        RobotPose(start),
        Motion { at_rest: true, ..Motion::default() },
        Drive::new(model, &config.drive, motion_drift, start),
        Contacts::default(),
        Odometer::new(&config.odometry, odometry_drift),
        Dock::new(&config.docking),
        Battery::new(&config.battery, streams.stream("fault/battery")),
    );
    world.spawn(parts).id()
}

fn spawn_lasers(world: &mut World, config: &SimConfig, streams: &Streams) -> Vec<Entity> {
    let mut spawn =
        |(index, spec): (usize, &robot::LaserSpec)| world.spawn(Laser::new(index, spec, &config.lasers, streams)).id();
    config.model.lasers.iter().enumerate().map(&mut spawn).collect()
}

/// The systems in the order of a step.
fn schedule(world: &mut World) -> Schedule {
    let mut schedule = Schedule::new(SimulationStep);
    schedule.set_executor(SingleThreadedExecutor::new());
    let ambiguity_detection = LogLevel::Error;
    schedule.set_build_settings(ScheduleBuildSettings { ambiguity_detection, ..ScheduleBuildSettings::default() });
    let others = (move_obstacles, walk, follow, move_doors).chain();
    let settling = (settle_robot, settle_obstacles, note_rest).chain();
    let motion = (others, drive_robot, step_physics, settling, count_contacts);
    let measurement = (measure_odometry, scan, report_battery);
    schedule.add_systems((advance_clock, place_bodies, motion.chain(), update_battery, measurement.chain()).chain());
    schedule.initialize(world).expect("the systems are in one order");
    schedule
}

/// Takes the measurements of time 0, in the order of a step.
fn take_first_readings(world: &mut World) {
    world.run_system_once(measure_odometry).expect("the robot has odometry");
    world.run_system_once(scan).expect("the robot has a pose");
    world.run_system_once(report_battery).expect("the robot has a battery");
}
