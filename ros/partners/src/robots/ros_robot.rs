//! A simulated robot as a node of ROS 2.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use maps::Pose;
use network::Publication;
use recording::ros;
use remote::NodeMessage;
use robot::{LaserSpec, Reading, VelocityCommand};
use ros_messages::RosMessage;
use runs::{Controller, ControllerInput, ControllerOutput, Touched};
use scenarios::Error;
use scenarios::scenario::Scenario;

use super::commands::{self, Command};
use super::config::RobotConfig;
use super::exchange::Exchange;
use super::frames::Frames;
use super::hub::{Incoming, Station};
use super::lifecycle::{self, ManagedNode};
use super::navigation::NavigationServer;
use super::pace::{Commands, Oddity, Pace, STALE};
use super::topics::Topics;

/// The longest wait for a message in one call.
const PATIENCE: Duration = Duration::from_millis(50);

/// How long to wait once the node that drives has been discovered: it may not have discovered this node yet.
const SETTLING: Duration = Duration::from_secs(1);

/// The most cells of a map that is published.
const MOST_CELLS: usize = 60_000_000;

/// The most messages that are taken in a step. Others wait, or are lost.
const MOST: usize = 1000;

/// Whether a late subscriber gets the last estimated pose at once, as from AMCL: clients of Nav2 request it.
const POSE_IS_LATCHED: bool = true;

/// What the robots of a scenario have in common. It does not change.
pub(super) struct RobotSetup {
    pub(super) config: RobotConfig,
    pace: Pace,
    map: ros::OccupancyGrid,
    lasers: Vec<LaserSpec>,
    frames: Frames,
}

impl RobotSetup {
    /// # Errors
    /// If a period is no multiple of the scenario's step, the scenario has no robot to drive, its map is too
    /// large, or frames cannot be renamed so.
    pub(super) fn of(config: RobotConfig, scenario: &Scenario) -> Result<Self, Error> {
        let pace = Pace::of(config.pace, scenario.file.execution.step())?;
        let premises = scenario.premises.as_ref().filter(|_| scenario.schedule.is_none()).ok_or_else(|| {
            let message = format!("the scenario {} has no robot to drive", scenario.name);
            Error::refused(message, "name one with a map, and without a schedule")
        })?;
        let (mut map, lasers) = (ros::occupancy_grid(&premises.map), premises.entry.sim.model.lasers.clone());
        let frames = Frames::of(&lasers, &config.frames)?;
        map.header.frame_id = frames.map.clone().into();
        if map.data.len() > MOST_CELLS {
            let message = format!("the map has {} cells, which is too much for a message", map.data.len());
            return Err(Error::refused(message, format!("{MOST_CELLS} are possible")));
        }
        Ok(Self { config, pace, map, lasers, frames })
    }
}

/// The node. In [`drive`](Controller::drive), it publishes what the robot senses, and takes commands.
pub(super) struct RosRobot {
    station: Station,
    topics: Topics,
    /// The requests of other nodes to its action and the scenario's components.
    exchange: Exchange,
    frames: Frames,
    pace: Pace,
    lasers: Vec<LaserSpec>,
    /// The action server of the robot's own navigation, if that drives.
    navigation: Option<NavigationServer>,
    is_localized: bool,
    /// Since when the run could begin: in lock step, once the node that drives has been discovered.
    found: Option<Instant>,
    has_begun: bool,
    /// The time of the readings that were published last.
    shown: Option<Duration>,
    /// Whether all robots have completed this step.
    is_together: bool,
    /// Since when a command has been awaited.
    waiting_since: Option<Instant>,
    /// The output for this step, as far as it is known.
    output: ControllerOutput,
    commands: Commands,
    /// In lock step, the command of this period.
    held: VelocityCommand,
    /// The irregularities of commands that have been noted.
    noted: BTreeSet<Oddity>,
    /// How far doors were open when this was published last.
    doors: Vec<f64>,
}

impl Controller for RosRobot {
    fn drive(&mut self, input: &ControllerInput<'_>) -> Option<ControllerOutput> {
        let now = input.now;
        let has_begun = self.await_partner();
        self.serve_states(input, has_begun);
        if !has_begun {
            return None;
        }
        if self.shown.replace(now) != Some(now) {
            self.publish_readings(input);
            self.publish_doors(input);
            self.pass_on(input.outbox);
            self.is_together = false;
        }
        if !self.is_together {
            let publishes_time = self.station.keep_step(now)?;
            if publishes_time && self.pace.publishes(now) {
                self.publish(&self.topics.clock, false, &ros::Clock { clock: now.into() });
            }
            self.is_together = true;
        }
        let navigates = self.navigation.is_some() && input.software.navigator().status().is_under_way();
        let commanded = if let Pace::LockStep { deadline, .. } = self.pace {
            if self.pace.awaits(now) {
                self.held = self.await_command(now, deadline)?;
            }
            self.held
        } else {
            if !self.listen(now) {
                return None;
            }
            self.last_command(now, navigates)
        };
        self.output.velocity = (!navigates).then_some(commanded);
        self.serve(input);
        Some(std::mem::take(&mut self.output))
    }

    fn serves(&self) -> bool {
        true
    }

    fn resume(&mut self) {
        self.pace.resume();
        self.waiting_since = None;
    }

    fn leave(&mut self, outbox: &[NodeMessage]) {
        self.pass_on(outbox);
        if let Some(navigation) = &mut self.navigation {
            navigation.leave();
            let outbox = navigation.take_outbox();
            self.pass_on(&outbox);
        }
        self.station.leave();
    }
}

impl RosRobot {
    /// Announces all topics, and publishes what does not change.
    pub(super) fn begin(setup: &RobotSetup, station: Station, topics: Topics) -> Self {
        let RobotSetup { config, pace, map, lasers, frames } = setup;
        let robot = Self {
            station,
            exchange: Exchange::of(topics.offered.clone()),
            topics,
            navigation: config.navigates.then(|| NavigationServer::new(frames.map.clone())),
            frames: frames.clone(),
            pace: pace.clone(),
            lasers: lasers.clone(),
            is_localized: config.localizes,
            found: None,
            has_begun: false,
            shown: None,
            is_together: false,
            waiting_since: None,
            output: ControllerOutput::default(),
            commands: Commands::default(),
            held: VelocityCommand::STOP,
            noted: BTreeSet::new(),
            doors: Vec::new(),
        };
        robot.offer_all();
        if config.publishes_map {
            robot.publish(&robot.topics.map, true, map);
        }
        robot.publish(&robot.topics.tf_static, true, &frames.fixed(lasers));
        robot
    }

    /// Handles the requests of other nodes to its navigation, and takes those to components.
    fn serve(&mut self, input: &ControllerInput<'_>) {
        let Self { navigation, exchange, station, output, .. } = self;
        let mut request = |is_of_navigation: bool| {
            let is_meant = |service: &str| {
                let within = exchange.within(service);
                let is_state = ManagedNode::of_service(within).is_some();
                !is_state && NavigationServer::serves(within) == is_of_navigation
            };
            let request = station.request(is_meant)?;
            exchange.accept(request)
        };
        if let Some(navigation) = navigation {
            output.trip = navigation.act(input, || request(true));
        }
        output.requests.extend(std::iter::from_fn(|| request(false)));
        let outbox = navigation.as_mut().map(NavigationServer::take_outbox);
        self.pass_on(&outbox.unwrap_or_default());
    }

    /// Responds to requests for the states of the nodes of Nav2 that the robot replaces.
    fn serve_states(&mut self, input: &ControllerInput<'_>, has_begun: bool) {
        let Self { station, exchange, .. } = self;
        loop {
            let is_answered = |service: &str| {
                ManagedNode::of_service(exchange.within(service)).is_some_and(|node| !node.is_frozen(input))
            };
            let Some(request) = station.request(is_answered) else { return };
            if let Some(request) = exchange.accept(request) {
                exchange.send(lifecycle::response(&request, has_begun), &station.publisher);
            }
        }
    }

    /// Sends responses and messages of its navigation and of components to other nodes.
    fn pass_on(&mut self, outbox: &[NodeMessage]) {
        outbox.iter().for_each(|message| self.exchange.send(message.clone(), &self.station.publisher));
    }

    /// Publishes how far doors are open, if that has changed: as joints, which turn or slide.
    fn publish_doors(&mut self, ControllerInput { now, doors, .. }: &ControllerInput<'_>) {
        let places = || doors.iter().map(|(_, place)| *place);
        if places().eq(self.doors.iter().copied()) {
            return;
        }
        self.doors = places().collect();
        let message = ros::JointState {
            header: ros::Header::new(*now, self.frames.map.clone()),
            name: doors.iter().map(|(name, _)| (*name).to_owned()).collect(),
            position: self.doors.clone(),
            ..ros::JointState::default()
        };
        self.publish(&self.topics.doors, true, &message);
    }

    /// Announces all topics that get messages later.
    fn offer_all(&self) {
        let topics = &self.topics;
        self.offer::<ros::Clock>(&topics.clock, false);
        self.offer::<ros::Transforms>(&topics.tf, false);
        self.offer::<ros::Odometry>(&topics.odom, false);
        self.offer::<ros::BatteryState>(&topics.battery, false);
        self.offer::<ros::Contacts>(&topics.contacts, false);
        if !self.lasers.is_empty() {
            self.offer::<ros::LaserScan>(&topics.scan, false);
        }
        if self.is_localized {
            self.offer::<ros::PoseWithCovarianceStamped>(&topics.estimate, POSE_IS_LATCHED);
            self.offer::<ros::Particles>(&topics.particles, false);
        }
        if self.navigation.is_some() {
            self.offer::<ros::Path>(&topics.plan, false);
        }
        self.exchange.offer(&self.station.publisher);
    }

    /// Announces a topic before it has messages.
    fn offer<T: RosMessage>(&self, topic: &str, is_latched: bool) {
        let (topic, kind) = (topic.to_owned(), T::name().full());
        self.station.publisher.publish(Publication { topic, kind, is_latched, body: Vec::new() });
    }

    fn publish<T: RosMessage>(&self, topic: &str, is_latched: bool, message: &T) {
        self.station.publisher.publish(Publication::of(topic, is_latched, message));
    }

    /// Publishes the readings of sensors. The time is published after them, so a node that has it can have the
    /// readings.
    fn publish_readings(&self, input: &ControllerInput<'_>) {
        let (software, Frames { map, odom, footprint, .. }) = (input.software, &self.frames);
        let mut transforms = Vec::new();
        for reading in software.readings() {
            match reading {
                Reading::Scan(scan) => {
                    let mut message = ros::laser_scan(&self.lasers[scan.laser], scan);
                    message.header.frame_id = self.frames.lasers[scan.laser].clone().into();
                    self.publish(&self.topics.scan, false, &message);
                }
                Reading::Odometry(odometry) => {
                    let mut message = ros::odometry(odometry);
                    message.header.frame_id = odom.clone().into();
                    message.child_frame_id = footprint.clone().into();
                    self.publish(&self.topics.odom, false, &message);
                    let mut add = |frame: &String, child: &String, pose: &Pose| {
                        let (frame, child) = (frame.clone(), child.clone());
                        transforms.push(ros::transform(odometry.time, frame, child, pose));
                    };
                    add(odom, footprint, &odometry.pose);
                    let estimate = software.estimate();
                    if self.is_localized && odometry.time == estimate.time {
                        add(map, odom, &(estimate.pose * odometry.pose.inverse()));
                    }
                }
                Reading::Battery(of) => {
                    let mut state = ros::battery_state(of.time, of.charge_pct, of.charging);
                    state.header.frame_id = self.frames.base.clone().into();
                    self.publish(&self.topics.battery, false, &state);
                }
            }
        }
        if !transforms.is_empty() {
            self.publish(&self.topics.tf, false, &ros::Transforms { transforms });
        }
        if !input.touched.is_empty() {
            let header = ros::Header::new(input.now, self.frames.base.clone());
            let contacts = input.touched.iter().map(contact).collect();
            self.publish(&self.topics.contacts, false, &ros::Contacts { header, contacts });
        }
        if software.readings().iter().any(|reading| matches!(reading, Reading::Scan(_))) {
            self.publish_estimate(input);
        }
    }

    /// Publishes the estimated pose, its particles, and the path.
    fn publish_estimate(&self, ControllerInput { now, software, .. }: &ControllerInput<'_>) {
        let (estimate, map) = (software.estimate(), &self.frames.map);
        if self.is_localized {
            let (time, covariance) = (estimate.time, estimate.covariance.into());
            let mut message = ros::estimate(time, &estimate.pose, covariance);
            message.header.frame_id = map.clone().into();
            self.publish(&self.topics.estimate, POSE_IS_LATCHED, &message);
            if self.station.is_read(&self.topics.particles) {
                let header = ros::Header::new(estimate.time, map.clone());
                let particle = |(pose, weight)| ros::Particle { pose: ros::pose(&pose), weight };
                let particles = software.particles().map(particle).collect();
                self.publish(&self.topics.particles, false, &ros::Particles { header, particles });
            }
        }
        if self.navigation.is_some() && self.station.is_read(&self.topics.plan) {
            let header = ros::Header::new(*now, map.clone());
            let pose = |point: &maps::Point| ros::PoseStamped {
                header: header.clone(),
                pose: ros::pose(&maps::pose(point.x, point.y, 0.0)),
            };
            let poses = software.path().iter().map(pose).collect();
            self.publish(&self.topics.plan, false, &ros::Path { header: header.clone(), poses });
        }
    }

    /// Waits for a moment until commands can come; in lock step, until a node is there that sends them. Returns whether
    /// they can.
    fn await_partner(&mut self) -> bool {
        if self.has_begun {
            return true;
        }
        let is_in_step = matches!(self.pace, Pace::LockStep { .. });
        if self.found.is_none() && is_in_step && !self.has_partner() {
            self.note_once(Oddity::Missing);
        } else if self.found.get_or_insert_with(network::now).elapsed() >= SETTLING {
            // Discards what came before the run.
            (self.commands, self.output, self.has_begun) = (Commands::default(), ControllerOutput::default(), true);
            return true;
        }
        self.receive(PATIENCE, Duration::ZERO);
        false
    }

    fn has_partner(&self) -> bool {
        self.station.is_read(&self.topics.clock) && self.station.is_published(&self.topics.command)
    }

    /// Waits for a moment until the simulated time `now` is due, and receives messages meanwhile. Returns whether it is
    /// due.
    fn listen(&mut self, now: Duration) -> bool {
        let (begun, mut taken) = (network::now(), 0);
        loop {
            let left = self.pace.left(now);
            let has_come = self.receive(left.min(PATIENCE), now);
            taken += usize::from(has_come);
            if left.is_zero() && (!has_come || taken > MOST) {
                break;
            }
            if !left.is_zero() && begun.elapsed() >= PATIENCE {
                return false;
            }
        }
        if self.pace.is_late() {
            self.note_once(Oddity::Behind);
        }
        true
    }

    /// Waits for a moment for the command of the period that begins now. `None` if it has not come.
    fn await_command(&mut self, now: Duration, deadline: Duration) -> Option<VelocityCommand> {
        let (begun, since) = (network::now(), *self.waiting_since.get_or_insert_with(network::now));
        loop {
            let is_over = since.elapsed() >= deadline;
            while let Some(command) = self.commands.of_period(now) {
                match command {
                    Ok(velocity) => {
                        self.waiting_since = None;
                        return Some(velocity);
                    }
                    Err(oddity) => self.note_once(oddity),
                }
            }
            if is_over {
                let seconds = deadline.as_secs_f64();
                let words = format!("no command came for the period at {} s in {seconds} s", now.as_secs_f64());
                self.output.notes.push(format!("{words}: the robot stops"));
                self.waiting_since = None;
                return Some(VelocityCommand::STOP);
            }
            if begun.elapsed() >= PATIENCE {
                return None;
            }
            self.receive(PATIENCE.min(deadline), now);
        }
    }

    /// The last command; a stop if it is too old, which is noted unless the robot `navigates`.
    fn last_command(&mut self, now: Duration, navigates: bool) -> VelocityCommand {
        let command = self.commands.last(now);
        if command.is_none() && self.commands.forget() && !navigates {
            self.output.notes.push(format!("no command came for {} s: the robot stops", STALE.as_secs_f64()));
        }
        command.unwrap_or_default()
    }

    /// Receives a message, if one comes within this time. Returns whether one has.
    fn receive(&mut self, patience: Duration, now: Duration) -> bool {
        let Some(Incoming { topic, kind, body }) = self.station.receive(patience) else { return false };
        if topic == self.topics.command {
            self.take_command(&kind, &body, now);
        } else if let Some(pose) = commands::initial_pose(&body, &self.frames.map) {
            self.output.pose = Some(pose);
        } else {
            self.note_once(Oddity::Unreadable);
        }
        true
    }

    fn take_command(&mut self, kind: &str, body: &[u8], now: Duration) {
        let Some(command) = Command::is_known(kind).then(|| Command::read(kind, body)).flatten() else {
            return self.note_once(Oddity::Unreadable);
        };
        if command.is_partial {
            self.note_once(Oddity::Sideways);
        }
        let is_in_step = matches!(self.pace, Pace::LockStep { .. });
        if let Err(oddity) = self.commands.take(command, now, is_in_step) {
            self.note_once(oddity);
        }
    }

    fn note_once(&mut self, oddity: Oddity) {
        if !self.noted.insert(oddity) {
            return;
        }
        let Topics { command, clock, initial_pose, .. } = &self.topics;
        self.station.note(&match oddity {
            Oddity::Unreadable => format!(
                "a message on {command} or {initial_pose} is left out: it is of another type or frame, too short, or not \
                 finite"
            ),
            Oddity::Sideways => format!("commands on {command} demand more than driving forwards and turning"),
            Oddity::Old => format!("commands on {command} are left out: their stamps are older than {clock}"),
            Oddity::Ahead => format!(
                "commands on {command} are left out: their stamps are ahead of {clock}; does their node use `use_sim_time`?"
            ),
            Oddity::Behind => "the simulation is slower than real time: time passes as it can".to_owned(),
            Oddity::Missing => format!("waiting for a node that publishes on {command} and reads {clock}"),
            Oddity::TooMany => {
                format!("more commands come on {command} than there are periods: the oldest are left out")
            }
        });
    }
}

/// Which bodies touch each other, and where. The robot is the first body, and the normal is the direction in which it
/// is pushed, as in Gazebo. Forces are unknown.
fn contact(touched: &Touched<'_>) -> ros::Contact {
    /// The number of a model among entities.
    const MODEL: u8 = 2;
    let entity = |name: &str| ros::Entity { id: 0, name: name.to_owned(), r#type: MODEL };
    let vectors = |[x, y]: [f64; 2]| vec![ros::Vector { x, y, z: 0.0 }];
    ros::Contact {
        collision1: entity("steward"),
        collision2: entity(touched.body),
        positions: vectors([touched.at.x, touched.at.y]),
        normals: vectors(touched.normal),
        depths: vec![touched.depth_m],
        wrenches: Vec::new(),
    }
}
