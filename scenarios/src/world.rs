//! The world in which a run takes place: time, and a simulated robot with its software if the scenario has a map.

use std::time::Duration;

use bt::Tree;
use channels::{ChannelSystem, ProcessId};
use components::{Processes, Software};
use nav::{GiveUpReason, InitialPose};
use recording::{Battery, Body, BodyShape, Navigation, RobotState, Scene, TraceHash, Truth};
use robot::{Reading, Streams};
use sim::Simulation;

use crate::Error;
use crate::given_up::GivenUps;
use crate::scenario::{Premises, STEP};

/// A robot slower than this counts as at rest, in m/s and rad/s.
const AT_REST: f64 = 1e-3;

/// The world of a run.
pub(crate) struct World {
    now: Duration,
    robot: Option<SimulatedRobot>,
}

impl World {
    /// The world at the start of a run, with these components of its robot if there is one.
    pub(crate) fn new(robot: Option<(&Premises, Processes)>, streams: &Streams) -> Result<Self, Error> {
        let robot = robot.map(|(premises, processes)| SimulatedRobot::new(premises, processes, streams));
        Ok(Self { now: Duration::ZERO, robot: robot.transpose()? })
    }

    /// Moves on by a step: physics and sensors, then the robot's software.
    pub(crate) fn step(&mut self, system: &mut ChannelSystem) {
        self.now += STEP;
        if let Some(SimulatedRobot { sim, software, .. }) = &mut self.robot {
            sim.step();
            software.step(sim, system, self.now);
        }
    }

    /// Time since the start of the run.
    pub(crate) fn time(&self) -> Duration {
        self.now
    }

    pub(crate) fn robot(&self) -> Option<&SimulatedRobot> {
        self.robot.as_ref()
    }

    pub(crate) fn robot_mut(&mut self) -> Option<&mut SimulatedRobot> {
        self.robot.as_mut()
    }

    /// What is known of the robot.
    pub(crate) fn robot_state(&self) -> RobotState {
        self.robot.as_ref().map_or_else(RobotState::default, SimulatedRobot::state)
    }
}

/// A simulated robot with its software.
pub(crate) struct SimulatedRobot {
    pub(crate) sim: Simulation,
    pub(crate) software: Software,
    given_up: GivenUps,
    /// Whether it has been at each place.
    reached: Vec<bool>,
}

impl SimulatedRobot {
    fn new(premises: &Premises, processes: Processes, streams: &Streams) -> Result<Self, Error> {
        Ok(Self {
            sim: simulate(premises, streams)?,
            software: software(premises, processes, streams)?,
            given_up: GivenUps::default(),
            reached: vec![false; premises.places.iter().count()],
        })
    }

    /// Enters what the robot did and sensed in the last step.
    pub(crate) fn enter_into_trace(&self, hash: &mut TraceHash) {
        let truth = self.sim.truth();
        hash.pose(&truth.pose());
        hash.odometry(&truth.odometry());
        hash.battery(&truth.battery());
        for reading in self.software.readings() {
            if let Reading::Scan(scan) = reading {
                hash.scan(scan);
            }
        }
    }

    /// Tells a tree that asks for it where the robot is and how fast it drives, as far as the software knows.
    pub(crate) fn tell(&self, tree: &Tree, system: &mut ChannelSystem, bt: ProcessId) {
        let position = self.software.estimate().pose.translation.vector;
        let speed = self.software.odometry().map(|odometry| odometry.linear_mps.abs());
        let entries = [
            ("robot_pose", Some(bt::Value::from(&*format!("{};{}", position.x, position.y)))),
            ("robot_speed", speed.map(bt::Value::Real)),
        ];
        for (key, value) in entries.into_iter().filter(|(key, _)| tree.names_entry(key)) {
            if let (Some(board), Some(value)) = (bt::blackboard_in_mut(system, bt), value) {
                // An entry that the tree uses for something else keeps its value.
                let _ = board.set(key, value);
            }
        }
    }

    /// The reason, if navigation has just given up.
    pub(crate) fn note_given_up(&mut self) -> Option<GiveUpReason> {
        self.given_up.note(&self.software)
    }

    /// The places, by index, at which it has come to rest for the first time.
    pub(crate) fn note_arrivals(&mut self, premises: &Premises) -> Vec<usize> {
        let truth = self.sim.truth();
        if truth.linear_mps().abs() > AT_REST || truth.angular_radps().abs() > AT_REST {
            return Vec::new();
        }
        let pose = truth.pose();
        let places = premises.places.iter().zip(&mut self.reached).enumerate();
        let new = places.filter(|(_, ((_, there), reached))| !**reached && there.contains(&pose));
        let new = new.map(|(place, (_, reached))| {
            *reached = true;
            place
        });
        new.collect()
    }

    fn state(&self) -> RobotState {
        let truth = self.sim.truth();
        let battery = truth.battery();
        RobotState {
            truth: Some(Truth { pose: truth.pose(), distance_m: truth.distance_m(), collisions: truth.collisions() }),
            estimate: Some(self.software.estimate().pose),
            battery: Some(Battery { charge_pct: battery.charge_pct, charging: battery.charging }),
        }
    }

    /// What navigation is doing, if that differs from what was told.
    pub(crate) fn new_navigation(&self, told: &Navigation) -> Option<Navigation> {
        let software = &self.software;
        let (status, reason, recovery) =
            (software.navigation_status().name(), software.navigation_reason(), software.recovery());
        let same = told.status == status
            && told.recovery.as_deref() == recovery.map(nav::Recovery::name)
            && told.reason == reason.map(|reason| reason.to_string());
        (!same).then(|| Navigation {
            status: status.to_owned(),
            reason: reason.map(|reason| reason.to_string()),
            recovery: recovery.map(|recovery| recovery.name().to_owned()),
        })
    }

    /// What is visible now.
    pub(crate) fn scene(&self) -> Scene {
        let (truth, software) = (self.sim.truth(), &self.software);
        let stride = software.particle_count().div_ceil(Scene::MAX_PARTICLES).max(1);
        Scene {
            scans: truth.scans().cloned().collect(),
            particles: software.particles().step_by(stride).map(|pose| pose.translation.vector.into()).collect(),
            path: software.path().to_vec(),
            bodies: truth.obstacles().map(|obstacle| body_record(&obstacle)).collect(),
        }
    }
}

/// The record of a body.
fn body_record(obstacle: &sim::ObstacleTruth<'_>) -> Body {
    let shape = match obstacle.shape {
        sim::Shape::Disc { radius_m } => BodyShape::Disc { radius_m },
        sim::Shape::Box { length_m, width_m } => BodyShape::Box { length_m, width_m },
    };
    Body { name: obstacle.name.to_owned(), shape, pose: obstacle.pose }
}

fn simulate(premises: &Premises, streams: &Streams) -> Result<Simulation, Error> {
    let Premises { entry, start, station, .. } = premises;
    Simulation::within(premises.building(), &entry.sim, *start, *station, streams).map_err(|error| {
        let problem = entry.sites.start.span.problem(format!("the world cannot be set up: {error}"));
        Error::bad_input(
            problem.with_label("the start").with_help("the whole body of the robot must be on free floor at the start"),
        )
    })
}

fn software(premises: &Premises, processes: Processes, streams: &Streams) -> Result<Software, Error> {
    let Premises { entry, places, start, .. } = premises;
    let refused =
        |error: nav::Error| Error::bad_input(entry.map.span.problem(error.to_string()).with_label("this map"));
    let atlas = premises.atlas().map_err(refused)?;
    let rng = streams.stream("nav/localization");
    Software::new(&atlas, places, &InitialPose::at(*start), processes, rng).map_err(refused)
}
