//! The world in which a run takes place: time, and a simulated robot with its software if the scenario has a map.

use std::time::Duration;

use bt::Tree;
use channels::{ChannelSystem, ProcessId};
use components::{Processes, Software};
use devices::{DeviceProcess, Surroundings};
use maps::{Point, Shape, pose};
use nav::{GiveUpReason, InitialPose};
use recording::{Battery, Body, Navigation, NavigationStatus, RobotState, Scene, TraceHash, Truth};
use remote::NodeMessage;
use robot::{Reading, Robot, Streams, VelocityCommand};
use scenarios::Error;
use scenarios::scenario::Premises;
use sim::{Contact, ObstacleConfig, ObstacleMotion, Simulation};

use crate::controller::{Controller, ControllerInput, ControllerOutput, PassiveRobot, Touched, TripCommand};

/// A robot slower than this counts as at rest, in m/s and rad/s. Chosen, not measured.
const AT_REST: f64 = 1e-3;

/// The gap between the robot and a box that it has put down, in meters: chosen so that they do not touch at once.
const BESIDE_M: f64 = 0.05;

pub(crate) struct World {
    now: Duration,
    pub(crate) robot: Option<SimulatedRobot>,
    devices: Vec<Device>,
}

struct Device {
    process: ProcessId,
    speech: Option<String>,
    /// When the last audible speech began.
    last: Option<Duration>,
}

impl World {
    /// The world at the start of a run, with these components of its robot, if there is one, and the devices of a
    /// system.
    pub(crate) fn new(
        robot: Option<(&Premises, Processes)>,
        system: &ChannelSystem,
        streams: &Streams,
    ) -> Result<Self, Error> {
        let robot = robot.map(|(premises, processes)| SimulatedRobot::new(premises, processes, streams));
        let devices = system.topology().processes().filter(|id| system.process::<DeviceProcess>(*id).is_some());
        let devices = devices.map(|process| Device { process, speech: None, last: None }).collect();
        Ok(Self { now: Duration::ZERO, robot: robot.transpose()?, devices })
    }

    /// Advances to a time, by one step if there is a robot: physics and sensors, then the robot's software, which
    /// drives it unless a controller does.
    pub(crate) fn step(&mut self, to: Duration, system: &mut ChannelSystem, has_controller: bool) {
        self.now = to;
        let Some(SimulatedRobot { sim, software, advice, .. }) = &mut self.robot else { return };
        sim.step();
        if !has_controller {
            return software.step(sim, system, self.now);
        }
        let mut passive = PassiveRobot { sim, advice: VelocityCommand::STOP };
        software.step(&mut passive, system, self.now);
        *advice = passive.advice;
    }

    /// Has a controller drive the robot after a step. The outbox has the components' responses and messages for nodes
    /// of ROS 2. Returns the controller's output; `None` while that is not ready.
    pub(crate) fn obey(
        &mut self,
        controller: &mut dyn Controller,
        outbox: &[NodeMessage],
        system: &mut ChannelSystem,
    ) -> Option<ControllerOutput> {
        let SimulatedRobot { sim, software, advice, .. } = self.robot.as_mut()?;
        let truth = sim.truth();
        let new = truth.contacts().iter().skip_while(|contact| contact.time < self.now);
        let touched: Vec<Touched<'_>> = new.map(touched).collect();
        let doors: Vec<(&str, f64)> = truth.doors().collect();
        let input = ControllerInput { now: self.now, software, touched: &touched, doors: &doors, outbox };
        let mut output = controller.drive(&input)?;
        sim.drive(output.velocity.unwrap_or(*advice));
        output.pose.iter().for_each(|pose| software.relocalize(pose));
        match output.trip.take() {
            // A navigation that has been frozen meanwhile ignores the command, and no trip begins.
            Some(TripCommand::Start(goal)) => drop(software.drive_to(goal, system)),
            Some(TripCommand::End) => software.end_trip(),
            None => {}
        }
        Some(output)
    }

    /// Lets devices sense and act after a step.
    pub(crate) fn move_devices(&mut self, system: &mut ChannelSystem) {
        let Some(robot) = &mut self.robot else { return };
        for Device { process, .. } in &self.devices {
            if !system.is_suspended(*process)
                && let Some(device) = system.process_mut::<DeviceProcess>(*process)
            {
                device.act(&mut robot.around());
            }
        }
    }

    /// The texts that speakers have begun to speak since the last call, with their processes.
    pub(crate) fn new_speeches(&mut self, system: &ChannelSystem) -> Vec<(ProcessId, String)> {
        let mut new = Vec::new();
        for Device { process, speech, last } in &mut self.devices {
            let device = system.process::<DeviceProcess>(*process).filter(|_| !system.is_suspended(*process));
            let audible = device.and_then(DeviceProcess::speech);
            *speech = audible.map(|(_, text)| text.to_owned());
            if let Some((since, text)) = audible.filter(|(since, _)| *last != Some(*since)) {
                *last = Some(since);
                new.push((*process, text.to_owned()));
            }
        }
        new
    }

    pub(crate) fn scene(&self) -> Option<Scene> {
        let scene = self.robot.as_ref().map(SimulatedRobot::scene)?;
        Some(Scene { speeches: self.devices.iter().filter_map(|device| device.speech.clone()).collect(), ..scene })
    }

    pub(crate) fn time(&self) -> Duration {
        self.now
    }
}

pub(crate) struct SimulatedRobot {
    pub(crate) sim: Simulation,
    pub(crate) software: Software,
    /// The last command of its software, while a controller drives.
    advice: VelocityCommand,
    /// How many trips navigation had given up in the last step.
    trips_given_up: u64,
    bodies: Vec<ObstacleConfig>,
    /// How it stands to each place.
    visits: Vec<Visit>,
}

/// How far a robot is on its way to a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Visit {
    /// It has not come to rest there, or only before it first left.
    Awaited,
    /// It stands there from the start.
    FromStart,
    /// It has come to rest there.
    Arrived,
}

impl SimulatedRobot {
    fn new(premises: &Premises, processes: Processes, streams: &Streams) -> Result<Self, Error> {
        Ok(Self {
            sim: simulate(premises, streams)?,
            software: software(premises, processes, streams)?,
            advice: VelocityCommand::STOP,
            trips_given_up: 0,
            bodies: premises.entry.sim.obstacles.clone(),
            visits: vec![Visit::Awaited; premises.places.iter().count()],
        })
    }

    /// Records what the robot did and sensed in the last step.
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

    /// Writes the robot's position and speed, as far as they are known to the software, to the blackboard of a tree
    /// that reads them.
    pub(crate) fn write_to_blackboard(&self, tree: &Tree, system: &mut ChannelSystem, bt: ProcessId) {
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
        let before = std::mem::replace(&mut self.trips_given_up, self.software.navigator().trips_given_up());
        self.software.navigator().reason().filter(|_| self.trips_given_up > before)
    }

    /// The places, by index, at which it has come to rest for the first time; one where it stands from the start counts
    /// then, and once more when it has come back.
    pub(crate) fn note_arrivals(&mut self, premises: &Premises, is_start: bool) -> Vec<usize> {
        let truth = self.sim.truth();
        let is_at_rest = truth.linear_mps().abs() <= AT_REST && truth.angular_radps().abs() <= AT_REST;
        let pose = truth.pose();
        let mut new = Vec::new();
        for (place, ((_, there), visit)) in premises.places.iter().zip(&mut self.visits).enumerate() {
            match visit {
                Visit::Awaited if is_at_rest && there.contains(&pose) => {
                    *visit = if is_start { Visit::FromStart } else { Visit::Arrived };
                    new.push(place);
                }
                Visit::FromStart if !there.contains(&pose) => *visit = Visit::Awaited,
                _ => {}
            }
        }
        new
    }

    pub(crate) fn state(&self) -> RobotState {
        let truth = self.sim.truth();
        let battery = truth.battery();
        RobotState {
            truth: Some(Truth { pose: truth.pose(), distance_m: truth.distance_m(), collisions: truth.collisions() }),
            estimate: Some(self.software.estimate().pose),
            battery: Some(Battery { charge_pct: battery.charge_pct, charging: battery.charging }),
        }
    }

    /// The status of navigation, if it differs from the last report.
    pub(crate) fn new_navigation(&self, recorded: Option<&Navigation>) -> Option<Navigation> {
        let navigator = self.software.navigator();
        let status = navigator.status().to_string();
        let new = Navigation {
            status: NavigationStatus::try_from(status).expect("records have every status of navigation"),
            reason: navigator.reason().map(|reason| reason.to_string()),
            recovery: navigator.recovery().map(|recovery| recovery.name().to_owned()),
        };
        (recorded != Some(&new)).then_some(new)
    }

    pub(crate) fn radius_m(&self) -> f64 {
        self.sim.model().radius_m
    }

    /// The position of a person or box; `None` for a box that the robot carries.
    pub(crate) fn body(&self, name: &str) -> Option<Point> {
        let mut bodies = self.sim.truth().obstacles();
        bodies.find(|body| body.name == name).map(|body| body.pose.translation.vector.into())
    }

    /// The distance between the robot's edge and the nearest person, in meters; infinite without people.
    pub(crate) fn person_m(&self) -> f64 {
        let (truth, described) = (self.sim.truth(), self.described());
        let center = truth.pose().translation.vector.into();
        let people = truth.obstacles().filter(|body| described.is_person(body.name));
        let nearest_m = people.map(|body| body.distance_m(&center)).fold(f64::INFINITY, f64::min);
        (nearest_m - self.radius_m()).max(0.0)
    }

    fn described(&self) -> Described<'_> {
        Described { sim: &self.sim, bodies: &self.bodies }
    }

    fn around(&mut self) -> Around<'_> {
        Around { sim: &mut self.sim, bodies: &self.bodies }
    }

    /// Makes the box of a tray fall.
    ///
    /// # Errors
    /// Why it cannot fall.
    pub(crate) fn drop_box(&mut self, tray: ProcessId, system: &mut ChannelSystem) -> Result<(), &'static str> {
        let tray = system.process_mut::<DeviceProcess>(tray).expect("the fault is that of a tray");
        tray.drop_box(&mut self.around())
    }

    fn scene(&self) -> Scene {
        let (truth, software) = (self.sim.truth(), &self.software);
        let stride = software.particle_count().div_ceil(Scene::MAX_PARTICLES).max(1);
        Scene {
            scans: truth.scans().cloned().collect(),
            particles: software.particles().step_by(stride).map(|(pose, _)| pose.translation.vector.into()).collect(),
            path: software.path().to_vec(),
            bodies: truth.obstacles().map(|obstacle| body_record(&obstacle)).collect(),
            speeches: Vec::new(),
        }
    }
}

/// The bodies of the world, as they were described.
#[derive(Clone, Copy)]
struct Described<'a> {
    sim: &'a Simulation,
    bodies: &'a [ObstacleConfig],
}

impl<'a> Described<'a> {
    /// The description of a body; `None` for an unknown one.
    fn config(self, name: &str) -> Option<&'a ObstacleConfig> {
        self.bodies.iter().chain(&self.sim.faults().bodies).find(|body| body.name == name)
    }

    fn is_person(self, name: &str) -> bool {
        self.config(name).is_some_and(|body| match body.motion {
            ObstacleMotion::Person(_) | ObstacleMotion::Follower(_) => true,
            // The people of the fault `people`, unless they give way.
            ObstacleMotion::Route { .. } => matches!(body.shape, Shape::Disc { .. }),
            _ => false,
        })
    }

    fn is_movable(self, name: &str) -> bool {
        self.config(name).is_some_and(|body| matches!(body.motion, ObstacleMotion::Movable { .. }))
    }
}

/// The robot and its surroundings, for devices.
struct Around<'a> {
    sim: &'a mut Simulation,
    bodies: &'a [ObstacleConfig],
}

impl Around<'_> {
    fn described(&self) -> Described<'_> {
        Described { sim: self.sim, bodies: self.bodies }
    }

    fn position(&self) -> Point {
        self.sim.truth().pose().translation.vector.into()
    }

    /// Puts a lifted box down beside the robot and in its view, as near as possible to this direction from its heading,
    /// in degrees.
    fn put_down_towards(&mut self, name: &str, direction_deg: f64) -> bool {
        let robot = self.sim.truth().pose();
        let half_m = self.described().config(name).map_or(0.0, |body| body.shape.bounding_radius_m());
        let reach_m = self.sim.model().radius_m + half_m + BESIDE_M;
        [0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0].into_iter().any(|turn_deg: f64| {
            let there = robot * pose(0.0, 0.0, (direction_deg + turn_deg).to_radians()) * pose(reach_m, 0.0, 0.0);
            self.sim.truth().sees(&there.translation.vector.into()) && self.sim.put_down(name, there).is_ok()
        })
    }
}

impl Surroundings for Around<'_> {
    fn door_opening(&self, door: &str) -> Option<f64> {
        self.sim.truth().door_opening(door)
    }

    fn move_door(&mut self, door: &str, open: bool) {
        self.sim.command_door(door, open);
    }

    fn people_in_view(&self, names: &[String]) -> Vec<f64> {
        let (truth, robot) = (self.sim.truth(), self.position());
        let people = truth.obstacles().filter(|body| self.described().is_person(body.name));
        let wanted = people.filter(|body| names.is_empty() || names.iter().any(|name| name == body.name));
        let at = wanted.map(|body| Point::from(body.pose.translation.vector));
        at.filter(|at| truth.sees(at)).map(|at| (at - robot).norm()).collect()
    }

    fn take_box(&mut self, reach_m: f64) -> Option<String> {
        let (truth, robot) = (self.sim.truth(), self.position());
        let within_m = self.sim.model().radius_m + reach_m;
        let boxes = truth.obstacles().filter(|body| self.described().is_movable(body.name));
        let boxes = boxes.filter(|body| truth.sees(&body.pose.translation.vector.into()));
        let boxes = boxes.map(|body| (body.distance_m(&robot), body.name));
        let nearest = boxes.filter(|(distance_m, _)| *distance_m <= within_m).min_by(|a, b| a.0.total_cmp(&b.0));
        let name = nearest?.1.to_owned();
        self.sim.pick_up(&name).is_ok().then_some(name)
    }

    fn put_down(&mut self, name: &str) -> bool {
        self.put_down_towards(name, 0.0)
    }

    fn drop_box(&mut self, name: &str) -> bool {
        self.put_down_towards(name, 180.0)
    }
}

fn touched(Contact { obstacle, at, normal, depth_m, .. }: &Contact) -> Touched<'_> {
    let body = obstacle.as_deref().unwrap_or("walls");
    Touched { body, at: *at, normal: (*normal).into(), depth_m: *depth_m }
}

fn body_record(obstacle: &sim::ObstacleTruth<'_>) -> Body {
    Body { name: obstacle.name.to_owned(), shape: obstacle.shape, pose: obstacle.pose }
}

fn simulate(premises: &Premises, streams: &Streams) -> Result<Simulation, Error> {
    let Premises { entry, start, station, .. } = premises;
    Simulation::within(&premises.building(), &entry.sim, *start, *station, streams).map_err(|error| {
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

#[cfg(test)]
mod tests {
    use nav::NavigationStatus as Status;

    use super::*;

    #[test]
    fn records_have_every_status_of_navigation() {
        let under_way = [Status::PreparingBeforeMove, Status::Moving, Status::WaitingObstacle, Status::Failing];
        let others = [Status::Idle, Status::GoalReached, Status::Aborted, Status::Thinking, Status::Error];
        for status in under_way.into_iter().chain(others) {
            assert!(NavigationStatus::try_from(status.to_string()).is_ok(), "{status}");
        }
    }
}
