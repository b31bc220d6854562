//! The robot's behavior, and the answers to skills, while a component is frozen and after it has restarted.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, ChannelId, ChannelSystem, Domain, Envelope, Message, Offer, Pattern, Process, ProcessId,
    RoundRobin, Topology, TransitionId, Use, Value,
};
use components::{
    BATTERY_READER, BatteryReader, Component, LOCALIZATION, Localization, NAVIGATION, Navigation, Processes, Software,
    operations,
};
use maps::{Cell, CellIndex, OccupancyGrid, Place, Places, Point, Pose, pose};
use nav::{Atlas, Goal, InitialPose, LocalizationParameters};
use robot::{BatteryState, Odometry, Reading, Robot, RobotModel, Streams, VelocityCommand};

const STEP: Duration = Duration::from_millis(20);

/// A robot without lasers that obeys instantly and whose odometry is exact.
struct Ideal {
    model: RobotModel,
    pose: Pose,
    time: Duration,
    command: VelocityCommand,
}

impl Robot for Ideal {
    fn model(&self) -> &RobotModel {
        &self.model
    }

    fn read(&mut self, readings: &mut Vec<Reading>) {
        self.time += STEP;
        let VelocityCommand { linear_mps, angular_radps } = self.command;
        let dt_s = STEP.as_secs_f64();
        self.pose *= pose(linear_mps * dt_s, 0.0, angular_radps * dt_s);
        readings.push(Reading::Odometry(Odometry { time: self.time, pose: self.pose, linear_mps, angular_radps }));
        // The level shows the time.
        let charge_pct = 100.0 - self.time.as_secs_f64();
        readings.push(Reading::Battery(BatteryState { time: self.time, charge_pct, charging: false }));
    }

    fn drive(&mut self, command: VelocityCommand) {
        self.command = command;
    }
}

/// Asks all three components, one question at a time.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Client {
    question: Option<(ChannelId, Message)>,
    answer: Option<Message>,
    lines: Vec<(ChannelId, ChannelId)>,
}

impl Process for Client {
    fn offers(&self, offers: &mut Vec<Offer>) {
        offers.extend(self.question.clone().map(|(channel, message)| Offer {
            transition: TransitionId(0),
            action: Action::Send(channel, message.into()),
        }));
        offers.extend((1..).zip(&self.lines).map(|(number, (_, replies))| Offer {
            transition: TransitionId(number),
            action: Action::Receive(*replies, Pattern::Any),
        }));
    }

    fn take(&mut self, _transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        match received {
            Some(envelope) => self.answer = Some(envelope.message),
            None => self.question = None,
        }
    }

    fn uses(&self) -> Vec<Use> {
        Vec::new()
    }

    fn location(&self) -> String {
        String::new()
    }
}

/// A robot in a hall of 10 m × 4 m, with its software and a client that asks.
struct Scene {
    robot: Ideal,
    software: Software,
    system: ChannelSystem,
    client: ProcessId,
}

fn hall() -> OccupancyGrid {
    let mut map = OccupancyGrid::new(200, 80, 0.05, pose(0.0, 0.0, 0.0));
    for (column, row) in (0..200).flat_map(|column| (0..80).map(move |row| (column, row))) {
        let is_wall = column == 0 || row == 0 || column == 199 || row == 79;
        map.set(CellIndex { column, row }, if is_wall { Cell::Occupied } else { Cell::Free });
    }
    map
}

fn places() -> Places {
    let mut places = Places::default();
    let around =
        |x: f64| [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(dx, dy)| Point::new(x + dx, 2.0 + dy));
    places.insert("Start", Place::Area { corners: around(1.0).to_vec() });
    places.insert("Destination", Place::Area { corners: around(8.0).to_vec() });
    places
}

impl Scene {
    fn new() -> Self {
        let mut topology = Topology::default();
        let client = topology.process("Client").unwrap();
        let operations = operations(&places());
        let [battery_reader, localization, navigation] = [BATTERY_READER, LOCALIZATION, NAVIGATION].map(|name| {
            let component = topology.process(name).unwrap();
            let own = operations.iter().filter(|operation| operation.component == name);
            let requests = Domain::new(own.clone().map(|operation| operation.request.clone()));
            topology.channel(client, component, Capacity::One, requests).unwrap();
            let replies = Domain::new(own.flat_map(|operation| operation.replies.clone()));
            topology.channel(component, client, Capacity::One, replies).unwrap();
            component
        });
        let lines = [BATTERY_READER, LOCALIZATION, NAVIGATION].map(|name| {
            let channel = |source, target| topology.find_channel(source, target).unwrap();
            (channel("Client", name), channel(name, "Client"))
        });
        let processes: [(_, Box<dyn Process>); 4] = [
            (client, Box::new(Client { question: None, answer: None, lines: lines.to_vec() })),
            (battery_reader, Box::new(BatteryReader::new(&topology, battery_reader).unwrap())),
            (localization, Box::new(Localization::new(&topology, localization).unwrap())),
            (navigation, Box::new(Navigation::new(&topology, navigation).unwrap())),
        ];
        let system = ChannelSystem::new(Arc::new(topology), processes).unwrap();
        let model = RobotModel { lasers: Vec::new(), ..RobotModel::default() };
        let start = pose(1.0, 2.0, 0.0);
        let processes = Processes { battery_reader, localization, navigation };
        let rng = Streams::new(1).stream("nav/localization");
        let atlas = Atlas::new(Arc::new(hall()), &model, LocalizationParameters::default()).unwrap();
        let atlas = Arc::new(atlas);
        let software = Software::new(&atlas, &places(), &InitialPose::at(start), processes, rng).unwrap();
        let robot = Ideal { model, pose: start, time: Duration::ZERO, command: VelocityCommand::STOP };
        Self { robot, software, system, client }
    }

    fn pass(&mut self, seconds: f64) {
        for _ in 0..(seconds / STEP.as_secs_f64()).round() as usize {
            let now = self.robot.time + STEP;
            self.software.step(&mut self.robot, &mut self.system, now);
            self.system.advance(now);
            assert!(self.system.run(&mut RoundRobin::default(), 1000).all(|event| event.is_ok()));
        }
    }

    /// Asks, lets one step pass, and returns the answer if there is one by then.
    fn ask(&mut self, component: &str, request: Message) -> Option<Message> {
        let channel = self.system.topology().find_channel("Client", component).unwrap();
        let client = self.system.process_mut::<Client>(self.client).unwrap();
        (client.question, client.answer) = (Some((channel, request)), None);
        self.pass(STEP.as_secs_f64());
        self.system.process::<Client>(self.client).unwrap().answer.clone()
    }

    fn go(&mut self, what: &str) -> Option<Message> {
        self.ask(NAVIGATION, Message::symbols([what, "Destination"]))
    }

    /// Whether Localization reports that the robot is there.
    fn is_at(&mut self, place: &str) -> Option<bool> {
        let answer = self.ask(LOCALIZATION, Message::symbols(["is_at", place]))?;
        Some(answer.field(2) == Some(&Value::Bool(true)))
    }

    fn level(&mut self) -> Option<Value> {
        self.ask(BATTERY_READER, Message::symbols(["get_level"]))?.field(2).cloned()
    }

    fn x_m(&self) -> f64 {
        self.robot.pose.translation.x
    }
}

fn status(name: &str) -> Option<Message> {
    Some(Message::symbols(["ok", name]))
}

#[test]
fn without_outages_the_robot_arrives() {
    let mut scene = Scene::new();
    scene.pass(0.1);
    assert_eq!((scene.is_at("Start"), scene.is_at("Destination")), (Some(true), Some(false)));
    assert_eq!(scene.go("start_navigation"), status("running"));
    scene.pass(25.0);
    assert_eq!(scene.go("get_status"), status("success"));
    assert_eq!(scene.is_at("Destination"), Some(true));
}

#[test]
fn a_frozen_battery_reader_repeats_the_last_level() {
    let mut scene = Scene::new();
    scene.pass(1.0);
    scene.software.freeze(Component::BatteryReader, true);
    let before = scene.level();
    scene.pass(5.0);
    assert_eq!(scene.level(), before);
    scene.software.freeze(Component::BatteryReader, false);
    assert_ne!(scene.level(), before);
}

#[test]
fn with_frozen_navigation_the_robot_stands_still_and_then_continues() {
    let mut scene = Scene::new();
    scene.go("start_navigation");
    scene.pass(5.0);
    scene.software.freeze(Component::Navigation, true);
    scene.pass(STEP.as_secs_f64());
    let stood_m = scene.x_m();
    assert!((1.5..7.0).contains(&stood_m), "under way: {stood_m}");
    scene.pass(10.0);
    assert_eq!(scene.x_m(), stood_m);
    assert_eq!(scene.go("get_status"), status("running"), "the process answers as before");
    assert_eq!(scene.go("stop_navigation"), status("stopped"));
    assert_eq!(scene.go("start_navigation"), status("running"), "orders wait");
    scene.software.freeze(Component::Navigation, false);
    scene.pass(25.0);
    assert_eq!(scene.go("get_status"), status("success"));
}

#[test]
fn frozen_localization_keeps_the_old_pose_until_it_continues() {
    let mut scene = Scene::new();
    scene.pass(0.1);
    scene.software.freeze(Component::Localization, true);
    let believed = *scene.software.estimate();
    scene.go("start_navigation");
    scene.pass(4.0);
    assert!(scene.x_m() > 1.8, "navigation relies on the pose that it gets");
    assert_eq!((*scene.software.estimate(), scene.is_at("Start")), (believed, Some(true)));
    scene.go("stop_navigation");
    scene.software.freeze(Component::Localization, false);
    assert_eq!(scene.is_at("Start"), Some(false));
    assert!((scene.software.estimate().pose.translation.x - scene.x_m()).abs() < 0.3);
}

#[test]
fn restarted_localization_starts_from_its_initial_pose() {
    let mut scene = Scene::new();
    scene.go("start_navigation");
    scene.pass(10.0);
    scene.go("stop_navigation");
    scene.pass(1.0);
    assert_eq!(scene.is_at("Start"), Some(false));
    scene.software.restart(Component::Localization, &mut scene.system);
    assert_eq!(scene.is_at("Start"), Some(true));
    let here = InitialPose::at(scene.robot.pose);
    scene.software.relocalize(&here);
    assert_eq!(scene.is_at("Start"), Some(false));
}

#[test]
fn restarted_navigation_has_no_trip_and_takes_the_next() {
    let mut scene = Scene::new();
    scene.go("start_navigation");
    scene.pass(5.0);
    scene.software.restart(Component::Navigation, &mut scene.system);
    assert_eq!(scene.go("get_status"), status("idle"));
    let stood_m = scene.x_m();
    scene.pass(5.0);
    assert_eq!(scene.x_m(), stood_m);
    assert_eq!(scene.go("start_navigation"), status("running"));
    scene.pass(25.0);
    assert_eq!(scene.go("get_status"), status("success"));
}

#[test]
fn a_goal_of_no_skill_aborts_the_trip_until_a_skill_starts_the_next() {
    let mut scene = Scene::new();
    let back = || Goal::at(Point::new(2.0, 2.0), Some(std::f64::consts::PI));
    scene.go("start_navigation");
    scene.pass(5.0);
    scene.software.drive_to(back(), &mut scene.system).unwrap();
    assert_eq!(scene.go("get_status"), status("failure"));
    assert_eq!(scene.go("stop_navigation"), status("stopped"));
    scene.pass(25.0);
    assert!((scene.x_m() - 2.0).abs() < 0.1 && scene.robot.pose.rotation.angle().abs() > 3.0, "{}", scene.robot.pose);
    assert_eq!(scene.go("get_status"), status("idle"));

    assert_eq!(scene.go("start_navigation"), status("running"));
    scene.pass(25.0);
    assert_eq!(scene.go("get_status"), status("success"));
    scene.software.drive_to(back(), &mut scene.system).unwrap();
    assert_eq!(scene.go("get_status"), status("success"), "that trip was over");
    scene.software.freeze(Component::Navigation, true);
    assert!(scene.software.drive_to(back(), &mut scene.system).is_err());
}

#[test]
fn a_restarted_battery_reader_forgets_its_pending_requests() {
    let mut scene = Scene::new();
    scene.software.freeze(Component::BatteryReader, true);
    assert_eq!(scene.level(), None, "there is no reading yet");
    scene.software.restart(Component::BatteryReader, &mut scene.system);
    scene.software.freeze(Component::BatteryReader, false);
    scene.pass(1.0);
    assert_eq!(scene.system.process::<Client>(scene.client).unwrap().answer, None);
    assert!(scene.level().is_some());
}

#[test]
fn components_are_found_by_name() {
    assert_eq!(Component::ALL.map(|component| Component::named(component.name())), Component::ALL.map(Some));
    assert_eq!(Component::named("Camera"), None);
}
